"""Clocks and messages of other programs: OSC, MIDI clock, Ableton Link.

They may import `ipc`, `preview`, `safety`, and `protocol`; the session starts their processes. Begin with `osc`, then
`clock_process`.
"""
