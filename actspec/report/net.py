"""Networks as text and as JSON: what logs hold, a training, an evaluation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from actspec.diagnostics import Diagnostic, many, one_line
from actspec.fields import units_of
from actspec.laws.network import NetworkLaw
from actspec.learn.closed_loop import HORIZON
from actspec.learn.evaluate import Errors, Evaluation, errors_of, graded, limit_of, worst
from actspec.learn.inspect import Inspection
from actspec.learn.recurrent import along
from actspec.learn.survey import JointData
from actspec.learn.train import Trained, input_ranges
from actspec.learn.windows import Dataset, Split, gathered, slacks
from actspec.report.tables import table
from actspec.report.terminal import diagnostic_record, json_number
from actspec.units import format_number

DATA, TRAIN, EVALUATE = "actspec-net-data/1", "actspec-net-train/1", "actspec-net-evaluate/1"
INSPECT = "actspec-net-inspect/1"
CONVERT = "actspec-net-convert/1"


def _unit(data: Dataset) -> str:
    return units_of(data.actuators[0].kind).torque


def _share(value: float | None) -> str:
    return "-" if value is None else f"{100.0 * value:.3g} %"


def _number(value: float | None, digits: int = 3) -> str:
    return "-" if value is None else format_number(value, digits)


def data_lines(data: Dataset, found: Sequence[JointData]) -> Iterator[str]:
    """A row a joint."""
    logs = len({track.log.path for track in data.tracks})
    yield (
        f"group {one_line(data.group)}: {many(logs, 'log')}, {len(data.taps)} samples of {data.period * 1e3:g} ms, "
        f"torque: {data.kind}"
    )
    rows = [
        ["joint", "minutes", "rate", "gaps", "at limit", "band", "error", "velocity", "torque RMS", "outside"]
    ]
    for joint in found:
        ends = [
            f"{r['low']:.3g} to {r['high']:.3g}" for r in (joint.ranges["error"], joint.ranges["velocity"])
        ]
        rows.append(
            [
                one_line(joint.joint),
                f"{joint.minutes:.3g}",
                f"{joint.rate:.4g} Hz",
                str(joint.gaps),
                _share(joint.saturation),
                f"{joint.band:.3g} Hz",
                *ends,
                _number(joint.torque_rms),
                "-" if joint.outside is None else _share(max(joint.outside.values())),
            ]
        )
    yield from table(rows)


def data_record(data: Dataset, found: Sequence[JointData], findings: Sequence[Diagnostic]) -> dict[str, Any]:
    """As JSON; SI units, null is unknown."""
    return {
        "format": DATA,
        "group": data.group,
        "taps": list(data.taps),
        "tap_period": data.period,
        "torque": data.kind,
        "joints": [asdict(joint) for joint in found],
        "findings": [diagnostic_record(item) for item in findings],
    }


def manifest_entries(
    data: Dataset, parts: Split, trained: Trained, logs: Sequence[Any], model: Mapping[str, Any] | None
) -> tuple[dict[str, Any], list[tuple[str, Errors]]]:
    """What a trained network's manifest holds beside its files, and the errors on held-out rows of each joint."""
    import numpy as np

    x, y, joint = gathered(data, parts.validate)
    recurrent = bool(trained.layers.recurrent)
    if recurrent:
        law = NetworkLaw(trained.layers, (0,), data.period)
        found = np.concatenate(along(law, data.tracks, parts.validate))
    else:
        found = trained.layers(x)[0][:, 0]
    # Where the torque is told within a slack, what lies within it is no error.
    slack = slacks(data, parts.validate)
    y = np.clip(found, y - slack, y + slack)
    overall = errors_of(found, y)
    judged = [("", overall)]
    for j, actuator in enumerate(data.actuators):
        if (mine := joint == j).any():
            judged.append((actuator.joint, errors_of(found[mine], y[mine])))

    def short(value: float) -> float:
        return float(f"{value:.6g}")

    entries = {
        "inputs": "position_velocity",
        "taps": [0] if recurrent else list(data.taps),
        "tap_period": f"{data.period * 1e3:.10g} ms",
        "position_scale": 1.0,
        "velocity_scale": 1.0,
        "torque_scale": 1.0,
        "initial_history": "zero" if recurrent else "first_sample",
        "joints": [a.joint for a in data.actuators],
        "torque": data.kind,
        "logs": [{"path": log.path, "sha256": log.sha256} for log in logs],
        **(model or {}),
        "range": input_ranges(
            data, [np.concatenate(both) for both in zip(parts.train, parts.validate, strict=True)]
        ),
        "validation": {
            "rmse": short(overall.rmse),
            "relative_error": short(overall.relative_error or 0.0),
            "r2": short(overall.r2 if overall.r2 is not None else 0.0),
            "rows": overall.rows,
            "logs": list(parts.logs),
        },
    }
    return entries, judged


def train_lines(
    data: Dataset,
    parts: Split,
    trained: Trained,
    judged: Sequence[tuple[str, Errors]],
    laws: Mapping[str, Mapping[str, Errors]],
) -> Iterator[str]:
    """Errors on held-out rows, and the spread over seeds; `laws` are those of the spec's laws there, by joint."""
    unit, (_, overall) = _unit(data), judged[0]
    seen = sum(map(len, parts.train))
    share = overall.rows / (seen + overall.rows)
    what = f"whole recordings, {share:.0%}" if parts.whole else "the last fifth of each recording"
    grades = _grades(data, judged, laws)
    layers = trained.layers
    middle = ["LSTM", *(layer.hidden.shape[1] for layer in layers.recurrent)] if layers.recurrent else []
    sizes = "-".join(str(n) for n in (layers.inputs, *middle, *(len(d.bias) for d in layers.dense)))
    yield (
        f"group {one_line(data.group)}: {sizes}, {seen} rows to train on, {overall.rows} held out ({what}); "
        f"torque: {data.kind}"
    )
    rows = [["joint", f"RMSE [{unit}]", "relative", "worst", "R2", "grade"]]
    rows += [
        [
            one_line(name) or "all",
            _number(e.rmse),
            _share(e.relative_error),
            _number(e.worst),
            _number(e.r2, 4),
            grades[name],
        ]
        for name, e in (*judged[1:], judged[0])
    ]
    yield from table(rows)
    for run in trained.runs if len(trained.runs) > 1 else ():
        kept = ", kept" if run is trained.run else ""
        yield f"seed {run.seed}: RMSE {_number(run.rmse)} {unit}{kept}"
    run = trained.run
    seconds = sum(item.seconds for item in trained.runs)
    yield f"seed {run.seed}, {many(run.epochs, 'epoch')}, best after {run.best}, {seconds:.1f} s"


def _grades(
    data: Dataset, judged: Sequence[tuple[str, Errors]], laws: Mapping[str, Mapping[str, Errors]]
) -> dict[str, str]:
    """What `net evaluate` would call such errors, by joint; "" for all: the worst of them."""
    limits = {actuator.joint: limit_of(actuator) for actuator in data.actuators}
    found = {name: graded(errors, limits[name], laws[name]) for name, errors in judged if name}
    return {**found, "": worst(found.values())}


def _errors(errors: Errors) -> dict[str, Any]:
    return {name: json_number(value) if name != "rows" else value for name, value in asdict(errors).items()}


def train_record(
    data: Dataset,
    parts: Split,
    trained: Trained,
    judged: Sequence[tuple[str, Errors]],
    laws: Mapping[str, Mapping[str, Errors]],
    paths: Mapping[str, str],
    findings: Sequence[Diagnostic],
) -> dict[str, Any]:
    """As JSON; SI units, null is unknown. `laws` as in `train_lines`."""
    import numpy as np

    rmse = [run.rmse for run in trained.runs]
    grades = _grades(data, judged, laws)
    return {
        "format": TRAIN,
        "group": data.group,
        "files": dict(paths),
        "torque": data.kind,
        "rows": sum(map(len, parts.train)),
        "validation": {
            **_errors(judged[0][1]),
            "grade": grades[""],
            "logs": list(parts.logs),
            "whole_recordings": parts.whole,
        },
        "joints": [{"joint": name, **_errors(errors), "grade": grades[name]} for name, errors in judged[1:]],
        "seed": trained.run.seed,
        "epochs": trained.run.epochs,
        "seeds": [
            {"seed": r.seed, "rmse": r.rmse, "epochs": r.epochs, "seconds": r.seconds} for r in trained.runs
        ],
        "spread": float(np.std(rmse)) if len(rmse) > 1 else None,
        "findings": [diagnostic_record(item) for item in findings],
    }


def evaluate_lines(found: Evaluation) -> Iterator[str]:
    """A row a joint and the baselines beside, then the closed loop."""
    rows = [["joint", "RMSE", "relative", "worst", "R2", "of the limit", "grade", *found.baselines]]
    for joint in found.joints:
        share = None if joint.limit is None else joint.errors.rmse / joint.limit
        rows.append(
            [
                one_line(joint.joint),
                _number(joint.errors.rmse),
                _share(joint.errors.relative_error),
                _number(joint.errors.worst),
                _number(joint.errors.r2, 4),
                _share(share),
                joint.grade,
                *(_number(joint.baselines[name].rmse) for name in found.baselines),
            ]
        )
    e = found.overall
    rows.append(
        [
            "all",
            _number(e.rmse),
            _share(e.relative_error),
            _number(e.worst),
            _number(e.r2, 4),
            "",
            found.grade,
            *(_number(base.rmse) for base in found.baselines.values()),
        ]
    )
    yield from table(rows)
    if found.closed_loop is None:
        yield f"no closed loop: {found.why_not}"
    else:
        shown = ", ".join(f"{name} {_number(value)}" for name, value in found.closed_loop.items())
        yield f"position RMSE of rollouts over {HORIZON:g} s in MuJoCo: {shown}"
    if found.outside is not None:
        yield f"outside of the range that it was trained on: {_share(found.outside['any'])} of the rows"


def evaluate_record(found: Evaluation, findings: Sequence[Diagnostic]) -> dict[str, Any]:
    """As JSON; SI units, null is unknown."""
    closed: dict[str, Any] | None = None
    if found.closed_loop is not None:
        closed = {"horizon": HORIZON}
        closed |= {
            name: None if value is None else {"position_rmse": value}
            for name, value in found.closed_loop.items()
        }
    return {
        "format": EVALUATE,
        "overall": {**_errors(found.overall), "grade": found.grade},
        "joints": [
            {
                "joint": joint.joint,
                **_errors(joint.errors),
                "effort_limit": joint.limit,
                "grade": joint.grade,
                "baselines": {name: _errors(e) for name, e in joint.baselines.items()},
            }
            for joint in found.joints
        ],
        "baselines": {name: _errors(e) for name, e in found.baselines.items()},
        "closed_loop": closed,
        "outside": None if found.outside is None else dict(found.outside),
        "findings": [diagnostic_record(item) for item in findings],
    }


def inspect_lines(found: Inspection, path: str) -> Iterator[str]:
    """What a network does, a line a property."""
    guess = ", by its weights" if found.guessed else ", by its manifest"
    if found.doubtful:
        guess += " (doubtful: no damping of a drive)"
    yield f"{one_line(path)}: {found.kind}, {found.inputs} inputs"
    at = "" if found.saturates_at is None else f", from an error of {format_number(found.saturates_at, 3)}"
    yield from table(
        [
            ["inputs", found.order + guess, ""],
            ["error_sign", found.error_sign, ""],
            ["stiffness", format_number(found.stiffness, 4), "N*m/rad"],
            ["damping", format_number(found.damping, 4), "N*m*s/rad"],
            ["delay_taps", format_number(found.delay_taps, 3), "samples"],
            ["at_rest", format_number(found.at_rest, 3), "N*m"],
            ["saturation", format_number(found.saturation, 4) + at, "N*m"],
        ]
    )
    yield from (f"contradiction: {item.text}" for item in found.contradictions)


def inspect_record(found: Inspection, path: str) -> dict[str, Any]:
    """The same as JSON; SI."""
    record = asdict(found)
    return {
        "format": INSPECT,
        "file": path,
        "kind": record["kind"],
        "n_inputs": record["inputs"],
        "inputs": record["order"],
        "error_sign": record["error_sign"],
        **{key: json_number(record[key]) for key in ("stiffness", "damping", "delay_taps", "at_rest")},
        "saturation": {"torque": json_number(found.saturation), "error": json_number(found.saturates_at)},
        "guessed": found.guessed,
        "contradictions": [item.text for item in found.contradictions],
    }


def convert_record(path: str, written: Mapping[str, str], findings: Sequence[Diagnostic]) -> dict[str, Any]:
    """As JSON: the network that was read, as it was named, and the files that were written."""
    said = [diagnostic_record(item) for item in findings]
    return {"format": CONVERT, "file": path, "files": dict(written), "findings": said}
