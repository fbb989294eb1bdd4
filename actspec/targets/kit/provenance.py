"""What the head of every written file says in the same words: what was lost, and where numbers come from."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import actspec
from actspec.diagnostics import one_line
from actspec.ir import ActuatorSet, Origin, Quantity
from actspec.targets.base import Approximation
from actspec.targets.kit.python_text import grouped
from actspec.units import format_quantity


def loss_lines(
    approximations: Iterable[Approximation], digits: int = 6, all_joints: int | None = None
) -> Iterator[str]:
    """One line for the joints that lose the same.

    Args:
        approximations: Of one target.
        digits: Significant digits of the size.
        all_joints: Where so many joints lose the same they are not named; None: they are.
    """
    comma = ";" if all_joints is None else ","
    for loss, members in grouped(approximations, lambda one: replace(one, joint="")):
        error = loss.max_torque_error
        size = "" if error is None else f"{comma} at most {format_quantity(error, loss.unit, digits)}"
        if size and loss.at:
            size += f" {loss.at}"
        named = [member.joint for member in members if member.joint and len(members) != all_joints]
        tail = f": {', '.join(named)}" if named else ""
        yield f"{loss.field}: {loss.asked} -> {loss.emitted}{size} ({loss.why}){tail}"


def source_lines(actuators: ActuatorSet, shown: Iterable[Quantity]) -> Iterator[str]:
    """One line for each entry of `sources` that the shown numbers cite, in the spec's order."""
    used = {quantity.source for quantity in shown}
    for source in actuators.sources:
        if source.key in used:
            commit = f"commit {source.commit}" if source.commit else None
            parts = (source.title, source.url, source.page, commit)
            yield f"{source.key}: " + ", ".join(part for part in parts if part)


def with_origin(quantity: Quantity, *remarks: str) -> str:
    """A known number with its origin, formula, source and deviation: `25 N*m/rad (authored; manual)`.

    Args:
        quantity: The number; `unknown` stands alone.
        remarks: What else to say, behind the origin.
    """
    text = format_quantity(quantity.value, quantity.unit)
    if quantity.value is None:
        return text
    about = [quantity.origin.value, *remarks]
    if quantity.formula:
        about.append(quantity.formula)
    if quantity.source and quantity.origin is not Origin.MODEL:
        about.append(quantity.source)
    if quantity.std is not None:
        about.append(f"std {format_quantity(quantity.std, quantity.unit)}")
    return f"{text} ({'; '.join(about)})"


def written_by(title: str = "") -> str:
    """First line of every file; `title`: ` for MuJoCo 3.12`."""
    return f"Written by actspec {actspec.__version__}{title}. Do not edit: change the spec and compile again."


def sections(
    actuators: ActuatorSet,
    approximations: Iterable[Approximation],
    heading: str,
    shown: Iterable[Quantity] | None = None,
    digits: int = 6,
) -> Iterator[tuple[str, list[str]]]:
    """What a head ends with: the losses under their heading, then the sources; what is empty is left out.

    Args:
        actuators: What was compiled.
        approximations: What the target lost.
        heading: Of the losses.
        shown: Numbers of the file; None: all that are known.
        digits: Significant digits of a loss's size.
    """
    lost = list(loss_lines(approximations, digits))
    if lost:
        yield heading, lost
    cited = list(source_lines(actuators, known_quantities(actuators) if shown is None else shown))
    if cited:
        yield "Sources:", cited


def xml_head(head: Iterable[str], below: Iterable[tuple[str, Iterable[str]]]) -> str:
    """One XML comment: first lines, and headings with their lines."""
    lines = list(head)
    for heading, said in below:
        lines += ["", heading, *(f"  {line}" for line in said)]
    return xml_comment(lines)


def xml_comment(lines: Iterable[str]) -> str:
    """One XML comment of indented lines, with nothing in it that would end it."""
    body = "\n".join(f"  {line}".rstrip() for line in map(_in_comment, lines))
    return f"<!--\n{body}\n-->"


def _in_comment(line: str) -> str:
    """A line that cannot end the comment: no `--`, no control characters."""
    safe = one_line(line)
    while "--" in safe:
        safe = safe.replace("--", "- -")
    return safe


def known_quantities(actuators: ActuatorSet) -> Iterator[Quantity]:
    """Every number of every joint that is known."""
    return (q for actuator in actuators.joints for _, q in actuator.quantities() if q.known)
