"""The edit plan: what changes in an MJCF, as data that both the MjSpec and the text follow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed
from actspec.ir import ActuatorSet, Command, JointActuator, assumed
from actspec.laws.stability import LIMIT, StepDrive
from actspec.readings.joint import JointReading, read_joints
from actspec.resolution.quantities import Reports
from actspec.robot.view import ActuatorView, JointView, ModelFormat, RobotView
from actspec.simulators import text_of
from actspec.simulators.mujoco import POLYNOMIALS, MujocoDialect
from actspec.targets.base import Approximation
from actspec.targets.kit.joint import delta_action_loss, own_number, unknown_passive, warn_unknown_armature
from actspec.targets.mujoco.drive import Drive, Form, drive_of
from actspec.units import format_number, format_quantity

if TYPE_CHECKING:
    import mujoco

    from actspec.robot.xml_tree import XmlDocument


@dataclass(frozen=True, slots=True)
class JointEdit:
    """New passive values of a joint; None leaves the file's.

    Attributes:
        joint: Name.
        damping: (linear, quadratic, cubic) passive viscous coefficients.
        armature: [kg*m^2 or kg].
        frictionloss: [N*m or N].
        stiffness: Written only where `springdamper` goes out of force.
        effort: `actuatorfrcrange` becomes -+ this [N*m or N].
        springdamper_off: Take `springdamper` out of force.
    """

    joint: str
    damping: tuple[float, float, float] | None = None
    armature: float | None = None
    frictionloss: float | None = None
    stiffness: float | None = None
    effort: float | None = None
    springdamper_off: bool = False

    @property
    def empty(self) -> bool:
        """Whether nothing changes."""
        return self == JointEdit(self.joint)


@dataclass(frozen=True, slots=True)
class Replaced:
    """An actuator of the file that becomes a drive, in its place and under its name."""

    index: int
    drive: Drive


@dataclass(frozen=True, slots=True)
class KeyEdit:
    """New `ctrl` and `act` of a keyframe, whole vectors; None leaves the file's."""

    index: int
    ctrl: tuple[float, ...] | None
    act: tuple[float, ...] | None


@dataclass(frozen=True, slots=True)
class Plan:
    """All edits of one model.

    Attributes:
        joints: Edits of joints, in the robot's order.
        replaced: Actuators that become drives.
        removed: Indices of actuators that go, because another drives the joint already.
        added: Drives of joints that had no actuator, appended in the robot's joint order.
        renamed: Removed actuator's name to that of its joint's drive, for sensors.
        timestep: New `option/timestep` [s]; None leaves the file's.
        integrator: New `option/integrator`; None leaves the file's.
        keys: Edits of keyframes.
        dcmotors: Whether the edited model has a dcmotor.
    """

    joints: tuple[JointEdit, ...] = ()
    replaced: tuple[Replaced, ...] = ()
    removed: tuple[int, ...] = ()
    added: tuple[Drive, ...] = ()
    renamed: dict[str, str] = field(default_factory=dict)
    timestep: float | None = None
    integrator: str | None = None
    keys: tuple[KeyEdit, ...] = ()
    dcmotors: bool = False

    def holds_act(self, dialect: MujocoDialect) -> bool:
        """Whether the edited model's keyframes can hold activations in a version."""
        return dialect.keyframe_act or not self.dcmotors

    @property
    def drives(self) -> tuple[Drive, ...]:
        """All drives, in the file's actuator order, added ones last."""
        return (*(r.drive for r in self.replaced), *self.added)


def plan_model(
    actuators: ActuatorSet, robot: RobotView, dialect: MujocoDialect, target: str, collector: Collector
) -> tuple[Plan, tuple[Approximation, ...]]:
    """Plan all edits but those of keyframes (`with_keys` adds them, from the compiled model), with what they lose."""
    step = actuators.physics_dt.require()
    names = {a.name for a in robot.actuators}
    lost: list[Approximation] = []
    joint_edits: list[JointEdit] = []
    replaced: list[Replaced] = []
    removed: list[int] = []
    added: list[Drive] = []
    renamed: dict[str, str] = {}
    reports = Reports()
    readings = read_joints(robot)
    if not robot.actuation:
        collector.at("", Span(robot.path)).error(
            "MJC026",
            'the file switches all actuators off (option/flag actuation="disable"): no drive would give a force',
            "remove the flag from the model",
        )
    for actuator in actuators.joints:
        joint = robot.joint(actuator.joint)
        assert joint is not None
        reading = readings[joint.name]
        # One that gives a force is replaced before one that the file switches off.
        own = tuple(drive.view for drive in sorted(reading.drives, key=lambda one: not one.is_on))
        result = drive_of(actuator, joint, reading, dialect, step, target, collector, reports)
        if result is None:
            continue
        drive, losses = result
        lost += losses
        if own:
            # The first's name; without one the next, so that sensors have something to point to.
            name = next((a.name for a in own if a.name), "")
            drive = replace(
                drive, name=name, group=_group_on(robot, own[0].group, drive, own[0].span, collector)
            )
            replaced.append(Replaced(own[0].index, drive))
            _note_replaced(own, drive, collector)
            for other in own[1:]:
                removed.append(other.index)
                if other.name and other.name != drive.name:
                    renamed[other.name] = drive.name
        else:
            if drive.name in names:
                collector.at(joint.name, next(a.span for a in robot.actuators if a.name == drive.name)).error(
                    "MJC002",
                    f"the actuator of '{joint.name}' would have the joint's name, but another actuator has it",
                    "rename the other actuator",
                )
            added.append(replace(drive, group=_group_on(robot, 0, drive, joint.span, collector)))
        joint_edits.append(_joint_edit(actuator, joint, own, dialect, robot.inertia_reason, collector))
    reports.tell(collector)
    units = [a.armature.unit for a in actuators.joints if a.armature.value is None]
    kept = f"MuJoCo takes what the file has, else 0 {units[0] if units else ''}"
    warn_unknown_armature(actuators, target, "MJC016", kept, collector)
    lost += unknown_passive(actuators, target, "MuJoCo", partial(_acting, robot, readings))
    timestep = None
    if robot.timestep is not None and step != robot.timestep:
        timestep = step
        collector.at("timing.physics_dt", actuators.physics_dt.span).info(
            "MJC010",
            f"option/timestep becomes {format_number(step)} s, the file has {format_number(robot.timestep)} s",
        )
    lost += delta_action_loss(
        actuators, target, "MuJoCo runs no network: wrap the environment with the runtime"
    )
    gone = {entry.index for entry in replaced} | set(removed)
    dcmotors = any(a.control == "dcmotor" and a.index not in gone for a in robot.actuators)
    plan = Plan(
        joints=tuple(edit for edit in joint_edits if not edit.empty),
        replaced=tuple(sorted(replaced, key=lambda r: r.index)),
        removed=tuple(sorted(removed)),
        added=tuple(added),
        renamed=renamed,
        timestep=timestep,
        dcmotors=dcmotors or any(d.form is Form.DCMOTOR for d in (*(r.drive for r in replaced), *added)),
    )
    return plan, tuple(lost)


def _acting(robot: RobotView, readings: Mapping[str, JointReading], joint: str, name: str) -> str:
    """What MuJoCo takes for a number that the spec says is unknown; `name`: of armature or a friction."""
    if robot.format is ModelFormat.NONE:
        return "the including model's own"
    reading = readings[joint]
    own = {
        "armature": reading.armature,
        "friction_coulomb": reading.frictionloss,
        "friction_viscous": reading.friction_viscous,
    }[name]
    if robot.format is ModelFormat.URDF and own.value is None:
        own = assumed(0.0, own.unit, "a URDF cannot say it")
    return own_number(own, "the file's", "MuJoCo's default")


def integrator_for(
    actuators: ActuatorSet, robot: RobotView, document: XmlDocument, collector: Collector
) -> str | None:
    """`implicitfast` where nobody chose an integrator and the file's default is too coarse for a drive; else None.

    From h kd/I + h^2 kp/(2 I) = 1 on, the speed changes its sign with every step of Euler, which takes kd explicitly.
    """
    if any(option.get("integrator") is not None for option in document.sections("option")):
        return None
    step = actuators.physics_dt.require()
    drives, figures = {}, {}
    for actuator in actuators.joints:
        kd = None if actuator.kd is None else actuator.kd.value
        least = None if actuator.inertia_free is None else actuator.inertia_free.low
        if kd is None or kd <= 0.0 or least is None or least <= 0.0:
            continue
        kp = None if actuator.kp is None else actuator.kp.value
        passive = max(actuator.friction_viscous.value or 0.0, 0.0)
        drives[actuator.joint] = StepDrive(step, kp or 0.0, kd, passive)
        figures[actuator.joint] = drives[actuator.joint].figure(least)
    worst = max(figures, key=figures.__getitem__, default=None)
    if worst is None or figures[worst] < 1.0:
        return None
    needing = [joint for joint, figure in figures.items() if figure >= 1.0]
    collector.at("option/integrator", Span(robot.path)).info(
        "MJC028",
        "becomes implicitfast: the file states none, and Euler takes kd explicitly, too coarsely for "
        f"{listed(needing)} ({drives[worst].formula} = {format_number(figures[worst], 3)} at {worst}, limit {LIMIT:g})",
        'to keep it, state `<option integrator="Euler"/>`, in a URDF `<mujoco><option integrator="Euler"/></mujoco>`',
    )
    return "implicitfast"


def _group_on(robot: RobotView, group: int, drive: Drive, span: Span, collector: Collector) -> int:
    """The group that a drive gets: that of the actuator that it replaces, unless the file switches that off."""
    if group not in robot.off_groups:
        return group
    on = next(number for number in range(32) if number not in robot.off_groups)
    collector.at(drive.joint, span).warning(
        "MJC027",
        f"'{drive.name}' gets group {on}: the file switches group {group} off (option actuatorgroupdisable), and the "
        "drive would give no torque",
        "add the joint to robot.unmanaged if its drive is to stay off",
    )
    return on


def _note_replaced(own: tuple[ActuatorView, ...], drive: Drive, collector: Collector) -> None:
    first = own[0]
    if len(own) > 1:
        collector.at(drive.joint, own[1].span).warning(
            "MJC011",
            f"'{drive.joint}' had {len(own)} actuators ({', '.join(a.name or '(no name)' for a in own)}), it gets one: "
            "the number of controls changes",
            f"send the command to '{drive.name}'",
        )
    if first.gear != 1.0:
        collector.at(drive.joint, first.span).warning(
            "MJC012",
            f"'{first.name}' had gear {format_number(first.gear)}, it gets 1: its control and its sensors are in joint "
            "units now",
        )


def _joint_edit(
    actuator: JointActuator,
    joint: JointView,
    own: tuple[ActuatorView, ...],
    dialect: MujocoDialect,
    weightless: str,
    collector: Collector,
) -> JointEdit:
    """What changes at the joint itself; `weightless`: why the robot's inertia is unknown."""
    place, viscous = collector.at(joint.name, joint.span), actuator.friction_viscous.value
    folded = [0.0, 0.0, 0.0]
    for a in own:
        # MuJoCo takes gear^2 for every power, measured from 3.7 to 4.0: gear 3, 1 N*m*s^2/rad^2, 2 rad/s give 36 N*m.
        for power in range(3):
            folded[power] += a.gear**2 * a.damping[power]
    linear = viscous if viscous is not None else joint.damping + folded[0]
    damping = (linear, joint.damping_polynomial[0] + folded[1], joint.damping_polynomial[1] + folded[2])
    current = (joint.damping, *joint.damping_polynomial)
    if any(damping[1:]):
        if not dialect.polynomials:
            place.error(
                "MJC003",
                f"'{joint.name}' has polynomial damping, which MuJoCo {dialect.text} cannot hold",
                f"compile for MuJoCo {text_of(POLYNOMIALS)} or later, or remove the second and third number",
            )
        if viscous is not None and actuator.friction_viscous.origin.value in ("authored", "identified"):
            place.warning(
                "MJC013",
                f"'{joint.name}' keeps its polynomial damping ({format_number(damping[1])} w|w|, "
                f"{format_number(damping[2])} w^3) beside "
                f"friction.viscous {format_quantity(viscous, actuator.friction_viscous.unit)}",
            )
    armature = actuator.armature.value
    own_armature = sum(a.gear**2 * a.armature for a in own)
    if armature is None:
        armature = joint.armature + own_armature
    coulomb = actuator.friction_coulomb.value
    limit = actuator.effort_limit.value
    effort = None
    if limit is not None and joint.effort_range is not None:
        low, high = joint.effort_range
        if low > -limit or high < limit:
            effort = limit
    edit = JointEdit(
        joint=joint.name,
        damping=damping if damping != current else None,
        armature=armature if armature != joint.armature else None,
        frictionloss=coulomb if coulomb is not None and coulomb != joint.frictionloss else None,
        effort=effort,
    )
    if joint.springdamper and "stiffness" in joint.unknown:
        # It stays in force, unless a number is to stand in its place.
        if viscous is not None or any(folded):
            place.error(
                "MJC025",
                f"'{joint.name}' has a springdamper in force, which would overwrite friction.viscous; its stiffness "
                f"cannot be written in its place: {weightless}",
                "put the mesh files there, or write stiffness and damping in the model instead of springdamper",
            )
        edit = replace(edit, damping=None)
    elif joint.springdamper:
        # In force it would overwrite what is written, and follow the armature.
        place.info(
            "MJC020",
            f"'{joint.name}' has a springdamper in force; it is written out of force, with the stiffness "
            f"{format_number(joint.stiffness)} and the viscous friction {format_number(damping[0])} that it stood for",
        )
        edit = replace(edit, damping=damping, stiffness=joint.stiffness, springdamper_off=True)
    return edit


def with_keys(plan: Plan, robot: RobotView, model: mujoco.MjModel, settles: frozenset[str]) -> Plan:
    """Add the keyframes' new controls and activations to a plan.

    A keyframe's control stays where its meaning stays; where a control's kind or gear changed, and
    for added ones, it becomes the keyframe's joint position (0 for velocity and effort). The
    activation of a filtered drive is its control.

    Args:
        plan: The other edits.
        robot: The robot.
        model: The original model, compiled.
        settles: Joints whose actuator in the file had the same kind and gear.
    """
    keys = []
    by_index = {r.index: r.drive for r in plan.replaced}
    for index in range(model.nkey):
        ctrl: list[float] = []
        act: list[float] = []
        for actuator in range(len(robot.actuators)):
            if actuator in plan.removed:
                continue
            drive = by_index.get(actuator)
            if drive is None:
                ctrl += _controls(model, index, actuator)
                act += _activations(model, index, actuator)
                continue
            value = (
                _controls(model, index, actuator)[0]
                if drive.joint in settles
                else _resting(drive, model, index)
            )
            ctrl.append(value)
            act += [value] if drive.time_constant else []
        for drive in plan.added:
            value = _resting(drive, model, index)
            ctrl.append(value)
            act += [value] if drive.time_constant else []
        old_ctrl = [float(x) for x in model.key_ctrl[index]]
        old_act = [float(x) for x in model.key_act[index]]
        key = KeyEdit(
            index,
            tuple(ctrl) if ctrl != old_ctrl else None,
            tuple(act) if act != old_act else None,
        )
        if key.ctrl is not None or key.act is not None:
            keys.append(key)
    return replace(plan, keys=tuple(keys))


def _resting(drive: Drive, model: mujoco.MjModel, key: int) -> float:
    if drive.command is not Command.POSITION:
        return 0.0
    import mujoco

    joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, drive.joint)
    return float(model.key_qpos[key][model.jnt_qposadr[joint]])


def _controls(model: mujoco.MjModel, key: int, actuator: int) -> list[float]:
    """Controls of one actuator; from 3.11 on it may have none or several."""
    address = getattr(model, "actuator_ctrladr", None)
    if address is None:
        return [float(model.key_ctrl[key][actuator])]
    start, count = int(address[actuator]), int(model.actuator_ctrlnum[actuator])
    return [float(x) for x in model.key_ctrl[key][start : start + count]]


def _activations(model: mujoco.MjModel, key: int, actuator: int) -> list[float]:
    start, count = int(model.actuator_actadr[actuator]), int(model.actuator_actnum[actuator])
    return [] if start < 0 else [float(x) for x in model.key_act[key][start : start + count]]


def unchanged_controls(plan: Plan, robot: RobotView) -> frozenset[str]:
    """Joints whose control means the same as before: same kind, gear 1 before and after."""
    kinds = {
        Command.POSITION: ("position", "dcmotor", "pid"),
        Command.VELOCITY: ("velocity",),
        Command.EFFORT: ("motor",),
    }
    same = set()
    for entry in plan.replaced:
        actuator = robot.actuators[entry.index]
        if actuator.gear == 1.0 and actuator.control in kinds[entry.drive.command]:
            if actuator.control == "motor" and actuator.gain != 1.0:
                continue
            # A dcmotor without stiffness is commanded in volts.
            if actuator.control == "dcmotor" and actuator.kp == 0.0:
                continue
            same.add(entry.drive.joint)
    return frozenset(same)
