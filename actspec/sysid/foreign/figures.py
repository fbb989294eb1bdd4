"""What is taken from another tool's file, and what is not."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from actspec.diagnostics import Collector, Path, Span, SpecError, dotted
from actspec.fields import unit_of_kind
from actspec.joints import JointKind
from actspec.logs import LogError
from actspec.spec.document import Document, document_from_text
from actspec.sysid.identified import FIELDS, FIGURE


@dataclass(frozen=True, slots=True)
class Given:
    """A file of another tool.

    Attributes:
        path: As given.
        data: Its bytes.
        sha256: Of them.
    """

    path: str
    data: bytes
    sha256: str


@dataclass(frozen=True, slots=True)
class Options:
    """What a file does not say itself.

    Attributes:
        joints: Names of joints, in the order of the file where it has one.
        layout: Blocks of a vector, in order.
        step: Physics step of the simulation that was fitted [s]; None: not stated.
        commit: Version of the tool; "": not stated.
        names: Parameter of the tool to (joint, field).
        linear: Whether the joints are slides.
    """

    joints: tuple[str, ...]
    layout: tuple[str, ...] = ()
    step: float | None = None
    commit: str = ""
    names: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    linear: bool = False


@dataclass(frozen=True, slots=True)
class Figure:
    """One number.

    Attributes:
        value: SI.
        unit: SI unit.
        std: Standard deviation; None where the source has none.
        note: What else is to be known of it.
    """

    value: float
    unit: str
    std: float | None = None
    note: str | None = None


@dataclass(slots=True)
class JointFound:
    """What was taken of one joint.

    Attributes:
        figures: By the fields of results.
        bounds_hit: Fields that ended at a bound.
        left_out: What was not taken, to the reason.
    """

    figures: dict[str, Figure] = field(default_factory=dict)
    bounds_hit: list[str] = field(default_factory=list)
    left_out: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Found:
    """What a file gave.

    Attributes:
        given: The file.
        method: Tool and model.
        commit: Version of the tool; "": unknown.
        joints: By name.
        note: What was not taken and is of no joint; "": nothing.
    """

    given: Given
    method: str
    commit: str
    joints: Mapping[str, JointFound]
    note: str = ""


AT_ZERO = 1e-6
"""Friction up to this is 0, the lower bound of BAM's and PACE's fits [SI]. Chosen: below what any joint has."""


def take(
    joint: JointFound, field: str, value: float, span: Span, collector: Collector, note: str | None = None
) -> None:
    """Friction of a fit that is bounded by 0; one at the bound has no value."""
    if value > AT_ZERO:
        joint.figures[field] = Figure(value, unit_of(field), note=note)
        return
    joint.bounds_hit.append(field)
    collector.warning(
        "SYS073", f"{field} is left out: {value} is at the lower bound of the fit, 0", span=span
    )


def unit_of(name: str, linear: bool = False) -> str:
    """SI unit of a field of results at a hinge, or at a slide."""
    return unit_of_kind(FIELDS[FIGURE[name]][1], JointKind.SLIDE if linear else JointKind.HINGE)


def document(given: Given, export: str) -> Document:
    """A file's YAML or JSON; it includes nothing.

    Raises:
        LogError: it is neither.
    """
    # Tabs may indent JSON, and cannot stand in its texts.
    data = given.data.replace(b"\t", b" ") if given.path.lower().endswith(".json") else given.data
    try:
        return document_from_text(data, given.path)
    except SpecError as err:
        first = err.diagnostics[0]
        raise LogError.of(
            "SYS070",
            f"is neither JSON nor YAML that is read: {first.message}",
            first.span or Span(given.path),
            help=export,
        ) from err


def number(
    read: Document, path: Path, value: Any, collector: Collector, *, at_least: float | None = None
) -> float | None:
    """A finite number at `path`; None after an error."""
    where, span = dotted(path), read.spans.value(path)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        collector.at(where, span).error("SYS072", f"must be a number, got {str(value)[:40]!r}")
        return None
    if not math.isfinite(value):
        collector.at(where, span).error("SYS072", f"is {value}", "the fit has not converged")
        return None
    if at_least is not None and value < at_least:
        collector.at(where, span).error("SYS072", f"must be at least {at_least:g}, got {value}")
        return None
    return float(value)
