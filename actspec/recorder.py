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
from collections.abc import Callable, Sequence
from typing import Any

__all__ = ["EnvironmentRecorder", "Recorder"]

GAP = 100
"""Rows that a gap is long. Chosen: ten times what identification fills in."""
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
        self._gaps: list[int] = []
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
            values = _numbers(part)
            if values.shape != (len(self.joints),):
                raise ValueError(f"{name} must have shape ({len(self.joints)},), got {values.shape}")
            row.append(values)
        self._rows.append(row)

    def gap(self) -> None:
        """The next row does not follow the last one: it comes as many rows later as no fit fills in."""
        self._gaps.append(len(self._rows))

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
        steps = np.ones(len(self._rows))
        steps[[row for row in self._gaps if 0 < row < len(steps)]] = GAP
        time = (np.cumsum(steps) - 1.0) * self.period
        write_log(Log(os.fspath(path), "", time, joints, Sidecar()), force=True)


def _numbers(part: Any) -> Any:
    """A copy as numpy's array, of whatever numpy reads, and of tensors and Warp's arrays on any device."""
    import numpy as np

    if hasattr(part, "detach"):
        part = part.detach().cpu()
    return np.array(part.numpy() if hasattr(part, "numpy") else part, dtype=float)


class EnvironmentRecorder:
    """One environment of a simulator, a row after each of its steps.

        recorder = actspec.mjlab.recorder(env)
        env.reset()
        recorder.add()
        while running:
            env.step(policy(...))
            recorder.add()
        recorder.save("rollout.csv")

    The target that the joints have after a step is the command that was sent in the row before and held since. An
    episode that ends leaves a gap.

    Args:
        joints: Names, in the order of the arrays.
        period: Of the environment's steps [s].
        read: Gives the position targets of now, positions [rad or m], speeds and torques of the joints, (joints,) each.
        restarted: Whether the episode has just begun.
        slides: Those of the joints that are slides.
    """

    def __init__(
        self,
        joints: Sequence[str],
        period: float,
        read: Callable[[], tuple[Any, Any, Any, Any]],
        restarted: Callable[[], bool],
        *,
        slides: Sequence[str] = (),
    ) -> None:
        self._kept = Recorder(joints, period, slides=slides)
        self._read, self._restarted = read, restarted
        self._pending: tuple[Any, Any, Any] | None = None

    def __len__(self) -> int:
        return len(self._kept)

    def add(self) -> None:
        """Add what is read now; its command is known with the next row."""
        target, *readings = (_numbers(part) for part in self._read())
        if self._restarted():
            # The last command of an episode is not read any more: its row is left out.
            self._kept.gap()
        elif self._pending is not None:
            self._kept.add(target, *self._pending)
        position, velocity, torque = readings
        self._pending = position, velocity, torque

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the rows, but for the last, whose command is not known; as `Recorder.save`."""
        self._kept.save(path)


def of_scene(
    env: Any, torque: str, *, environment: int, entity: str, slides: Sequence[str]
) -> EnvironmentRecorder:
    """A recorder of a robot in an environment of mjlab or Isaac Lab, whose names differ in the torque's alone.

    Args:
        env: The environment, wrapped or not.
        torque: Attribute of the robot's data.
        environment: Which of them.
        entity: Name of the robot in the scene.
        slides: Its joints that are slides.
    """
    inner = getattr(env, "unwrapped", env)
    robot = inner.scene[entity]
    signals = ("joint_pos_target", "joint_pos", "joint_vel", torque)

    def read() -> tuple[Any, Any, Any, Any]:
        target, position, velocity, torque = (getattr(robot.data, name)[environment] for name in signals)
        return target, position, velocity, torque

    def restarted() -> bool:
        return int(inner.episode_length_buf[environment]) == 0

    return EnvironmentRecorder(list(robot.joint_names), float(inner.step_dt), read, restarted, slides=slides)
