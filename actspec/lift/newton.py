"""An overlay of a stage with NewtonActuators as an ActuatorSet: which prims are of which joint, and what they say.

A joint's prim counts in degrees, an actuator in radians. What an attribute that is not written means is Newton's:
no gain, no limit. What the stage below the overlay says is not at hand: of it nothing is taken for stated.
Source: newton-usd-schemas 0.6.0; Newton 1.8.0, `newton/_src/actuators`.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from actspec.diagnostics import one_line
from actspec.fields import units_of
from actspec.ir import (
    ActuatorSet,
    Command,
    Delay,
    JointActuator,
    JointKind,
    Level,
    Network,
    Quantity,
    assumed,
    stated,
    tidy,
    unknown,
)
from actspec.lift.figures import NONE_FROM, delay_of_steps, real_limit
from actspec.lift.lifted import LeftAlone, Lifted
from actspec.robot.usda import NUMERIC, Asset, UsdaAttribute, UsdaLayer, UsdaPrim
from actspec.robot.view import JointView

ACTUATOR = "NewtonActuator"
TARGETS = "newton:targets"
PD, PID, NEURAL = "NewtonPDControlAPI", "NewtonPIDControlAPI", "NewtonNeuralControlAPI"
MAX_EFFORT, DC_MOTOR = "NewtonMaxEffortClampingAPI", "NewtonDCMotorClampingAPI"
BY_POSITION, DELAY = "NewtonPositionBasedClampingAPI", "NewtonActuatorDelayAPI"
_KNOWN = (PD, PID, NEURAL, MAX_EFFORT, DC_MOTOR, BY_POSITION, DELAY)

READ: dict[str, tuple[str, ...]] = {
    "newton:kp": (PD, PID),
    "newton:kd": (PD, PID),
    "newton:constEffort": (PD, PID),
    "newton:ki": (PID,),
    "newton:modelPath": (NEURAL,),
    "newton:maxEffort": (MAX_EFFORT,),
    "newton:saturationEffort": (DC_MOTOR,),
    "newton:velocityLimit": (DC_MOTOR,),
    "newton:maxMotorEffort": (DC_MOTOR,),
    "newton:delaySteps": (DELAY,),
}
"""Attribute of an actuator to the API schemas of which one has to be applied for it to act."""

_DEGREE = math.pi / 180.0
_STAGE = "the stage's own"


def lift_newton(
    layer: UsdaLayer, joints: Sequence[JointView], prims: Mapping[str, str], physics_dt: float
) -> Lifted:
    """What an overlay says of a robot's actuators.

    The command of a drive without stiffness is a speed, of one without gains a torque.

    Args:
        layer: The overlay.
        joints: The robot's joints, in its order.
        prims: Joint to the path of its prim.
        physics_dt: The simulation's step [s], of which delays are multiples.
    """
    actuators: list[JointActuator] = []
    alone: list[LeftAlone] = []
    for joint in newton_joints(layer, joints, prims):
        why = unsupported(joint)
        if why is None:
            actuators.append(NewtonDrive(joint, os.path.dirname(layer.path), physics_dt).actuator())
        else:
            prim = joint.actuators[0] if joint.actuators else joint.prim
            alone.append(LeftAlone(joint.name, why, None if prim is None else prim.span))
    return Lifted(
        ActuatorSet(
            robot=next((path.split("/")[1] for path in layer.prims), ""),
            joints=tuple(actuators),
            unmanaged=tuple(item.joint for item in alone),
            physics_dt=unknown("s", "the format has no time step"),
        ),
        tuple(alone),
    )


@dataclass(frozen=True, slots=True)
class NewtonJoint:
    """One joint of an overlay.

    Attributes:
        view: The joint in the robot's file.
        prim: The joint's own prim; None: the overlay has none.
        actuators: The actuators that target it, in the file's order.
    """

    view: JointView
    prim: UsdaPrim | None
    actuators: tuple[UsdaPrim, ...]

    @property
    def name(self) -> str:
        """Of the joint."""
        return self.view.name


def newton_joints(
    layer: UsdaLayer, joints: Sequence[JointView], prims: Mapping[str, str]
) -> tuple[NewtonJoint, ...]:
    """The joints of an overlay, each with the actuators that are in force there.

    Args:
        layer: The overlay.
        joints: As in `lift_newton`.
        prims: Likewise.
    """
    targeted: dict[str, list[UsdaPrim]] = {}
    for prim in layer.prims.values():
        attribute = prim.attributes.get(TARGETS)
        targets = attribute.value if attribute is not None and isinstance(attribute.value, tuple) else ()
        # What is no def is left to the stage, and of several targets Newton takes the first.
        if prim.type == ACTUATOR and prim.active and prim.specifier == "def" and targets:
            targeted.setdefault(str(targets[0]), []).append(prim)
    paths = [(joint, prims.get(joint.name, "")) for joint in joints]
    return tuple(
        NewtonJoint(joint, layer.prims.get(path), tuple(targeted.get(path, ()))) for joint, path in paths
    )


def unsupported(joint: NewtonJoint) -> str | None:
    """Why a spec cannot say what the overlay does at a joint; None when it can."""
    if joint.view.mimic is not None:
        return f"follows '{one_line(joint.view.mimic)}' (mimic)"
    if not joint.actuators:
        return "no NewtonActuator"
    if len(joint.actuators) > 1:
        return f"{len(joint.actuators)} NewtonActuators"
    prim = joint.actuators[0]
    drives = [api for api in prim.apis if api in (PD, PID, NEURAL)]
    if len(drives) != 1:
        return f"an actuator with {' and '.join(drives) or 'no drive'}, which Newton refuses"
    if BY_POSITION in prim.apis:
        return "a torque limit that depends on the position"
    if DELAY in prim.apis and "newton:delaySteps" not in prim.attributes:
        return "a delay without newton:delaySteps, which Newton refuses"
    if _figure(prim, "newton:ki"):
        return "a PID drive"
    if _figure(prim, "newton:constEffort") and not _figure(prim, "newton:kp"):
        return "a constant torque without a stiffness"
    return None


def _figure(prim: UsdaPrim, name: str) -> float:
    """A number that is in force; 0 without one."""
    found = _attribute(prim, name)
    return found.value if found is not None and isinstance(found.value, int | float) else 0.0


def _attribute(prim: UsdaPrim, name: str) -> UsdaAttribute | None:
    """An attribute of an actuator with a value, where one of its API schemas is applied."""
    found = prim.attributes.get(name)
    if found is None or found.value is None or not any(api in prim.apis for api in READ[name]):
        return None
    return found


class NewtonDrive:
    """One joint that a spec can describe."""

    def __init__(self, joint: NewtonJoint, folder: str, physics_dt: float) -> None:
        self._joint = joint
        self._prim = joint.actuators[0]
        self._folder = folder
        self._physics_dt = physics_dt
        self._kind = joint.view.kind
        self._units = units_of(self._kind)

    def actuator(self) -> JointActuator:
        """The joint's actuator."""
        units, joint = self._units, self._joint
        network = self._network()
        kp, kd, command = self._gains(network)
        stall, speed = self._line()
        level = Level.IDEAL_PD if stall is None else Level.DC_MOTOR
        if network is not None:
            level = Level.ACTUATOR_NET
        return JointActuator(
            joint=joint.name,
            kind=self._kind,
            group=self._prim.name,
            pattern=re.escape(joint.name),
            level=level,
            command=command,
            kp=kp,
            kd=kd,
            effort_limit=self._effort_limit(),
            velocity_limit=self._velocity_limit(),
            stall_torque=stall,
            no_load_speed=speed,
            peak_torque=unknown(units.torque),
            continuous_torque=unknown(units.torque),
            armature=self._own("newton:armature", units.inertia),
            reflected_inertia=unknown(units.inertia),
            friction_coulomb=self._own("newton:friction", units.torque),
            friction_viscous=self._own("newton:damping", units.velocity_gain, 1.0 / _DEGREE),
            delay=self._delay(),
            encoder_bias=self._bias(kp),
            default_position=unknown(units.position),
            position_range=joint.view.range,
            network=network,
            span=self._prim.span,
        )

    def _number(self, found: UsdaAttribute | None) -> float | None:
        """An attribute's number; None where it has none."""
        if found is None or found.type not in NUMERIC or not isinstance(found.value, int | float):
            return None
        return None if math.isnan(found.value) else float(found.value)

    def _own(self, name: str, unit: str, factor: float = 1.0) -> Quantity:
        """A number of the joint's prim; of a hinge `factor` is what one of its units is in `unit`."""
        prim = self._joint.prim
        found = None if prim is None else prim.attributes.get(name)
        value = self._number(found)
        if found is None or value is None:
            return unknown(unit, _STAGE)
        if factor == 1.0 or self._kind is not JointKind.HINGE:
            return stated(value, unit, found.span)
        written = unit.replace("rad", "deg")
        # As many digits as single precision has, in which USD keeps it.
        return stated(float(f"{value * factor:.7g}"), unit, found.span, formula=f"{value:g} {written}")

    def _velocity_limit(self) -> Quantity:
        found = self._own("newton:velocityLimit", self._units.speed, _DEGREE)
        return real_limit(found)

    def _stated(self, name: str, unit: str) -> Quantity | None:
        """A number of the actuator; None where it is not in force."""
        found = _attribute(self._prim, name)
        value = self._number(found)
        return None if found is None or value is None else stated(value, unit, found.span)

    def _gains(self, network: Network | None) -> tuple[Quantity | None, Quantity | None, Command]:
        if network is not None:
            return None, None, Command.POSITION
        units = self._units
        kp = self._stated("newton:kp", units.stiffness) or assumed(0.0, units.stiffness, "Newton takes 0")
        kd = self._stated("newton:kd", units.velocity_gain) or assumed(
            0.0, units.velocity_gain, "Newton takes 0"
        )
        if kp.value:
            return kp, kd, Command.POSITION
        command = Command.VELOCITY if kd.value else Command.EFFORT
        return None, kd if kd.value else None, command

    def _line(self) -> tuple[Quantity | None, Quantity | None]:
        """Stall torque and no-load speed; None where one of them is put out of the way."""
        stall = self._stated("newton:saturationEffort", self._units.torque)
        speed = self._stated("newton:velocityLimit", self._units.speed)
        if stall is None or speed is None or max(stall.require(), speed.require()) >= NONE_FROM:
            return None, None
        return stall, speed

    def _effort_limit(self) -> Quantity:
        """The least of the clamps that are in force; a line that never falls is one of them."""
        unit = self._units.torque
        names = ["newton:maxEffort", "newton:maxMotorEffort"]
        if self._line()[0] is None:
            names.append("newton:saturationEffort")
        clamps = [found for name in names if (found := self._stated(name, unit)) is not None]
        if not clamps:
            return unknown(unit, "the overlay has no limit")
        return real_limit(min(clamps, key=Quantity.require))

    def _delay(self) -> Delay | None:
        found = _attribute(self._prim, "newton:delaySteps")
        steps = self._number(found)
        if found is None or steps is None or steps == 0.0:
            return None
        return delay_of_steps(steps, steps, self._physics_dt if steps > 0.0 else None, found.span)[0]

    def _bias(self, kp: Quantity | None) -> Quantity:
        """What a constant torque of a position drive amounts to at its encoder."""
        unit = self._units.position
        found = _attribute(self._prim, "newton:constEffort")
        torque = self._number(found)
        if found is None or not torque or kp is None or not kp.value:
            return assumed(0.0, unit, "no bias is stated")
        formula = f"{-torque:g} / {kp.value:g} (stiffness)"
        return stated(tidy(-torque / kp.value), unit, found.span, formula=formula)

    def _network(self) -> Network | None:
        if NEURAL not in self._prim.apis:
            return None
        found = _attribute(self._prim, "newton:modelPath")
        if found is None or not isinstance(found.value, Asset):
            return Network("", None, self._prim.span)
        return Network(os.path.normpath(os.path.join(self._folder, found.value.path)), None, found.span)
