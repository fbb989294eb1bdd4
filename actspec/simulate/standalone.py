"""What scripts in simulators' environments share with us: numpy alone.

`actspec.verify` sends this file along with each script, which imports it by its bare name: nothing of actspec is
in those environments, so that an agreement is one between two programs.

What every probe is asked, beside what it says itself:
    columns: the managed joints, the columns of every array.
    commands: what each of them is commanded by: position, velocity or effort.
    step: physics step [s].
    motions: names of motions; or
    parts: into how many steps each step is divided, for each run of responses: [1, 2];
    lags: nominal delay of each column in physics steps.
Arrays: `NAME/command`, `NAME/q`, `NAME/qd` for each motion; (n_step, n_env, n_column). For responses `command`
    (n_step, n_course, n_column), `q` and `qd` at the start (n_course, n_column), `inertia` of a body without armature,
    `coulomb` and `viscous` friction (n_column,).
Answers: `error` where the file is refused; arrays `NAME`, the torque at each joint in each step of a motion. For
    responses `q1` (n_step + 1, n_course, n_column) and `torque1` for `parts` 1, and so on.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np

Array = np.ndarray[Any, Any]
Answered = tuple[Any, Mapping[str, Array]]
"""What goes to OUT.json and OUT.npz."""


def serve(
    answer: Callable[[Any, dict[str, Array]], Answered], begin: Callable[[Any], None] | None = None
) -> None:
    """Answer the job of the command line, `SCRIPT JOB.json IN.npz OUT.json OUT.npz`; an error is an answer.

    Args:
        answer: Job and arrays to what is written.
        begin: Called with the job first.
    """
    job_path, arrays_path, said_path, out_path = sys.argv[1:]
    with open(job_path, encoding="utf-8") as file:
        job = json.load(file)
    with np.load(arrays_path) as found:
        arrays = {key: found[key] for key in found.files}
    if begin is not None:
        begin(job)
    said: Any
    out: Mapping[str, Array]
    try:
        said, out = answer(job, arrays)
    except Exception as err:  # whatever the package or the file says is the answer
        said, out = {"error": f"{type(err).__name__}: {err}"}, {}
    with open(said_path, "w", encoding="utf-8") as file:
        json.dump(said, file)
    np.savez(out_path, **out)  # type: ignore[arg-type]  # numpy's stub takes them for allow_pickle


class Body:
    """Joints that move by semi-implicit steps, the torque held, as a rigid-body engine moves them.

    Args:
        inertia: Armature included > 0 [kg*m^2 or kg], shape (n_joint,).
        coulomb: Dry friction >= 0 [N*m or N], likewise.
        viscous: b >= 0 [N*m*s/rad or N*s/m], likewise.
        step: [s].
        q: Positions [rad or m], shape (n_course, n_joint).
        qd: Speeds [rad/s or m/s], likewise.
    """

    def __init__(
        self, inertia: Array, coulomb: Array, viscous: Array, step: float, q: Array, qd: Array
    ) -> None:
        self.inertia, self.coulomb, self.viscous, self.step = inertia, coulomb, viscous, step
        self.q, self.qd = q.copy(), qd.copy()

    def move(self, torque: Array) -> None:
        """One step: friction takes no more of the speed than there is; torque [N*m or N], (n_course, n_joint)."""
        free = self.qd + self.step * torque / self.inertia
        left = np.maximum(np.abs(free) - self.step * self.coulomb / self.inertia, 0.0)
        self.qd = np.sign(free) * left / (1.0 + self.step * self.viscous / self.inertia)
        self.q = self.q + self.step * self.qd


class Moving(Protocol):
    """What is stepped: an engine's joints, or a drive of one on bodies."""

    def positions(self) -> Array:
        """Where it is [rad or m], shape (n_course, n_joint)."""

    def go(self, command: Array) -> Array:
        """Torque at a command [N*m or N], both (n_course, n_joint), and one part of a step with it."""


class Driven:
    """Bodies that a drive moves.

    Args:
        drive: Command, positions and speeds, (n_course, n_joint) each, to the torque of one part of a step.
        body: Where they begin; its step is that of a part.
    """

    def __init__(self, drive: Callable[[Array, Array, Array], Array], body: Body) -> None:
        self._drive, self._body = drive, body

    def positions(self) -> Array:
        """See `Moving`."""
        return self._body.q

    def go(self, command: Array) -> Array:
        """See `Moving`."""
        torque = self._drive(command, self._body.q, self._body.qd)
        self._body.move(torque)
        return torque


def follow(moving: Moving, command: Array, parts: int) -> tuple[Array, Array]:
    """Let joints follow their commands, each step in so many parts.

    Args:
        moving: Where they begin, and what moves them by a part of a step.
        command: One a step, shape (n_step, n_course, n_joint).
        parts: Of a step.

    Returns:
        Positions at the start of each step and at the end, (n_step + 1, n_course, n_joint), and torques at the start
        of each step, (n_step, n_course, n_joint).
    """
    q, torques = [moving.positions()], []
    for now in command:
        for part in range(parts):
            torque = moving.go(now)
            if part == 0:
                torques.append(torque)
        q.append(moving.positions())
    return np.stack(q), np.stack(torques)
