"""The parent's side of stages: finds their Python, starts and watches them, and presents several as one."""
