"""softact: from a YAML spec of a soft pneumatic actuator to its data sheet."""
