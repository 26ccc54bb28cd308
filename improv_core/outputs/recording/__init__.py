"""Recordings of robots' commands, as mcap files. Begin with `recorder`."""
