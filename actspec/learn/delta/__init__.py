"""Delta action: a correction of the policy's commands, learned from logs at its rate."""
