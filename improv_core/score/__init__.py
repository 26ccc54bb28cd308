"""What is played: movements, motion, profiles, and scores. Standard library only, Python 3.10 and newer."""
