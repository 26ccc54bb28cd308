"""The process that reads sensors, and the stage's side of it.

Begin with `client`, the stage's side; `process` reads, and `readings` turns messages into changes of senses.
"""
