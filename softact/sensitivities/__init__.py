"""How every measure depends on the numbers of a spec."""
