"""One actuator of an MJCF from its text: the element folded onto those of its default class.

A class holds one actuator, and each element in it changes that one. What all tags share goes on to any
tag. Gains go on from the nearest class above that holds the same tag, or `general`; to `general` from any.
Source: MuJoCo 4.0, measured on 2000 random pairs of classes; before 3.16 gains went from any tag to any other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from actspec.robot.compiled import NAN, ActuatorLaw, Control
from actspec.robot.xml_tree import NUMBER, Element

TRANSMISSIONS = {
    "joint": "joint",
    "jointinparent": "jointinparent",
    "tendon": "tendon",
    "cranksite": "slidercrank",
    "site": "site",
    "body": "body",
}
"""Attribute to the kind of transmission; of several the last in this order counts."""

_OF_TAG = (
    "tag", "gain", "bias", "dynamics", "gain_type", "bias_type", "dynamics_type", "inputs", "mode",
    "inherits", "states",
)  # fmt: skip
"""What an element hands on to one of its own tag only."""


def numbers(text: str | None, most: int) -> tuple[float, ...]:
    """Numbers of an attribute; nan for one that is none, nothing for an absent attribute.

    Args:
        text: The attribute.
        most: Numbers that are used.
    """
    if text is None:
        return ()
    return tuple(float(part) if NUMBER.fullmatch(part) else NAN for part in text.split()[:most])


@dataclass(slots=True)
class ActuatorText(ActuatorLaw):
    """What MuJoCo would keep of an actuator, as far as the text tells; nan is a number that it does not tell.

    Attributes:
        tag: The shortcut that the gains belong to; `general` for none.
        ranges: `ctrlrange`, `forcerange` and `actrange`.
        limited: `ctrllimited`, `forcelimited` and `actlimited`; None: automatic.
        gear, damping, armature, delay, group: As in the file.
        inherits: `inheritrange`.
        transmission, target: As in `ActuatorView`.
        above: What the class above its class holds.
    """

    tag: str = "general"
    ranges: dict[str, tuple[float, ...]] = field(default_factory=dict)
    limited: dict[str, bool | None] = field(default_factory=dict)
    gear: float = 1.0
    damping: tuple[float, ...] = (0.0, 0.0, 0.0)
    armature: float = 0.0
    delay: float = 0.0
    group: int = 0
    inherits: float = 0.0
    transmission: str = "other"
    target: str = ""
    above: ActuatorText | None = None

    def below(self) -> ActuatorText:
        """What a class below starts with."""
        made = replace(self, above=self, ranges=dict(self.ranges), limited=dict(self.limited))
        made._take(self)
        return made

    def apply(self, element: Element) -> None:
        """Change it as an element does."""
        self._common(element)
        tag = element.tag
        if tag == "general":
            self._general(element)
            self.tag = tag
            return
        # A shortcut does not take it from its class. Measured, MuJoCo 4.0.
        self.limited.pop("actlimited", None)
        before: ActuatorText | None = self
        while before is not None and not before._passes_on(tag):
            before = before.above
        if before is not self:
            self._take(before or ActuatorText())
        getattr(self, f"_{tag}", self._opaque)(element)
        self.tag = tag

    def _passes_on(self, tag: str) -> bool:
        """Whether an actuator of a tag begins with the gains that are here."""
        if tag in ("pid", "dcmotor"):
            return tag == self.gain_type
        return self.tag == tag or (self.tag == "general" and (tag == "general" or self.gain_type == "fixed"))

    def _take(self, other: ActuatorText) -> None:
        """Take over the gains of another, and all else that belongs to a tag."""
        for name in _OF_TAG:
            value = getattr(other, name)
            setattr(self, name, list(value) if isinstance(value, list) else value)

    def _common(self, element: Element) -> None:
        for name in ("ctrlrange", "forcerange", "actrange"):
            found = numbers(element.get(name), 2)
            if found:
                self.ranges[name] = found if len(found) == 2 else (NAN, NAN)
        for name in ("ctrllimited", "forcelimited", "actlimited"):
            flag = element.get(name)
            if flag is not None:
                self.limited[name] = {"true": True, "false": False}.get(flag)
        self.gear = _first(element, "gear", self.gear)
        self.armature = _first(element, "armature", self.armature)
        self.delay = _first(element, "delay", self.delay)
        group = _first(element, "group", float(self.group))
        self.group = int(group) if math.isfinite(group) else 0
        damping = numbers(element.get("damping"), 3)
        self.damping = (*damping, *self.damping[len(damping) :])
        for name, kind in TRANSMISSIONS.items():
            target = element.get(name)
            if target is not None:
                self.transmission, self.target = kind, target

    def _general(self, element: Element) -> None:
        for name, values in (("gainprm", self.gain), ("biasprm", self.bias), ("dynprm", self.dynamics)):
            found = numbers(element.get(name), 10)
            values[: len(found)] = found
        self.gain_type = element.get("gaintype", self.gain_type) or ""
        self.bias_type = element.get("biastype", self.bias_type) or ""
        self.dynamics_type = element.get("dyntype", self.dynamics_type) or ""
        self.inherits = _first(element, "inheritrange", self.inherits)
        self._read_inputs(element)

    def _read_inputs(self, element: Element) -> None:
        text = element.get("input")
        if text is not None:
            self.inputs = frozenset(text.split())

    def _motor(self, element: Element) -> None:
        self._take(ActuatorText())

    def _position(self, element: Element) -> None:
        self._servo(element)
        if self.dynamics_type != "filterexact":
            self.dynamics_type = "none"
        tau = numbers(element.get("timeconst"), 1)
        if tau:
            self.dynamics[0] = tau[0]
            self.dynamics_type = "none" if tau[0] == 0.0 else "filterexact"

    def _intvelocity(self, element: Element) -> None:
        self._servo(element)
        self.dynamics_type = "integrator"

    def _servo(self, element: Element) -> None:
        kp = self.gain[0] = _first(element, "kp", self.gain[0])
        self.bias[:2] = 0.0, -kp
        self._velocity_gain(element)
        self.inherits = _first(element, "inheritrange", self.inherits)
        self.gain_type, self.bias_type = "fixed", "affine"

    def _velocity_gain(self, element: Element) -> None:
        kv, ratio = numbers(element.get("kv"), 1), numbers(element.get("dampratio"), 1)
        if kv:
            self.bias[2] = -kv[0]
        elif ratio:
            self.bias[2] = ratio[0]

    def _velocity(self, element: Element) -> None:
        kv = _first(element, "kv", self.gain[0])
        self._take(ActuatorText())
        self.gain[0], self.bias[2], self.bias_type = kv, -kv, "affine"

    def _damper(self, element: Element) -> None:
        kv = _first(element, "kv", -self.gain[2] if self.tag == "damper" else 0.0)
        self._take(ActuatorText())
        self.gain[0], self.gain[2], self.gain_type = 0.0, -kv, "affine"
        self.limited["ctrllimited"] = True

    def _cylinder(self, element: Element) -> None:
        self.dynamics[0] = _first(element, "timeconst", self.dynamics[0])
        bias = numbers(element.get("bias"), 3)
        self.bias[: len(bias)] = bias
        self.gain[0] = _first(element, "area", self.gain[0])
        across = _first(element, "diameter", -1.0)
        if not across < 0.0:
            self.gain[0] = math.pi / 4.0 * across**2
        self.gain_type, self.bias_type, self.dynamics_type = "fixed", "affine", "filter"

    def _adhesion(self, element: Element) -> None:
        self.gain[0] = _first(element, "gain", self.gain[0])
        self.gain_type, self.bias_type = "fixed", "none"
        self.limited["ctrllimited"] = True

    def _pid(self, element: Element) -> None:
        kp = _first(element, "kp", -self.bias[1] if self.gain_type == "pid" else 1.0)
        self.gain[0] = _first(element, "ki", self.gain[0] if self.gain_type == "pid" else 0.0)
        self.bias[1] = -kp
        self._velocity_gain(element)
        self.inherits = _first(element, "inheritrange", self.inherits)
        alias = numbers(element.get("posrange"), 2)
        if alias:
            self.ranges["ctrlrange"] = alias if len(alias) == 2 else (NAN, NAN)
        self.inputs = self.inputs or frozenset({"pos", "vel"})
        self._read_inputs(element)
        self.gain_type, self.bias_type, self.dynamics_type = "pid", "affine", "none"

    def _dcmotor(self, element: Element) -> None:
        resistance, constant = self.gain[:2] if self.gain_type == "dcmotor" else (0.0, 0.0)
        constants = (*numbers(element.get("motorconst"), 2), 0.0, 0.0)
        nominal = (*numbers(element.get("nominal"), 3), 0.0, 0.0, 0.0)
        resistance = _first(element, "resistance", resistance)
        torque_constant = constants[0] if element.get("motorconst") is not None else constant
        voltage_constant = constants[1]
        if nominal[0] > 0.0 and voltage_constant <= 0.0 and nominal[2] > 0.0:
            voltage_constant = _nominal_constant(nominal, resistance, self.damping[0])
        if torque_constant > 0.0 and voltage_constant > 0.0:
            constant = math.sqrt(torque_constant * voltage_constant)
        else:
            constant = torque_constant if torque_constant > 0.0 else voltage_constant
        if resistance == 0.0 and nominal[0] > 0.0 and nominal[1] > 0.0:
            resistance = constant * nominal[0] / nominal[1]
        self.gain[0], self.gain[1] = resistance, constant
        controller = numbers(element.get("controller"), 6)
        for at, slot in zip(range(len(controller)), (4, 5, 6), strict=False):
            self.gain[slot] = controller[at]
        if len(controller) == 6 and controller[5] > 0.0:
            self.gain[7] = controller[5]
        self._saturation(element, constant)
        cogging = numbers(element.get("cogging"), 3)
        self.bias[: len(cogging)] = cogging
        lag = numbers(element.get("inductance"), 2)
        if self.gain_type != "dcmotor":
            self.dynamics[0] = 0.0
        if lag:
            self.dynamics[0] = lag[0] / resistance if lag[0] and resistance else (*lag, 0.0)[1]
        others = [numbers(element.get(name), 6) for name in ("thermal", "lugre")]
        slew = len(controller) > 3 and controller[3] > 0.0
        self.states = self.states or slew or any(any(values) for values in others)
        self._mode(element)
        self.gain_type = self.bias_type = self.dynamics_type = "dcmotor"

    def _saturation(self, element: Element, constant: float) -> None:
        saturation = numbers(element.get("saturation"), 3)
        if not saturation:
            return
        torque, current = (*saturation, 0.0, 0.0)[:2]
        torque = constant * current if torque == 0.0 and current > 0.0 else torque
        self.ranges["forcerange"] = (-torque, torque)
        self.limited["forcelimited"] = torque != 0.0

    def _mode(self, element: Element) -> None:
        text = element.get("input")
        if text in ("position", "velocity"):
            self.mode, self.inputs = text, frozenset()
        elif text is not None:
            self.mode, self.inputs = None, frozenset(text.split())

    def _opaque(self, element: Element) -> None:
        """A muscle, an orientation or a plugin: no gain of a joint drive."""
        self.gain_type = self.bias_type = self.dynamics_type = element.tag
        self.gain[0] = NAN

    def control(self, tag: str) -> Control:
        """What the actuator is; nan stands for what the text does not tell.

        Args:
            tag: Of the actuator's own element.
        """
        bias = list(self.bias)
        # A positive number in the place of -kv is a damping ratio, where the gain is kp.
        if bias[2] > 0.0 and (self.gain[0] == -bias[1] or self.gain_type == "pid"):
            bias[2] = NAN
        return ActuatorLaw.control(
            replace(self, bias=bias, states=self.states or self.dynamics[0] != 0.0), tag
        )


def _nominal_constant(nominal: Sequence[float], resistance: float, viscous: float) -> float:
    """Back-EMF constant from rated voltage, stall torque and no-load speed, actuator damping included.

    Source: MuJoCo's documentation of dcmotor: w0 = V K / (K^2 + R B).
    """
    voltage, stall, speed = nominal[:3]
    if viscous > 0.0 and resistance > 0.0:
        inner = voltage**2 - 4.0 * resistance * viscous * speed**2
        return (voltage + math.sqrt(inner)) / (2.0 * speed) if inner > 0.0 else voltage / speed
    if viscous > 0.0 and stall > 0.0:
        exact = voltage / speed - voltage * viscous / stall
        return exact if exact > 0.0 else voltage / speed
    return voltage / speed


def _first(element: Element, name: str, otherwise: float) -> float:
    """The first number of an attribute, or what there was before."""
    found = numbers(element.get(name), 1)
    return found[0] if found else otherwise


def class_text(classes: Sequence[Sequence[Element]]) -> ActuatorText:
    """An actuator as its default classes make it.

    Args:
        classes: Elements of each class, the outermost first.
    """
    found = ActuatorText()
    for elements in classes:
        found = found.below()
        for one in elements:
            found.apply(one)
    return found


def actuator_text(of_class: ActuatorText, element: Element) -> ActuatorText:
    """An actuator as its own element makes it.

    Args:
        of_class: What its classes make; not changed.
        element: Its own.
    """
    found = of_class.below()
    found.apply(element)
    return found
