"""Files that are not compared with a model although they name its joints."""

from __future__ import annotations

from collections.abc import Iterator
from os.path import basename

from actspec.audit.case import Case
from actspec.diagnostics import Diagnostic, Severity, Span, listed
from actspec.readings.pair import SHARE, joint_names


def strangers(case: Case) -> Iterator[Diagnostic]:
    """What names the joints of a model, and is called otherwise, in a robot that has no model.

    Args:
        case: Its robots are paired.
    """
    models = {
        artifact.path: frozenset(joint_names(artifact) or ())
        for artifact in case.artifacts
        if artifact.robot is not None
    }
    for robot in case.robots:
        members = [case.artifacts[index] for index in robot.artifacts]
        if any(member.robot is not None for member in members):
            continue
        for member in members:
            own = frozenset(joint_names(member) or ())
            near = [path for path, joints in models.items() if own and len(own & joints) >= SHARE * len(own)]
            if member.config is not None and near:
                yield Diagnostic(
                    "AUD015",
                    Severity.INFO,
                    f"this has the joints of {listed(map(basename, near), 2)}, and is not compared with it: the names "
                    "do not say that it is the same robot",
                    "",
                    Span(member.path),
                    "write the robot's name into the file's name",
                )
