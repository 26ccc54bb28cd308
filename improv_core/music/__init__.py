"""Clocks and messages of other programs: OSC, MIDI clock, Ableton Link."""
