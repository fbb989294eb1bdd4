"""MuJoCo 3.2 to 4.0: text-preserving edits of an MJCF, checked against MjSpec on every run."""
