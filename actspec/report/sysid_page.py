"""A fit as one page: every figure with its interval, the logs beside the fitted joints, and what is not told."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import actspec
from actspec.diagnostics import Diagnostic, listed, many, shell_word
from actspec.fields import BY_SPEC
from actspec.ir import ActuatorSet, JointActuator, Origin, Quantity
from actspec.logs import Log
from actspec.report.axes import Axis, plot_style
from actspec.report.page import articles, figure, fold, plain, plain_table, whole
from actspec.report.row_pictures import Interval, intervals
from actspec.report.sysid_answers import loop_of
from actspec.report.sysid_pictures import pictures
from actspec.resources import data_path
from actspec.spec.remedy import remedy
from actspec.spec.results import JointResult, Results, value_of
from actspec.spec.validate import Spec
from actspec.spec.variants import named
from actspec.sysid.identified import FIELDS, METHODS
from actspec.sysid.replay import SPEC, Replay
from actspec.sysid.system import WIDE
from actspec.units import format_number

NAMES = tuple(field for field, _ in FIELDS.values())
"""Fields of a fit, in the order in which they are shown."""
EVEN = 0.05
"""Difference of an interval's two halves, as a share of the larger, that is not worth two numbers. Chosen."""
NO_FIGURE = "This method tells no figure of the spec; what it tells stands with the joints."
ABSOLUTE = ("delay", "encoder_bias")
"""Fields whose change is a difference: a share of nearly 0 tells nothing."""


@dataclass(frozen=True, slots=True)
class Identified:
    """A results file, and what belongs to it.

    Attributes:
        path: Of the file.
        results: What stands in it.
        sha256: Of its bytes.
        spec: The spec; None: it is not there.
        actuators: The spec, resolved; None: its model is not there.
        replays: Joint to its logs, simulated.
        logs: Logs that are there.
        findings: What is missing or wrong.
    """

    path: str
    results: Results
    sha256: str
    spec: Spec | None
    actuators: ActuatorSet | None
    replays: Mapping[str, Sequence[Replay]]
    logs: Sequence[Log]
    findings: Sequence[Diagnostic]


@dataclass(frozen=True, slots=True)
class _Row:
    """One figure of a joint; SI."""

    field: str
    state: str
    value: float | None
    std: float | None
    unit: str
    spec: float | None
    origin: str
    ends: tuple[float, float] | None = None

    @property
    def low(self) -> float | None:
        """Of the 95 % interval: as the file has it, else by the standard deviation."""
        if self.ends is not None:
            return self.ends[0]
        if self.value is None or self.std is None:
            return None
        low = self.value - WIDE * self.std
        return low if self.field == "encoder_bias" else max(low, 0.0)

    @property
    def high(self) -> float | None:
        if self.ends is not None:
            return self.ends[1]
        return None if self.value is None or self.std is None else self.value + WIDE * self.std


def render(shown: Identified) -> str:
    """The page.

    Args:
        shown: What it is about.
    """
    rows = {name: _rows(shown, name, joint) for name, joint in shown.results.joints.items()}
    told = sum(row.state == "identified" for mine in rows.values() for row in mine)
    untold = sum(_untold(row) for mine in rows.values() for row in mine)
    title = f"{shown.results.robot}: {many(told, 'figure')} identified" + (
        f", {untold} not told" if untold else ""
    )
    body = [
        f"<h1>{plain(title)}</h1>",
        *_head(shown),
        *(["<h2>Findings</h2>"] if shown.findings else []),
        *articles(shown.findings),
        *_overview(rows),
        *_not_told(shown, rows),
        *_intervals(rows),
    ]
    for place, (name, joint) in enumerate(shown.results.joints.items()):
        body += _joint(shown, place, name, joint, rows[name])
    body += [*_files(shown), *_commands(shown), f'<p class="faint">actspec {plain(actspec.__version__)}</p>']
    own = data_path("templates", "report/sysid.css").read_text(encoding="utf-8")
    return whole(title, body, (plot_style(), own))


def _untold(row: _Row) -> bool:
    return row.state in ("not told", "at its bound")


def _head(shown: Identified) -> Iterator[str]:
    results = shown.results
    parts = [f"method {results.method}", many(len(results.joints), "joint")]
    parts += [many(len(results.data), "log")] if results.method in METHODS else []
    parts += [
        part for part in (results.date, results.temperature and f"{results.temperature} motors") if part
    ]
    if results.held_out_rmse is not None and results.held_out_rmse.value is not None:
        text = f"{results.held_out_rmse.value:.3g}"
        unit = results.held_out_rmse.unit or ""
        parts.append(f"position error {text} {unit} on pieces that the fit did not see".replace("  ", " "))
    if results.condition is not None:
        parts.append(f"condition number {results.condition:.3g}")
    yield f'<p class="faint">{plain("; ".join(parts))}.</p>'
    if results.note:
        yield f"<p>{plain(results.note)}</p>"
    if len(results.joints) > 1:
        links = " ".join(
            f'<a href="#joint-{place}">{plain(name)}</a>' for place, name in enumerate(results.joints)
        )
        yield f"<nav>{links}</nav>"


def _rows(shown: Identified, name: str, result: JointResult) -> list[_Row]:
    """The figures that the file tells, holds or lists without a value."""
    actuator = shown.actuators.joint(name) if shown.actuators is not None else None
    found = []
    for field, kind in FIELDS.values():
        stated = value_of(result, field)
        spec, origin = _of_spec(actuator, field)
        unit = kind.rotary_unit if actuator is None else BY_SPEC.get(field, BY_SPEC["kp"]).unit(actuator.kind)
        if field not in BY_SPEC:
            unit = kind.rotary_unit
        gains = result.gains
        if stated is not None and stated.value is not None:
            value, ends = stated.value, result.intervals.get(field)
            found.append(
                _Row(field, "identified", value, stated.std, stated.unit or unit, spec, origin, ends)
            )
        elif field in result.bounds_hit:
            found.append(_Row(field, "at its bound", None, None, unit, spec, origin))
        elif field in result.unidentifiable:
            found.append(_Row(field, "not told", None, None, unit, spec, origin))
        elif gains is not None and field in ("kp", "kd"):
            held = gains.kp if field == "kp" else gains.kd
            found.append(_Row(field, "held", held.value, None, held.unit or unit, spec, origin))
    return found


def _of_spec(actuator: JointActuator | None, field: str) -> tuple[float | None, str]:
    """What the spec has without the results, and where from."""
    if actuator is None:
        return None, ""
    if field == "delay":
        quantity: Quantity | None = actuator.delay.nominal if actuator.delay is not None else None
    elif field == "bandwidth":
        quantity = actuator.filter_cutoff
    else:
        quantity = getattr(actuator, BY_SPEC[field].ir)
    while quantity is not None and quantity.origin is Origin.IDENTIFIED:
        quantity = quantity.lost[0] if quantity.lost else None
    if quantity is None:
        return None, ""
    return quantity.value, quantity.origin.value


def _change(row: _Row) -> str:
    if row.value is None or row.spec is None:
        return ""
    away = row.value - row.spec
    if row.field in ABSOLUTE:
        text = f"{away:+.3g} {row.unit}"
    elif row.spec == 0.0:
        return ""
    else:
        text = f"{100.0 * away / abs(row.spec):+.3g} %"
    if row.low is not None and row.high is not None and not row.low <= row.spec <= row.high:
        text += ", outside"
    return text


def _number(value: float | None, std: float | None = None) -> str:
    """With the digits that its standard deviation leaves; without one with all that the file gives."""
    if value is None:
        return ""
    if not std:
        return format_number(value)
    places = 1 - math.floor(math.log10(std))
    rounded = round(value, places)
    return f"{rounded:.{places}f}" if 0 < places < 7 else format_number(rounded)


def _overview(rows: Mapping[str, Sequence[_Row]]) -> Iterator[str]:
    """Joint by field, where there are several."""
    if len(rows) < 2:
        return
    fields = [field for field in NAMES if any(row.field == field for mine in rows.values() for row in mine)]
    units = {row.field: row.unit for mine in rows.values() for row in mine}
    lines = []
    for name, mine in rows.items():
        by = {row.field: row for row in mine}
        lines.append([name, *(_short(by.get(field)) for field in fields)])
    yield "<h2>Figures</h2>"
    heads = ["joint", *(f"{field} [{units[field]}]" for field in fields)]
    yield from plain_table(heads, lines, range(1, len(heads)))
    said = (
        "Value and half of the 95 % interval, both halves where it is uneven; in brackets: held; -: not told."
    )
    yield f'<p class="faint">{plain(said)}</p>'


def _short(row: _Row | None) -> str:
    """Value and interval in one cell; an uneven interval has two halves."""
    if row is None:
        return ""
    if row.value is None:
        return "-"
    if row.low is None or row.high is None:
        return f"({_number(row.value)})" if row.state == "held" else _number(row.value)
    above, below = row.high - row.value, row.value - row.low
    wide = max(above, below)
    value = _number(row.value, wide)
    if abs(above - below) <= EVEN * wide:
        return f"{value} ± {_number(wide, wide)}"
    return f"{value} +{_number(above, wide)} −{_number(below, wide)}"


def _not_told(shown: Identified, rows: Mapping[str, Sequence[_Row]]) -> Iterator[str]:
    """What has no value, why, and what would give it one."""
    found: dict[tuple[str, str, str, str | None], list[str]] = {}
    for name, mine in rows.items():
        result = shown.results.joints[name]
        for row in mine:
            if _untold(row):
                would = remedy(row.field, result)
                why = result.reasons.get(row.field, "")
                key = (row.field, f"{row.state}: {why}" if why else row.state, would.words, would.experiment)
                found.setdefault(key, []).append(name)
    left_out = [
        [field, name, why]
        for name, joint in shown.results.joints.items()
        for field, why in joint.left_out.items()
    ]
    if left_out:
        yield "<h2>What another tool found and these results have not</h2>"
        yield from plain_table(["figure", "joint", "why"], left_out)
    if shown.results.method not in METHODS and not found:
        return
    yield "<h2>What the logs do not tell</h2>"
    if not found:
        told = any(rows.values())
        said = "Every figure of this fit has a value and an interval." if told else NO_FIGURE
        yield f"<p>{plain(said)}</p>"
        return
    lines = []
    for (field, why, words, experiment), names in found.items():
        command = "" if experiment is None else design(_spec_path(shown), experiment, names)
        lines.append(
            f"<tr><td>{plain(field)}</td><td>{plain(listed(names, 12))}</td><td class=long>{plain(why)}</td>"
            f"<td class=long>{plain(words)}{f'<pre>{plain(command)}</pre>' if command else ''}</td></tr>"
        )
    yield '<div class="wide"><table><tr><th>field</th><th>joints</th><th>why</th><th>what would tell it</th></tr>'
    yield from lines
    yield "</table></div>"


def design(spec: str, experiment: str, joints: Sequence[str]) -> str:
    """The command line that designs an experiment, safe to paste into a shell.

    Args:
        spec: Path.
        experiment: Of `design`.
        joints: That it moves.
    """
    words = ["actspec", "sysid", "design", spec, "-o", f"{experiment}.csv", "--experiment", experiment]
    for joint in joints:
        words += ["--joint", joint]
    return " ".join(map(shell_word, words))


def _spec_path(shown: Identified) -> str:
    if shown.spec is not None:
        return named(shown.spec.document.path, shown.spec.document.variant)
    return shown.results.spec.path if shown.results.spec is not None else "SPEC"


def _intervals(rows: Mapping[str, Sequence[_Row]]) -> Iterator[str]:
    """A picture a field: each joint's interval beside the spec's value."""
    if not any(row.value is not None for mine in rows.values() for row in mine):
        return
    yield "<h2>Intervals of 95 %</h2>"
    yield '<div class="grid">'
    for field in NAMES:
        mine = {name: row for name, all_rows in rows.items() for row in all_rows if row.field == field}
        if not any(row.value is not None for row in mine.values()):
            continue
        unit = next(iter(mine.values())).unit
        lines = [
            Interval(name, row.value, row.low, row.high, row.spec, row.state) for name, row in mine.items()
        ]
        outside = [name for name, row in mine.items() if _change(row).endswith("outside")]
        text = f"The spec's value is outside of the interval of {listed(outside)}." if outside else ""
        yield from figure(
            intervals(f"{field}: 95 % intervals by joint", Axis(field, unit), lines), field, text
        )
    yield "</div>"


def _joint(
    shown: Identified, place: int, name: str, result: JointResult, rows: Sequence[_Row]
) -> Iterator[str]:
    yield f'<h2 id="joint-{place}">{plain(name)}</h2>'
    heads = ["field", "value", "std", "95 %", "unit", "spec", "change", "state"]
    lines = []
    for row in rows:
        interval = "" if row.low is None else f"{_number(row.low, row.std)} to {_number(row.high, row.std)}"
        spec = f"{_number(row.spec)} ({row.origin})" if row.spec is not None else row.origin
        lines.append(
            [
                row.field,
                _number(row.value, row.std) or "-",
                _number(row.std, row.std),
                interval,
                row.unit,
                spec,
                _change(row),
                row.state,
            ]
        )
    if lines:
        yield from plain_table(heads, lines, (1, 2, 3, 5, 6))
    yield from _beside(result)
    if name in shown.replays:
        if any(one.name == SPEC for one in shown.replays[name]):
            told = [FIELDS[figure][0] for figure in FIELDS if figure in shown.replays[name][0].told]
            of = f", with the {listed(told)} of these results" if told else ""
            said = f"Simulated is the spec's joint{of}: this method fits no motion."
            yield f'<p class="faint">{plain(said)}</p>'
        for one in shown.replays[name]:
            yield from pictures(one, loop_of(result), named=len(shown.replays[name]) > 1)
    else:
        yield '<p class="faint">No log of this joint is simulated.</p>'
    yield from _correlation(result)


def _beside(result: JointResult) -> Iterator[str]:
    """Combinations and diagnostics."""
    if result.combinations:
        yield "<p>What the logs tell of several figures together:</p>"
        yield from plain_table(
            ["combination", "value", "std", "unit"],
            [
                [name, _number(one.value, one.std), _number(one.std, one.std), one.unit]
                for name, one in result.combinations.items()
            ],
            (1, 2),
        )
    if result.diagnostics or result.closed_loop_bandwidth is not None:
        lines = [
            [name, _number(one.value, one.std), _number(one.std, one.std), one.unit]
            for name, one in result.diagnostics.items()
        ]
        stated = result.closed_loop_bandwidth
        if stated is not None and "closed_loop_bandwidth" not in result.diagnostics:
            lines.append(
                [
                    "closed_loop_bandwidth",
                    _number(stated.value, stated.std),
                    _number(stated.std, stated.std),
                    "Hz",
                ]
            )
        yield "<p>Of the experiment and the closed loop, no figures of the spec:</p>"
        yield from plain_table(["diagnostic", "value", "std", "unit"], lines, (1, 2))


def _correlation(result: JointResult) -> Iterator[str]:
    """Errors that go together, as a matrix."""
    pairs = {frozenset((a, b)): r for a, b, r in result.correlation}
    fields = [field for field in NAMES if any(field in pair for pair in pairs)]
    if not fields:
        return
    head = "".join(f"<th>{plain(field)}</th>" for field in fields)
    lines = []
    for a in fields:
        cells = []
        for b in fields:
            r = 1.0 if a == b else pairs.get(frozenset((a, b)))
            if r is None:
                cells.append("<td class=n></td>")
            else:
                strength = "" if a == b else f' style="--r:{abs(r):.2f}"'
                cells.append(f'<td class="n{" r" if a != b else ""}"{strength}>{r:.2f}</td>')
        lines.append(f"<tr><th>{plain(a)}</th>{''.join(cells)}</tr>")
    yield from fold(
        "Correlation of the errors",
        (
            f'<div class="wide"><table><tr><th></th>{head}</tr>{"".join(lines)}</table></div>',
            '<p class="faint">Empty: less than a half.</p>',
        ),
        shown=True,
    )


def _files(shown: Identified) -> Iterator[str]:
    yield "<h2>Files</h2>"
    lines = [["results", shown.path, shown.sha256, ""]]
    spec = shown.results.spec
    if shown.spec is not None:
        document = shown.spec.document
        state = "" if spec is None or spec.sha256 == document.text_sha256 else "changed since the fit"
        lines.append(["spec", named(document.path, document.variant), document.text_sha256, state])
    elif spec is not None:
        lines.append(["spec", spec.path, spec.sha256, "not here"])
    here = {log.sha256: log.path for log in shown.logs}
    for entry in shown.results.data:
        path = here.get(entry.sha256)
        if shown.results.method in METHODS:
            lines.append(["log", path or entry.path, entry.sha256, "" if path else "not here"])
        else:
            lines.append(["source", entry.path, entry.sha256, ""])
    known = {entry.sha256 for entry in shown.results.data}
    lines += [["log", log.path, log.sha256, "given"] for log in shown.logs if log.sha256 not in known]
    yield from plain_table(["", "file", "sha256", ""], lines)


def _commands(shown: Identified) -> Iterator[str]:
    """How the results and this page come about again."""
    report = ["actspec", "sysid", "report", shown.path, "-o", "report.html"]
    yield "<h2>Again</h2>"
    if shown.results.method not in METHODS:
        yield f"<pre>{plain(' '.join(map(shell_word, report)))}</pre>"
        return
    logs = [entry.path for entry in shown.results.data]
    default = {"friction.static", "friction.stribeck_velocity", "bandwidth"}
    extra = [
        field
        for field in NAMES
        if field in default and any(value_of(joint, field) for joint in shown.results.joints.values())
    ]
    fit = ["actspec", "sysid", "fit", _spec_path(shown), *(logs or ["LOG"]), "-o", shown.path]
    if shown.results.method != "rollout":
        fit += ["--method", shown.results.method]
    if extra:
        fit += ["--free", ",".join(extra)]
    yield f"<pre>{plain(' '.join(map(shell_word, fit)))}\n{plain(' '.join(map(shell_word, report)))}</pre>"
    yield '<p class="faint">Other options of the fit do not stand in the results file.</p>'
