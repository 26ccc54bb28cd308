"""What is played: movements, motion, profiles, scores. Standard library only, Python 3.10 and newer."""
