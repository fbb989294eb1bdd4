"""RobotView: what a robot file says, read without changing or running anything.

A view is plain data. It also carries the bytes of the files that it was read from, so that a
target can edit the author's text without going back to the disk.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

from actspec.diagnostics import Diagnostic, Span
from actspec.joints import InertiaRange, JointKind

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


NAMELESS = "MuJoCo Model"
"""MuJoCo's name for a model without one."""


class ModelFormat(str, Enum):
    """Format of a robot file."""

    MJCF = "mjcf"
    URDF = "urdf"
    NONE = "none"
    """No model: the spec lists the joints."""


@dataclass(frozen=True, slots=True)
class ModelFile:
    """One file of a model.

    Attributes:
        path: Path on disk, as reached from the user's argument.
        include: The text of the `<include file=...>` attribute that named it; "" for the main file.
        data: Its bytes.
    """

    path: str
    include: str
    data: bytes


@dataclass(frozen=True, slots=True)
class JointView:
    """One joint as the file (through classes, includes and units) has it.

    Attributes:
        name: Name; joints without a name are left out of a view's `joints`.
        kind: hinge, slide, ball or free.
        span: Line of the element in the author's file.
        body: Name of the body (MJCF) or child link (URDF).
        dof: Index of its first velocity in the mass matrices; -1 when there are none.
        range: Position range [rad or m]; None: unlimited.
        damping: Linear passive damping in force [N*m*s/rad or N*s/m].
        damping_polynomial: Coefficients of w|w| and w^3 (MuJoCo 3.7 and later).
        stiffness: Passive stiffness in force [N*m/rad or N/m].
        armature: [kg*m^2 or kg].
        frictionloss: Dry friction [N*m or N].
        effort_range: `actuatorfrcrange`, or -+ URDF effort [N*m or N]; None: no limit.
        velocity_limit: URDF velocity [rad/s or m/s]; None: the file does not say.
        stated: Which of `damping`, `armature`, `frictionloss`, `effort`, `velocity`, `range`, `axis` the file
            states, itself or by a default class; the others are the engine's defaults.
        springdamper: Whether `springdamper` is in force and overwrites stiffness and damping.
        mimic: Joint that this one follows (URDF); None.
        reference_position: Position in the reference pose (first keyframe, else qpos0) [rad or m].
        parent: The named joint that it hangs on, over fixed bodies; "" for a joint of the base, which a free joint
            moves.
        places: Name in `stated` to the element that states it (of a default class, or a part of a URDF's
            joint); the others are at `span`.
        unknown: Fields whose value neither the text nor, without its meshes, the compiled model tells; what stands
            in them means nothing.
        axis: Its direction in the frame of the robot's base in the pose in which the file draws it, of length 1; None:
            unknown, or it has none.
        point: A point on that axis, in the same frame and pose [m]; None: unknown, or it has none.
        tree: Number of the body whose frame that is: joints of one have it in one frame; 0 in a URDF, None where
            nobody knows.
        zero_inertia: M_jj and 1/(M^-1)_jj at qpos0, armature included [kg*m^2 or kg], of a compiled hinge or
            slide; None: unknown.
    """

    name: str
    kind: JointKind
    span: Span
    body: str
    dof: int = -1
    range: tuple[float, float] | None = None
    damping: float = 0.0
    damping_polynomial: tuple[float, float] = (0.0, 0.0)
    stiffness: float = 0.0
    armature: float = 0.0
    frictionloss: float = 0.0
    effort_range: tuple[float, float] | None = None
    velocity_limit: float | None = None
    stated: frozenset[str] = frozenset()
    springdamper: bool = False
    mimic: str | None = None
    reference_position: float = 0.0
    parent: str = ""
    places: Mapping[str, Span] = field(default_factory=dict)
    unknown: frozenset[str] = frozenset()
    axis: tuple[float, float, float] | None = None
    point: tuple[float, float, float] | None = None
    tree: int | None = None
    zero_inertia: tuple[float, float] | None = None

    @property
    def spring(self) -> float | None:
        """Passive stiffness, wherever it pulls to; None: unknown."""
        return None if "stiffness" in self.unknown else self.stiffness


@dataclass(frozen=True, slots=True)
class ActuatorView:
    """One actuator of an MJCF, classified.

    Attributes:
        name: Name; "" when it has none.
        index: Position in the model's actuator order.
        span: Line of the element.
        tag: XML tag: `position`, `motor`, `general`, ...; "" when unknown.
        transmission: `joint`, `jointinparent`, `tendon`, `site`, `body` or `slidercrank`.
        target: Name of the joint, tendon, site or body.
        control: `position`, `velocity`, `motor`, `dcmotor`, `pid`, `intvelocity`, `damper`, `plugin`
            or `other`.
        gear: First gear number.
        kp: Stiffness at the joint, gear included [N*m/rad]; 0 when it has none.
        kd: Drive velocity gain at the joint, gear included [N*m*s/rad]; 0 when it has none.
        gain: gainprm[0] as compiled; for a motor, force per control.
        force_range: `forcerange` as in the file, actuator side; None: unlimited.
        control_range: `ctrlrange` in force; None: unlimited, or the file switches `clampctrl` off.
        input_range: Range in force of what the gain multiplies: the control, or the activation that it fills
            (`actrange`); None: unlimited.
        damping: Actuator-level damping (linear, quadratic, cubic), actuator side; zeros before 3.7.
        armature: Actuator-level armature, actuator side.
        time_constant: Filter time constant of the activation [s]; 0 without.
        delay: [s]; 0 without.
        group: Actuator group.
        offset: Constant force beside gain and feedback, actuator side [N*m or N].
        line: Torque-speed line of a dcmotor at the joint, gear included: (stall torque [N*m],
            no-load speed [rad/s]); None for others, and where no voltage limits it or it has more
            than a PD (an integral, states, cogging).
        back_emf: Part of `kd` that is back-EMF of a dcmotor in voltage or passive mode; 0 for others.
        stated: Attributes that the element or its default class states, by their names in the file.
        places: Attribute to the default class's element that states it; the others are at `span`.
        unknown: Fields whose value the text alone does not tell, velocity gains that follow the mass of a missing
            mesh, and gains that the control or a plugin decides on; what stands in them means nothing.
        disabled: Whether the file's `option` switches it off: it gives no force, but its damping and
            armature stay. Source: MuJoCo 3.7, 3.11 and 4.0, measured.
        moves: Joints that feel its force over a tendon, a site or a crank; None: it may be any of the file's.
    """

    name: str
    index: int
    span: Span
    tag: str
    transmission: str
    target: str
    control: str
    gear: float
    kp: float
    kd: float
    gain: float
    force_range: tuple[float, float] | None
    control_range: tuple[float, float] | None
    input_range: tuple[float, float] | None
    damping: tuple[float, float, float]
    armature: float
    time_constant: float
    delay: float
    group: int
    offset: float = 0.0
    line: tuple[float, float] | None = None
    back_emf: float = 0.0
    stated: frozenset[str] = frozenset()
    places: Mapping[str, Span] = field(default_factory=dict)
    unknown: frozenset[str] = frozenset()
    disabled: bool = False
    moves: tuple[str, ...] | None = ()

    @property
    def is_direct(self) -> bool:
        """Whether it drives a joint, and not a tendon, a site or a body."""
        return self.transmission in ("joint", "jointinparent")

    @property
    def is_filled(self) -> bool:
        """Whether its force is an activation alone, which the control fills over time."""
        known = not {"kp", "kd", "gain"} & self.unknown
        return self.control == "other" and self.kp == self.kd == 0.0 and known

    @property
    def input(self) -> str:
        """What its `input_range` is the range of: `control` or `activation`."""
        if self.input_range != self.control_range:
            return "activation"
        integrated = self.control in ("intvelocity", "other") and self.tag != "cylinder"
        return "activation" if integrated and not {"kp", "kd"} & self.unknown else "control"

    @property
    def is_scaled(self) -> bool | None:
        """Whether a servo makes another position or speed of its control than itself; None: unknown.

        So one is commanded in degrees, by a byte or by an action.
        """
        if self.control not in ("position", "velocity"):
            return False
        name = "kp" if self.control == "position" else "kd"
        if not self.gear or {name, "gain", "offset", "gear"} & self.unknown:
            # These two elements have one number for both.
            return False if self.tag in ("position", "velocity") else None
        feedback: float = getattr(self, name) / self.gear**2
        # Of a position an offset alone is an encoder's: the servo is commanded in what that reads.
        moved = self.control == "velocity" and bool(self.offset)
        return moved or not math.isclose(self.gain, feedback, rel_tol=0.01)


@dataclass(frozen=True, slots=True)
class PoseInertia:
    """Mass matrices of the robot at its reference pose and at sampled poses, armature left out.

    Attributes:
        matrices: Shape (n_pose, nv, nv); the first is the reference pose. [kg*m^2, kg, kg*m]
        armature: The file's own armature, shape (nv,), actuator armature included.
    """

    matrices: NDArray[np.float64]
    armature: NDArray[np.float64]

    def held(self, armature: Mapping[int, float]) -> dict[int, InertiaRange]:
        """M_jj with the other joints held, armature included.

        Args:
            armature: Degree of freedom to the armature it is to have; others keep the file's.

        Returns: degree of freedom to its inertia over the poses, for every key of `armature`.
        """
        import numpy as np

        diagonal = self.matrices.diagonal(axis1=1, axis2=2)
        with np.errstate(all="ignore"):
            values = diagonal[:, list(armature)] + list(armature.values())
        return dict(zip(armature, pose_ranges(values), strict=True))

    def free(self, armature: Mapping[int, float]) -> dict[int, InertiaRange]:
        """1/(M^-1)_jj with the other joints free, armature included; see `held`."""
        import numpy as np

        full = self.armature.copy()
        for dof, value in armature.items():
            full[dof] = value
        # Inertias of 1e300 kg*m^2 have inverses of 0, and are infinite then.
        with np.errstate(all="ignore"):
            total = self.matrices + np.diag(full)
            try:
                inverse = np.linalg.inv(total)
            except np.linalg.LinAlgError:
                # Two joints on one axis without armature: nothing resists, and the inertia is 0.
                least = 1e-12 * max(float(np.abs(total).max(initial=0.0)), 1e-300)
                inverse = np.linalg.inv(total + least * np.eye(len(full)))
            diagonal = inverse.diagonal(axis1=1, axis2=2)
            values = np.reciprocal(diagonal[:, list(armature)])
        return dict(zip(armature, pose_ranges(values), strict=True))


@dataclass(frozen=True, slots=True)
class JointInertia:
    """Inertia of one joint over the poses, armature included [kg*m^2 or kg].

    Attributes:
        held: M_jj with the other joints held.
        free: 1/(M^-1)_jj with the other joints free.
    """

    held: InertiaRange
    free: InertiaRange


def pose_ranges(values: NDArray[np.float64]) -> list[InertiaRange]:
    """Range of each column over the poses, from values of shape (n_pose, n); the first is the reference."""
    columns = (values[0].tolist(), values.min(axis=0).tolist(), values.max(axis=0).tolist())
    return [InertiaRange(*column) for column in zip(*columns, strict=True)]


@dataclass(frozen=True, slots=True)
class RobotView:
    """A robot file, read.

    Attributes:
        name: The model's name.
        path: Path of the main file.
        format: MJCF, URDF or none.
        joints: Named joints in the robot's order.
        actuators: Actuators in the model's order (MJCF).
        timestep: The file's step [s]; None when the format has none.
        integrator: MuJoCo's name, e.g. `Euler`, `implicitfast`; "" when the format has none.
        keyframes: Names of the keyframes, in order ("" for one without a name).
        inertia: Mass matrices over poses; None when they cannot be known without the meshes, say.
        inertia_reason: Why `inertia` is None; "" otherwise.
        files: The main file first, then its includes in order.
        diagnostics: Warnings of the reader.
        eulerdamp: Whether the Euler integrator takes joint damping implicitly (MuJoCo's flag).
        joint_inertia: Inertia of each hinge and slide with the file's armature; None: not taken.
        actuation: Whether the file leaves actuators on at all (MuJoCo's flag).
        off_groups: Actuator groups that the file switches off.
        refusal: Why MuJoCo does not take the file, whose numbers then come from the text alone; None: it does.
        refused_at: Where it met that; None: it does not say.
        packages: ROS package to its folder, as the spec has them.
        mass: Of all links of the robot together, without objects beside it [kg]; None: unknown.
        uncompiled: Whether a compilation would tell more, of inertia above all.
        pose_at: Where the first keyframe is written; None: there is none, or nobody knows.
        coupled: Joints that an equality or a closed loop couples with others, so that they do not move alone (MJCF).
        pose: Where joints stand in place of the reference pose's on a bench [rad or m]; no file says it.
    """

    name: str
    path: str
    format: ModelFormat
    joints: tuple[JointView, ...]
    actuators: tuple[ActuatorView, ...] = ()
    timestep: float | None = None
    integrator: str = ""
    keyframes: tuple[str, ...] = ()
    inertia: PoseInertia | None = None
    inertia_reason: str = ""
    files: tuple[ModelFile, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    eulerdamp: bool = True
    joint_inertia: Mapping[str, JointInertia] | None = None
    actuation: bool = True
    off_groups: frozenset[int] = frozenset()
    refusal: str | None = None
    refused_at: Span | None = None
    packages: Mapping[str, str] = field(default_factory=dict)
    coupled: frozenset[str] = frozenset()
    mass: float | None = None
    pose_at: Span | None = None
    uncompiled: bool = False
    pose: Mapping[str, float] = field(default_factory=dict)

    def joint(self, name: str) -> JointView | None:
        """The joint of that name, or None."""
        return next((j for j in self.joints if j.name == name), None)

    def keyframe_position(self, joint: JointView) -> float | None:
        """Position of one of its joints in the first keyframe [rad or m]; None: there is none, or nobody knows."""
        known = self.keyframes and "reference_position" not in joint.unknown
        return joint.reference_position if known else None

    @property
    def scalar_joints(self) -> tuple[JointView, ...]:
        """The named hinges and slides, in the robot's order."""
        return tuple(joint for joint in self.joints if joint.kind.is_scalar)

    @property
    def loose_actuators(self) -> tuple[ActuatorView, ...]:
        """The actuators that drive no named hinge or slide directly."""
        scalar = {joint.name for joint in self.scalar_joints}
        return tuple(a for a in self.actuators if not (a.is_direct and a.target in scalar))

    def inertias(self) -> Mapping[str, JointInertia]:
        """Inertia of each hinge and slide with the file's own armature; none without mass matrices. Takes long."""
        if self.joint_inertia is not None:
            return self.joint_inertia
        if self.inertia is None:
            return {}
        joints = [joint for joint in self.scalar_joints if joint.dof >= 0]
        armature = {joint.dof: joint.armature for joint in joints}
        dofs = {joint.name: joint.dof for joint in joints}
        for actuator in self.actuators:
            if actuator.is_direct and actuator.target in dofs:
                armature[dofs[actuator.target]] += actuator.gear**2 * actuator.armature
        held, free = self.inertia.held(armature), self.inertia.free(armature)
        return {name: JointInertia(held[dof], free[dof]) for name, dof in dofs.items()}


def isaac_order(robot: RobotView, wanted: Sequence[str]) -> tuple[str, ...] | None:
    """Joints as Isaac Lab has them: breadth-first over the tree; None where no model tells the tree.

    Joints of one parent go by name. Fixed joints count for nothing, as after the importer's
    `merge_fixed_joints`.

    Args:
        robot: The robot.
        wanted: Joints to give.

    Source:
        Breadth-first: isaac-sim/IsaacLab#37 ("parsing of joints in Isaac Sim is done in a breadth-first
        order"). By name: the URDF importer reads with urdfdom, which keeps joints in a map by name; so Isaac
        Lab's A1 and Go2 begin with FL, FR, RL, RR and its ANYmal with LF, LH, RF, RH, where their URDFs
        begin with FR, FL and with LF, RF. A USD from another importer may differ.
    """
    if robot.format is ModelFormat.NONE:
        return None
    below: dict[str, list[str]] = {}
    for joint in robot.joints:
        below.setdefault(joint.parent, []).append(joint.name)
    free = {joint.name for joint in robot.joints if joint.kind is JointKind.FREE}
    found = []
    queue = deque([""])
    while queue:
        for name in sorted(below.pop(queue.popleft(), ())):
            queue.append(name)
            if name not in free:
                found.append(name)
    kept = set(wanted)
    order = tuple(name for name in found if name in kept)
    return order if len(order) == len(kept) else None


def joints_above(robots: Iterable[RobotView]) -> dict[str, frozenset[str]]:
    """Each joint with those between it and the base, as the first of the robot's files that has it says."""
    found: dict[str, frozenset[str]] = {}
    for robot in robots:
        parents = {joint.name: joint.parent for joint in robot.joints}
        for name, parent in parents.items():
            chain: list[str] = []
            while parent in parents and parent not in chain:
                chain.append(parent)
                parent = parents[parent]
            found.setdefault(name, frozenset(chain))
    return found
