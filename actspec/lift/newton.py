"""An overlay of a stage with NewtonActuators as an ActuatorSet: which prims are of which joint, and what they say.

A joint's prim counts in degrees, an actuator in radians. What an attribute that is not written means is Newton's:
no gain, no limit. What the stage below the overlay says is not at hand: of it nothing is taken for stated.
Source: newton-usd-schemas 0.6.0; Newton 1.8.0, `newton/_src/actuators`.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from actspec.diagnostics import Span, one_line, shortened
from actspec.ir import ActuatorSet, Command, Delay, JointActuator, JointKind, Level, Network, Quantity
from actspec.lift.config_joint import NONE_FROM, delay_of_steps, real_limit
from actspec.lift.lifted import LeftAlone, Lifted
from actspec.readings.quantities import assumed, stated, tidy, units_of, unknown
from actspec.robot.usda import NUMERIC, Asset, UsdaAttribute, UsdaLayer, UsdaPrim
from actspec.robot.view import JointView

ACTUATOR = "NewtonActuator"
TARGETS = "newton:targets"
_KINDS = {"PhysicsRevoluteJoint": JointKind.HINGE, "PhysicsPrismaticJoint": JointKind.SLIDE}
_AXES = {"angular": JointKind.HINGE, "linear": JointKind.SLIDE}

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

_OURS = "Written by actspec "
_STEP = re.compile(r"Every physics step of (\d+(?:\.\d+)?(?:e[-+]?\d+)?) ms:")


def lift_newton(
    layer: UsdaLayer,
    joints: Sequence[JointView | str] | None = None,
    *,
    prims: Mapping[str, str] | None = None,
    physics_dt: float | None = None,
) -> Lifted:
    """What an overlay says of a robot's actuators.

    The command of a drive without stiffness is a speed, of one without gains a torque.

    Args:
        layer: The overlay.
        joints: The robot's joints, in its order, names alone where no robot file has them; None: those that the
            overlay names itself.
        prims: Joint to the path of its prim; None: a joint is called as its prim is.
        physics_dt: The simulation's step [s], of which delays are multiples; None: what the head says, to its six
            digits, where actspec wrote it.
    """
    found, remarks = newton_joints(layer, joints, prims)
    head = _head_step(layer)
    step = head.value if physics_dt is None else physics_dt
    actuators: list[JointActuator] = []
    alone: list[LeftAlone] = []
    notes: dict[str, tuple[str, ...]] = {}
    for joint in found:
        why = unsupported(joint)
        if why is not None:
            prim = joint.actuators[0] if joint.actuators else joint.prim
            alone.append(LeftAlone(joint.name, why, None if prim is None else prim.span))
            continue
        drive = NewtonDrive(joint, os.path.dirname(layer.path), step)
        actuators.append(drive.actuator())
        if drive.notes:
            notes[joint.name] = tuple(dict.fromkeys(drive.notes))
    whole = (*remarks, *_unfollowed(layer))
    if whole:
        notes[""] = whole
    return Lifted(
        ActuatorSet(
            robot=next((path.split("/")[1] for path in layer.prims), ""),
            joints=tuple(actuators),
            unmanaged=tuple(item.joint for item in alone),
            physics_dt=head,
        ),
        tuple(alone),
        notes,
    )


def _unfollowed(layer: UsdaLayer) -> Iterator[str]:
    for word in layer.unfollowed:
        yield f"{word} are not followed: what they bring in is not here"


def _head_step(layer: UsdaLayer) -> Quantity:
    """The step that our own head names."""
    if any(line.startswith(_OURS) for line in layer.head):
        for line in layer.head:
            match = _STEP.match(line)
            if match:
                return stated(tidy(float(match[1]) / 1e3), "s", Span(layer.path, 1))
    return unknown("s", "the format has no time step")


@dataclass(frozen=True, slots=True)
class NewtonJoint:
    """One joint of an overlay.

    Attributes:
        name: Of the joint.
        view: The joint in the robot's file; None: not at hand.
        kind: Hinge or slide; None: neither the file nor the robot says.
        prim: The joint's own prim; None: the overlay has none.
        actuators: The actuators that target it, in the file's order.
    """

    name: str
    view: JointView | None
    kind: JointKind | None
    prim: UsdaPrim | None
    actuators: tuple[UsdaPrim, ...]


def newton_joints(
    layer: UsdaLayer, joints: Sequence[JointView | str] | None, prims: Mapping[str, str] | None
) -> tuple[tuple[NewtonJoint, ...], tuple[str, ...]]:
    """The joints of an overlay, and remarks on what of it is no joint's.

    Args:
        layer: The overlay.
        joints: As in `lift_newton`.
        prims: Likewise.
    """
    targeted, remarks = _targeted(layer)
    views = {joint if isinstance(joint, str) else joint.name: joint for joint in joints or ()}
    views = {
        name: view
        for name, view in views.items()
        if isinstance(view, str) or view.kind in (JointKind.HINGE, JointKind.SLIDE)
    }
    paths = _named(layer, targeted) if prims is None else dict(prims)
    found = []
    for name in views or paths:
        path = paths.get(name, "")
        view = views.get(name)
        joint = None if view is None or isinstance(view, str) else view
        prim = layer.prims.get(path)
        kind = joint.kind if joint is not None else None if prim is None else _kind(prim)
        found.append(NewtonJoint(name, joint, kind, prim, tuple(targeted.pop(path, ()))))
    strays = [f"actuators at {shortened(path)}, which is none of the joints" for path in targeted]
    return tuple(found), (*remarks, *strays)


def _targeted(layer: UsdaLayer) -> tuple[dict[str, list[UsdaPrim]], list[str]]:
    """Joints' paths to the actuators that are in force there."""
    found: dict[str, list[UsdaPrim]] = {}
    remarks = []
    for prim in layer.prims.values():
        if prim.type != ACTUATOR or not prim.active:
            continue
        if prim.specifier != "def":
            remarks.append(f"{shortened(prim.path)} is no def: left to the stage, if it has one")
            continue
        attribute = prim.attributes.get(TARGETS)
        targets = attribute.value if attribute is not None and isinstance(attribute.value, tuple) else ()
        if not targets:
            remarks.append(f"{shortened(prim.path)} has no target, which Newton refuses")
            continue
        if len(targets) > 1:
            remarks.append(f"{shortened(prim.path)} has {len(targets)} targets: Newton takes the first")
        found.setdefault(str(targets[0]), []).append(prim)
    return found, remarks


def _named(layer: UsdaLayer, targeted: Mapping[str, Sequence[UsdaPrim]]) -> dict[str, str]:
    """Names of the joints to their paths: the last name, or the whole path where two end alike."""
    paths = dict.fromkeys([prim.path for prim in layer.prims.values() if _is_joint(prim)] + list(targeted))
    last = [path.rpartition("/")[2] for path in paths]
    return {name if last.count(name) == 1 else path: path for name, path in zip(last, paths, strict=True)}


def _is_joint(prim: UsdaPrim) -> bool:
    return prim.type in _KINDS or any(
        api == "NewtonJointAPI" or api.startswith("PhysicsDriveAPI:") for api in prim.apis
    )


def _kind(prim: UsdaPrim) -> JointKind | None:
    """What a prim's type says, else the axis of its drive."""
    if prim.type in _KINDS:
        return _KINDS[prim.type]
    kinds = {_AXES[axis] for axis in _axes(prim) if axis in _AXES}
    return kinds.pop() if len(kinds) == 1 else None


def _axes(prim: UsdaPrim) -> Iterator[str]:
    yield from (api.partition(":")[2] for api in prim.apis if api.startswith("PhysicsDriveAPI:"))
    yield from (name.split(":")[1] for name in prim.attributes if name.startswith("drive:"))


def unsupported(joint: NewtonJoint) -> str | None:
    """Why a spec cannot say what the overlay does at a joint; None when it can."""
    if joint.view is not None and joint.view.mimic is not None:
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
    """One joint that a spec can describe.

    Attributes:
        notes: What a spec cannot hold, or says otherwise; complete once the actuator is made.
    """

    def __init__(self, joint: NewtonJoint, folder: str, physics_dt: float | None) -> None:
        self.notes: list[str] = []
        self._joint = joint
        self._prim = joint.actuators[0]
        self._folder = folder
        self._physics_dt = physics_dt
        self._kind = joint.kind or JointKind.HINGE
        self._units = units_of(self._kind)

    def actuator(self) -> JointActuator:
        """The joint's actuator."""
        units, joint, view = self._units, self._joint, self._joint.view
        network = self._network()
        kp, kd, command = self._gains(network)
        stall, speed = self._line()
        level = Level.IDEAL_PD if stall is None else Level.DC_MOTOR
        if network is not None:
            level = Level.ACTUATOR_NET
        limit = self._effort_limit()
        self._note(limit)
        return JointActuator(
            joint=joint.name,
            kind=self._kind,
            group=self._prim.name,
            pattern=re.escape(joint.name),
            level=level,
            command=command,
            kp=kp,
            kd=kd,
            effort_limit=limit,
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
            position_range=None if view is None else view.range,
            network=network,
            span=self._prim.span,
        )

    def _number(self, found: UsdaAttribute | None) -> float | None:
        """An attribute's number; None where it has none."""
        if found is None or found.value is None:
            return None
        if found.type not in NUMERIC or not isinstance(found.value, int | float):
            self.notes.append(f"{found.name} is of type {found.type}: Newton takes a number")
            return None
        if math.isnan(found.value):
            return None
        if found.value < 0.0 and found.name != "newton:constEffort":
            self.notes.append(f"{found.name} is {found.value:g}: Newton takes no negative number")
        return float(found.value)

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
        self.notes.append(f"stiffness 0: the command is a {'speed' if kd.value else 'torque'}")
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
        delay, note = delay_of_steps(steps, steps, self._physics_dt if steps > 0.0 else None, found.span)
        self.notes += note
        return delay

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

    def _note(self, limit: Quantity) -> None:
        """What does nothing, and what acts beside the actuator."""
        for name in self._prim.attributes:
            apis = READ.get(name, ())
            if apis and not any(api in self._prim.apis for api in apis):
                self.notes.append(f"{name} does nothing without {' or '.join(apis)}")
        self.notes += [f"{api} is not read" for api in self._prim.apis if api not in _KNOWN]
        if self._joint.kind is None:
            self.notes.append("the kind of the joint is not stated: it is taken as a hinge")
        head = f"drive:{'angular' if self._kind is JointKind.HINGE else 'linear'}:physics:"
        attributes = {} if self._joint.prim is None else self._joint.prim.attributes
        for part in ("stiffness", "damping"):
            if self._number(attributes.get(head + part)):
                self.notes.append(f"the stage's own drive acts beside the actuator ({head}{part})")
        force = self._number(attributes.get(f"{head}maxForce"))
        if force is not None and force < (math.inf if limit.value is None else limit.value):
            self.notes.append(
                f"{head}maxForce clips at {force:g} {self._units.torque} too, where it is in force"
            )
