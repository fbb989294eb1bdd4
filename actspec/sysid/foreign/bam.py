"""Parameter files of BAM (Better Actuator Models, Rhoban/bam): a servo on a pendulum, friction models m1 to m6.

Of a motor torque tau = kt V / R - kt^2 / R qd, BAM takes friction of at most

    m1   friction_base + friction_viscous |qd|
    m2   and friction_stribeck exp(-|qd / dtheta_stribeck|^alpha)
    m3   and load_friction_base |tau_external - tau|
    m4-6 both, by direction and with squares of the torque

all at the output [N*m, rad, s, V, A, Ohm]. So kt^2 / R is no friction: it is back-EMF, which in a servo that commands a
voltage brakes at any command, as a drive's kd does. `friction_viscous` is without it, `to_mujoco`'s damping is with it.

Source: bam/model.py, bam/actuator.py, bam/to_mujoco.py at 1b5a1ce.
"""

from __future__ import annotations

from collections.abc import Mapping

from actspec.diagnostics import Collector, listed, shortened
from actspec.ir import tidy
from actspec.spec.document import Document
from actspec.sysid.foreign.figures import (
    Figure,
    Found,
    Given,
    JointFound,
    Options,
    document,
    number,
    take,
    unit_of,
)
from actspec.units import format_number

OPTIONS = ("joints", "commit")
EXPORT = (
    "give a parameter file of BAM, with kt, R, armature, friction_base, friction_viscous, model and actuator"
)
VOLTAGE = ("mx64", "mx106", "xl320", "xl330", "sts3215")
"""Actuators whose firmware commands a voltage, P on the position error."""
CURRENT = ("xl330i", "erob80_100", "erob80_50")
"""Actuators whose firmware commands a current: back-EMF acts at the end of the supply alone."""
TORQUE = ("unitree_go1",)
GAUSS = 0.01
"""alpha this near to 2 is the law's Gaussian. Chosen: 0.3 % of the Stribeck part at most."""
LOADED = (
    "load_friction_base",
    "load_friction_stribeck",
    "load_friction_motor",
    "load_friction_external",
    "load_friction_motor_stribeck",
    "load_friction_external_stribeck",
    "load_friction_motor_quad",
    "load_friction_external_quad",
)
STRIBECK = ("friction_stribeck", "dtheta_stribeck", "alpha")
NEEDED = ("armature", "friction_base", "friction_viscous")
SIGNED = ("q_offset",)
ABOVE = ("kt", "R", "armature", "dtheta_stribeck")
ELSEWHERE: Mapping[str, str] = {
    "q_offset": "{} rad: zero of BAM's test bench, not of a robot's encoder",
    "max_velocity": "{} rad/s: how fast the firmware moves its own target; a spec has no such limit of the command",
    "error_gain_ratio": "{}: part of kp, with the firmware's gain and the supply, which the file does not have",
    "current_limit": "{} A: the servo's setting; with kt it is an effort_limit",
    "max_torque": "{} N*m: belongs in effort_limit of the spec",
    "ratio": "{}: part of kp, with the gain that was sent, which the file does not have",
}
"""Parameters that are no figures of a joint, to the reason."""


def read(given: Given, options: Options, collector: Collector) -> Found:
    """One servo's parameters, for each of the joints that are named."""
    from actspec.logs import LogError

    read = document(given, EXPORT)
    if not options.joints:
        raise LogError.of("SYS071", "which joints have this servo?", where="--joint", help="--joint hip knee")
    model, actuator = read.data.get("model"), read.data.get("actuator")
    models = [f"m{n}" for n in range(1, 7)]
    if model not in models or not isinstance(actuator, str):
        told = "names no actuator" if model in models else f"names no model of {listed(models)}"
        collector.error(
            "SYS070",
            f"{told}: it is no parameter file of BAM",
            span=read.spans.value(("model",)),
            help=EXPORT,
        )
        return Found(given, "bam", options.commit, {})
    values: dict[str, float] = {}
    for name, value in read.data.items():
        if name not in ("model", "actuator"):
            checked = number(read, (name,), value, collector, at_least=None if name in SIGNED else 0.0)
            if checked is not None:
                values[name] = checked
            if checked == 0.0 and name in ABOVE:
                span = read.spans.value((name,))
                collector.error("SYS072", f"must be above 0, got {value}", where=name, span=span)
    for name in (*NEEDED, *(STRIBECK if model == "m2" else ())):
        if name not in read.data:
            collector.error(
                "SYS070",
                f"has no `{name}`, which {model} has",
                span=read.spans.value(()),
                help=EXPORT,
            )
    if collector.failed:
        return Found(given, "bam", options.commit, {})
    joint = _joint(model, actuator, values, read, collector)
    same = dict.fromkeys(options.joints, joint)
    return Found(given, f"bam {model} of {shortened(actuator)}", options.commit, same)


def _joint(
    model: str, actuator: str, values: Mapping[str, float], read: Document, collector: Collector
) -> JointFound:
    joint = JointFound()
    joint.figures["armature"] = Figure(values["armature"], unit_of("armature"))
    _drive(joint, actuator, values)
    friction = ("friction_base", *STRIBECK, *LOADED)
    loads = [name for name in LOADED if name in values]
    alpha = values.get("alpha", 2.0)
    if model == "m1" or (model == "m2" and abs(alpha - 2.0) <= GAUSS):
        base = values["friction_base"]
        take(joint, "friction.coulomb", base, read.spans.value(("friction_base",)), collector)
        if model == "m2":
            static = tidy(base + values["friction_stribeck"])
            joint.figures["friction.static"] = Figure(static, unit_of("friction.static"))
            speed = Figure(values["dtheta_stribeck"], unit_of("friction.stribeck_velocity"))
            joint.figures["friction.stribeck_velocity"] = speed
    else:
        reason = (
            f"{model} has friction that grows with the load ({listed(loads)}), a spec's does not"
            if model != "m2"
            else f"m2 falls off by |qd/v|^{format_number(alpha, 4)}, a spec's Stribeck curve by (qd/v)^2"
        )
        numbers = ", ".join(f"{name} {values[name]}" for name in friction if name in values)
        joint.left_out["friction.coulomb"] = f"{reason}: {numbers}"
        joint.left_out |= dict.fromkeys(("friction.static", "friction.stribeck_velocity"), reason)
        collector.warning(
            "SYS073",
            f"friction is left out: {reason}",
            where="friction_base",
            span=read.spans.value(("friction_base",)),
            help="import the m1 of the same servo, which has the Coulomb friction that fits best without load",
        )
    take(
        joint,
        "friction.viscous",
        values["friction_viscous"],
        read.spans.value(("friction_viscous",)),
        collector,
        "without kt^2/R, which is the drive's",
    )
    known = {"kt", "R", *NEEDED, *friction}
    for name, value in values.items():
        if name in ELSEWHERE:
            joint.left_out[name] = ELSEWHERE[name].format(value)
        elif name not in known:
            joint.left_out[shortened(name)] = f"{value}: actspec does not know this parameter"
    _tell(joint, values, read, collector)
    return joint


def _drive(joint: JointFound, actuator: str, values: Mapping[str, float]) -> None:
    """kt and R: the motor's constant, and the torque-speed line's slope, which is kd where a voltage is commanded."""
    kt, resistance = values.get("kt"), values.get("R")
    joint.left_out["kp"] = "follows from the firmware's gain and the supply, which the file does not have"
    if kt is not None:
        joint.left_out["kt"] = f"{kt} N*m/A: belongs in the motor, as torque_constant with side: joint"
    if kt is None or resistance is None:
        why = (
            "the file has no kt and R"
            if actuator not in TORQUE
            else "a setting of the drive, which the file does not have"
        )
        joint.left_out["kd"] = why
        return
    slope, per_volt = tidy(kt * kt / resistance), format_number(kt / resistance, 6)
    joint.left_out["R"] = (
        f"{resistance} Ohm: a supply of V volts gives a motor of stall_torque {per_volt} N*m/V x V, no_load_speed "
        f"{format_number(1.0 / kt, 6)} rad/s/V x V"
    )
    words = f"kt^2/R = {format_number(slope, 6)} N*m*s/rad"
    if actuator in VOLTAGE:
        joint.figures["kd"] = Figure(
            slope, unit_of("kd"), note="kt^2/R: back-EMF of a servo that commands a voltage"
        )
    elif actuator in CURRENT:
        joint.left_out["kd"] = (
            f"the firmware's, which the file does not have; {words} acts at the end of the supply alone"
        )
    else:
        joint.left_out["kd"] = (
            f"{words} is kd where the servo commands a voltage; '{shortened(actuator)}' is not known here"
        )


def _tell(joint: JointFound, values: Mapping[str, float], read: Document, collector: Collector) -> None:
    other = [name for name in joint.left_out if name in values]
    if other:
        collector.info(
            "SYS074",
            f"not a joint's figures: {listed(other)}; where each belongs stands in the results under `left_out`",
            span=read.spans.value((other[0],)),
        )
