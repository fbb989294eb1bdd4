"""Real files, changed by their structure, through the commands' own entry point: `python -m tests.fuzz --help`."""
