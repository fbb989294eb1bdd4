"""The Newton target: an overlay of a robot's USD stage, with its actuators."""
