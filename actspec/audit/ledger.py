"""The ledger: what acts on each joint, per actuator and file, in SI units at the joint.

One row per actuator; a joint without an actuator has one row of control `none`. Fields of the joint
(its passive part, limit, totals, frequency) repeat in each of its rows. None is unknown, never zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from actspec.diagnostics import Span
from actspec.joints import JointKind

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
        stall_torque: Torque-speed line at zero speed; None without a line.
        no_load_speed: Torque-speed line at zero torque; None without a line.
        armature: Joint and actuator armature together.
        inertia_min: Least inertia over the poses, other joints held, armature included.
        inertia_max: Largest likewise.
        inertia_free_min: Least with the other joints free.
        natural_frequency: sqrt(kp of all actuators / inertia at the reference pose) [rad/s].
        damping_ratio: total_damping / (2 sqrt(kp inertia)) at the reference pose [-].
        stability: h * Kd / inertia_free_min, with the damping that is integrated explicitly [-].
        delay: Of the command [s].
        command_range: Clamp of the command; None: no clamp.
        position_range: The joint's own range; None: unlimited or unknown.
        action_scale: Command unit per action unit.
        default_position: Default pose.
        places: Field to where it is written, for fields that have a place of their own.
        stated: Fields that the file states itself; the others are an engine's default or computed.
    """

    file: str
    artifact: int
    span: Span
    joint: str
    actuator: str
    control: str
    drives: str = ""
    kind: JointKind | None = None
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
    natural_frequency: float | None = None
    damping_ratio: float | None = None
    stability: float | None = None
    delay: float | None = None
    command_range: tuple[float, float] | None = None
    position_range: tuple[float, float] | None = None
    action_scale: float | None = None
    default_position: float | None = None
    places: Mapping[str, Span] = field(default_factory=dict)
    stated: frozenset[str] = frozenset()

    def place(self, name: str) -> Span:
        """Where a field is written; the row's own place when it has none."""
        return self.places.get(name, self.span)
