"""One module of an actuator that is a chain of equal ones: free, and blocked."""
