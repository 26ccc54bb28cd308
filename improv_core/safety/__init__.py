"""What makes robots stand, and what says that they do. Standard library only."""
