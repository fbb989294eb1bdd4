from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.known import same
from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.configs import (
    EXPLICIT,
    MJLAB_WITH_LINE,
    NO_STOCK_CLASSES,
    WITH_LINE,
    Group,
    groups_of,
    major_version,
    misspelt,
    stock_groups,
)
from actspec.audit.rules.joints import partner_rows
from actspec.readings.artifact import ActuatorGroup, FileKind, Framework, RobotConfig
from actspec.simulators import release
from actspec.simulators.classes import StockClass
from actspec.simulators.isaaclab import CLIPPING_AT_SOLVERS, clips_at_solvers

_MJLAB_EXPLICIT = MJLAB_WITH_LINE | {"IdealPdActuatorCfg"}


class RequiredFieldMissing(RuleInParts):
    code = "CFG104"
    name = "required-field-missing"
    aliases: ClassVar[dict[str, str]] = {
        "LIM105": "explicit-drive-without-effort-limit",
        "LIM110": "torque-speed-line-without-a-figure",
    }
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    written_over = frozenset({"actuators", "gains", "efforts", "speeds", "classes"})
    needs = NO_STOCK_CLASSES

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        for _, config, group, stock in stock_groups(case):
            yield self._required(config, group, stock)
        for framework, explicit, with_line in (
            (Framework.ISAACLAB, EXPLICIT, WITH_LINE),
            (Framework.MJLAB, _MJLAB_EXPLICIT, MJLAB_WITH_LINE),
        ):
            for found in groups_of(case, framework, explicit):
                if found.complete:
                    yield self._effort(case, found)
            for found in groups_of(case, framework, with_line):
                if found.complete:
                    yield self._line(found)

    def _required(self, config: RobotConfig, group: ActuatorGroup, stock: StockClass) -> Iterator[Finding]:
        known = any(note.where in (group.name, f"actuators.{group.name}") for note in config.notes)
        alone = len(config.groups) == 1 and group.name == config.name
        # A field that is misspelt is CFG103's.
        missing = sorted(stock.required - {*group.settings, *misspelt(config.framework, group).values()})
        if missing and not known and not alone:
            yield Finding(
                self.code,
                f"this {group.cls} has no {' and no '.join(missing)}: it cannot be made",
                group.span,
                help="None takes the USD's value" if _takes_none(config, missing) else None,
                about=" ".join(missing),
            )

    def _effort(self, case: Case, group: Group) -> Iterator[Finding]:
        """An explicit drive without an effort limit of its own."""
        if _is_there(group, "effort_limit", "actuator_effort_limit"):
            return
        isaac = group.framework is Framework.ISAACLAB
        then = _isaac_default(case.versions.isaaclab, group) if isaac else "mjlab then takes none"
        if then is None:
            return
        renamed = isaac and major_version(case.versions.isaaclab) >= 3
        name = "actuator_effort_limit" if renamed else "effort_limit"
        limited = _with_its_limit(case, group, FileKind.URDF) if isaac else _limited_in_mjcf(case, group)
        # A USD has most likely the limit that the MJCF has, too.
        likely = _with_its_limit(case, group, FileKind.MJCF) if isaac else set()
        for joint in group.joints:
            if joint not in limited:
                yield Finding(
                    self.code,
                    f"this {group.cfg.cls} sets no effort limit: {then}",
                    group.cfg.span,
                    joint,
                    help=f"set {name} to what the motor and its drive can give",
                    severity=Severity.INFO if joint in likely else Severity.WARNING,
                    noted_in_folders=True,
                    about="effort_limit",
                )

    def _line(self, group: Group) -> Iterator[Finding]:
        """Half a torque-speed line."""
        missing = []
        if not _is_there(group, "velocity_limit", "actuator_velocity_limit"):
            missing.append("velocity_limit")
        if not _is_there(group, "saturation_effort"):
            missing.append("saturation_effort")
        for joint in group.joints if missing else ():
            yield Finding(
                self.code,
                f"this {group.cfg.cls} sets no {' and no '.join(missing)}: it cannot be built without its "
                "torque-speed line",
                group.cfg.span,
                joint,
                help="velocity_limit is the speed at which no torque is left, saturation_effort the torque at "
                "standstill",
                about=" ".join(missing),
            )


def _is_there(group: Group, *names: str) -> bool:
    """Whether one of the settings is written, under its name or a misspelt one, which is CFG103's."""
    meant = misspelt(group.framework, group.cfg).values()
    return group.written(*names) is not None or any(name in meant for name in names)


def _takes_none(config: RobotConfig, missing: list[str]) -> bool:
    return config.framework is Framework.ISAACLAB and set(missing) <= {"stiffness", "damping"}


def _isaac_default(version: str | None, group: Group) -> str | None:
    """What counts in place of the missing limit; None where that is the USD's, or the solver's clamp."""
    clips = clips_at_solvers(None if version is None else release(version))
    solver = group.written("effort_limit_sim") is not None
    if clips is False or (clips and solver):
        return None
    nowhere = "at 1e9 N*m, which no joint reaches"
    if clips:
        return f"Isaac Lab {version} then clips {nowhere}"
    first = "at its effort_limit_sim" if solver else nowhere
    later = "the lower of that and the limit" if solver else "the limit"
    return f"{CLIPPING_AT_SOLVERS} then clip {first}; later versions at {later} that the USD has"


def _with_its_limit(case: Case, group: Group, kind: FileKind) -> set[str]:
    """Joints whose effort_limit_sim a model of this kind has; of a URDF the USD is made: whichever counts."""
    solver = group.written("effort_limit_sim")
    found: set[str] = set()
    for row in group.rows if solver is not None else ():
        own = group.number(solver, row.joint)
        efforts = [other.effort_limit for other in partner_rows(case, row, kind)]
        if own is not None and any(limit is not None and same(limit, own) for limit in efforts):
            found.add(row.joint)
    return found


def _limited_in_mjcf(case: Case, group: Group) -> set[str]:
    """Joints of the group that an MJCF of the robot limits."""
    return {
        row.joint
        for row in group.rows
        for other in partner_rows(case, row, FileKind.MJCF)
        if other.effort_limit is not None and other.effort_limit < math.inf
    }
