"""Rules, one a module, named by its code, with its page beside it. Those that need actuators alone run in `compile`."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from actspec.diagnostics import Diagnostic, Severity, listed
from actspec.ir import ActuatorSet

if TYPE_CHECKING:
    from actspec.audit.case import Case
    from actspec.audit.finding import Finding
    from actspec.audit.rule import Rule


@cache
def all_rules() -> tuple[type[Rule], ...]:
    """Every rule, by code."""
    files = (path.name for path in Path(__file__).parent.iterdir())
    return tuple(_rule_in(name[:-3]) for name in sorted(files) if re.fullmatch(r"[a-z]{3}\d{3}\.py", name))


def _rule_in(name: str) -> type[Rule]:
    """The rule of a module: the class that has its name as code."""
    from actspec.audit.rule import Rule

    (rule,) = (
        found
        for found in vars(import_module(f"{__name__}.{name}")).values()
        if isinstance(found, type)
        and issubclass(found, Rule)
        and getattr(found, "code", None) == name.upper()
    )
    return rule


def check_actuators(
    actuators: ActuatorSet, explicit: Mapping[str, Collection[str]]
) -> tuple[Diagnostic, ...]:
    """What the rules that need no other file say of a spec that is compiled: one a rule and group, its worst.

    FRC101 and FRC106 are not among them: `resolve` has judged friction before (`actspec.spec.plausible`).

    Args:
        actuators: What is compiled.
        explicit: What it is compiled to, in words, to the joints whose drive is explicit there: those of MuJoCo
            under the Euler integrator, and the torque classes of Isaac Lab and mjlab under any.
    """
    from actspec.audit.finding import Finding
    from actspec.audit.rules.dmp101 import DriveAndJointDamping
    from actspec.audit.rules.stb102 import ExplicitDrive

    case = case_of(actuators, explicit)
    rules = (DriveAndJointDamping, ExplicitDrive)
    found = [item for rule in rules for item in rule().check(case) if isinstance(item, Finding)]
    return tuple(_worst(actuators, found, {rule.code: rule.severity for rule in rules}))


def case_of(actuators: ActuatorSet, explicit: Mapping[str, Collection[str]]) -> Case:
    """A spec alone as the rules and the ledger see it; arguments as of `check_actuators`."""
    from actspec.audit.case import Case
    from actspec.readings.artifact import Artifact, FileKind, Robot
    from actspec.readings.ledger import rows_of_spec

    artifact = Artifact("", FileKind.SPEC, actuators.robot, spec=actuators)
    robot = Robot(actuators.robot, (0,))
    return Case((), (artifact,), rows_of_spec(artifact, 0), (robot,), explicit=explicit)


def _worst(
    actuators: ActuatorSet, found: list[Finding], severities: Mapping[str, Severity]
) -> Iterator[Diagnostic]:
    """For each rule and group the finding with the largest figure, and the joints that have the same."""
    group_of = {actuator.joint: actuator.group for actuator in actuators.joints}
    groups: dict[tuple[str, str], list[Finding]] = {}
    for finding in found:
        groups.setdefault((finding.code, group_of[finding.joint]), []).append(finding)
    for (code, group), members in groups.items():
        worst = max(members, key=lambda finding: finding.value or 0.0)
        joints = [finding.joint for finding in members if finding.message == worst.message]
        where = f"actuators.{group}"
        message = f"{listed(joints)}: {worst.message}"
        span = worst.span if worst.span.path else None
        yield Diagnostic(code, worst.severity or severities[code], message, where, span, worst.help)
