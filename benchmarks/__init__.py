"""Timings of softact beside other programs, on the same mesh and load."""
