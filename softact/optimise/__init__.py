"""Optimisation of a spec (Optuna): every trial is a run that is kept in the sweeps' cache."""
