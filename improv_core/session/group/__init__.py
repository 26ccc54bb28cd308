"""Several stages that play as one."""
