"""Numbers of a foreign file as quantities: what it states, what its engine puts there, what nobody says."""

from __future__ import annotations

from actspec.diagnostics import Span
from actspec.ir import JointKind, Origin, Quantity
from actspec.resolution.quantities import unit_of
from actspec.units import Kind


def stated(
    value: float, unit: str, span: Span, *, note: str | None = None, formula: str | None = None
) -> Quantity:
    """A number that a file states at `span`, or that follows from one by `formula`."""
    return Quantity(value + 0.0, unit, Origin.MODEL, source=span.path, span=span, note=note, formula=formula)


def assumed(value: float, unit: str, note: str) -> Quantity:
    """What an engine takes where the file is silent; `note` says whose default it is."""
    return Quantity(value, unit, Origin.DEFAULT, note=note)


def unknown(unit: str, note: str | None = None, span: Span | None = None) -> Quantity:
    """A number that the file does not tell; with a place where it writes something else."""
    source = None if span is None else span.path
    return Quantity(None, unit, Origin.UNKNOWN, source=source, span=span, note=note)


class Units:
    """Units of one kind of joint."""

    def __init__(self, kind: JointKind) -> None:
        self.torque = unit_of(Kind.TORQUE, kind)
        self.speed = unit_of(Kind.SPEED, kind)
        self.position = unit_of(Kind.POSITION, kind)
        self.stiffness = unit_of(Kind.STIFFNESS, kind)
        self.velocity_gain = unit_of(Kind.VELOCITY_GAIN, kind)
        self.inertia = unit_of(Kind.INERTIA, kind)
