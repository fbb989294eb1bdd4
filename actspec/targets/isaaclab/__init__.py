"""The Isaac Lab target: actuator cfgs as a Python module, by version of Isaac Lab and of what runs below it."""

from __future__ import annotations

from actspec.simulators.isaaclab import IsaacLabDialect, isaaclab_dialect
from actspec.spec.models import IsaacSimTarget
from actspec.targets.base import TargetOptions


def dialect_for(options: TargetOptions, version: str = "") -> IsaacLabDialect:
    """The row of a target's versions and backend; `version`: in place of the target's own.

    Raises: UnknownVersion: there is no such row.
    """
    given = options.of(IsaacSimTarget)
    return isaaclab_dialect(version or options.version, given.isaac_sim, given.backend)
