"""What processes say to each other, and what the player asks of an output. Standard library only."""
