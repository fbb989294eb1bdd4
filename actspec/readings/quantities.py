"""Numbers of a file as quantities: what it states, what its engine puts there, what nobody says."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, lru_cache

from actspec.diagnostics import Span
from actspec.fields import unit_of_kind
from actspec.ir import JointKind, Origin, Quantity
from actspec.units import Kind


def stated(
    value: float, unit: str, span: Span, *, note: str | None = None, formula: str | None = None
) -> Quantity:
    """A number that a file states at `span`, or that follows from one by `formula`."""
    return Quantity(value + 0.0, unit, Origin.MODEL, source=span.path, span=span, note=note, formula=formula)


@lru_cache(maxsize=1024)
def assumed(value: float, unit: str, note: str) -> Quantity:
    """What an engine takes where the file is silent; `note` says whose default it is."""
    return Quantity(value, unit, Origin.DEFAULT, note=note)


def unknown(unit: str, note: str | None = None, span: Span | None = None) -> Quantity:
    """A number that nobody tells; with a place where the file writes something else."""
    source = None if span is None else span.path
    return Quantity(None, unit, Origin.UNKNOWN, source=source, span=span, note=note)


def tidy(value: float) -> float:
    """A computed number to 12 significant digits, so that 81 x 0.000111842 is 0.009059202 in every file.

    Chosen: a relative change of 5e-13 at most, a thousandth of what any target is checked to.
    """
    return float(f"{value:.12g}")


@dataclass(frozen=True, slots=True)
class Units:
    """SI units of one kind of joint: `N*m` or `N`, `rad/s` or `m/s`, and so on."""

    torque: str
    speed: str
    position: str
    stiffness: str
    velocity_gain: str
    inertia: str


@cache
def units_of(joint: JointKind) -> Units:
    """The units of a hinge or a slide."""
    kinds = (Kind.TORQUE, Kind.SPEED, Kind.POSITION, Kind.STIFFNESS, Kind.VELOCITY_GAIN, Kind.INERTIA)
    return Units(*(unit_of_kind(kind, joint) for kind in kinds))
