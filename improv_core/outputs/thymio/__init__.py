"""The output for Thymio II robots, over Aseba's binary protocol: by USB, by the radio dongle, or over TCP.

Begin with `thymio`, which drives one robot; `bus` has the robots at one address, and `program` runs on each robot.
They may import `outputs.devices` and `score`.
"""
