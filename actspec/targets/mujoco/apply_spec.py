"""The plan applied through MjSpec: the authority on what the edited model is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from actspec.ir import Command
from actspec.simulators.mujoco import DcMotorDialect, MujocoDialect
from actspec.targets.mujoco.actuator_xml import GENERAL_INPUTS, controller, general_form, needs_general
from actspec.targets.mujoco.drive import VOLTAGE, Drive, Form
from actspec.targets.mujoco.plan import JointEdit, Plan

if TYPE_CHECKING:
    import mujoco

VECTORS = (
    "gear",
    "ctrlrange",
    "forcerange",
    "actrange",
    "lengthrange",
    "dynprm",
    "gainprm",
    "biasprm",
    "damping",
)
SCALARS = (
    "ctrllimited",
    "forcelimited",
    "actlimited",
    "actearly",
    "dyntype",
    "gaintype",
    "biastype",
    "cranklength",
    "inheritrange",
    "armature",
    "delay",
    "nsample",
    "interp",
    "actdim",
    "ctrlspec",
    "type",
)
"""Fields of an actuator that a class may have set; some are missing in older bindings."""


def apply_to_spec(
    spec: mujoco.MjSpec, plan: Plan, dialect: MujocoDialect, note: str, *, explicit: bool = False
) -> None:
    """Edit a spec in place.

    Args:
        spec: From `open_spec`, uncompiled.
        plan: The edits.
        dialect: That of the installed MuJoCo.
        note: Put on each element that is edited, so that the engine's errors name it.
        explicit: Write `<general>`, as `actuator_xml` does, because the main default class holds an
            actuator whose numbers a shortcut would inherit.
    """
    import mujoco

    if plan.timestep is not None:
        spec.option.timestep = plan.timestep
    if plan.integrator is not None:
        spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{plan.integrator.upper()}")
    joints = {joint.name: joint for joint in spec.joints}
    for edit in plan.joints:
        _edit_joint(joints[edit.joint], edit, note)
    actuators = list(spec.actuators)
    for entry in plan.replaced:
        element = actuators[entry.index]
        _forget_class(element, spec.default.actuator)
        _write(element, entry.drive, dialect, note, explicit)
    for sensor in spec.sensors:
        if sensor.objtype == mujoco.mjtObj.mjOBJ_ACTUATOR and sensor.objname in plan.renamed:
            sensor.objname = plan.renamed[sensor.objname]
    for group in spec.tuples:
        # A tuple whose actuator is deleted would go with it.
        for index, (kind, name) in enumerate(zip(group.objtype, list(group.objname), strict=True)):
            if int(kind) == int(mujoco.mjtObj.mjOBJ_ACTUATOR) and name in plan.renamed:
                group.objname[index] = plan.renamed[name]
    gone = [actuators[index] for index in plan.removed]
    for element in gone:
        spec.delete(element)
    for entry in plan.replaced:
        # After the deletion: an unnamed one takes the name of one that goes.
        if actuators[entry.index].name != entry.drive.name:
            actuators[entry.index].name = entry.drive.name
    for drive in plan.added:
        element = spec.add_actuator()
        element.name = drive.name
        _forget_class(element, spec.default.actuator)
        _write(element, drive, dialect, note, explicit)
    keys = list(spec.keys)
    for key in plan.keys:
        if key.ctrl is not None:
            keys[key.index].ctrl = list(key.ctrl)
        if key.act is not None:
            keys[key.index].act = list(key.act)
    if not plan.holds_act(dialect):
        for element in keys:
            element.act = []


def _edit_joint(joint: Any, edit: JointEdit, note: str) -> None:
    import mujoco

    joint.info = f"{joint.info} ({note})" if joint.info else note
    if edit.springdamper_off:
        joint.springdamper = [0.0, 0.0]
    if edit.damping is not None:
        for power, value in enumerate(edit.damping):
            joint.damping[power] = value
    if edit.stiffness is not None:
        joint.stiffness[0] = edit.stiffness
    if edit.armature is not None:
        joint.armature = edit.armature
    if edit.frictionloss is not None:
        joint.frictionloss = edit.frictionloss
    if edit.effort is not None:
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_TRUE if hasattr(mujoco, "mjtLimited") else 1
        joint.actfrcrange = [-edit.effort, edit.effort]


def _forget_class(element: Any, default: Any) -> None:
    """Give an actuator the values that it would have without a class: those of the main default."""
    for name in VECTORS:
        getattr(element, name)[:] = getattr(default, name)
    for name in SCALARS:
        if hasattr(default, name):
            setattr(element, name, getattr(default, name))
    element.userdata = list(default.userdata)


def _write(element: Any, drive: Drive, dialect: MujocoDialect, note: str, explicit: bool) -> None:
    """Write every number of a drive."""
    import mujoco

    element.info = f"{element.info} ({note})" if element.info else note
    element.trntype = mujoco.mjtTrn.mjTRN_JOINT
    element.target = drive.joint
    element.refsite = element.slidersite = ""
    limit = drive.effort_limit
    # First: a dcmotor corrects its constant for a damping of its own.
    element.damping[:] = 0.0
    element.armature = 0.0
    if drive.form is Form.DCMOTOR:
        _write_dcmotor(element, drive, dialect)
    else:
        if explicit or needs_general(drive):
            if dialect.general_input:
                element.type = mujoco.mjtActuator.mjACTUATOR_GENERAL
                keyword = GENERAL_INPUTS.get(drive.form) if explicit else None
                if keyword is not None:
                    element.ctrlspec = int(getattr(mujoco.mjtCtrlInput, f"mjINPUT_{keyword.upper()}"))
        elif drive.form is Form.POSITION:
            element.set_to_position(kp=drive.kp, kv=drive.kd)
        elif drive.form is Form.VELOCITY:
            element.set_to_velocity(kv=drive.kd)
        else:
            element.set_to_motor()
        form = general_form(drive)
        element.dyntype = getattr(mujoco.mjtDyn, f"mjDYN_{form.dyntype.upper()}")
        element.gaintype = getattr(mujoco.mjtGain, f"mjGAIN_{form.gaintype.upper()}")
        element.biastype = getattr(mujoco.mjtBias, f"mjBIAS_{form.biastype.upper()}")
        for name, numbers in (("dynprm", form.dynprm), ("gainprm", form.gainprm), ("biasprm", form.biasprm)):
            getattr(element, name)[:] = [*numbers, *([0.0] * (10 - len(numbers)))]
        element.actlimited = element.actearly = 0
        element.forcelimited = 0 if limit is None else 1
        element.forcerange = [0.0, 0.0] if limit is None else [-limit, limit]
    if not explicit or drive.form is Form.DCMOTOR:
        # A `<general>` has no word for it and takes that of the main default, for a viewer's slider.
        element.inheritrange = 0.0
    element.gear[0] = 1.0
    element.ctrllimited = 1 if drive.control_limited else 0
    element.ctrlrange = list(drive.control_range or (0.0, 0.0))
    element.delay = drive.delay
    element.nsample = drive.delay_steps
    element.group = drive.group
    if drive.user:
        element.userdata = list(drive.user)


def _write_dcmotor(element: Any, drive: Drive, dialect: MujocoDialect) -> None:
    import mujoco

    numbers = controller(drive, dialect)
    limit = drive.effort_limit
    # 1 is "position" before 3.12; from then on the bit of each control input.
    mode: dict[str, int] = {"input_mode": 1}
    if dialect.dcmotor is DcMotorDialect.TORQUE:
        bit = {
            Command.POSITION: mujoco.mjtCtrlInput.mjINPUT_POS,
            Command.VELOCITY: mujoco.mjtCtrlInput.mjINPUT_VEL,
            Command.EFFORT: mujoco.mjtCtrlInput.mjINPUT_FF,
        }[drive.command]
        mode = {"ctrlspec": int(bit)}
    element.set_to_dcmotor(
        motorconst=[0.0, 0.0],
        resistance=0.0,
        nominal=list(numbers.nominal),
        saturation=[0.0 if limit is None else limit, 0.0, 0.0],
        controller=[numbers.kp, 0.0, numbers.kd, 0.0, 0.0, VOLTAGE],
        **mode,
    )
