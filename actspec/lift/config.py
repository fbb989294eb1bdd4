"""A training or deploy configuration as an ActuatorSet.

A configuration speaks in patterns; the joints that they mean come from a robot file, or from the patterns
themselves where each is a name.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Sequence

from actspec.diagnostics import listed, one_line
from actspec.ir import ActuatorSet, JointActuator, Quantity, Randomization, stated, unknown
from actspec.lift.config_joint import ConfigJoint, below_root, drive_kind
from actspec.lift.lifted import LeftAlone, Lifted
from actspec.patterns import PatternError, compile_pattern
from actspec.readings.artifact import ActuatorGroup, Artifact, Framework, RandomizedRange, RobotConfig
from actspec.readings.config import selected
from actspec.readings.dict_keys import plain_name
from actspec.readings.joint_names import joint_names, matching
from actspec.readings.overlap import has_last
from actspec.readings.versions import Versions, friction_unit_of, is_native, meant_for
from actspec.robot.view import JointView

_DRIVES = ("implicit", "ideal_pd", "dc_motor", "network", "position", "velocity", "motor", "pid")
"""Controls of the ledger for which the law has words."""

_RANDOMIZED = {
    "kp": "kp",
    "kd": "kd",
    "armature": "armature",
    "friction": "friction.coulomb",
    "joint_damping": "friction.viscous",
    "effort_limit": "effort_limit",
    "strength": "strength",
    "encoder_bias": "encoder_bias",
}
"""Field of a range as the audit names it to the spec's name; others a spec does not have."""

_WHEN = {"prestartup": "startup", "startup": "startup", "reset": "reset", "interval": "interval"}
"""Mode of an event to the spec's word; any other, and none, is a reset. Chosen: what most ranges are drawn at."""


def lift_config(
    artifact: Artifact,
    joints: Sequence[JointView | str] | None = None,
    *,
    versions: Versions | None = None,
    physics_dt: float | None = None,
) -> Lifted:
    """What a configuration says of a robot's actuators.

    Args:
        artifact: With a `config`.
        joints: The robot's joints, in its order, names alone where no robot file has them; None: those that the
            configuration names itself.
        versions: What it is written for; what a field means may depend on it. None: what its head says, where
            actspec wrote it.
        physics_dt: The simulation's step [s], for delays in steps, where the configuration does not say; None:
            nobody does.
    """
    config = artifact.config
    assert config is not None
    versions = meant_for(versions or Versions(), artifact)
    views: dict[str, JointView | None] = {}
    for one in joints or ():
        if isinstance(one, str):
            views[one] = None
        elif one.kind.is_scalar:
            views[one.name] = one
    named = tuple(views) or joint_names(artifact) or _plain_names(config)
    members: dict[str, list[tuple[ActuatorGroup, str]]] = {}
    for group in config.groups:
        for joint, pattern in selected(config, group, named):
            members.setdefault(joint, []).append((group, pattern))
    own_step = _time(config, "physics_dt")
    found: list[JointActuator] = []
    alone: list[LeftAlone] = []
    notes: dict[str, list[str]] = {}
    for name in named:
        chosen = members.get(name, [])
        view = views.get(name)
        why = _unsupported(config, chosen, view, versions)
        if why is not None:
            alone.append(LeftAlone(name, why, chosen[-1][0].span if chosen else config.span))
            continue
        *earlier, (group, pattern) = chosen
        step = own_step.value or physics_dt
        drive = ConfigJoint(config, group, name, pattern, named, view, versions, step, earlier)
        found.append(drive.actuator(_randomizations(config, name, named)))
        said = [*_overlapping(chosen), *drive.notes]
        if said:
            notes[name] = said
    if not views:
        alone += _unnamed(config, named)
    whole = [*_whole(config, versions)]
    if found and not any(views.values()):
        whole.append(
            "no robot file states the kinds of the joints: all are taken as hinges; a joint that slides is "
            "{name: NAME, kind: slide} in robot.joints of the spec, with a group of its own: --joints with the robot's "
            "URDF does both"
        )
        if asset := asset_of(config):
            whole.append(f"the configuration reads {one_line(asset)}: name it too")
    if whole:
        notes[""] = whole
    return Lifted(
        ActuatorSet(
            robot=config.name,
            joints=tuple(found),
            unmanaged=tuple(item.joint for item in alone),
            physics_dt=own_step,
            decimation=_decimation(config),
            control_dt=_time(config, "control_dt"),
            diagnostics=config.unrolled.notes,
        ),
        tuple(alone),
        {name: tuple(said) for name, said in notes.items()},
    )


def _unsupported(
    config: RobotConfig,
    chosen: Sequence[tuple[ActuatorGroup, str]],
    view: JointView | None,
    versions: Versions,
) -> str | None:
    """Why a joint cannot be described by its groups and its robot file, if that is at hand; None when it can."""
    if view is not None and view.mimic is not None:
        return f"follows '{one_line(view.mimic)}' (mimic)"
    if not chosen:
        return "no group of the configuration selects it"
    if len(chosen) > 1 and not has_last(config.framework, versions):
        return f"{len(chosen)} groups select it: {', '.join(one_line(group.name) for group, _ in chosen)}"
    group = chosen[-1][0]
    cls = one_line(group.cls)
    control = drive_kind(config.framework, group)
    if config.framework is Framework.LEGGED_GYM and control == "velocity":
        return "control_type V: its gains act on speeds and accelerations"
    if leaves_to_model(config.framework, group):
        return f"{cls} leaves it to the model's own actuator"
    if control == "dcmotor":
        return f"the gains of {cls} are in volts"
    if control not in _DRIVES and group.unread is not None:
        return not_read([group])
    if control not in _DRIVES:
        return f"an actuator of another kind ({cls})"
    return None


def not_read(groups: Sequence[ActuatorGroup]) -> str:
    """Why classes of one module are not known; at least one group, whose class is `unread`."""
    module = one_line(groups[0].unread or "")
    classes = list(dict.fromkeys(one_line(group.cls) for group in groups))
    are = f"{listed(classes)} {'is a class' if len(classes) == 1 else 'are classes'} of {module}"
    if groups[0].of_run:
        return f"{are}, and a run's file says nothing of what a class does"
    return f"{are}, whose file, {file_of(module)}, is not there"


def file_of(module: str) -> str:
    """The file of a module that is not there, from where its package is."""
    return f"{one_line(module.replace('.', '/'))}.py"


def leaves_to_model(framework: Framework, group: ActuatorGroup) -> bool:
    """Whether a group takes the actuator that the robot's MJCF has, whose figures no configuration states."""
    return framework is Framework.MJLAB and "xml" in group.cls.lower()


def _randomizations(config: RobotConfig, joint: str, named: tuple[str, ...]) -> tuple[Randomization, ...]:
    """The ranges of a joint that a spec has words for, in the author's order."""
    return tuple(
        Randomization(
            _RANDOMIZED[one.field],
            one.operation,
            one.low,
            one.high,
            one.distribution,
            _WHEN.get(one.when, "reset"),
            one.every,
            "joint",
            one.span,
        )
        for one in config.randomize
        if one.field in _RANDOMIZED and _concerns(config.framework, one, joint, named)
    )


def _concerns(framework: Framework, one: RandomizedRange, joint: str, named: tuple[str, ...]) -> bool:
    """Whether a range is for a joint; one by names of actuators is where mjlab gives them the joints' names."""
    patterns = one.joints if one.joints is not None else one.actuators
    if patterns is None:
        return True
    # mjlab and Isaac Lab match ranges as they match groups; legged_gym has no patterns here.
    style = Framework.MJLAB if framework is Framework.LEGGED_GYM else framework
    return joint in named and any(matching(style, pattern, (joint,)) for pattern in patterns)


def asset_of(config: RobotConfig) -> str | None:
    """The robot file that a configuration reads, where that is an MJCF or URDF that is there."""
    path = config.model
    if path is None or not path.lower().endswith((".xml", ".urdf")):
        return None
    if "\0" in path:
        return None
    return path if os.path.isfile(path) else below_root(path, config.span.path)


def _plain_names(config: RobotConfig) -> tuple[str, ...]:
    """Joints that the configuration names one by one, in the author's order."""
    found: dict[str, None] = {}
    for group in config.groups:
        for pattern in group.joints or ():
            name = plain_name(config.framework, pattern)
            if name is not None:
                found[name] = None
    return tuple(found)


def _unnamed(config: RobotConfig, named: Sequence[str]) -> Iterator[LeftAlone]:
    """Patterns of joints that nobody names."""
    why = "a pattern, and no file names the joints: name the robot's MJCF or URDF too"
    for group in config.groups:
        for pattern in group.joints or ():
            plain = plain_name(config.framework, pattern) is not None
            if not plain and not matching(config.framework, pattern, named):
                yield LeftAlone(pattern, why, group.span)


def _overlapping(chosen: Sequence[tuple[ActuatorGroup, str]]) -> Iterator[str]:
    if len(chosen) > 1:
        names = ", ".join(one_line(group.name) for group, _ in chosen)
        yield f"several groups have the joint ({names}): as in Isaac Lab 2.x the last counts, over what others state"


def _whole(config: RobotConfig, versions: Versions) -> Iterator[str]:
    """Remarks on the whole configuration."""
    for group in config.groups:
        if group.joints is None:
            yield f"group {one_line(group.name)}: which joints it is for could not be read"
        yield from _refused(config, group)
    count = _decimation(config)
    if count is not None and not (_time(config, "physics_dt").known or _time(config, "control_dt").known):
        own = " (5 ms in legged_gym's own)" if config.framework is Framework.LEGGED_GYM else ""
        yield (
            f"decimation {count} counts physics steps whose length it does not state{own}: it is left out, and no "
            f"control rate is written; state both, timing: {{physics_dt: ..., decimation: {count}}}"
        )
    if config.framework is not Framework.ISAACLAB:
        return
    fields = ("friction", "dynamic_friction", "viscous_friction")
    frictions = [s for g in config.groups for name in fields if (s := g.settings.get(name)) is not None]
    if friction_unit_of(versions) is None and any(s.value for s in frictions):
        yield (
            "friction is left unknown: what it means depends on the versions of Isaac Lab and Isaac Sim (of 3.0 on the "
            f"backend); {_lacking(versions)}"
        )


def _lacking(versions: Versions) -> str:
    """What to state of the versions that tell what friction means, and how."""
    native = versions.isaaclab is not None and is_native(versions)
    asked = {
        "the version of Isaac Lab": (versions.isaaclab, "-t isaaclab==2.3"),
        "the backend": (versions.backend if native else "", "-t backend==newton"),
        "the version of Isaac Sim": (versions.isaac_sim if not native else "", "-t isaac_sim==5.1"),
    }
    lacking = {name: option for name, (stated, option) in asked.items() if stated is None}
    if not lacking:
        return "those stated do not tell it"
    return f"state {' and '.join(lacking)}, such as {' '.join(lacking.values())}"


def _refused(config: RobotConfig, group: ActuatorGroup) -> Iterator[str]:
    """Patterns that select nothing because they are refused."""
    if config.framework not in (Framework.ISAACLAB, Framework.MJLAB):
        return
    for pattern in group.joints or ():
        try:
            compile_pattern(pattern)
        except PatternError as err:
            yield f"group {one_line(group.name)}: {err.message}, so it selects no joint"


def _time(config: RobotConfig, name: str) -> Quantity:
    setting = config.settings.get(name)
    if setting is None:
        return unknown("s")
    step = setting.number
    if step is None or not 0.0 < step < math.inf:
        return unknown("s", setting.unknown or "the file has no time above 0", setting.span)
    return stated(step, "s", setting.span)


def _decimation(config: RobotConfig) -> int | None:
    setting = config.settings.get("decimation")
    number = None if setting is None else setting.number
    return int(number) if number is not None and 1 <= number < math.inf and number.is_integer() else None
