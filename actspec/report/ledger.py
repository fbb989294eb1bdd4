"""The ledger as tables: what acts on each joint, by file, and where the files of one robot disagree."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from actspec.audit.case import Case
from actspec.diagnostics import Span, listed, one_line
from actspec.fields import DAMPING_PARTS, FIELDS, Field, Role, unit_of
from actspec.ir import JointKind
from actspec.readings.artifact import Artifact
from actspec.readings.ledger import LedgerRow, bound_of_command
from actspec.report.page import CARDS, head_of, plain
from actspec.report.tables import Style, table
from actspec.units import format_number

COLUMNS = tuple(field for field in FIELDS.values() if field.name in LedgerRow.__dataclass_fields__)
"""Figures of a row, in the order in which reports show them."""

_SOLVERS = FIELDS["solver_effort_limit"]
"""A second clamp, which a table has where it is the lower one."""

_IN_TABLES = tuple(field for field in FIELDS.values() if field in (*COLUMNS, _SOLVERS))

_NOT_IN_JSON = ("stall_torque", "no_load_speed", "action_scale", "default_position")

JSON_FIELDS = tuple(column.name for column in COLUMNS if column.name not in _NOT_IN_JSON)
"""Figures of a ledger entry of `actspec-report/1`. Source: the design, §9."""

JSON_FLAGS = tuple(f"{name}_{flag}" for name in DAMPING_PARTS for flag in ("clamped", "implicit"))
"""Its properties of the damping. Source: the design, §7."""

COMPARED = tuple(
    FIELDS[name]
    for name in (
        "kp",
        "kd",
        "joint_damping",
        "total_damping",
        "frictionloss",
        "effort_limit",
        "velocity_limit",
        "armature",
        "action_scale",
        "default_position",
    )
)
"""What files can state; what is computed from a model alone is not compared."""

SAME = 1.005
"""A ratio up to here is rounding. Chosen: files write three digits."""

MARKS = {
    ("clamped", True): ("c", "clamped by the effort limit"),
    ("clamped", False): ("u", "not clamped by the effort limit"),
    ("implicit", True): ("i", "integrated implicitly"),
    ("implicit", False): ("e", "integrated explicitly"),
}
"""What is known of a part of the damping, to its mark and the mark in words. What is unknown has no mark."""


_BOUND = "b"
"""The mark of an effort that no limit bounds, but what is commanded."""


def cell(value: float | None) -> str:
    """A figure for people: `-` is unknown, `inf` no limit."""
    return "-" if value is None else format_number(value, 4)


Row = tuple[str | tuple[str, ...], ...]
"""Cells of a line; a tuple of names is shortened by who writes it."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """A table in any form: text, Markdown or HTML.

    Attributes:
        title: What it is about.
        heads: Title and unit of each column.
        rows: Its lines.
        notes: Lines below it.
        differing: Numbers of rows that stand out.
        marked: Numbers of columns whose figures have marks behind them.
    """

    title: str
    heads: tuple[tuple[str, str], ...]
    rows: tuple[Row, ...]
    notes: tuple[str, ...] = ()
    differing: frozenset[int] = frozenset()
    marked: tuple[int, ...] = ()

    def titles(self) -> list[str]:
        """Each column's title with its unit."""
        return [f"{title} [{unit}]" if unit else title for title, unit in self.heads]

    def cells(self, most: int) -> Iterator[list[str]]:
        """The rows as text.

        Args:
            most: Names of one cell that are written out.
        """
        for row in self.rows:
            yield [one if isinstance(one, str) else listed(one, most) for one in row]


# --- what acts on each joint ---------------------------------------------------------------------


def ledger_sheets(case: Case) -> Iterator[Sheet]:
    """One table a file and kind of joint, in the order of the files; joints with equal rows share a line."""
    for index, artifact in enumerate(case.artifacts):
        rows = case.rows_of(index)
        slides = [row for row in rows if row.kind is JointKind.SLIDE]
        others = [row for row in rows if row.kind is not JointKind.SLIDE]
        bounds = _bounds(artifact, rows)
        named = artifact.name not in ("", artifact.path)
        title = f"{artifact.path} ({artifact.name})" if named else artifact.path
        if others:
            yield _sheet(title, others, bounds)
        if slides:
            yield _sheet(f"{title}, slide joints" if others else title, slides, bounds)


def _bounds(artifact: Artifact, rows: Sequence[LedgerRow]) -> dict[Span, float]:
    """Where the clamped command of a joint's only servo bounds its torque, and no limit does: place to bound."""
    views = {} if artifact.robot is None else {view.span: view for view in artifact.robot.actuators}
    count = Counter(row.joint for row in rows)
    found = {}
    for row in rows:
        if row.effort_limit == math.inf and count[row.joint] == 1 and row.span in views:
            bound = bound_of_command(row, views[row.span])
            if bound is not None:
                found[row.span] = bound[0] * bound[1]
    return found


def _sheet(title: str, rows: Sequence[LedgerRow], bounds: Mapping[Span, float]) -> Sheet:
    known = {column: {_number(row, column) for row in rows} - {None} for column in _IN_TABLES}
    # Of rows with and without a figure the unknown ones would be lost in a list of zeros.
    zero = [c for c in _IN_TABLES if known[c] == {0.0} and all(_number(row, c) == 0.0 for row in rows)]
    columns = [column for column in _IN_TABLES if known[column] and column not in zero]
    merged: dict[tuple[str, ...], list[str]] = {}
    for row in rows:
        name = f"{row.actuator} ({row.drives})".lstrip() if row.drives else row.joint
        merged.setdefault((row.control, *(_marked(row, column, bounds) for column in columns)), []).append(
            name
        )
    marked = tuple(place for place, column in enumerate(columns, 2) if column.name in DAMPING_PARTS)
    notes = list(_legend(cells[place - 1] for cells in merged for place in marked))
    if any(row.span in bounds for row in rows):
        marked += tuple(place for place, column in enumerate(columns, 2) if column.name == "effort_limit")
        notes.append(f"effort limit: {_BOUND} none, bounded by the clamped command (LIM101)")
    if zero:
        notes.append(f"0 for all: {', '.join(column.title for column in zero)}")
    heads = (("joints", ""), ("control", ""), *((column.title, _unit(rows, column)) for column in columns))
    lines: tuple[Row, ...] = tuple((tuple(joints), *cells) for cells, joints in merged.items())
    return Sheet(title, heads, lines, tuple(notes), marked=marked)


def _number(row: LedgerRow, column: Field) -> float | None:
    if column is _SOLVERS:
        clamp = row.more.get(column.name)
        return clamp if clamp is not None and (row.effort_limit is None or clamp < row.effort_limit) else None
    value: float | None = getattr(row, column.name)
    return None if value is None or math.isnan(value) else float(value)


def _unit(rows: Sequence[LedgerRow], column: Field) -> str:
    """The unit of a column; "" where its rows have several, as the scales of positions and speeds."""
    units = {row.unit(column.name) for row in rows if _number(row, column) is not None}
    return units.pop() if len(units) == 1 else ""


def _marked(row: LedgerRow, column: Field, bounds: Mapping[Span, float]) -> str:
    """A row's figure; a part of the damping with its marks, `0.5 ui`, and so what bounds the effort without a limit."""
    value = _number(row, column)
    if column.name == "effort_limit" and row.span in bounds:
        return f"{cell(bounds[row.span])} {_BOUND}"
    if column.name not in DAMPING_PARTS or not value:
        return cell(value)
    known = ((flag, getattr(row, f"{column.name}_{flag}")) for flag in ("clamped", "implicit"))
    return f"{cell(value)} {''.join(MARKS[item][0] for item in known if item in MARKS)}".rstrip()


def _legend(texts: Iterable[str]) -> Iterator[str]:
    """The marks that stand in cells, in words."""
    used = {mark for text in texts for mark in text.partition(" ")[2]}
    meant = [f"{mark} {words}" for mark, words in MARKS.values() if mark in used]
    if meant:
        yield f"damping: {', '.join(meant)}"


# --- where files disagree ------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Line:
    """One field of joints that have the same values in every source.

    Attributes:
        joints: Their names.
        field: The field.
        unit: Of the values.
        values: One a source; None is unknown.
        ratio: Largest over smallest magnitude; None when fewer than two are known; inf beside 0 or no limit.
    """

    joints: tuple[str, ...]
    field: Field
    unit: str
    values: tuple[float | None, ...]
    ratio: float | None

    @property
    def differs(self) -> bool:
        """Whether sources disagree."""
        return self.ratio is not None and self.ratio > SAME


@dataclass(frozen=True, slots=True)
class Comparison:
    """One robot.

    Attributes:
        robot: Its name.
        sources: Its artifacts, as headings.
        lines: By field, then by joint.
    """

    robot: str
    sources: tuple[str, ...]
    lines: tuple[Line, ...]

    def sheet(self, names: Sequence[str], differs: bool = True) -> Sheet | None:
        """The fields in which files disagree, or agree; None when there are none.

        Args:
            names: Headings of the sources.
            differs: Which of the two.
        """
        lines = [line for line in self.lines if line.differs is differs]
        if not lines:
            return None
        heads = (("field", ""), ("joints", ""), *((name, "") for name in names), ("ratio", ""))
        rows: tuple[Row, ...] = tuple(
            (
                f"{line.field.title} [{line.unit}]" if line.unit else line.field.title,
                line.joints,
                *map(cell, line.values),
                cell(line.ratio),
            )
            for line in lines
        )
        title = f"{self.robot}: where the files {'disagree' if differs else 'agree'}"
        return Sheet(title, heads, rows, differing=frozenset(range(len(rows)) if differs else ()))


def comparisons(case: Case) -> Iterator[Comparison]:
    """Robots that more than one source describes."""
    for robot in case.robots:
        if len(robot.artifacts) > 1:
            sources = tuple(_source(case.artifacts[index]) for index in robot.artifacts)
            lines = tuple(_lines([case.rows_of(index) for index in robot.artifacts]))
            if lines:
                yield Comparison(robot.name, sources, lines)


def _source(artifact: Artifact) -> str:
    named = artifact.config is not None and artifact.name not in ("", artifact.path)
    return f"{artifact.path} ({artifact.name})" if named else artifact.path


def _lines(sources: Sequence[Sequence[LedgerRow]]) -> Iterator[Line]:
    joints = dict.fromkeys(row.joint for rows in sources for row in rows if row.joint)
    for column in COMPARED:
        merged: dict[tuple[str, tuple[float | None, ...]], list[str]] = {}
        for joint in joints:
            own = [[row for row in rows if row.joint == joint] for rows in sources]
            values = tuple(_value(rows, column) for rows in own)
            if sum(value is not None for value in values) > 1:
                kind = next((row.kind for rows in own for row in rows if row.kind is not None), None)
                command = next((row.command for rows in own for row in rows if row.command), "")
                merged.setdefault((unit_of(column.name, kind, command), values), []).append(joint)
        for (unit, values), names in merged.items():
            yield Line(tuple(names), column, unit, values, _ratio(values))


def _value(rows: Sequence[LedgerRow], column: Field) -> float | None:
    """Of a joint in one source; of several actuators the first that states it.

    A joint without actuator leaves its limit, and the passive figures that it does not state, to whoever drives
    it; it and a motor leave the gains to a controller outside of the file, which is not a gain of 0.
    """
    return next((value for row in rows if (value := _stated(row, column)) is not None), None)


def _stated(row: LedgerRow, column: Field) -> float | None:
    value = _number(row, column)
    if column.role in (Role.DRIVE, Role.TOTAL) and row.control in ("none", "motor"):
        return None
    bare = row.control == "none" and column.name not in row.stated
    return None if bare and value in (0.0, math.inf) else value


def _ratio(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    sizes = [abs(value) for value in known]
    if len(known) < 2:
        return None
    if max(known) == min(known):
        return 1.0
    if min(known) < 0.0 < max(known) or min(sizes) == 0.0 or math.isinf(max(sizes)):
        return math.inf
    return max(sizes) / min(sizes)


# --- as text -------------------------------------------------------------------------------------


def ledger_lines(case: Case, style: Style) -> Iterator[str]:
    """The ledger as text, then where files disagree."""
    sheets = list(ledger_sheets(case))
    for index, sheet in enumerate(sheets):
        if index:
            yield ""
        yield style.bold(one_line(sheet.title))
        yield from _ledger_text(sheet)
        yield from (f"  {note}" for note in sheet.notes)
    if not sheets:
        yield "no robot was read: there is no ledger"
    for comparison in comparisons(case):
        # The files by number: their paths are long.
        numbers = [f"[{index}]" for index in range(1, len(comparison.sources) + 1)]
        found = comparison.sheet(numbers)
        if found is not None:
            yield ""
            yield style.bold(one_line(found.title))
            for number, source in zip(numbers, comparison.sources, strict=True):
                yield f"  {number} {one_line(source)}"
            yield from table([found.titles(), *found.cells(most=2)])


def _ledger_text(sheet: Sheet) -> list[str]:
    """A table with titles of two words on two lines, because there are many columns, and marks behind figures."""
    words = [title.partition(" ") for title, _ in sheet.heads]
    heads = [[first for first, _, _ in words], [rest for _, _, rest in words], [u for _, u in sheet.heads]]
    heads = [head for head in heads if any(head)]
    rows = list(sheet.cells(most=2))
    for place in sheet.marked:
        width = max(len(row[place].partition(" ")[2]) for row in rows)
        if width:
            for row in rows:
                figure, _, mark = row[place].partition(" ")
                row[place] = f"{figure} {mark.ljust(width)}"
            most = max(len(row[place]) for row in (*heads, *rows))
            for row in (*heads, *rows):
                row[place] = row[place].rjust(most)
    return table([*heads, *rows], headings=len(heads))


def sheet_table(sheet: Sheet, css: str = "", above: str = "", *, cards: bool = False) -> Iterator[str]:
    """A sheet as HTML; figures, from the third column on, stand right.

    Args:
        sheet: The table.
        css: Class of the headings of figures.
        above: A line before it.
        cards: Whether a row is a card on a phone; see `plain_table`.
    """
    if above:
        yield above
    figure_head = f'<th class="{css}">' if css else "<th>"
    heads = (
        ("<th>" if place < 2 or title == "ratio" else figure_head) + f"{plain(title)}</th>"
        for place, title in enumerate(sheet.titles())
    )
    yield f'<div class="wide"><table{CARDS * cards}><tr>{"".join(heads)}</tr>'
    names = [head_of(title, cards) for title in sheet.titles()]
    for number, (row, cells) in enumerate(zip(sheet.rows, sheet.cells(most=6), strict=True)):
        yield '<tr class="differs">' if number in sheet.differing else "<tr>"
        for place, (raw, text) in enumerate(zip(row, cells, strict=True)):
            kind = ' class="long"' if not isinstance(raw, str) else ' class="n"' if place > 1 else ""
            yield f"<td{kind}{names[place]}>{plain(text)}</td>"
        yield "</tr>"
    yield "</table></div>"
    yield from (f'<p class="faint">{plain(note)}</p>' for note in sheet.notes)
