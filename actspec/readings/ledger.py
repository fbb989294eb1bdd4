"""The ledger: what acts on each joint, per actuator and file, in SI units at the joint.

One row per actuator; a joint without an actuator has one row of control `none`. Fields of the joint
(its passive part, limit, totals, frequency) repeat in each of its rows. None is unknown, never zero.

Of a robot file, a joint is one row for each actuator that drives it directly, a bare one is one row of control
`none`. What drives a tendon, a site, a body, a ball or a joint without a name has a row without a joint, without
figures at a joint, after all others. How much of it reaches a joint depends on the pose: limit, total damping and
what follows from them are unknown at a joint that it moves.

A configuration speaks in patterns; which joints they mean, and the joints' inertia, come from the model that it is
paired with. Without one, each pattern is a row of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from actspec.diagnostics import Span
from actspec.fields import FIELDS, unit_of
from actspec.ir import Command, JointActuator, Level, Origin, Quantity
from actspec.joints import InertiaRange, JointKind
from actspec.readings.artifact import Artifact
from actspec.readings.drive import DriveReading, largest
from actspec.readings.joint import IMPLICIT, JointReading, read_joints
from actspec.robot.view import ActuatorView, ModelFormat, RobotView

CONTROLS = (
    "position",
    "velocity",
    "motor",
    "dcmotor",
    "pid",
    "implicit",
    "ideal_pd",
    "dc_motor",
    "network",
    "other",
    "none",
)
"""What a row's `control` can be. Source: the design, §9."""


@dataclass(frozen=True, slots=True)
class LedgerRow:
    """One actuator as one file has it. Units: [N*m, rad] for a hinge, [N, m] for a slide.

    Attributes:
        file: The file as the user named it.
        artifact: Index into `Case.artifacts`.
        span: Where the actuator (or the bare joint) is written.
        joint: Name of the joint; a pattern in a configuration whose robot is not at hand; "" for a tendon or site.
        actuator: Name of the actuator, or of the cfg group.
        control: One of `CONTROLS`.
        drives: What it drives that is no hinge or slide with a name: `tendon spine`, `site tip`; "" for a joint.
        kind: hinge or slide; None when nobody says.
        command: What its drive's command is, of a configuration or spec: `position`, `velocity` or `effort`; "" else.
        kp: Drive stiffness, gear included.
        kd: The drive's velocity gain in its linear region, gear included; back-EMF is in it.
        kd_clamped: Whether the effort limit clamps the kd torque.
        kd_implicit: Whether it is integrated implicitly; None when the file does not say.
        joint_damping: Passive viscous friction of the joint.
        joint_damping_clamped: Whether the effort limit clamps it; None when the file does not say, as a URDF, whose
            damping some importers put into the drive.
        joint_damping_implicit: Whether it is integrated implicitly; None when the file does not say.
        actuator_damping: MuJoCo's actuator-level damping at the joint (gear squared).
        actuator_damping_clamped: As of the joint's.
        actuator_damping_implicit: Likewise.
        back_emf: Part of `kd` that is back-EMF of a dcmotor in voltage or passive mode; 0 for others.
        total_damping: kd of all the joint's actuators, joint and actuator damping together.
        frictionloss: Dry friction.
        effort_limit: Least of the clamps that act on the joint; None: unknown; inf: there is none.
        velocity_limit: The joint's or solver's speed limit.
        stall_torque: Torque-speed line at zero speed, of all the joint's actuators; None without a line.
        no_load_speed: Torque-speed line at zero torque, likewise.
        armature: Joint and actuator armature together.
        inertia_min: Least inertia over the poses, other joints held, armature included.
        inertia_max: Largest likewise.
        inertia_free_min: Least with the other joints free.
        inertia_free_max: Largest likewise.
        inertia: At the reference pose, other joints held, armature included.
        natural_frequency: sqrt(k / inertia), where k is kp of all actuators and the joint's own spring together
            [rad/s].
        damping_ratio: total_damping / (2 sqrt(k inertia)) [-].
        stability: h * Kd / inertia_free_min, with the damping that is integrated explicitly [-].
        delay: Of the command [s].
        command_range: Clamp of the command; None: no clamp.
        position_range: The joint's own range; None: unlimited or unknown.
        action_scale: Command unit per action unit.
        default_position: Default pose.
        more: Other fields of `FIELDS` that a configuration has of the joint, as a range of its delay.
        by_key: Field to the numbers that a dict has of it by pattern, in its order, and where each stands, where nobody
            knows which of them are this pattern's.
        places: Field to where it is written, for fields that have a place of their own.
        stated: Fields that the file states itself; the others are an engine's default or computed.
        made: Field to what its figure at the joint is made of where the file has others: `39 x gear 100`.
        overruled: Of other groups of a configuration that have the joint too, and lose it to this one.
    """

    file: str
    artifact: int
    span: Span
    joint: str
    actuator: str
    control: str
    drives: str = ""
    kind: JointKind | None = None
    command: str = ""
    kp: float | None = None
    kd: float | None = None
    kd_clamped: bool | None = None
    kd_implicit: bool | None = None
    joint_damping: float | None = None
    joint_damping_clamped: bool | None = None
    joint_damping_implicit: bool | None = None
    actuator_damping: float | None = None
    actuator_damping_clamped: bool | None = None
    actuator_damping_implicit: bool | None = None
    back_emf: float | None = None
    total_damping: float | None = None
    frictionloss: float | None = None
    effort_limit: float | None = None
    velocity_limit: float | None = None
    stall_torque: float | None = None
    no_load_speed: float | None = None
    armature: float | None = None
    inertia_min: float | None = None
    inertia_max: float | None = None
    inertia_free_min: float | None = None
    inertia_free_max: float | None = None
    inertia: float | None = None
    natural_frequency: float | None = None
    damping_ratio: float | None = None
    stability: float | None = None
    delay: float | None = None
    command_range: tuple[float, float] | None = None
    position_range: tuple[float, float] | None = None
    action_scale: float | None = None
    default_position: float | None = None
    more: Mapping[str, float] = field(default_factory=dict)
    by_key: Mapping[str, Mapping[str, tuple[float, Span]]] = field(default_factory=dict)
    places: Mapping[str, Span] = field(default_factory=dict)
    stated: frozenset[str] = frozenset()
    made: Mapping[str, str] = field(default_factory=dict)
    overruled: tuple[LedgerRow, ...] = ()

    def place(self, name: str) -> Span:
        """Where a field is written; the row's own place when it has none."""
        return self.places.get(name, self.span)

    def unit(self, name: str) -> str:
        """SI unit of a field; a joint of unknown kind is taken for a hinge, as nearly all are."""
        return unit_of(name, self.kind, self.command)


_OF_MODEL = {name: name for name in ("position", "velocity", "motor", "dcmotor", "pid")}


def rows_of_robot(artifact: Artifact, index: int) -> tuple[LedgerRow, ...]:
    """Rows of an MJCF or URDF.

    A dcmotor's voltage is not among the clamps of a limit: it is `stall_torque` and `no_load_speed`.

    A URDF has no actuator and no armature; an effort or velocity of 0 stays 0. Damping and friction that
    a URDF does not state are 0, as in every importer.

    An actuator that the file switches off has a row of control `other` without gains; only its damping and
    armature are in the totals.

    `default_position` is the first keyframe's. The command range of a servo is in joint position or speed,
    that of a motor in torque at the joint.

    Args:
        artifact: Of kind MJCF or URDF, with its robot.
        index: Its place in `Case.artifacts`.
    """
    robot = artifact.robot
    assert robot is not None
    found = [
        row
        for reading in read_joints(robot, robot.inertias()).values()
        for row in _rows(artifact.path, index, reading, robot)
    ]
    found.extend(_loose(artifact.path, index, actuator) for actuator in robot.loose_actuators)
    return tuple(found)


_OF_ALONE = ("natural_frequency", "damping_ratio", "stability")
"""Fields that follow from a joint's own inertia where it moves alone."""


def _rows(file: str, index: int, reading: JointReading, robot: RobotView) -> list[LedgerRow]:
    """One for each actuator, or the bare joint's."""
    mjcf = reading.format is ModelFormat.MJCF
    joint, inertia = reading.joint, reading.inertia
    implicit, places = reading.is_passive_implicit, reading.places
    damping, limit = reading.total_damping, reading.effort_limit
    pose = {"default_position": robot.pose_at} if robot.pose_at is not None else {}
    shared: dict[str, Any] = {
        "file": file,
        "artifact": index,
        "span": joint.span,
        "joint": joint.name,
        "actuator": "",
        "control": "none",
        "kind": joint.kind,
        "joint_damping": reading.joint_damping.value,
        "joint_damping_clamped": False if mjcf else None,
        "joint_damping_implicit": implicit,
        "actuator_damping": 0.0 if mjcf else None,
        "actuator_damping_clamped": False if mjcf else None,
        "actuator_damping_implicit": implicit,
        "frictionloss": reading.frictionloss.value,
        "effort_limit": limit.value,
        "velocity_limit": joint.velocity_limit,
        "armature": reading.total_armature,
        **dynamics_at(
            reading.total_stiffness,
            damping,
            None if inertia is None else inertia.held,
            None if inertia is None else inertia.free,
            reading.timestep,
            reading.explicit_damping(damping),
        ),
        # What an equality couples it with moves along, and damps.
        **(dict.fromkeys(_OF_ALONE) if joint.name in robot.coupled else {}),
        "position_range": None if "range" in joint.unknown else joint.range,
        "default_position": robot.keyframe_position(joint),
        "places": {**_elsewhere(places, joint.span), **pose},
        "stated": frozenset(places),
        "made": {} if limit.formula is None else {"effort_limit": limit.formula},
    }
    if not reading.drives:
        return [LedgerRow(**shared)]
    found = (_of_drive(reading, drive, places) for drive in reading.drives)
    return [LedgerRow(**{**shared, **own, "places": {**own["places"], **pose}}) for own in found]


def _of_drive(reading: JointReading, drive: DriveReading, places: Mapping[str, Span]) -> dict[str, Any]:
    """The fields in which the row of an actuator differs from that of the bare joint."""
    view = drive.view
    # The joint's own attribute keeps its place: two places state such a field.
    places = {**drive.places, **places}
    # But of clamps the one that binds: the control range of 25 N*m, and not the joint's 60 N*m.
    bound, own = drive.bound, reading.joint_bound.value
    if bound.span is not None and bound.value is not None and own is not None and bound.value < own:
        places["effort_limit"] = drive.places.get("effort_limit", bound.span)
    if bound.value == 0.0 and "effort" not in reading.joint.stated:
        # A servo of gain 0 beside a motor applies no torque: the limit stands at the one that does.
        most = max(reading.acting, key=lambda one: one.bound.value or 0.0, default=drive)
        places["effort_limit"] = most.places.get("effort_limit", most.view.span)
    same = {
        "span": view.span,
        "actuator": view.name,
        "actuator_damping": drive.damping,
        "places": _elsewhere(places, view.span),
        "stated": frozenset(places),
    }
    if not drive.is_on:
        return {**same, "control": "other", "kp": 0.0, "kd": 0.0, "back_emf": 0.0}
    hidden = "force_range" in view.unknown or "effort_range" in reading.joint.unknown
    limit = view.force_range is not None or reading.joint.effort_range is not None
    line = reading.line
    return {
        **same,
        "control": _OF_MODEL.get(view.control, "other"),
        "kp": drive.kp.value,
        "kd": drive.kd.value,
        "kd_clamped": None if hidden else limit,
        "kd_implicit": reading.integrator in IMPLICIT if reading.integrator else None,
        "back_emf": _known(view, "back_emf"),
        "stall_torque": line[0],
        "no_load_speed": line[1],
        "delay": _known(view, "delay"),
        "command_range": drive.command_range,
    }


def _elsewhere(places: Mapping[str, Span], row: Span) -> dict[str, Span]:
    """Places that are not the row's own."""
    # Most are on the line of the row, which is then the same object, or on another line.
    return {
        name: place
        for name, place in places.items()
        if place is not row and (place.line != row.line or place != row)
    }


def _loose(file: str, index: int, actuator: ActuatorView) -> LedgerRow:
    """The row of an actuator whose joint has no name, or that drives something else."""
    return LedgerRow(
        file=file,
        artifact=index,
        span=actuator.span,
        joint="",
        actuator=actuator.name,
        control=_OF_MODEL.get(actuator.control, "other"),
        drives=f"{actuator.transmission} {actuator.target}".rstrip(),
        delay=_known(actuator, "delay"),
    )


def bound_of_command(row: LedgerRow, view: ActuatorView) -> tuple[float, float] | None:
    """What the clamp of a servo's command bounds its torque at, with the joint inside its range and at rest.

    Args:
        row: Of the actuator.
        view: The actuator.

    Returns: The gain at the joint, and how far the command is from the joint or how fast at most, whose product is the
        largest torque [N*m or N]; None where nothing bounds it.
    """
    command, kp, kd = row.command_range, row.kp, row.kd
    if command is None or kp is None or "gain" in view.unknown:
        return None
    own = row.position_range or command
    if kp > 0.0 and row.control in ("position", "dcmotor", "pid"):
        targets: tuple[float, ...] = command
    elif kp > 0.0:
        # Of a kind that is no servo, as a cylinder with a spring in it, the control is not the target.
        targets = tuple(view.gear**2 * view.gain * end / kp + view.gear * view.offset / kp for end in command)
    elif kd is not None and kd > 0.0 and row.control == "velocity":
        return kd, largest(command)
    else:
        return None
    return kp, max(abs(target - end) for target in targets for end in own)


def _known(actuator: ActuatorView, name: str) -> float | None:
    """A field of an actuator; None where the text does not tell."""
    value: float = getattr(actuator, name)
    return None if name in actuator.unknown else value


_OF_LEVEL = {Level.IDEAL_PD: "ideal_pd", Level.DC_MOTOR: "dc_motor", Level.ACTUATOR_NET: "network"}

_FIELDS = {
    name: field.ir
    for name, field in FIELDS.items()
    if field.ir in JointActuator.__dataclass_fields__
    and name in LedgerRow.__dataclass_fields__
    and name != "delay"
}
"""Field of a row to that of the actuator."""

_STATED = (Origin.AUTHORED, Origin.IDENTIFIED, Origin.DERIVED)


def rows_of_spec(artifact: Artifact, index: int) -> tuple[LedgerRow, ...]:
    """One row for each joint that the spec manages, in the robot's order.

    The spec's viscous friction is joint damping, and there is no damping at the actuator. How a target
    integrates kd the spec does not say, so there is no `stability`.

    Args:
        artifact: Of kind spec, with its actuators.
        index: Its place in `Case.artifacts`.
    """
    assert artifact.spec is not None
    return tuple(_of_spec(artifact.path, index, actuator) for actuator in artifact.spec.joints)


def _of_spec(path: str, index: int, actuator: JointActuator) -> LedgerRow:
    values: dict[str, Any] = {}
    places: dict[str, Span] = {}
    stated = set()
    quantities: dict[str, Quantity | None] = {
        field: getattr(actuator, name) for field, name in _FIELDS.items()
    }
    quantities["delay"] = actuator.delay.nominal if actuator.delay is not None else None
    if actuator.command_range is not None:
        quantities["command_range"] = actuator.command_range[0]
    for name, quantity in quantities.items():
        values[name] = quantity.value if quantity is not None else None
        if quantity is not None and quantity.origin in _STATED:
            stated.add(name)
        if quantity is not None and quantity.span is not None:
            places[name] = quantity.span
    values.pop("command_range", None)
    kp, viscous = values["kp"], values["joint_damping"]
    # With command effort there is no drive gain at all, which is not the same as an unknown one.
    kd = 0.0 if actuator.kd is None else values["kd"]
    total = None if kd is None or viscous is None else kd + viscous
    limit = values["effort_limit"]
    effort = actuator.command is Command.EFFORT
    return LedgerRow(
        file=path,
        artifact=index,
        span=actuator.span or Span(path),
        joint=actuator.joint,
        actuator=actuator.group,
        control="motor" if effort and actuator.level is Level.IDEAL_PD else _OF_LEVEL[actuator.level],
        kind=actuator.kind,
        command=actuator.command.value,
        kd_clamped=None if limit is None else math.isfinite(limit),
        joint_damping_clamped=False,
        actuator_damping=0.0,
        actuator_damping_clamped=False,
        back_emf=0.0,
        command_range=_range(actuator),
        position_range=actuator.position_range,
        places=places,
        stated=frozenset(stated),
        **dynamics_at(kp, total, actuator.inertia_held, actuator.inertia_free),
        **values,
    )


def _range(actuator: JointActuator) -> tuple[float, float] | None:
    if actuator.command_range is None:
        return None
    low, high = (end.value for end in actuator.command_range)
    return None if low is None or high is None else (low, high)


def dynamics_at(
    stiffness: float | None,
    damping: float | None,
    held: InertiaRange | None,
    free: InertiaRange | None,
    step: float | None = None,
    explicit: float | None = None,
) -> dict[str, Any]:
    """Fields that follow from the sums over what acts on a joint, and from its inertia.

    Args:
        stiffness: kp of everything that drives the joint, and its spring [N*m/rad or N/m]; None: unknown, and so are
            the others.
        damping: Gains and passive damping together [N*m*s/rad or N*s/m].
        held: Inertia with the other joints held, armature included [kg*m^2 or kg].
        free: Inertia with the other joints free, likewise.
        step: Of the integration [s].
        explicit: The part of the damping that is integrated explicitly, in the unit of `damping`.

    Returns: natural_frequency is sqrt(stiffness / inertia) [rad/s] and damping_ratio is damping / (2 sqrt(stiffness
        inertia)) [-] at the reference pose, stability is step * explicit / least free inertia [-], which is stable
        below 2.
    """
    frequency = ratio = stability = None
    if stiffness is not None and stiffness > 0.0 and held is not None and held.reference > 0.0:
        frequency = math.sqrt(stiffness / held.reference)
        ratio = None if damping is None else damping / (2.0 * math.sqrt(stiffness * held.reference))
    if step is not None and explicit is not None and free is not None and free.low > 0.0:
        stability = step * explicit / free.low
    return {
        "total_damping": damping,
        "inertia_min": None if held is None else held.low,
        "inertia_max": None if held is None else held.high,
        "inertia_free_min": None if free is None else free.low,
        "inertia_free_max": None if free is None else free.high,
        "inertia": None if held is None else held.reference,
        "natural_frequency": frequency,
        "damping_ratio": ratio,
        "stability": stability,
    }
