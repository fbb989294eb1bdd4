"""The deploy target: what the robot's own computer needs of a spec, as YAML."""
