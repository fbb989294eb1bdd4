"""The MuJoCo releases that are agreed with."""

from __future__ import annotations

VERSIONS = ("3.2.7", "3.3.7", "3.5.0", "3.7.0", "3.11.0", "3.12.0", "3.17.0", "4.0.0")
"""One release on each side of every change that actspec's capability table names."""
