"""The process that reads sensors, and the stage's side of it."""
