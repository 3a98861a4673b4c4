"""How far the figures of a run scatter where the numbers of its spec do, to first order."""
