"""Logs from a loop of one's own, a simulation's or a robot's, in the form that all commands read.

recorder = actspec.Recorder(["hip", "knee"], period=0.02)
while running:
    position, velocity, torque = read()
    command = policy(...)
    recorder.add(command, position, velocity, torque)
    send(command)
recorder.save("rollout.csv")
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import Any

__all__ = ["Recorder"]

SIGNALS = ("command", "position", "velocity", "torque")


class Recorder:
    """Rows of joints: what was read, and the command that is sent then and held until the next row.

    Args:
        joints: Names, in the order of every array.
        period: Time between two rows [s].
        slides: Those of them that are slides, in m and N.

    Raises:
        ValueError: no joint, a name twice, or a period that is not above 0.
    """

    def __init__(self, joints: Sequence[str], period: float, *, slides: Sequence[str] = ()) -> None:
        if not joints or len(set(joints)) != len(joints):
            raise ValueError(f"joints must be names, each once, got {list(joints)}")
        if not (period > 0.0 and math.isfinite(period)):
            raise ValueError(f"period must be above 0 s, got {period}")
        unknown = set(slides) - set(joints)
        if unknown:
            raise ValueError(f"slides are not among the joints: {sorted(unknown)}")
        self.joints, self.period, self.slides = tuple(joints), float(period), frozenset(slides)
        self._rows: list[list[Any]] = []
        self._has: tuple[bool, ...] | None = None

    def __len__(self) -> int:
        return len(self._rows)

    def add(self, command: Any, position: Any, velocity: Any = None, torque: Any = None) -> None:
        """Add a row: readings of now, torque included, and the command that is sent now.

        Args:
            command: Position command [rad or m], shape (joints,): what numpy reads, tensors too; None: not known.
            position: [rad or m], likewise.
            velocity: [rad/s or m/s]; None: not read.
            torque: [N*m or N], as it is under the command of the row before; None: not read.

        Raises:
            ValueError: another shape, or another set of signals than in the first row.
        """
        import numpy as np

        given = (command, position, velocity, torque)
        has = tuple(part is not None for part in given)
        if not has[1]:
            raise ValueError("position is needed in each row")
        if self._has is None:
            self._has = has
        if has != self._has:
            raise ValueError("each row must have the same signals as the first")
        row = []
        for name, part in zip(SIGNALS, given, strict=True):
            if part is None:
                continue
            values = np.asarray(part.detach().cpu() if hasattr(part, "detach") else part, dtype=float).copy()
            if values.shape != (len(self.joints),):
                raise ValueError(f"{name} must have shape ({len(self.joints)},), got {values.shape}")
            row.append(values)
        self._rows.append(row)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the rows as CSV, or as NPZ where the name ends so; a file that is there is replaced.

        Raises:
            ValueError: no row was added.
            LogError: the file cannot be written.
        """
        import numpy as np

        from actspec.logs import JointLog, Log, Sidecar, write_log

        if not self._rows or self._has is None:
            raise ValueError("no row was added")
        names = [name for name, there in zip(SIGNALS, self._has, strict=True) if there]
        arrays = {name: np.stack([row[k] for row in self._rows]) for k, name in enumerate(names)}
        joints = {
            joint: JointLog(
                joint, joint in self.slides, **{name: array[:, j] for name, array in arrays.items()}
            )
            for j, joint in enumerate(self.joints)
        }
        time = np.arange(len(self._rows), dtype=float) * self.period
        write_log(Log(os.fspath(path), "", time, joints, Sidecar()))
