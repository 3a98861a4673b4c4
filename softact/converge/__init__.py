"""Mesh convergence: refine until the named measures stay, and say what the coarse mesh is worth."""
