"""What a compiled model needs while it runs."""

from __future__ import annotations

from actspec.learn.mujoco import reset

__all__ = ["reset"]
