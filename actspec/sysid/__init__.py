"""Identification: from a robot's log to figures of its actuators, with what the log cannot tell."""
