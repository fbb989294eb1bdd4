"""Learned models of actuators, and what a compiled model needs while it runs."""
