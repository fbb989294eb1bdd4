"""What of a target's options can be told before it is written: its version, and names of joints in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import TypeVar

from actspec.diagnostics import Collector, EmitError
from actspec.simulators import UnknownVersion
from actspec.simulators.isaaclab import IsaacLabDialect
from actspec.simulators.mjlab import MjlabDialect, mjlab_dialect
from actspec.simulators.mujoco import MujocoDialect, mujoco_dialect
from actspec.simulators.newton import NewtonDialect, newton_dialect
from actspec.targets.base import TargetOptions
from actspec.targets.deploy.order import check_sdk_order
from actspec.targets.isaaclab import dialect_for

T = TypeVar("T")


def mujoco_row(options: TargetOptions, collector: Collector) -> MujocoDialect:
    """The row of a MuJoCo target; see `_row`."""
    return _row(lambda: mujoco_dialect(options.version), "MJC007", options, collector)


def mjlab_row(options: TargetOptions, collector: Collector) -> MjlabDialect:
    """The row of an mjlab target; see `_row`."""
    return _row(lambda: mjlab_dialect(options.version), "MJL007", options, collector)


def newton_row(options: TargetOptions, collector: Collector) -> NewtonDialect:
    """The row of a Newton target; see `_row`."""
    return _row(lambda: newton_dialect(options.version), "NWT007", options, collector)


def isaaclab_row(options: TargetOptions, collector: Collector) -> IsaacLabDialect:
    """The row of an Isaac Lab target; see `_row`."""
    return _row(lambda: dialect_for(options), "ISL001", options, collector)


ROWS: Mapping[str, Callable[[TargetOptions, Collector], object]] = {
    "mujoco": mujoco_row,
    "mjlab": mjlab_row,
    "newton": newton_row,
    "isaaclab": isaaclab_row,
}
"""The row of a target's version, by its kind."""


def check_options(
    targets: Sequence[TargetOptions], managed: Sequence[str] | None, collector: Collector
) -> None:
    """Report versions that are not known, and orders that do not name the managed joints.

    Args:
        targets: The targets.
        managed: The joints that the spec manages; None: unknown.
        collector: Takes what is wrong.
    """
    for options in targets:
        if options.kind in ROWS:
            with suppress(EmitError):
                ROWS[options.kind](options, collector)
        if options.kind == "deploy" and managed is not None:
            check_sdk_order(options, managed, collector)


def _row(row: Callable[[], T], code: str, options: TargetOptions, collector: Collector) -> T:
    """The row of a target's version.

    Args:
        row: Looks it up.
        code: Of the error where there is none.
        options: The target.
        collector: Takes that error.

    Raises: EmitError: the version is not known.
    """
    try:
        return row()
    except UnknownVersion as err:
        options.at(err.key, collector).error(code, err.message, err.help)
        raise EmitError(collector.sorted()) from None
