"""Clocks and messages of other programs: OSC, MIDI clock, Ableton Link.

It may import `ipc`, `preview`, `safety`, and `protocol`; the session starts its processes. Begin with `osc`, then
`clock_process`.
"""
