"""The Isaac Lab target: actuator cfgs as a Python module, by version of Isaac Lab and of what runs below it."""
