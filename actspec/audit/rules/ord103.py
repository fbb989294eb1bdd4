from __future__ import annotations

from collections.abc import Iterator, Sequence

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import FRAMEWORKS
from actspec.audit.rules.crowded import crowded
from actspec.readings.artifact import FileKind, RobotConfig
from actspec.readings.ledger import LedgerRow
from actspec.readings.overlap import has_last

_Subject = tuple[int, RobotConfig | None]


class JointInTwoGroups(RuleOver[_Subject]):
    code = "ORD103"
    name = "joint-in-two-groups"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    written_over = frozenset({"actuators", "joints"})
    paired = True
    needs = "no configuration with several actuator groups among the files"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework not in FRAMEWORKS or len(config.groups) < 2:
                continue
            yield index, config
        for index in {found.artifact: None for found in case.once(crowded)}:
            yield index, None

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Count the groups of each joint."""
        index, config = subject
        if config is None:
            yield from self._crowded(case, index)
            return
        seen: dict[str, LedgerRow] = {}
        # The ledger is in the joints' order; what counts is the order of the groups.
        order = {group.span: place for place, group in enumerate(config.groups)}
        every = (one for row in case.rows_of(index) for one in (*row.overruled, row))
        rows = sorted(every, key=lambda row: order.get(row.span, len(order)))
        again = [(row, first) for row in rows if (first := seen.setdefault(row.joint, row)).span != row.span]
        raises = not has_last(config.framework, case.versions)
        then = (
            "the cfg raises an error"
            if raises
            else "in Isaac Lab 2.x the last group wins, 3.0 raises an error"
        )
        # Patterns that take too much are one fault of the file, however many groups they meet.
        groups = list(dict.fromkeys(row.actuator for row, _ in again))
        before = list(dict.fromkeys(first.actuator for _, first in again))
        selects = "selects a joint" if len(groups) == 1 else "select joints"
        has = "has" if len(before) == 1 else "have"
        alike = not raises and all(_alike(first, row) for row, first in again)
        joints = {name: {row.joint for row in rows if row.actuator == name} for name in (*groups, *before)}
        earlier = {joint for name in before for joint in joints[name]}
        # A group of some of the joints that others have is there to replace what those say.
        replaces = not raises and all(joints[name] < earlier for name in groups)
        severity = Severity.WARNING if alike else self.severity
        if replaces:
            # Whoever names it is told: Isaac Lab 3.0 raises an error.
            severity = Severity.INFO if case.is_met(index) else Severity.WARNING
        told: set[str] = set()
        for row, first in again:
            if row.joint in told:
                continue
            told.add(row.joint)
            yield Finding(
                self.code,
                f"{_named(groups)} {selects} that {_named(before)} {has} already: {then}",
                row.span,
                row.joint,
                help="let the patterns of the groups exclude each other",
                related=(first.span,),
                severity=severity,
                about=" ".join((*groups, *before)),
                # What another file says against the group that has the joint is no fault of a group that replaces it.
                fields=() if replaces else _apart(first, row),
            )

    def _crowded(self, case: Case, index: int) -> Iterator[Finding]:
        """Actuators of an MJCF on a joint that has one already, while the one that they are meant for has none."""
        for found in case.once(crowded):
            if found.artifact != index:
                continue
            side = f", while {found.side} has one" if found.side else ""
            yield Finding(
                self.code,
                f"a second {found.actuator.tag or 'actuator'} drives this joint, and none drives {found.lone}{side}",
                found.actuator.span,
                found.joint,
                help=f'did you mean joint="{found.lone}"?',
                related=(found.first.span,),
                severity=Severity.WARNING,
                confidence=Confidence.MEDIUM,
                noted_in_folders=True,
                about=found.lone,
                # Both together give the joint's figures.
                fields=_FIELDS,
            )


def _named(groups: Sequence[str]) -> str:
    *others, last = groups
    return f"groups {', '.join(others)} and {last}" if others else f"group {last}"


_FIELDS = (
    "kp",
    "kd",
    "effort_limit",
    "velocity_limit",
    "armature",
    "stall_torque",
    "no_load_speed",
)


def _alike(one: LedgerRow, other: LedgerRow) -> bool:
    """Whether it does not matter which of the two counts."""
    return one.control == other.control and not _apart(one, other)


def _apart(one: LedgerRow, other: LedgerRow) -> tuple[str, ...]:
    """The figures of a joint that two groups do not have alike."""
    return tuple(field for field in _FIELDS if getattr(one, field) != getattr(other, field))
