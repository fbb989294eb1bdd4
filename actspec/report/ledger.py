"""The ledger as tables: per file and kind of joint, joints with equal rows in one line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from actspec.audit.case import Case
from actspec.audit.ledger import LedgerRow
from actspec.diagnostics import listed, one_line
from actspec.ir import JointKind
from actspec.report.columns import COLUMNS, Column, cell, legend, marked, number
from actspec.report.compare import Comparison, comparisons
from actspec.report.style import Style
from actspec.report.tables import table


@dataclass(frozen=True, slots=True)
class LedgerTable:
    """One table.

    Attributes:
        title: File, robot and kind of joints.
        columns: Those with any figure other than 0.
        zero: Titles of those whose figures are all 0.
        kind: hinge, slide or unknown.
        rows: Joints, control and cells of each line.
        legend: What the marks in the cells mean; "" without marks.
    """

    title: str
    columns: tuple[Column, ...]
    zero: tuple[str, ...]
    kind: JointKind | None
    rows: tuple[tuple[tuple[str, ...], str, tuple[str, ...]], ...]
    legend: str


def ledger_tables(case: Case) -> Iterator[LedgerTable]:
    """Tables in the order of the files."""
    for index, artifact in enumerate(case.artifacts):
        rows = case.rows_of(index)
        slides = [row for row in rows if row.kind is JointKind.SLIDE]
        others = [row for row in rows if row.kind is not JointKind.SLIDE]
        title = (
            artifact.path if artifact.name in ("", artifact.path) else f"{artifact.path} ({artifact.name})"
        )
        if others:
            yield _table(title, others, others[0].kind)
        if slides:
            yield _table(f"{title}, slide joints" if others else title, slides, JointKind.SLIDE)


def _table(title: str, rows: Sequence[LedgerRow], kind: JointKind | None) -> LedgerTable:
    known = {column: {number(row, column) for row in rows} - {None} for column in COLUMNS}
    # Of rows with and without a figure the unknown ones would be lost in a list of zeros.
    zero = tuple(c for c in COLUMNS if known[c] == {0.0} and all(number(row, c) == 0.0 for row in rows))
    columns = tuple(column for column in COLUMNS if known[column] and column not in zero)
    merged: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for row in rows:
        key = (row.control, tuple(marked(row, column) for column in columns))
        merged.setdefault(key, []).append(
            f"{row.actuator} ({row.drives})".lstrip() if row.drives else row.joint
        )
    lines = tuple((tuple(joints), control, cells) for (control, cells), joints in merged.items())
    told = legend(
        text for _, _, cells in lines for column, text in zip(columns, cells, strict=True) if column.part
    )
    return LedgerTable(title, columns, tuple(column.title for column in zero), kind, lines, told)


def ledger_lines(case: Case, style: Style) -> Iterator[str]:
    """The ledger as text."""
    first = True
    for found in ledger_tables(case):
        if not first:
            yield ""
        first = False
        yield style.bold(one_line(found.title))
        # Titles of two words take two lines: there are many columns.
        words = [column.title.partition(" ") for column in found.columns]
        heads = [
            ("joints", "control", *(first for first, _, _ in words)),
            ("", "", *(rest for _, _, rest in words)),
            ("", "", *(column.unit(found.kind) for column in found.columns)),
        ]
        heads = [head for head in heads if any(head)]
        rows = [(listed(joints, 2), control, *cells) for joints, control, cells in found.rows]
        yield from table(_aligned([*heads, *rows], len(heads), found.columns), headings=len(heads))
        if found.legend:
            yield f"  {found.legend}"
        if found.zero:
            yield f"  0 for all: {', '.join(found.zero)}"
    if first:
        yield "no robot was read: there is no ledger"
    for comparison in comparisons(case):
        yield from _disagreement(comparison, style)


def _aligned(
    lines: Sequence[tuple[str, ...]], heads: int, columns: Sequence[Column]
) -> list[tuple[str, ...]]:
    """Lines of a table with the figures of marked columns below each other, the marks behind them."""
    found = [list(line) for line in lines]
    for place, column in enumerate(columns, 2):
        if not column.part:
            continue
        marks = max(len(line[place].partition(" ")[2]) for line in lines[heads:])
        if marks:
            for line in found[heads:]:
                figure, _, mark = line[place].partition(" ")
                line[place] = f"{figure} {mark.ljust(marks)}"
            width = max(len(line[place]) for line in found)
            for line in found:
                line[place] = line[place].rjust(width)
    return [tuple(line) for line in found]


def _disagreement(comparison: Comparison, style: Style) -> Iterator[str]:
    """Fields in which the files of one robot differ; the files by number, their paths are long."""
    lines = [line for line in comparison.lines if line.differs]
    if not lines:
        return
    yield ""
    yield style.bold(one_line(f"{comparison.robot}: where the files disagree"))
    for index, source in enumerate(comparison.sources, 1):
        yield f"  [{index}] {one_line(source)}"
    numbers = [f"[{index}]" for index in range(1, len(comparison.sources) + 1)]
    rows: list[tuple[str, ...]] = [("field", "", "joints", *numbers, "ratio")]
    for line in lines:
        values = (cell(value) for value in line.values)
        rows.append((line.column.title, line.unit, listed(line.joints, 2), *values, line.shown_ratio))
    yield from table(rows)
