"""A log from its table and its sidecar: which column is which signal of which joint, in SI units."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, did_you_mean, listed, shortened
from actspec.logs.log import BASE, SIGNALS, BaseLog, JointLog, Log, LogError, signal_like
from actspec.logs.sidecar import load_sidecar, sidecar_path
from actspec.logs.tables import Table, read_table
from actspec.patterns import PatternError, match_names
from actspec.spec.sidecar import Sidecar
from actspec.units import Kind, UnitError, parse_with_unit

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LEAST_ROWS = 20
"""Fewest rows of a log. Chosen: less is no experiment."""
SLOWEST = 0.5
"""Longest usual time between two rows [s]. Chosen: a drive's course cannot be seen at 2 Hz; milliseconds written as
seconds are longer."""
FASTEST = 5e-5
"""Shortest [s]. Chosen: no drive is read at 20 kHz over a link; seconds written as milliseconds or minutes are
shorter."""

_BASE: Mapping[str, Kind | None] = {
    f"base.{signal}.{component}": {
        "position": Kind.POSITION,
        "orientation": None,
    }.get(signal, Kind.SPEED)
    for signal, (components, _) in BASE.items()
    for component in components
}
"""Column of the base to its kind; None: without a unit."""
_UNIT = re.compile(r"(.*?)\s*\[([^\[\]]*)\]\s*", re.DOTALL)


@dataclass(frozen=True, slots=True)
class _Column:
    """One column: the file's name without its unit, ours, and its unit."""

    theirs: str
    ours: str
    unit: str | None
    index: int


@dataclass(frozen=True, slots=True)
class _Unit:
    """The unit of a column: its text, what one of it is in SI, 0 after an error, and whether it is a slide's."""

    column: _Column
    kind: Kind
    text: str
    scale: float
    linear: bool | None = None


def load_log(path: str) -> Log:
    """Read a log and its sidecar.

    Raises:
        LogError: with every error of both; a fault of a cell names its row.
    """
    table = read_table(path)
    sidecar = load_sidecar(path)
    out = Collector()
    columns = _columns(table, sidecar, path, out)
    time = _time(table, columns, sidecar, path, out)
    found: dict[str, dict[str, Array]] = {}
    parts: dict[str, list[_Unit]] = {}
    ignored = []
    base = {name: column for name, column in columns.items() if name in _BASE}
    for column in columns.values():
        if column.ours == "time" or column.ours in base:
            continue
        joint, _, signal = column.ours.rpartition(".")
        if not joint or signal not in SIGNALS:
            if not _misspelt(column, path, out):
                ignored.append(column.theirs)
            continue
        kind = SIGNALS[signal]
        scale = 1.0
        if kind is not None:
            unit = _unit_of(column, kind, sidecar, path, out)
            scale = unit.scale
            parts.setdefault(joint, []).append(unit)
        if (bits := _unsigned(table.columns[column.index])) is not None:
            message = (
                f"jumps between 0 and {2**bits - 1}: a signed number of {bits} bits, read as an unsigned one"
            )
            help = f"subtract {2**bits} from what is above {2 ** (bits - 1) - 1}"
            out.error("LOG014", message, where=column.theirs, span=Span(path, 1, column.index + 1), help=help)
        if kind is None and not set(table.columns[column.index].tolist()) <= {0.0, 1.0}:
            out.error("LOG014", "must be 0 or 1 in every row", where=column.theirs, span=Span(path, 1))
        found.setdefault(joint, {})[signal] = table.columns[column.index] * scale
    linear = {joint: _linear(units, path, out) for joint, units in parts.items()}
    moved = _base(table, base, sidecar, path, out)
    if not found and not out.failed:
        message = "no column is a signal of a joint"
        help = f"name columns `JOINT.SIGNAL [UNIT]`, or map them in {sidecar_path(path)}; signals: {', '.join(SIGNALS)}"
        for joint, _, text in (name.rpartition(".") for name in ignored):
            if joint and (like := signal_like(text)):
                near = shortened(joint)
                help = f"'{near}.{shortened(text)}' may be `{near}.{like}`: {help}"
                break
        out.error("LOG011", message, span=Span(path, 1), help=help)
    out.raise_if_failed(LogError)
    assert time is not None
    _check_sidecar(sidecar, columns, list(found), path)
    joints = {name: JointLog(name, linear.get(name), **signals) for name, signals in found.items()}
    digest = hashlib.sha256(table.data).hexdigest()
    return Log(path, digest, time, joints, sidecar, tuple(ignored), table.first_row, moved)


def _unsigned(values: Array) -> int | None:
    """Bits of a whole number below 0 that was read as one above it, as counts of a servo's bus; None: it was not."""
    import numpy as np

    known = values[np.isfinite(values)]
    if not len(known) or known.min() < 0.0 or np.any(known != np.round(known)):
        return None
    turns = np.abs(np.diff(known))
    near = (bits for bits in (16, 32) if 0.5 * 2**bits <= known.max() < 2**bits)
    return next((bits for bits in near if turns.max(initial=0.0) > 0.9 * 2**bits), None)


def _base(
    table: Table, columns: Mapping[str, _Column], sidecar: Sidecar, path: str, out: Collector
) -> BaseLog | None:
    """How the base moved, each signal with all its components; None: no column tells."""
    import numpy as np

    found: dict[str, Array] = {}
    for signal, (components, unit) in BASE.items():
        names = [f"base.{signal}.{component}" for component in components]
        there = [name for name in names if name in columns]
        if there and len(there) < len(names):
            lacking = listed(name for name in names if name not in there)
            out.error("LOG011", f"the log has {listed(there)}, and no {lacking}", span=Span(path, 1))
        if len(there) < len(names):
            continue
        parts = []
        for name in names:
            column, kind, scale = columns[name], _BASE[name], 1.0
            if kind is not None:
                read = _unit_of(column, kind, sidecar, path, out)
                scale = read.scale
                if read.linear is unit.startswith("rad"):
                    place = Span(path, 1, column.index + 1)
                    out.error("LOG013", f"must be in {unit}", where=column.theirs, span=place)
            parts.append(table.columns[column.index] * scale)
        found[signal] = np.stack(parts, axis=1)
    turn = found.get("orientation")
    if turn is not None and (bad := np.flatnonzero(np.abs(np.linalg.norm(turn, axis=1) - 1.0) > 0.1)).size:
        message = f"a quaternion has length 1, this one {np.linalg.norm(turn[bad[0]]):.3g}"
        place = Span(path, table.first_row + int(bad[0]))
        out.error("LOG014", message, where="base.orientation", span=place, help="order: w, x, y, z")
    return BaseLog(**found) if found else None


def _check_sidecar(
    sidecar: Sidecar, columns: Mapping[str, _Column], joints: Sequence[str], path: str
) -> None:
    """Units of columns that are not there, and gains of misspelt joints."""
    out = Collector()
    place = Span(sidecar_path(path))
    known = [*columns, *(column.theirs for column in columns.values()), *SIGNALS, "time"]
    for name in sidecar.units:
        if name not in known:
            help = did_you_mean(name, known, f"signals: {listed(SIGNALS)}")
            message = f"the log has no column '{shortened(name)}'"
            out.error("LOG015", message, where="units", span=place, help=help)
    for key, stated in (("gains", sidecar.gains), ("torque_constant", sidecar.torque_constant)):
        try:
            matched = {text: (text,) if text in joints else match_names(text, joints) for text in stated}
        except PatternError as err:
            out.error("LOG015", err.message, where=key, span=place, help=err.help)
            continue
        lacking = [name for name in joints if not any(name in names for names in matched.values())]
        for text in (text for text, names in matched.items() if not names and lacking):
            # Where all joints have theirs, the others are those of another log of the robot.
            message = f"'{shortened(text)}' is no joint of the log; none is stated for {listed(lacking)}"
            help = did_you_mean(text, lacking, f"joints: {listed(joints)}")
            out.error("LOG015", message, where=key, span=place, help=help)
    out.raise_if_failed(LogError)


def _columns(table: Table, sidecar: Sidecar, path: str, out: Collector) -> dict[str, _Column]:
    """By our name."""
    found: dict[str, _Column] = {}
    used = set()
    for index, header in enumerate(table.names):
        match = _UNIT.fullmatch(header)
        theirs, unit = (match[1], match[2]) if match else (header, None)
        used.update({header, theirs} & set(sidecar.columns))
        ours = sidecar.columns.get(header, sidecar.columns.get(theirs, theirs))
        if not ours:
            continue
        if ours in found:
            message = (
                f"two columns are {shortened(ours)}: {shortened(found[ours].theirs)}, {shortened(theirs)}"
            )
            out.error("LOG011", message, span=Span(path, 1, index + 1))
            continue
        found[ours] = _Column(theirs, ours, unit, index)
    for name in sidecar.columns:
        if name not in used:
            message = f"the log has no column '{shortened(name)}'"
            help = did_you_mean(name, table.names, f"columns: {listed(table.names)}")
            out.error("LOG011", message, where="columns", span=Span(sidecar_path(path)), help=help)
    return found


def _time(
    table: Table, columns: Mapping[str, _Column], sidecar: Sidecar, path: str, out: Collector
) -> Array | None:
    """From the first row on [s]."""
    import numpy as np

    column = columns.get("time")
    if column is None:
        help = did_you_mean("time", table.names, "the first column is `time [s]`")
        out.error("LOG012", "the log has no column `time`", span=Span(path, 1), help=help)
        return None
    if (scale := _unit_of(column, Kind.TIME, sidecar, path, out).scale) == 0.0:
        return None
    raw = table.columns[column.index]
    if (bad := np.flatnonzero(~np.isfinite(raw))).size:
        message = f"the time is not a number in {bad.size} rows"
        out.error("LOG012", message, span=Span(path, table.first_row + int(bad[0])))
        return None
    if len(raw) < LEAST_ROWS:
        message = f"the log has {len(raw)} rows, at least {LEAST_ROWS} are needed"
        out.error("LOG012", message, span=Span(path))
        return None
    if (back := np.flatnonzero(np.diff(raw) <= 0)).size:
        row = int(back[0]) + 1
        message = f"the time does not grow: {raw[row]:.9g} follows {raw[row - 1]:.9g}"
        more = f", and {back.size - 1} more times" if back.size > 1 else ""
        help = "a log is one recording: split the file where the time starts again"
        out.error("LOG012", message + more, span=Span(path, table.first_row + row), help=help)
        return None
    # Subtracted before it is scaled: times since 1970 have no digits to lose.
    time: Array = (raw - raw[0]) * scale
    step = float(np.median(np.diff(time)))
    if step > SLOWEST:
        message = f"a row comes every {step:.6g} s: no course of a drive can be seen at that rate"
        help = "is the unit right? Write `time [ms]` for milliseconds"
        out.error("LOG012", message, span=Span(path, 1), help=help)
    if step < FASTEST:
        message = f"a row comes every {step * 1e6:.6g} us: no robot is read at that rate"
        help = "is the unit right? Write `time [s]` for seconds"
        out.error("LOG012", message, span=Span(path, 1), help=help)
    return time


def _unit_of(column: _Column, kind: Kind, sidecar: Sidecar, path: str, out: Collector) -> _Unit:
    """A column's unit, by its header or the sidecar."""
    signal = column.ours.rpartition(".")[2]
    place = Span(path, 1, column.index + 1)
    stated = next(
        (sidecar.units[key] for key in (column.theirs, column.ours, signal) if key in sidecar.units), None
    )
    if column.unit is not None and stated is not None and column.unit != stated:
        message = f"two units are stated: [{column.unit}] in the header, {stated} in {sidecar_path(path)}"
        out.error("LOG013", message, where=column.theirs, span=place, help="remove one")
        return _Unit(column, kind, stated, 0.0)
    unit = column.unit if column.unit is not None else stated
    if unit is None:
        si = kind.rotary_unit
        help = f"write `{shortened(column.theirs)} [{si}]`, or `units: {{{signal}: {si}}}` in {sidecar_path(path)}"
        out.error("LOG013", "the column has no unit", where=column.theirs, span=place, help=help)
        return _Unit(column, kind, "", 0.0)
    try:
        parsed = parse_with_unit(1.0, unit, kind)
    except UnitError as err:
        out.error("LOG013", err.message, where=column.theirs, span=place, help=err.help)
        return _Unit(column, kind, unit, 0.0)
    return _Unit(column, kind, unit, parsed.value, parsed.linear)


def _linear(units: Sequence[_Unit], path: str, out: Collector) -> bool | None:
    """Whether a joint's columns are a slide's; the fewer that contradict the others are wrong, of two the second."""
    told = [unit for unit in units if unit.linear is not None]
    if not told:
        return None
    linear = max(
        (True, False), key=lambda kind: (sum(unit.linear is kind for unit in told), told[0].linear is kind)
    )
    others = [unit for unit in told if unit.linear is linear]
    for unit in told:
        if unit.linear is linear:
            continue
        noun, theirs = ("slide", "hinge") if linear else ("hinge", "slide")
        right = unit.kind.linear_unit if linear else unit.kind.rotary_unit
        rest = "column has" if len(others) == 1 else "columns have"
        shown = listed(f"[{one.text}]" for one in others)
        message = f"[{unit.text}] is a unit of a {theirs}, the joint's other {rest} a {noun}'s: {shown}"
        place = Span(path, 1, unit.column.index + 1)
        help = f"write [{right}], if that is what it is"
        out.error("LOG013", message, where=unit.column.theirs, span=place, help=help)
    return linear


def _misspelt(column: _Column, path: str, out: Collector) -> bool:
    """Whether a column's name is nearly that of a signal: then it is an error, and not left out."""
    import difflib

    joint, _, signal = column.ours.rpartition(".")
    near = [f"{joint}.{name}" for name in difflib.get_close_matches(signal, SIGNALS, n=1, cutoff=0.75)]
    if column.ours.startswith("base."):
        near = difflib.get_close_matches(column.ours, _BASE, n=1, cutoff=0.85) or near
    if not joint or not near:
        return False
    help = f"did you mean '{near[0]}'?"
    place = Span(path, 1, column.index + 1)
    out.error("LOG011", f"'{shortened(column.ours)}' is no signal of a joint", span=place, help=help)
    return True
