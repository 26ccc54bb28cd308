"""The process that stops robots if their stage dies, and the stage's side of it.

Begin with `client`, the stage's side; `process` waits beside the stage, with publishers that are matched already.
"""
