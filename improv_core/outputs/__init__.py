"""Where velocities go: simulated robots, real ones, and files."""
