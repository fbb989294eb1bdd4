"""The randomisation target: a spec's ranges as event terms, a function and JSON."""
