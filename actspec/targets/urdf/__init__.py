"""The URDF target: the robot's own URDF with the spec's limits and joint friction."""
