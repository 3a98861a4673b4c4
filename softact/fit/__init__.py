"""Fitting a law to tests: the energy that the solver uses, in homogeneous deformation."""
