"""The process that stops robots if their stage dies, and the stage's side of it."""
