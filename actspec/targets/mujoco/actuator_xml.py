"""A drive as XML, in the words of one MuJoCo version."""

from __future__ import annotations

from dataclasses import dataclass

from actspec.ir import Command
from actspec.robot.xml_edit import escape_attribute, exact_number
from actspec.simulators.mujoco import DcMotorDialect, MujocoDialect
from actspec.targets.mujoco.drive import VOLTAGE, Drive, Form

GENERAL_INPUTS = {Form.POSITION: "pos", Form.VELOCITY: "vel"}
"""`input` of a `<general>`; MuJoCo has no word for a torque."""


@dataclass(frozen=True, slots=True)
class Controller:
    """Numbers of a `<dcmotor>` in one dialect.

    Attributes:
        nominal: Voltage, stall torque, no-load speed.
        kp: First controller gain, in the dialect's unit.
        kd: Third controller gain.
        keyword: Value of `input`.
    """

    nominal: tuple[float, float, float]
    kp: float
    kd: float
    keyword: str


def controller(drive: Drive, dialect: MujocoDialect) -> Controller:
    """The dcmotor's controller: exact for the law in both dialects.

    With K = V/w0 and R = K V/tau_s the motor gives (K/R)(v - K w), clipped at the torque limit.
    From 3.12 gains are torques and v = (R/K) tau_c + K w is clipped at V; from 3.7 to 3.11 gains
    are volts, v = kp_v (u - q) - kd_v w, so kp_v = kp R/K and kd_v = kd R/K - K.
    Source: measured, 3.7 to 4.0, error <= 3e-14 N*m.
    """
    assert drive.line is not None
    nominal = (VOLTAGE, drive.line.stall_torque, drive.line.no_load_speed)
    if dialect.dcmotor is DcMotorDialect.VOLTAGE:
        constant = VOLTAGE / drive.line.no_load_speed
        resistance = constant * VOLTAGE / drive.line.stall_torque
        ratio = resistance / constant
        return Controller(nominal, drive.kp * ratio, drive.kd * ratio - constant, "position")
    keyword = {Command.POSITION: "pos", Command.VELOCITY: "vel", Command.EFFORT: "ff"}[drive.command]
    return Controller(nominal, drive.kp, drive.kd, keyword)


def actuator_xml(drive: Drive, dialect: MujocoDialect, *, explicit: bool = False) -> str:
    """The actuator's element.

    Args:
        drive: What to write.
        dialect: Version to write it for.
        explicit: Write `<general>` with every array, because the file's main default class holds
            an actuator whose numbers a shortcut would inherit.
    """
    general = explicit and drive.form is not Form.DCMOTOR
    attributes: list[tuple[str, str]] = [("name", drive.name)] if drive.name else []
    attributes.append(("joint", drive.joint))
    if general or needs_general(drive):
        tag = "general"
        attributes += _general(drive, dialect, explicit)
    elif drive.form is Form.DCMOTOR:
        tag = "dcmotor"
        attributes += _dcmotor(drive, controller(drive, dialect))
    else:
        tag = drive.form.value
        attributes += _shortcut(drive)
    attributes.append(("gear", "1 0 0 0 0 0" if explicit else "1"))
    low, high = drive.control_range or (0.0, 0.0)
    attributes.append(("ctrllimited", "true" if drive.control_limited else "false"))
    if drive.control_range is not None or explicit:
        attributes.append(("ctrlrange", _numbers(low, high)))
    if tag != "dcmotor":
        limit = drive.effort_limit
        attributes.append(("forcelimited", "false" if limit is None else "true"))
        if limit is not None or explicit:
            attributes.append(("forcerange", _numbers(-(limit or 0.0), limit or 0.0)))
    if explicit and dialect.polynomials:
        attributes += [("damping", "0 0 0"), ("armature", "0")]
    if drive.delay_steps or (explicit and dialect.native_delay):
        attributes += [("delay", _numbers(drive.delay)), ("nsample", str(drive.delay_steps))]
    if drive.group or explicit:
        attributes.append(("group", str(drive.group)))
    if drive.user:
        attributes.append(("user", _numbers(*drive.user)))
    return "<" + tag + "".join(f' {name}="{escape_attribute(value)}"' for name, value in attributes) + "/>"


def _shortcut(drive: Drive) -> list[tuple[str, str]]:
    if drive.form is Form.POSITION:
        gains = [("kp", _numbers(drive.kp)), ("kv", _numbers(drive.kd))]
        return [*gains, ("timeconst", _numbers(drive.time_constant))] if drive.time_constant else gains
    if drive.form is Form.VELOCITY and not drive.time_constant:
        return [("kv", _numbers(drive.kd))]
    if drive.form is Form.MOTOR and not drive.time_constant:
        return []
    raise AssertionError("a filter on velocity and effort needs <general>")


def needs_general(drive: Drive) -> bool:
    """Whether no shortcut can hold the drive: a filter on a velocity or an effort, a constant force."""
    if drive.form is Form.DCMOTOR:
        return False
    return drive.offset != 0.0 or (drive.form is not Form.POSITION and drive.time_constant > 0.0)


@dataclass(frozen=True, slots=True)
class GeneralForm:
    """Arrays of a `<general>`: names of the types and the leading numbers of the parameters."""

    dyntype: str
    gaintype: str
    biastype: str
    dynprm: tuple[float, ...]
    gainprm: tuple[float, ...]
    biasprm: tuple[float, ...]


def general_form(drive: Drive) -> GeneralForm:
    """The drive's gain, bias and dynamics, as MuJoCo compiles its shortcut."""
    gain = {Form.POSITION: drive.kp, Form.VELOCITY: drive.kd, Form.MOTOR: 1.0}[drive.form]
    affine = drive.form is not Form.MOTOR
    filtered = drive.time_constant > 0.0
    return GeneralForm(
        dyntype="filterexact" if filtered else "none",
        gaintype="fixed",
        biastype="affine" if affine else "none",
        # 1 is MuJoCo's default of dynprm[0], which a shortcut without filter keeps.
        dynprm=(drive.time_constant if filtered else 1.0, 0.0, 0.0),
        gainprm=(gain, 0.0, 0.0),
        biasprm=(drive.offset, 0.0 - drive.kp, 0.0 - drive.kd) if affine else (0.0, 0.0, 0.0),
    )


def _general(drive: Drive, dialect: MujocoDialect, explicit: bool) -> list[tuple[str, str]]:
    form = general_form(drive)
    # A class fills what is not written: all ten numbers of each array then, and the flags of the filter.
    width = 10 if explicit else 3
    arrays = (("dynprm", form.dynprm), ("gainprm", form.gainprm), ("biasprm", form.biasprm))
    attributes = [("dyntype", form.dyntype), ("gaintype", form.gaintype), ("biastype", form.biastype)]
    attributes += [(name, _numbers(*values, *([0.0] * (width - 3)))) for name, values in arrays]
    if explicit:
        attributes += [("actlimited", "false"), ("actearly", "false")]
        keyword = GENERAL_INPUTS.get(drive.form)
        if dialect.general_input and keyword is not None:
            attributes.append(("input", keyword))
    return attributes


def _dcmotor(drive: Drive, numbers: Controller) -> list[tuple[str, str]]:
    limit = drive.effort_limit
    return [
        ("nominal", _numbers(*numbers.nominal)),
        *([] if limit is None else [("saturation", _numbers(limit, 0.0, 0.0))]),
        ("input", numbers.keyword),
        ("controller", _numbers(numbers.kp, 0.0, numbers.kd, 0.0, 0.0, VOLTAGE)),
    ]


def _numbers(*values: float) -> str:
    return " ".join(exact_number(value) for value in values)
