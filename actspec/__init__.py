"""actspec: a declarative config compiler for robot actuators."""

from __future__ import annotations

__version__ = "0.1.0"
