"""Comparisons of a spec's variants as text, Markdown, JSON and pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Diagnostic, one_line
from actspec.fields import units_of
from actspec.ir import Command, Level
from actspec.report.axes import Axis, speed_and_torque
from actspec.report.plot import COMMAND, Chart, Line, Points
from actspec.report.tables import escaped, markdown_table, percent, table
from actspec.report.terminal import diagnostic_record, json_number
from actspec.study.compare import Compared, Comparison, Trace
from actspec.study.measures import bounds_at, has_line
from actspec.study.metrics import Metrics
from actspec.study.variants import NAMES, NO_NETWORK
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

FORMAT = "actspec-compare/1"
ALIKE = 0.02
"""Share of the command up to which two answers count as alike. Chosen: within the band of settling."""
SPEEDS = 200
"""Of a drawn bound."""

SHOWN = 1.6
"""Of the longest settling time, what a picture shows."""

_HEAD = (
    "variant",
    "rise",
    "overshoot",
    "settling",
    "left",
    "bandwidth",
    "peak",
    "swing rise",
    "saturated",
    "MuJoCo off",
)


def record(comparisons: Sequence[Comparison], findings: Sequence[Diagnostic]) -> dict[str, Any]:
    """As JSON; SI units, null is unknown."""
    return {
        "format": FORMAT,
        "rows": [_row(found, row) for found in comparisons for row in found.rows],
        "missing": [
            {"spec": found.spec, **asdict(lacking)} for found in comparisons for lacking in found.missing
        ],
        "findings": [diagnostic_record(item) for item in findings],
    }


def _row(found: Comparison, row: Compared) -> dict[str, Any]:
    return {
        "spec": found.spec,
        "joint": row.actuator.joint,
        "joints": list(row.joints),
        "variant": row.variant,
        "course": row.course,
        "amplitude": row.amplitude,
        "inertia": row.inertia,
        "timestep": found.timestep,
        "integrator": found.integrator,
        "explicit_ratio": row.explicit_ratio,
        "law": _metrics(row.law_metrics),
        "simulated": None if row.simulated_metrics is None else _metrics(row.simulated_metrics),
        "stable": row.stable,
        "departure": row.departure,
        "change": row.change,
    }


def _metrics(found: Metrics) -> dict[str, Any]:
    return {name: json_number(value) for name, value in asdict(found).items()}


def lines(found: Comparison) -> Iterator[str]:
    """A table an actuator, the answer above it."""
    yield f"{one_line(found.spec)}: {_simulator(found)}"
    for rows in by_actuator(found):
        yield ""
        yield heading(rows)
        yield f"  {answer(rows)}"
        yield from table([_HEAD, *(_cells(of) for of in by_variant(rows).values())])
    yield from _after_gap(_missing(found))


def markdown(found: Comparison) -> Iterator[str]:
    """The same as Markdown."""
    yield f"### {escaped(found.spec)}: {_simulator(found)}"
    for rows in by_actuator(found):
        yield ""
        yield f"**{escaped(heading(rows))}**"
        yield ""
        yield f"{escaped(answer(rows))}"
        yield ""
        yield from markdown_table(
            [
                _HEAD,
                *([escaped(cell) for cell in _cells(of)] for of in by_variant(rows).values()),
            ],
            1,
        )
    yield from _after_gap(f"- {escaped(line)}" for line in _missing(found))


def _simulator(found: Comparison) -> str:
    if not found.rows:
        return "no joint is simulated"
    return f"MuJoCo at {_time(found.timestep)}, {found.integrator}"


def by_actuator(found: Comparison) -> Iterator[list[Compared]]:
    """Rows of each distinct actuator."""
    joints = dict.fromkeys(row.actuator.joint for row in found.rows)
    for joint in joints:
        yield [row for row in found.rows if row.actuator.joint == joint]


def by_variant(rows: Sequence[Compared]) -> dict[str, dict[str, Compared]]:
    """Rows of one actuator by variant and course."""
    found: dict[str, dict[str, Compared]] = {}
    for row in rows:
        found.setdefault(row.variant, {})[row.course] = row
    return found


def heading(rows: Sequence[Compared]) -> str:
    """Which joints, and what they are."""
    first = rows[0]
    a = first.actuator
    more = f" and {len(first.joints) - 1} more" if len(first.joints) > 1 else ""
    figures = [f"J {format_number(first.inertia, 4)} {a.armature.unit}"]
    for name, quantity in (("kp", a.kp), ("kd", a.kd), ("effort limit", a.effort_limit)):
        if quantity is not None:
            figures.append(
                f"{name} unknown"
                if quantity.value is None
                else f"{name} {quantity.value:.6g} {quantity.unit}"
            )
    asked = ", ".join(
        f"{name} {format_number(row.amplitude, 3)}" for name, row in by_variant(rows)[first.variant].items()
    )
    units = units_of(a.kind)
    unit = units.speed if a.command is Command.VELOCITY else units.position
    return f"{one_line(a.joint)}{more}: {', '.join(figures)} ({asked} {unit})"


def answer(rows: Sequence[Compared]) -> str:
    """What each part of the model changes of PD and limit, the largest first."""
    of = by_variant(rows)
    if "ideal_pd" not in of:
        return "there is no PD to compare with"
    whole = of.get("spec", of["ideal_pd"])["step"].actuator
    changes = []
    for name, words, own in (
        ("filter", "the filter", whole.filter_cutoff is not None),
        ("delay", "the delay", whole.delay is not None),
        ("dc_motor", "the torque-speed line", whole.level is not Level.IDEAL_PD),
        ("network", "the network", True),
    ):
        if name in of:
            share, course = max(
                (row.change or 0.0, course) for course, row in of[name].items() if course != "chirp"
            )
            changes.append(
                (share, f"{words}{'' if own else ' (not in the spec)'} {percent(share)} of the {course}")
            )
    large = [text for share, text in sorted(changes, reverse=True) if share > ALIKE]
    if not large:
        return f"nothing changes a step or a swing of PD and limit by more than {percent(ALIKE)}"
    return f"changes of PD and limit: {', '.join(large)}"


def _cells(of: Mapping[str, Compared]) -> list[str]:
    step, swing, chirp = (of[name] for name in ("step", "swing", "chirp"))
    one, two, three = step.law_metrics, swing.law_metrics, chirp.law_metrics
    units = units_of(step.actuator.kind)
    unit = units.torque
    angle = units.speed if step.actuator.command is Command.VELOCITY else units.position
    unstable = [row.course for row in of.values() if not row.stable]
    departures = [row.departure for row in of.values() if row.departure is not None and row.course != "chirp"]
    return [
        step.variant,
        _time(one.rise_time),
        percent(one.overshoot),
        _time(one.settling_time),
        f"{format_number(one.steady_state_error or 0.0, 2)} {angle}",
        "-" if three.bandwidth is None else f"{format_number(three.bandwidth, 3)} Hz",
        f"{format_number(two.peak_torque, 4)} {unit}",
        _time(two.rise_time),
        percent(two.saturated),
        f"unstable: {', '.join(unstable)}" if unstable else percent(max(departures)),
    ]


def _after_gap(lines: Iterable[str]) -> list[str]:
    """Lines after an empty one; nothing before none."""
    found = list(lines)
    return ["", *found] if found else []


def _missing(found: Comparison) -> Iterator[str]:
    """Variants that are not there, a line a reason; nobody expects a network."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for item in found.missing:
        if item.reason == NO_NETWORK:
            continue
        reasons.setdefault((item.variant, item.reason), []).append(item.joint)
    for (variant, reason), joints in reasons.items():
        more = f" and {len(joints) - 1} more" if len(joints) > 1 else ""
        yield f"not compared: {variant} of {one_line(joints[0])}{more}: {one_line(reason)}"


def _time(value: float | None) -> str:
    return "-" if value is None else f"{format_number(value * 1e3, 3)} ms"


def charts(found: Comparison) -> Iterator[Chart]:
    """A step and an envelope of each distinct actuator."""
    for rows in by_actuator(found):
        of = by_variant(rows)
        yield step_chart(of)
        yield envelope_chart(of)


_COLOURS = {"ideal_pd": 1, "filter": 3, "delay": 4, "dc_motor": 2, "network": 4, "spec": 0}
_DASHES = {"filter": "dashed", "delay": "dashed", "dc_motor": "dashed"}


def step_chart(of: Mapping[str, Mapping[str, Compared]]) -> Chart:
    """The step of one actuator, each variant by the law, the spec in MuJoCo too."""
    import numpy as np

    first = next(iter(of.values()))["step"]
    units = units_of(first.actuator.kind)
    unit, label = units.position, "position"
    if first.actuator.command is Command.VELOCITY:
        unit, label = units.speed, "speed"
    held = first.law.time[-1]
    settled = [row["step"].law_metrics.settling_time for row in of.values()]
    seen_until = min(held, SHOWN * max(held if time is None else time for time in settled))
    marks: list[Any] = [
        Line(np.array([0.0, held]), np.full(2, first.amplitude), "command", COMMAND, "dotted"),
    ]
    # The broad line below the others.
    for name in sorted((name for name in NAMES if name in of), key=lambda name: name != "spec"):
        row = of[name]["step"]
        broad = name == "spec"
        marks.append(
            Line(row.law.time, row.law.answer, name, _COLOURS[name], _DASHES.get(name, ""), broad=broad)
        )
    whole: Trace | None = of["spec"]["step"].simulated if "spec" in of else None
    if whole is not None:
        marks.append(Line(whole.time, whole.answer, "spec, in MuJoCo", 3, "dotted"))
    title = f"{first.actuator.joint}: step worth half of the effort limit"
    return Chart(
        title, Axis("time", "s", low=0.0, high=float(seen_until)), Axis(label, unit), marks, width=420
    )


def envelope_chart(of: Mapping[str, Mapping[str, Compared]]) -> Chart:
    """What the drive gives in a swing, inside of what the motor can."""
    import numpy as np

    row = next(of[name]["swing"] for name in ("spec", *NAMES) if name in of)
    shown = [name for name in ("ideal_pd", "spec") if name in of]
    fastest = max(float(np.abs(of[name]["swing"].law.speed).max()) for name in shown)
    speeds = np.linspace(-fastest, fastest, SPEEDS)
    marks: list[Any] = []
    if row.actuator.effort_limit.known:
        bounds = bounds_at(row.actuator, speeds)
        label = "motor" if has_line(row.actuator) else "limit"
        marks += [Line(speeds, bounds[0], label, COMMAND), Line(speeds, bounds[1], "", COMMAND)]
    for name in shown:
        at = of[name]["swing"].law
        marks.append(Points(at.speed[:-1], at.torque, name, _COLOURS[name]))
    return Chart(
        f"{row.actuator.joint}: torque against speed in a swing worth twice the effort limit",
        *speed_and_torque(row.actuator.kind),
        marks,
    )
