"""The weight of Improv: lines, message types, and the modules through which a save and a stop pass."""
