"""Simulated robots: exact arcs, and pymunk where robots touch. Begin with `simulator`, then `robot`."""
