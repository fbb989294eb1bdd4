"""Verification: what every target's files make of the spec, in the real engines and read back."""
