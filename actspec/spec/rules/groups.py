"""Rules of `actuators`: what a group needs as a whole."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from actspec.spec.models import Actuators, Motor, SpecModel
from actspec.spec.paths import Path
from actspec.spec.rules.breaches import Breaches, check_pattern
from actspec.spec.rules.gears import may_be_linked
from actspec.spec.rules.joint_fields import IDENTIFY, check_joint_fields
from actspec.spec.rules.randomization import check_randomize
from actspec.spec.values import SpecValue


def check_group(name: str, group: Actuators, model: SpecModel, breaches: Breaches) -> None:
    """A group, its overrides and its randomisation."""
    path: Path = ("actuators", name)
    motors = model.motors
    # Whether every joint of the group is in a linkage is seen when its joints are known.
    linked = may_be_linked(group.joints, model.linkages)
    for index, pattern in enumerate(group.joints):
        check_pattern(pattern, (*path, "joints", index), breaches)
    check_joint_fields(path, group, group, motors, breaches, linked=linked)
    for pattern, override in group.overrides.items():
        check_pattern(pattern, (*path, "overrides", pattern), breaches, key=True)
        check_joint_fields((*path, "overrides", pattern), override, group, motors, breaches, linked=linked)
    if group.level == "actuator_net" and group.network is None:
        breaches.error(
            "SPEC140",
            "level actuator_net needs `network`",
            path,
            "write network: {file: ..., manifest: ...}",
        )
    if group.level != "actuator_net" and group.network is not None:
        breaches.error(
            "SPEC140",
            f"`network` is for level actuator_net, this group is {group.level}",
            (*path, "network"),
        )
    if group.level == "dc_motor":
        _check_dc_motors(path, group, motors, breaches, linked=linked)
    for field, entry in group.randomize.items():
        at = (*path, "randomize", field)
        check_randomize(at, field, entry, breaches)
        if entry.from_ is not None and group.identified is None:
            breaches.error(
                "SPEC146", "asks for the identified range, but the group names no results", at, IDENTIFY
            )


def _check_dc_motors(
    path: Path, group: Actuators, motors: Mapping[str, Motor], breaches: Breaches, *, linked: bool
) -> None:
    """Level dc_motor needs the torque-speed line of every motor in the group."""
    used = [(group.motor, path)]
    for pattern, override in group.overrides.items():
        if override.motor is not None:
            used.append((override.motor, (*path, "overrides", pattern)))
    for name, at in used:
        if name is None and linked:
            continue
        if name is None:
            breaches.error(
                "SPEC147",
                "level dc_motor needs a `motor` with its torque-speed line",
                at,
                "add a motor with stall_torque and no_load_speed (or curve), or use level ideal_pd",
            )
            continue
        motor = motors.get(name)
        if motor is None:
            continue
        for field, value, place in _line_of(name, motor):
            if value is not None and value.value is not None:
                continue
            breaches.error(
                "SPEC147",
                f"level dc_motor needs {field} of the motor '{name}', which is "
                f"{'not stated' if value is None else 'unknown'}",
                at if value is None else place,
                "state it (or `curve`), or use level ideal_pd"
                if motor.curve is None
                else "state it, or use level ideal_pd",
            )


def _line_of(name: str, motor: Motor) -> Iterator[tuple[str, SpecValue | None, Path]]:
    """Figures of a motor's torque-speed line: name, what is stated, where."""
    path: Path = ("motors", name)
    if motor.curve is None:
        for field in ("stall_torque", "no_load_speed"):
            yield field, getattr(motor, field), (*path, field)
    else:
        for field in ("drive_torque", "brake_torque", "knee_speed", "no_load_speed"):
            yield field, getattr(motor.curve, field), (*path, "curve", field)
