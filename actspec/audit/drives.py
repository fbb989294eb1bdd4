"""Joints that were driven when a baseline was written and are not any more: what is said of such a joint goes with its
actuator, and reads like a mended fault.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from actspec.audit.baseline import relative_path
from actspec.audit.case import Case
from actspec.audit.outcome import LOST_DRIVE
from actspec.audit.rules.configs import names_model
from actspec.diagnostics import Diagnostic, Severity, Span, listed
from actspec.files import name_in_file
from actspec.readings.artifact import FileKind, Framework
from actspec.robot.view import RobotView


def driven(case: Case, folder: str) -> dict[str, frozenset[str]]:
    """The joints that the actuators of each MJCF drive, directly or not.

    Args:
        case: What was read.
        folder: To which the files' names are relative.
    """
    found: dict[str, frozenset[str]] = {}
    for index, artifact in case.of_kind(FileKind.MJCF):
        joints = None if artifact.robot is None else _driven(artifact.robot)
        if joints:
            found[_name(case, index, folder)] = joints
    return found


def vanished(case: Case, before: Mapping[str, frozenset[str]], folder: str) -> frozenset[tuple[str, str]]:
    """Joints that were driven and that their file does not have any more, by file and name; arguments as of
    `lost_drives`.
    """
    return frozenset(
        (name, joint)
        for index, artifact in case.of_kind(FileKind.MJCF)
        if artifact.robot is not None
        for name in (_name(case, index, folder),)
        for joint in before.get(name, frozenset()) - {one.name for one in artifact.robot.joints}
    )


def _name(case: Case, index: int, folder: str) -> str:
    return name_in_file(relative_path(case.artifacts[index].path, folder))


def _driven(robot: RobotView) -> frozenset[str] | None:
    """None: it may be any."""
    moved = [actuator.moves for actuator in robot.actuators]
    if any(joints is None for joints in moved):
        return None
    direct = {one.target for one in robot.actuators if one.is_direct}
    return frozenset({*direct, *(joint for joints in moved for joint in joints or ())} - {""})


@dataclass(frozen=True, slots=True)
class Lost:
    """Joints of a file that were driven.

    Attributes:
        file: The file as the baseline has it.
        joints: In the file's order.
        span: Where the first stands; the file of those that are gone.
        all: Whether no joint of the file is driven any more.
        gone: Whether they are no joints of the file any more.
    """

    file: str
    joints: tuple[str, ...]
    span: Span
    all: bool
    gone: bool = False

    def told(self, baseline: str) -> Diagnostic:
        """What is said of them."""
        several, written = bool(self.joints[1:]), "when the baseline was written"
        if self.gone:
            said = f"{listed(self.joints)} {'are no joints' if several else 'is no joint'} of it any more, and an "
            said += f"actuator drove {'each' if several else 'it'} {written}"
            back = "joint"
        else:
            names = "any of its joints" if self.all else listed(self.joints)
            said = f"no actuator drives {names} any more, as one did {written}: the joint"
            said += f"{'s swing' if several else ' swings'} freely"
            back = "actuator"
        return Diagnostic(
            LOST_DRIVE,
            Severity.WARNING,
            said,
            "",
            Span(self.span.path) if self.all else self.span,
            f"put the {back}{'s' * several} back; if it is meant, write the baseline again with "
            f"--write-baseline {baseline}",
        )


def lost_drives(case: Case, before: Mapping[str, frozenset[str]], folder: str) -> Iterator[Lost]:
    """Joints that nothing drives any more, and those that are gone and in whose place no others are: what is renamed is
    driven by its new name.

    None that are there of a model without any actuator that a configuration of mjlab loads, which was stripped for
    that: Isaac Lab and legged_gym load other files. A model without any joint is told as a file (AUD021).

    Args:
        case: What was read.
        before: As `driven` gave it when the baseline was written.
        folder: The baseline's.
    """
    for index, artifact in case.of_kind(FileKind.MJCF):
        robot, name = artifact.robot, _name(case, index, folder)
        now = None if robot is None else _driven(robot)
        if robot is None or now is None or not robot.joints:
            continue
        lost = before.get(name, frozenset()) - now
        joints = [one for one in robot.joints if one.name in lost]
        if joints and (robot.actuators or not _is_loaded_by_mjlab(case, index)):
            yield Lost(name, tuple(one.name for one in joints), joints[0].span, not robot.actuators)
        there = {one.name for one in robot.joints}
        gone = lost - there
        if len(gone) > len((now if robot.actuators else there) - before.get(name, frozenset())):
            yield Lost(name, tuple(sorted(gone)), Span(case.artifacts[index].path), False, True)


def _is_loaded_by_mjlab(case: Case, index: int) -> bool:
    """Whether a configuration of mjlab loads a model; of one that does not tell which, those beside or below it."""
    model = case.artifacts[index]
    for other in case.robot_of(index).artifacts:
        config, path = case.artifacts[other].config, case.artifacts[other].path
        if config is None or config.framework is not Framework.MJLAB:
            continue
        beside = os.path.join(os.path.dirname(os.path.abspath(path)), "")
        if (
            names_model(case, config, model)
            if config.model
            else os.path.abspath(model.path).startswith(beside)
        ):
            return True
    return False
