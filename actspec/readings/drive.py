"""One actuator that drives a joint, as a robot file has it: limits, gains and places, at the joint, gear included."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from actspec.diagnostics import Span
from actspec.fields import Units
from actspec.ir import Quantity, assumed, stated, tidy, unknown
from actspec.robot.view import ActuatorView, JointView

NOT_IN_FILE = "not known from the file alone"

_STATED_BY = {
    "kp": ("kp", "biasprm", "controller"),
    "kd": ("kv", "dampratio", "biasprm", "controller"),
    "actuator_damping": ("damping",),
    "armature": ("armature",),
    "delay": ("delay",),
    "command_range": ("ctrlrange", "inheritrange", "posrange", "actrange"),
    "effort_limit": ("forcerange", "forcelimited", "saturation"),
}
"""Figure to the attributes of an actuator that state it."""


@dataclass(frozen=True, slots=True)
class DriveReading:
    """One actuator that drives a joint directly.

    Attributes:
        view: The actuator, as the file has it.
        joint: Its joint.
        units: Of the joint.
    """

    view: ActuatorView
    joint: JointView
    units: Units

    @property
    def is_on(self) -> bool:
        """Whether it gives a force: the file may switch off a group of actuators, or all."""
        return not self.view.disabled

    @property
    def is_torque(self) -> bool:
        """Whether the control alone decides on the torque."""
        view = self.view
        return view.control == "motor" and view.kd == 0.0 and not {"kd", "gain"} & view.unknown

    @property
    def kp(self) -> Quantity:
        """Stiffness."""
        return self._gain("kp", self.units.stiffness)

    @property
    def kd(self) -> Quantity:
        """Velocity gain in the linear region; back-EMF is in it."""
        return self._gain("kd", self.units.velocity_gain)

    def _gain(self, name: str, unit: str) -> Quantity:
        view, place = self.view, self._place_of_gain(name)
        if name in view.unknown:
            return unknown(unit, NOT_IN_FILE, place)
        value: float = getattr(view, name)
        if not value and not view.stated & set(_STATED_BY[name]):
            word = {"kp": "kp", "kd": "kv"}[name]
            return assumed(0.0, unit, f"the file's servo has no {word}: MuJoCo takes 0")
        # The line of a dcmotor makes its gains, a gear those at the joint.
        formula = None
        if view.gear != 1.0 and view.gear:
            formula = f"{value / view.gear**2:g} x {view.gear:g}^2 (gear)"
        return stated(tidy(value) if formula else value, unit, place, formula=formula)

    @property
    def damping(self) -> float | None:
        """Linear damping of the actuator itself, at the joint; None: unknown."""
        view = self.view
        if view.unknown and {"damping", "gear"} & view.unknown:
            return None
        return view.gear**2 * view.damping[0]

    @property
    def armature(self) -> float | None:
        """Armature of the actuator itself, at the joint; None: unknown."""
        view = self.view
        if view.unknown and {"armature", "gear"} & view.unknown:
            return None
        return view.gear**2 * view.armature

    @property
    def force_bound(self) -> Quantity:
        """Largest torque that its own force range allows, of two ends the larger; infinite without one."""
        view, unit = self.view, self.units.torque
        place = self._place_at_joint("forcerange", "saturation", "forcelimited")
        if view.unknown and {"force_range", "gear"} & view.unknown:
            return unknown(unit, NOT_IN_FILE, place)
        if view.force_range is None:
            # A plugin or a muscle has bounds of its own.
            if view.control in ("plugin", "other") and "kp" in view.unknown:
                return unknown(unit, NOT_IN_FILE, place)
            return assumed(math.inf, unit, "the file has no limit")
        gear, end = abs(view.gear), largest(view.force_range)
        formula = None if gear == 1.0 else f"{end:g} x gear {gear:g}"
        return stated(tidy(gear * end) if formula else end, unit, place, formula=formula)

    @property
    def control_bound(self) -> Quantity:
        """Largest torque that the clamp of its control or activation allows; infinite unless that is the torque."""
        view, unit = self.view, self.units.torque
        place = self._place_at_joint(*self._clamp)
        if not (self.is_torque or view.is_filled):
            return assumed(math.inf, unit, "the control is no torque")
        if view.unknown and {"input_range", "gear"} & view.unknown:
            return unknown(unit, NOT_IN_FILE, place)
        torques = self.control_torques
        if torques is None:
            return assumed(math.inf, unit, "the file has no limit")
        factor = view.gear * view.gain
        end = largest(view.input_range or (0.0, 0.0))
        gain = f" x gain {abs(view.gain):g}" * (view.gain != 1.0 and view.control != "dcmotor")
        formula = None if abs(factor) == 1.0 else f"{end:g} x gear {abs(view.gear):g}{gain}"
        if view.offset:
            formula = f"{factor:g} (gear x gain), {view.gear * view.offset:g} (constant force)"
        return stated(
            tidy(largest(torques)) if formula else largest(torques),
            unit,
            place,
            note=f"the range of the motor's {view.input}",
            formula=formula,
        )

    @property
    def control_torques(self) -> tuple[float, float] | None:
        """Least and largest torque that a clamped torque command makes; None without a clamp."""
        view = self.view
        if view.input_range is None:
            return None
        # The input of a dcmotor without gains is the torque itself.
        gain = 1.0 if view.control == "dcmotor" else view.gain
        low, high = sorted(view.gear * (gain * end + view.offset) for end in view.input_range)
        return low, high

    @property
    def bound(self) -> Quantity:
        """Largest torque that it can apply, all clamps of its own together; infinite: any."""
        return least((self.force_bound, self.control_bound))

    @property
    def command_range(self) -> tuple[float, float] | None:
        """Clamp of the command at the joint: position or speed of a servo, torque of a motor; None: none known.

        Of a servo whose gain is not its stiffness, as one in degrees, it is where it goes (measured in MuJoCo 4.0).
        """
        view = self.view
        if view.input_range is None or not view.gear or {"gear", "input_range"} & view.unknown:
            return None
        if view.control == "motor":
            return None if "gain" in view.unknown else self.control_torques
        if view.is_scaled is None:
            return None
        ends = [end / view.gear for end in view.input_range]
        if view.is_scaled:
            feedback = view.kp if view.control == "position" else view.kd
            ends = [view.gear * (view.gain * end + view.offset) / feedback for end in view.input_range]
        return min(ends), max(ends)

    @property
    def filter_cutoff(self) -> Quantity | None:
        """First-order low-pass on the command; None without one."""
        view = self.view
        if view.time_constant <= 0.0 and "time_constant" not in view.unknown:
            return None
        place = self.place("timeconst", "dynprm")
        if "time_constant" in view.unknown:
            return unknown("Hz", NOT_IN_FILE, place)
        cutoff = 1.0 / (2.0 * math.pi * view.time_constant)
        return stated(cutoff, "Hz", place, formula=f"1 / (2 pi {view.time_constant:g} s)")

    @property
    def delay(self) -> Quantity | None:
        """Delay of the command; None without one."""
        view = self.view
        if view.delay <= 0.0 and "delay" not in view.unknown:
            return None
        place = self.place("delay")
        return unknown("s", NOT_IN_FILE, place) if "delay" in view.unknown else stated(view.delay, "s", place)

    @property
    def places(self) -> dict[str, Span]:
        """Figure that it states to where."""
        said = _said_of_actuator(self.view.stated, self._ranges_of_torque)
        found = {figure: self.view.places.get(name, self.view.span) for figure, name in said}
        if "effort_limit" in found and self._has_gear:
            found["effort_limit"] = self.view.span
        elif "effort_limit" in found and self.view.input_range and self.view.force_range:
            force, control = self.force_bound.value, self.control_bound.value
            if force is not None and control is not None and control < force:
                # Of two clamps the one that binds.
                found["effort_limit"] = self.view.places.get(self._clamp[0], self.view.span)
        if self.view.line is not None:
            place = self._place_at_joint("nominal", "motorconst", "resistance")
            found |= {"stall_torque": place, "no_load_speed": place}
        return found | {figure: self._place_of_gain(figure) for figure in ("kp", "kd") if figure in found}

    @property
    def _clamp(self) -> tuple[str, ...]:
        """Attributes that say what clamps its input, the range first."""
        if self.view.input == "activation":
            return ("actrange", "actlimited")
        return ("ctrlrange", "posrange", "inheritrange", "ctrllimited")

    @property
    def _ranges_of_torque(self) -> tuple[str, ...]:
        """Attributes of the ranges that clamp its torque beside those of the force."""
        return ("ctrlrange", "actrange") if self.is_torque else ("actrange",) if self.view.is_filled else ()

    def _place_of_gain(self, name: str) -> Span:
        """Where a gain is written: in the element, whichever attribute has it there, before its class."""
        words = _STATED_BY[name]
        own = any(word in self.view.stated and word not in self.view.places for word in words)
        return self.view.span if own else self._place_at_joint(*words)

    def _place_at_joint(self, *attributes: str) -> Span:
        """Where a figure is written that a gear multiplies: in the element that has the gear, before its class."""
        return self.view.span if self._has_gear else self.place(*attributes)

    @property
    def _has_gear(self) -> bool:
        """Whether the element itself has the gear that makes its figures those at the joint."""
        return self.view.gear != 1.0 and "gear" in self.view.stated and "gear" not in self.view.places

    def place(self, *attributes: str) -> Span:
        """Where the first of these attributes is written: in the element, or in its default class."""
        places = self.view.places
        return next((places[name] for name in attributes if name in places), self.view.span)


def largest(ends: tuple[float, float]) -> float:
    """The larger magnitude of a range's ends."""
    return max(abs(end) for end in ends)


def least(bounds: Sequence[Quantity]) -> Quantity:
    """The least bound; unknown if one of them is."""
    return min(bounds, key=lambda bound: -math.inf if bound.value is None else bound.value)


@lru_cache(maxsize=256)
def _said_of_actuator(stated: frozenset[str], torque: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Figures that an actuator states, each with the attribute that does.

    Args:
        stated: Its attributes.
        torque: Those of a range of its torque.
    """
    found = []
    for figure, names in _STATED_BY.items():
        last = torque if figure == "effort_limit" else ()
        said = next((name for name in (*names, *last) if name in stated), None)
        if said is not None:
            found.append((figure, said))
    return tuple(found)
