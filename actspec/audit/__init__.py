"""Rules over actuators, whether they come from a spec or from somebody's file."""
