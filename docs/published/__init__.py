"""Published figures beside softact's: what docs/validation_table.py puts on the page."""
