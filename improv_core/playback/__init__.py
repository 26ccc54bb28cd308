"""The parent's side of stages: finds their Python, starts and watches them, and shows several as one."""
