"""A model as it will be solved, drawn and counted before anything is solved."""

from softact.preview.look import Preview, of_spec, of_step
from softact.preview.writing import SUFFIXES, write

__all__ = ["SUFFIXES", "Preview", "of_spec", "of_step", "write"]
