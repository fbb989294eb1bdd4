from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, finite, is_driven_by_mjlab, own_figure, shown
from actspec.laws.stability import LIMIT, StepDrive
from actspec.readings.artifact import Artifact, FileKind, without_comments
from actspec.readings.ledger import LedgerRow
from actspec.robot.view import RobotView

_EMPTY_BODY = re.compile(rb"<body\b(?![^<>]*\bmocap\b)[^<>]*(?:/>|(?<!/)>\s*</body>)")
"""A body with nothing in it: where a hand or a tool is mounted, whose mass the joints before it move."""

_FEW, _LINKS = 2, 3
"""Actuators of a gripper at most, and joints that each moves at least. Chosen: a leg has an actuator a joint."""

RUNGE_KUTTA = 2.785
"""h kd/I at which the fourth-order Runge-Kutta step diverges: |1 - z + z^2/2 - z^3/6 + z^4/24| = 1.

Source: MuJoCo 4.0 agrees: 2.7 decays, 2.9 grows.
"""

HELD = 0.75
"""Share of the effort limit from which a joint's dry friction holds what the drive would start.

MuJoCo takes frictionloss implicitly, and only what is left of the limit throws the joint. Source: MuJoCo, with a limit
of 20 N*m, kd 20 N*m*s/rad and a figure of 5 (tests/audit/rules/test_held.py): at 1 and 2 rad/s the speed is steady with
a friction of 15 N*m, and changes by 2.5 rad/s from step to step with 10 N*m, by 5 without any.
"""

_Subject = tuple[Sequence[LedgerRow], RobotView, float, str]


class ExplicitVelocityGain(RuleOver[_Subject]):
    code = "STB101"
    name = "kv-under-euler"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    # Over nine blind samples 7 of 12 in strangers' folders were worth acting on, and two were false.
    noted_in_folders = True
    written_over = frozenset({"integrator", "step", "gains"})
    needs = "no MJCF with drives on joints of known inertia among the files"
    options: ClassVar[dict[str, float]] = {"near": 1.0}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for (index, joint), rows in by_joint(case, FileKind.MJCF).items():
            artifact = case.artifacts[index]
            robot = artifact.robot
            least = rows[0].inertia_free_min
            if robot is None or rows[0].control == "none" or least is None or least <= 0.0:
                continue
            yield rows, robot, least, joint

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find drives that the step is too long for."""
        rows, robot, least, joint = subject
        drive = _drive_of(robot, rows)
        if drive is None or rows[0].artifact in case.once(_parts_of_others):
            # A part has step, integrator and load of what includes it, of which it is told at the same place.
            return
        if robot.integrator == "RK4":
            drive = StepDrive(drive.step, 0.0, drive.explicit, 0.0)
        figure = drive.figure(least)
        limit = LIMIT if robot.integrator == "Euler" else RUNGE_KUTTA
        threshold = self.option(case, "near") if robot.integrator == "Euler" else limit
        if drive.explicit > 0.0 and figure >= threshold and not is_driven_by_mjlab(case, rows[0]):
            bounded = _is_bounded(rows, drive, least, limit)
            found = self._finding(rows, robot, drive, figure, limit, bounded, _reference(robot, joint))
            artifact = case.artifacts[rows[0].artifact]
            if joint in robot.coupled:
                # What it is coupled with moves with it, and the inertia is not that of the joint alone.
                found = replace(found, severity=Severity.INFO, confidence=Confidence.LOW)
            if not artifact.states(b"<option") and (
                artifact.is_part or _is_a_mount(artifact) or _is_a_gripper(robot)
            ):
                # Step, integrator and what it carries are those of the model that mounts it.
                found = replace(found, severity=Severity.INFO, confidence=Confidence.LOW)
            elif bounded and _is_held(rows[0]):
                found = replace(found, severity=Severity.INFO)
            yield found

    def _finding(
        self,
        rows: Sequence[LedgerRow],
        robot: RobotView,
        drive: StepDrive,
        figure: float,
        limit: float,
        bounded: bool,
        reference: float | None,
    ) -> Finding:
        beyond = figure >= limit
        usual = None if reference is None else drive.figure(reference)
        sure = beyond and usual is not None and usual >= limit
        what = "the velocity diverges" if beyond else "the velocity changes its sign with every step"
        figures = f"{figure:.3g}"
        if beyond and usual is not None and not sure:
            what += " in some poses"
            figures += f", {usual:.3g} in the reference pose"
        row = rows[0]
        if beyond and bounded:
            limit_here = finite(row.effort_limit)
            of = "" if limit_here is None else f" of {own_figure(row, 'effort_limit')}"
            what += f" as far as the limit{of} lets it"
        implicit = f", with d = {shown(row, 'kd', drive.implicit)}" if drive.implicit else ""
        return Finding(
            self.code,
            f"{robot.integrator} takes the damping of {shown(row, 'kd', drive.explicit)} explicitly: with a step of "
            f"{drive.step * 1e3:g} ms {what} ({drive.formula} = {figures}, limit {limit:g}{implicit})",
            row.place("kd"),
            row.joint,
            figure,
            "1",
            help='set integrator="implicitfast", or a shorter timestep, or state the true armature',
            fields=("kd",),
            severity=Severity.ERROR if sure else self.severity if beyond else Severity.INFO,
            confidence=self.confidence if beyond else Confidence.MEDIUM,
            noted_in_folders=bounded,
        )


def _drive_of(robot: RobotView, rows: Sequence[LedgerRow]) -> StepDrive | None:
    """The drives of a joint under an explicit integrator; None under another, or with something unknown."""
    if robot.integrator not in ("Euler", "RK4") or robot.timestep is None:
        return None
    kp = [row.kp for row in rows if row.kp is not None]
    kd = [row.kd for row in rows if row.kd is not None]
    actuator = [row.actuator_damping for row in rows if row.actuator_damping is not None]
    view, joint = robot.joint(rows[0].joint), rows[0].joint_damping
    spring = None if view is None else view.spring
    if joint is None or spring is None or min(len(kp), len(kd), len(actuator)) < len(rows):
        return None
    passive = joint + sum(actuator)
    if robot.integrator == "Euler" and robot.eulerdamp:
        return StepDrive(robot.timestep, sum(kp) + spring, sum(kd), passive)
    return StepDrive(robot.timestep, sum(kp) + spring, sum(kd) + passive, 0.0)


def _is_bounded(rows: Sequence[LedgerRow], drive: StepDrive, least: float, limit: float) -> bool:
    """Whether the effort limit clamps the drives, and the spring and damping beside them are stable without them."""
    spring = max(drive.kp - sum(row.kp or 0.0 for row in rows), 0.0)
    passive = max(drive.explicit - sum(row.kd or 0.0 for row in rows), 0.0)
    beside = StepDrive(drive.step, spring, passive, drive.implicit)
    return all(row.kd_clamped for row in rows) and beside.figure(least) < limit


def _is_held(row: LedgerRow) -> bool:
    """Whether the joint's dry friction takes `HELD` of the effort limit or more."""
    limit = finite(row.effort_limit)
    return limit is not None and (row.frictionloss or 0.0) >= HELD * limit


def _reference(robot: RobotView, joint: str) -> float | None:
    """Free inertia in the reference pose."""
    found = (robot.joint_inertia or {}).get(joint)
    return None if found is None else found.free.reference


def _is_a_mount(artifact: Artifact) -> bool:
    """Whether a body of a model is empty: a robot is put together there, with the options of what it becomes."""
    files = () if artifact.robot is None else artifact.robot.files
    return any(_EMPTY_BODY.search(without_comments(file.data)) for file in files)


def _is_a_gripper(robot: RobotView) -> bool:
    """Whether one or two actuators move a linkage of many joints: it is mounted on a robot, whose options hold."""
    count = len(robot.actuators)
    return count <= _FEW and len(robot.joints) >= _LINKS * count


def _parts_of_others(case: Case) -> frozenset[int]:
    """Models that another one includes."""
    models = list(case.of_kind(FileKind.MJCF))
    included = {
        os.path.realpath(file.path)
        for _, artifact in models
        if artifact.robot is not None
        for file in artifact.robot.files
        if file.include
    }
    return frozenset(index for index, artifact in models if os.path.realpath(artifact.path) in included)
