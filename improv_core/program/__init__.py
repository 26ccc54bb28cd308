"""What a program means: from trees to an analysis, and from there to a score."""
