"""Engines: the simulators' own code, each in a process of its own, asked for torques."""
