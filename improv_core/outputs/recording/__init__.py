"""Recordings of the commands that robots were sent, as mcap files. Begin with `recorder`."""
