"""One law per file: its constants, its energy as one formula, its source and when to use it."""
