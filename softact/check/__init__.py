"""Reference cases: small specs with stored values, run again and compared."""
