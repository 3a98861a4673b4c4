"""Contact: with rigid obstacles, of a body with itself, between bodies; see docs/contact.md."""
