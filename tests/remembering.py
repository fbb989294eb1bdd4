"""What is the same each time, and made once: the reference of time responses, which is most of what `verify` takes in
the tests, and of what `compare` and `report` do; and the grammar of a command, which takes longer than some commands.

Tests verify one spec again and again, each time with another mistake in a file, and against the same reference; they
report one robot in every form.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any

import pytest

from actspec.cli.main import parser
from actspec.simulate.experiment import Experiment
from actspec.simulate.reference import DrivenJoint, Trajectory, integrate

ORIGINAL = Experiment.reference
_MOVED: dict[Any, Trajectory] = {}
_COMPARED: dict[Any, Trajectory] = {}
MOST = 16
"""Comparisons that are kept, of some megabytes each: the last ones."""


def reference(experiment: Experiment, driven: Sequence[tuple[int, DrivenJoint]]) -> list[Trajectory]:
    """As `Experiment.reference`, whose lanes do not touch each other."""
    keys = [
        (
            joint,
            experiment.step,
            experiment.command.shape,
            *(
                part.tobytes()
                for part in (experiment.command[..., i], experiment.q[:, i], experiment.qd[:, i])
            ),
        )
        for i, joint in driven
    ]
    new = {key: one for key, one in zip(keys, driven, strict=True) if key not in _MOVED}
    _MOVED.update(zip(new, ORIGINAL(experiment, list(new.values())), strict=True))
    return [_MOVED[key] for key in keys]


def integrated(
    joints: Sequence[DrivenJoint], command: Any, q: Any, qd: Any, step: float, *, substeps: int
) -> Trajectory:
    """As `integrate`, for `compare`."""
    key = (tuple(joints), step, substeps, command.shape, *(part.tobytes() for part in (command, q, qd)))
    if key not in _COMPARED:
        _COMPARED[key] = integrate(joints, command, q, qd, step, substeps=substeps)
        for old in list(_COMPARED)[:-MOST]:
            del _COMPARED[old]
    return _COMPARED[key]


@contextmanager
def remembering() -> Iterator[None]:
    """Remember what was integrated, and grammars."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Experiment, "reference", reference)
        patch.setattr("actspec.study.compare.integrate", integrated)
        patch.setattr("actspec.cli.main.parser", cache(parser))
        yield
