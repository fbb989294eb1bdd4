"""What one joint becomes in Newton: the attributes of its prim, a NewtonActuator, and what they cannot hold.

- position: `NewtonPDControlAPI`, the command is `control.joint_target_q`;
- velocity: the same without kp, the command is `control.joint_target_qd`;
- effort: the same without gains, the command is `control.joint_act`;
- actuator_net: `NewtonNeuralControlAPI`.
The clamp is `NewtonDCMotorClampingAPI`, whose formula is the law's, or `NewtonMaxEffortClampingAPI`.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any

from actspec.diagnostics import Collector, shortened
from actspec.ir import JointActuator, JointKind, Quantity
from actspec.readings.onnx_file import NotOnnx, read_metadata, with_metadata
from actspec.simulators import text_of
from actspec.simulators.newton import JOINT_DAMPING, NETWORKS, NewtonDialect
from actspec.targets.base import Approximation
from actspec.targets.kit.joint import JointEmission
from actspec.targets.kit.network import NetworkWithManifest
from actspec.targets.kit.python_text import origin_of, py, stated
from actspec.targets.kit.sizes import lined
from actspec.targets.newton.usda import UsdAttribute, asset
from actspec.units import format_quantity

Schemas = tuple[tuple[str, ...], tuple[UsdAttribute, ...]]
"""API schemas of a prim, and its attributes."""


@dataclass(frozen=True, slots=True)
class JointPrims:
    """One joint in Newton's words.

    Attributes:
        actuator: What it is of.
        joint: What its own prim gets.
        drive: What the NewtonActuator has, other than its target.
        lost: What they cannot hold.
        network: Name and bytes of its network file; None without one.
    """

    actuator: JointActuator
    joint: Schemas
    drive: Schemas
    lost: tuple[Approximation, ...]
    network: tuple[str, bytes] | None


def prims_of(
    actuator: JointActuator,
    dialect: NewtonDialect,
    step: float,
    target: str,
    collector: Collector,
    network: NetworkWithManifest | None = None,
) -> JointPrims | None:
    """Choose schemas and attributes for one joint; None after an error.

    Args: as of `JointEmission`, and
        network: Of level actuator_net; None after an error.

    Raises: ValueError: the law lacks a number, or a delay is too long; it says which.
    """
    joint = JointEmission(actuator, dialect, step, target, collector)
    file = None
    if joint.learned:
        found = None if network is None else network_attributes(joint, network)
        if found is None:
            return None
        control, (attributes, file) = "NewtonNeuralControlAPI", found
    else:
        control, attributes = "NewtonPDControlAPI", gain_attributes(joint)
    clamping, limits = clamps(joint)
    delay = delay_attributes(joint)
    apis = (control, *clamping, *(["NewtonActuatorDelayAPI"] if delay else []))
    own, about = joint_prim(joint)
    no_command_path(joint)
    return JointPrims(
        joint.actuator,
        (own, tuple(about)),
        (apis, (*attributes, *limits, *delay)),
        tuple(joint.lost),
        file,
    )


def number(name: str, quantity: Quantity, what: str = "") -> UsdAttribute:
    """A known number as an attribute, with unit and origin behind it.

    Args:
        name: Of the attribute.
        quantity: The number.
        what: What it is, where the name does not say.
    """
    return given(name, quantity.require(), quantity.unit, what, origin_of(quantity))


def given(name: str, value: float, *notes: str) -> UsdAttribute:
    """A number as an attribute, infinity included."""
    text = py(value) if math.isfinite(value) else ("inf" if value > 0 else "-inf")
    return UsdAttribute("float", name, text, ", ".join(note for note in notes if note))


NewtonJoint = JointEmission[NewtonDialect]


def gain_attributes(joint: NewtonJoint) -> list[UsdAttribute]:
    """`newton:kp`, `newton:kd` and the encoder bias, which is a constant torque of -kp * bias before the clamp."""
    actuator = joint.actuator
    found = []
    for name, quantity in (("newton:kp", actuator.kp), ("newton:kd", actuator.kd)):
        if quantity is not None and quantity.known:
            found.append(number(name, quantity))
        else:
            found.append(UsdAttribute("float", name, "0.0"))
    bias = joint.law.encoder_bias
    if bias and joint.law.kp:
        note = f"-kp times the encoder's bias of {bias:g} {actuator.encoder_bias.unit}"
        found.append(given("newton:constEffort", -joint.law.kp * bias, joint.unit, note))
    return found


def clamps(joint: NewtonJoint) -> tuple[tuple[str, ...], list[UsdAttribute]]:
    """API schemas and attributes of the clamp: a torque-speed line, or the effort limit alone."""
    law = joint.law
    if law.stall_torque is not None or law.curve is not None:
        return ("NewtonDCMotorClampingAPI",), _line(joint)
    if not math.isfinite(law.effort_limit):
        return (), []
    return ("NewtonMaxEffortClampingAPI",), [number("newton:maxEffort", joint.actuator.effort_limit)]


def _line(joint: NewtonJoint) -> list[UsdAttribute]:
    actuator, law = joint.actuator, joint.law
    speed = actuator.velocity_limit.unit
    if law.curve is None:
        assert actuator.stall_torque is not None and actuator.no_load_speed is not None
        found = [
            number("newton:saturationEffort", actuator.stall_torque, "at standstill"),
            number("newton:velocityLimit", actuator.no_load_speed, "no-load speed"),
        ]
    else:
        line = joint.drive_side("Newton has one line for driving and braking")
        assert line.stall_torque is not None and line.no_load_speed is not None
        found = [
            given(
                "newton:saturationEffort",
                line.stall_torque,
                joint.unit,
                "of the line through the curve's knee",
            ),
            given("newton:velocityLimit", line.no_load_speed, speed, "no-load speed"),
        ]
    limit = lined(law).effort_limit
    if actuator.effort_limit.value == limit:
        return [*found, number("newton:maxMotorEffort", actuator.effort_limit)]
    why = "the curve's" if math.isfinite(limit) else "no effort_limit is known"
    return [*found, given("newton:maxMotorEffort", limit, joint.unit, why)]


def delay_attributes(joint: NewtonJoint) -> list[UsdAttribute]:
    """`newton:delaySteps`, in physics steps; empty without a delay."""
    why = "a NewtonActuator has one fixed delay"
    steps, asked = joint.one_delay(why, joint.count, lambda _: joint.late)
    delay = joint.actuator.delay
    if steps == 0 or delay is None:
        return []
    notes = [f"steps of {joint.step * 1e3:g} ms: {asked * 1e3:g} ms"]
    notes += [origin_of(delay.nominal)] if delay.nominal.known else []
    return [UsdAttribute("int", "newton:delaySteps", str(steps), ", ".join(notes))]


def no_command_path(joint: NewtonJoint) -> None:
    """Report filter and clamp of the command, and a network's bias, as lost where there are any."""
    joint.no_filter("a NewtonActuator has no filter on its command")
    if joint.learned:
        joint.no_bias("a network's position error has no bias")
    joint.no_range("a NewtonActuator does not clamp its command")


DEGREE = math.pi / 180.0
"""One degree [rad]."""


def joint_prim(joint: NewtonJoint) -> tuple[tuple[str, ...], list[UsdAttribute]]:
    """API schemas and attributes of the joint's prim; what the spec does not state keeps the stage's."""
    return ("NewtonJointAPI", f"PhysicsDriveAPI:{_axis(joint)}"), [*_no_drive(joint), *_passive(joint)]


def _axis(joint: NewtonJoint) -> str:
    return "angular" if joint.actuator.kind is JointKind.HINGE else "linear"


def _no_drive(joint: NewtonJoint) -> list[UsdAttribute]:
    """The stage's own drive, which would act beside the actuator, without gains; its force limit does not cut it."""
    head = f"drive:{_axis(joint)}:physics:"
    found = [
        UsdAttribute("float", f"{head}stiffness", "0.0", "the NewtonActuator is the drive"),
        UsdAttribute("float", f"{head}damping", "0.0"),
    ]
    if joint.actuator.effort_limit.known:
        found.append(number(f"{head}maxForce", joint.actuator.effort_limit))
    return found


def _passive(joint: NewtonJoint) -> list[UsdAttribute]:
    actuator = joint.actuator
    found = []
    for name, quantity in (
        ("newton:armature", actuator.armature),
        ("newton:friction", actuator.friction_coulomb),
    ):
        if stated(quantity):
            found.append(number(name, quantity))
    viscous = actuator.friction_viscous
    if stated(viscous):
        if joint.dialect.joint_damping:
            found.append(_in_degrees(joint, "newton:damping", viscous, DEGREE))
        else:
            since = text_of(JOINT_DAMPING)
            joint.no_viscous(
                f"Newton {joint.dialect.text} reads no joint damping from USD ({since} and later do)"
            )
    limit = actuator.velocity_limit
    if limit.known and joint.dialect.joint_damping:
        found.append(_in_degrees(joint, "newton:velocityLimit", limit, 1.0 / DEGREE))
        why = "Newton's MuJoCo solver, which Isaac Lab has, takes no speed limit of a joint"
        joint.no_velocity_limit(why, "newton:velocityLimit, which not all solvers take")
    else:
        since = text_of(JOINT_DAMPING)
        joint.no_velocity_limit(
            f"Newton {joint.dialect.text} reads no speed limit of a joint from USD ({since} and later do)"
        )
    joint.no_break_away(
        "the stage's own",
        "newton:friction is one number for sticking and sliding",
        "Newton has no Stribeck effect",
    )
    return found


def _in_degrees(joint: NewtonJoint, name: str, quantity: Quantity, factor: float) -> UsdAttribute:
    """A number that USD has per degree or in degrees, of a hinge."""
    if joint.actuator.kind is not JointKind.HINGE:
        return number(name, quantity)
    unit = quantity.unit.replace("rad", "deg")
    said = format_quantity(quantity.value, quantity.unit)
    return given(name, quantity.require() * factor, f"{unit}: {said}", origin_of(quantity))


TENSORS = (
    "input_name",
    "hidden_in_name",
    "cell_in_name",
    "output_name",
    "hidden_out_name",
    "cell_out_name",
)
"""Names of an lstm's inputs and outputs, which Newton takes from the file's own metadata."""


def network_attributes(
    joint: NewtonJoint, found: NetworkWithManifest
) -> tuple[list[UsdAttribute], tuple[str, bytes]] | None:
    """`newton:modelPath` and the file; None after an error."""
    manifest = found.manifest
    if not joint.dialect.networks:
        found.place.error(
            "NWT003",
            f"Newton {joint.dialect.text} reads no ONNX, and gives a network the velocity's error for the velocity",
            f"write for Newton {text_of(NETWORKS)} or later, or leave this target out",
        )
        return None
    takes = "Newton's network takes position errors"
    found.check_command(joint.actuator.group, joint.actuator.command, "NWT002", takes)
    if manifest.kind == "gru":
        found.place.error(
            "NWT003",
            "actspec does not write a gru for Newton, which names its inputs in another way",
            "use an mlp or an lstm, or leave this target out",
        )
    stride = found.stride(joint.step)
    metadata = None if stride is None else _metadata(joint.step, found, stride)
    if metadata is None or found.place.collector.failed:
        return None
    if manifest.initial_history == "first_sample" and manifest.kind == "mlp" and any(manifest.taps):
        joint.approximate(
            "network.initial_history",
            "first_sample",
            "zero",
            "Newton clears a network's history at a reset",
            joint.both_limits,
        )
    # Newton takes a file for torch's by the end of its name.
    name = f"{os.path.splitext(found.name)[0]}.onnx"
    data = with_metadata(found.data, metadata)
    return [UsdAttribute("asset", "newton:modelPath", asset(name))], (name, data)


def _metadata(step: float, file: NetworkWithManifest, stride: int) -> dict[str, Any] | None:
    """What Newton is to read of the network; None after an error."""
    try:
        own = read_metadata(file.data)
    except NotOnnx as err:
        file.place.error(
            "NWT004",
            f"'{shortened(file.name)}' has metadata that Newton cannot read: {err}",
            "export it again with torch.onnx.export",
        )
        return None
    asked = _asked(file, stride)
    for scale in ("pos_scale", "vel_scale", "effort_scale"):
        if asked[scale] == 0.0:
            file.place.error("NWT006", f"Newton does not accept a {scale} of 0", "fold it into the network")
    if "torque_scale" in own:
        own.setdefault("effort_scale", own.pop("torque_scale"))
    for key, value in asked.items():
        if key in own and not _same(own[key], value):
            file.place.error(
                "NWT006",
                f"the network's own metadata have {key} {shortened(str(own[key]))}, its manifest has {value}",
                "correct the one that is wrong: Newton reads the file's, and actspec writes the manifest's there",
            )
    if file.manifest.kind == "lstm":
        _check_lstm(step, file, {**own, **asked}, stride)
    return {**own, **asked}


def _asked(file: NetworkWithManifest, stride: int) -> dict[str, Any]:
    manifest = file.manifest
    found: dict[str, Any] = {
        "model_type": manifest.kind,
        "input_order": file.input_order,
        "input_idx": [tap * stride for tap in manifest.taps],
        "pos_scale": manifest.position_scale,
        "vel_scale": manifest.velocity_scale,
        "effort_scale": manifest.torque_scale,
    }
    if manifest.kind == "lstm":
        sizes = (("hidden_size", manifest.hidden_size), ("num_layers", manifest.num_layers))
        found |= {name: size for name, size in sizes if size is not None}
    return found


def _check_lstm(step: float, file: NetworkWithManifest, metadata: dict[str, Any], stride: int) -> None:
    manifest = file.manifest
    if (layers := metadata.get("num_layers")) not in (None, 1):
        file.place.error(
            "NWT003",
            f"Newton runs an lstm of one layer, got {shortened(str(layers))}: its ONNX runtime cannot take a layer's "
            "state from one array of all",
            "train one layer, such as --hidden 32, or leave this target out",
        )
        return
    missing = [name for name in (*TENSORS, "hidden_size", "num_layers") if name not in metadata]
    if missing:
        file.place.error(
            "NWT006",
            f"neither the lstm's own metadata nor its manifest have {', '.join(missing)}",
            "export the network with them: Newton finds its tensors by these names",
        )
    if manifest.taps != (0,) or manifest.inputs != "position_velocity" or stride != 1:
        file.place.error(
            "NWT003",
            "Newton gives an lstm position error and velocity of each physics step, in this order, got "
            f"{manifest.inputs}, taps {list(manifest.taps)} every {stride * step * 1e3:g} ms",
            f"train it on position_velocity, taps [0], every {step * 1e3:g} ms",
        )


def _same(own: Any, value: Any) -> bool:
    if isinstance(value, float) and isinstance(own, int | float):
        return math.isclose(own, value, rel_tol=1e-6)
    return bool(own == value)
