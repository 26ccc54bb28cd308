"""What will play, computed from what a stage reports. Standard library only."""
