from __future__ import annotations

import math
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, partner_rows, shown
from actspec.diagnostics import Span
from actspec.laws.stability import LIMIT, RINGING, StepDrive
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.ledger import LedgerRow

_EXPLICIT_CLASSES = ("ideal_pd", "dc_motor", "network")


_Subject = tuple[LedgerRow, float, float, float, str]


class ExplicitDrive(RuleOver[_Subject]):
    code = "STB102"
    name = "explicit-cfg-drive-unstable"
    aliases: ClassVar[dict[str, str]] = {"STB001": "explicit-drive-near-or-beyond-stability"}
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    # What else sets an armature or a step is not seen in a stranger's folder: over nine blind samples 30 of 41 folders
    # were worth acting on, and six were false, each by another thing that a program sets.
    noted_in_folders = True
    paired = True
    needs = "no configuration with explicit drives, its physics step and a model that gives inertia"
    options: ClassVar[dict[str, float]] = {"near": 1.0}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for rows in by_joint(case, FileKind.CFG).values():
            row = rows[0]
            config = case.artifacts[row.artifact].config
            step = config.physics_dt if config is not None else None
            inertia = row.inertia_free_min
            if row.place("kd") in case.once(_drawn):
                # What inherits the gains draws an armature.
                continue
            explicit = row.control in _EXPLICIT_CLASSES and len(rows) == 1
            if not explicit or step is None or row.kd is None or inertia is None or inertia <= 0.0:
                continue
            if row.effort_limit is None and any(
                other.effort_limit == 0.0 for other in partner_rows(case, row, FileKind.URDF)
            ):
                # What takes its limit from the model has no torque at all.
                continue
            yield row, case.once(_shortest).get(row.place("kd"), step), inertia, row.kd, ""
        for index, artifact in case.of_kind(FileKind.SPEC):
            step = artifact.spec.physics_dt.value if artifact.spec is not None else None
            for row in case.rows_of(index) if step is not None else ():
                concerned = ", ".join(to for to, joints in case.explicit.items() if row.joint in joints)
                inertia = row.inertia_free_min
                if step and concerned and row.kd is not None and inertia is not None and inertia > 0.0:
                    yield row, step, inertia, row.kd, f"; concerns {concerned}"

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find explicit drives that the step is too long for."""
        row, step, inertia, kd, concerned = subject
        drive = StepDrive(step, row.kp or 0.0, kd, max(row.joint_damping or 0.0, 0.0))
        figure = drive.figure(inertia)
        if kd <= 0.0 or not math.isfinite(figure) or figure < self.option(case, "near"):
            return
        beyond = figure >= LIMIT
        most = inertia if row.inertia_free_max is None else row.inertia_free_max
        least = drive.figure(most)
        # What has the larger share is what to lower.
        gain = "kp" if StepDrive(step, 0.0, kd, drive.implicit).figure(inertia) < 0.5 * figure else "kd"
        value = row.kp if gain == "kp" else kd
        # What else sets an armature, or another step, nobody sees here: what the figure is made of is said.
        implicit = f", d = {shown(row, 'kd', drive.implicit)}" if drive.implicit else ""
        rotor = "" if row.armature else ", no armature stated"
        what = "the velocity diverges" if beyond else "the velocity changes its sign with every step"
        pose = "" if least >= LIMIT or not beyond else f" in some poses, {least:.3g} in others"
        beside = _damping_beside(case, row)
        damped = StepDrive(step, row.kp or 0.0, kd, max(drive.implicit, beside)).figure(most)
        if least >= LIMIT > damped:
            damping = shown(row, "kd", beside)
            pose = f", or {damped:.3g} where the simulator takes the URDF's damping of {damping} implicitly"
        yield Finding(
            self.code,
            f"the drive ({row.control}) takes {gain} {shown(row, gain, value)} explicitly: with a step of "
            f"{step * 1e3:g} ms {what} ({drive.formula} = {figure:.3g}{pose}, limit {LIMIT:g}, "
            f"with I = {shown(row, 'inertia_free_min', inertia)}{implicit}{rotor}){concerned}",
            row.place(gain),
            row.joint,
            figure,
            "1",
            fields=(gain,),
            help="use the implicitfast integrator (MuJoCo) or `class: implicit` (Isaac Lab), a smaller physics_dt, a "
            f"lower {gain}, or state the true armature"
            if concerned
            else f"state the true armature, shorten the step, lower {gain}, or use an implicit class",
            # Which poses a file that is run already takes, nobody knows.
            severity=self.severity
            if (figure >= RINGING if concerned else damped >= LIMIT and not _is_wheel(case, row))
            else Severity.INFO,
            confidence=Confidence.HIGH if beyond else self.confidence,
        )


def _damping_beside(case: Case, row: LedgerRow) -> float:
    """The damping of the URDF beside a configuration of legged_gym, which the simulator may take implicitly, or not."""
    return max((model.joint_damping or 0.0 for model in _urdf_beside_gym(case, row)), default=0.0)


def _urdf_beside_gym(case: Case, row: LedgerRow) -> list[LedgerRow]:
    """What URDFs state of a joint of a configuration of legged_gym; nothing of another framework's."""
    config = case.artifacts[row.artifact].config
    is_gym = config is not None and config.framework is Framework.LEGGED_GYM
    return list(partner_rows(case, row, FileKind.URDF)) if is_gym else []


def _is_wheel(case: Case, row: LedgerRow) -> bool:
    """Whether a joint of a legged_gym configuration turns without end: forks give it a law of its own, in code."""
    models = _urdf_beside_gym(case, row)
    return bool(models) and all(model.position_range is None for model in models)


def _shortest(case: Case) -> dict[Span, float]:
    """Where gains stand, and the shortest step of the configurations that have them: a class that inherits them is what
    is run.
    """
    steps: dict[Span, float] = {}
    for rows in by_joint(case, FileKind.CFG).values():
        config = case.artifacts[rows[0].artifact].config
        if config is not None and config.physics_dt is not None:
            place = rows[0].place("kd")
            steps[place] = min(config.physics_dt, steps.get(place, math.inf))
    return steps


def _drawn(case: Case) -> frozenset[Span]:
    """Where gains stand that a configuration has whose armature is drawn at random."""
    return frozenset(
        row.place("kd")
        for _, rows in by_joint(case, FileKind.CFG).items()
        for row in rows
        if row.armature is None and row.kd is not None and "armature" in row.places
    )
