"""The meaning of programs: from trees to an analysis, and from there to a score."""
