"""The process that publishes what plays, and the stage's side of it."""
