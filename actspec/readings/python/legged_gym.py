"""legged_gym-style configurations: a class with nested classes `control`, `init_state`, `asset`, `sim`.

A key of `stiffness` and `damping` selects every joint whose name contains it; keys stay as written.
Source: https://github.com/leggedrobotics/legged_gym, legged_gym/envs/base/legged_robot.py, `_process_dof_props`.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from actspec.readings.artifact import NETWORK, PHYSX, ActuatorGroup, Framework, RobotConfig, Setting
from actspec.readings.config import IN_FIGURES
from actspec.readings.python.settings import Draft, known, setting
from actspec.readings.python.values import Cls, Unknown, Value, ancestors, reason_of

Get = Callable[[Cls, str], "Value | None"]
"""An attribute of a class or of its bases; None when no class that is read has it."""

_PD_SWITCHES = ("randomize_kpkd", "randomize_pd_gain", "randomize_pd_gains")

_RANGES = (
    ("strength", "scale", "motor_strength_range", ("randomize_motor", "randomize_motor_strength")),
    ("kp", "scale", "kp_range", (*_PD_SWITCHES, "randomize_kp")),
    ("kd", "scale", "kd_range", (*_PD_SWITCHES, "randomize_kd")),
    ("kp", "scale", "Kp_factor_range", ("randomize_Kp_factor",)),
    ("kd", "scale", "Kd_factor_range", ("randomize_Kd_factor",)),
    ("kp", "scale", "stiffness_multiplier_range", ("randomize_gains", "randomize_pd_gains")),
    ("kd", "scale", "damping_multiplier_range", ("randomize_gains", "randomize_pd_gains")),
    ("encoder_bias", "add", "motor_offset_range", ("randomize_motor_offset",)),
)
"""Field, operation, name in `domain_rand`, and the switches that turn it on; only names with one meaning.

Source: Improbable-AI/walk-these-ways and forks of legged_gym (`domain_rand` of their cfgs).
"""


_PHYSX_DRIVES = (1, 2)
"""`default_dof_drive_mode` of positions and of velocities: PhysX integrates the drive, and no torque is set."""


_TORQUES = ("P", "V", "T")
"""`control_type` of legged_gym: from positions, from velocities, as they are."""

_GROUP = ("stiffness", "damping", "control_type", "actuator_net_file")

_CONTROL = frozenset((*_GROUP, "use_actuator_network", "action_scale", "decimation"))
"""What `control` of legged_gym has; all else is a fork's own, such as the torque limits at which it clips.

Source: legged_gym, legged_robot_config.py and anymal_c_rough_config.py.
"""

_OWN_ARMATURE = re.compile("armature|(?:rotor|motor|actuator|dof|joint|reflected)_?inertia", re.IGNORECASE)
"""Names by which forks have an armature of their own: `dof_armature`, `rotor_inertia`. Other inertias are of links."""


def is_robot(cls: Cls, get: Get) -> bool:
    """Whether a class is a robot's cfg: it has `control` with gains, and names an asset if it names any."""
    control = _inner(cls, "control", get)
    if control is None or not any(get(control, name) is not None for name in ("stiffness", "damping")):
        return False
    asset = _inner(cls, "asset", get)
    # The base class of a framework has an empty `file` and gains of joints that no robot has.
    return asset is None or known(get(asset, "file")) != ""


def robot(cls: Cls, get: Get) -> RobotConfig:
    """A robot's cfg."""
    draft = Draft()
    control = _inner(cls, "control", get)
    assert control is not None, "is_robot"
    for name in ("decimation", "action_scale"):
        draft.set(name, get(control, name))
    for name, inner, attribute in (
        ("physics_dt", "sim", "dt"),
        ("default_position", "init_state", "default_joint_angles"),
        ("model", "asset", "file"),
    ):
        found = _inner(cls, inner, get)
        if found is not None:
            draft.set(name, get(found, attribute), "file" if name == "model" else "")
    _group(draft, cls, control, get)
    _ranges(draft, cls, get)
    for base in cls.bases:
        if not isinstance(base, Cls):
            draft.note(cls.name, f"what it inherits: {reason_of(base)}", cls.span)
    return draft.config(Framework.LEGGED_GYM, cls.name, cls.span)


def _inner(cls: Cls, name: str, get: Get) -> Cls | None:
    found = get(cls, name)
    return found.data if found is not None and isinstance(found.data, Cls) else None


def _group(draft: Draft, cls: Cls, control: Cls, get: Get) -> None:
    values = {name: get(control, name) for name in _GROUP}
    asset = _inner(cls, "asset", get)
    if asset is not None:
        values["armature"] = _armature(cls, asset, control, get)
    settings: dict[str, Setting] = {}
    for name, value in values.items():
        if value is not None:
            # Half a path finds no network.
            is_file = name.endswith("_file") and not isinstance(value.data, Unknown)
            held = settings[name] = setting(value, "network_file" if is_file else name)
            where = f"{'asset' if name == 'armature' else 'control'}.{name}"
            if held.unknown is not None:
                draft.note(where, held.unknown, held.span)
            elif name in IN_FIGURES:
                # Forks take lists of their own.
                settings[name] = draft.figure(where, held, certain=not isinstance(held.value, tuple))
    gains = [settings[name].value for name in ("stiffness", "damping") if name in settings]
    joints = dict.fromkeys(joint for gain in gains if isinstance(gain, dict) for joint in gain)
    certain = all(isinstance(gain, dict) for gain in gains)
    kind = settings.pop("control_type", None)
    cls_name = kind.value if kind is not None and isinstance(kind.value, str) else ""
    mode = None if asset is None else get(asset, "default_dof_drive_mode")
    if mode is not None and mode.data in _PHYSX_DRIVES:
        cls_name = PHYSX
    network = get(control, "use_actuator_network")
    if network is not None and network.data is True and not _is_chosen(control, cls_name):
        # The gains are not used then.
        cls_name = NETWORK
    patterns = tuple(joints) if certain else None
    own = tuple(name for name in _names(control) if name not in _CONTROL)
    draft.groups.append(ActuatorGroup("control", cls_name, control.span, patterns, settings, own=own))


def _names(cls: Cls) -> dict[str, None]:
    """What a class and those that it inherits have, each once."""
    return dict.fromkeys(name for one in ancestors(cls) if isinstance(one, Cls) for name in one.scope.names)


def _is_chosen(control: Cls, kind: str) -> bool:
    """Whether the class that has the network chose a torque beside it: the P that legged_gym's ANYmal C inherits is
    nobody's choice, and a fork's own `control_type` says what it runs."""
    words = {"control_type", "use_actuator_network"}
    stated = (words & one.scope.names.keys() for one in ancestors(control) if isinstance(one, Cls))
    return kind in _TORQUES and "control_type" in next(filter(None, stated), ())


def _armature(cls: Cls, asset: Cls, control: Cls, get: Get) -> Value | None:
    """`asset.armature`, unknown where joints have another: forks draw one in its place, add to it or multiply it, or
    set one by a name of their own."""
    domain = _inner(cls, "domain_rand", get)
    switch = None if domain is None else get(domain, "randomize_joint_armature")
    if switch is not None and switch.data is not False:
        return Value(Unknown("domain_rand.randomize_joint_armature draws another"), switch.span)
    for where, block in (("asset", asset), ("control", control)):
        for name in _names(block):
            own = get(block, name) if _OWN_ARMATURE.search(name) and name != "armature" else None
            # A fork's base has `dof_armature = []` where robots have theirs.
            if own is not None and known(own) not in ((), []) and own.data is not False:
                return Value(Unknown(f"{where}.{name} may be in its place"), own.span)
    return get(asset, "armature")


def _ranges(draft: Draft, cls: Cls, get: Get) -> None:
    domain = _inner(cls, "domain_rand", get)
    if domain is None:
        return
    for field, operation, name, switches in _RANGES:
        value = get(domain, name)
        if value is None:
            continue
        found = [switch for switch in (get(domain, one) for one in switches) if switch is not None]
        unknown = next((reason_of(switch.data) for switch in found if reason_of(switch.data)), None)
        if unknown is not None:
            draft.note(f"domain_rand.{name}", f"whether it is in force: {unknown}", value.span)
        elif all(switch.data for switch in found):
            if operation == "scale" and _is_below_zero(value):
                # Some forks add what others multiply by; no strength is negative.
                draft.note(f"domain_rand.{name}", "its ends are no factors", value.span)
            else:
                draft.range(field, value, operation, None)


def _is_below_zero(value: Value) -> bool:
    """Whether an end of a range is."""
    ends = known(value)
    return isinstance(ends, (list, tuple)) and any(isinstance(end, (int, float)) and end < 0 for end in ends)
