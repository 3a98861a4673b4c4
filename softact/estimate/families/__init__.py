"""Families of actuators, one a file."""
