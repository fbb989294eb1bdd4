"""The mjlab target: a module with an `EntityArticulationInfoCfg`."""
