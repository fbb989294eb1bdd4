"""What was taken of another tool's results, as text."""

from __future__ import annotations

from collections.abc import Iterator

from actspec.diagnostics import listed, many, one_line
from actspec.report.tables import table
from actspec.sysid.foreign.figures import Found
from actspec.units import format_number


def imported_lines(found: Found) -> Iterator[str]:
    """A table of figures, joints with the same ones together, and how much was left out."""
    alike: dict[tuple[tuple[str, float, float | None], ...], list[str]] = {}
    for name, joint in found.joints.items():
        same = tuple((field, figure.value, figure.std) for field, figure in joint.figures.items())
        alike.setdefault(same, []).append(name)
    for names in alike.values():
        joint = found.joints[names[0]]
        yield one_line(f"{listed(names)}: {found.method}")
        rows = [["field", "value", "std", "unit", ""]]
        for field, figure in joint.figures.items():
            std = "-" if figure.std is None else format_number(figure.std, 3)
            rows.append([field, format_number(figure.value), std, figure.unit, figure.note or ""])
        yield from table(rows)
    figures = sum(len(joint.figures) for joint in found.joints.values())
    left = sum(len(joint.left_out) + len(joint.bounds_hit) for joint in found.joints.values())
    yield f"{many(figures, 'figure')} of {many(len(found.joints), 'joint')}; left out: {left}"
