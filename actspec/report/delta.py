"""What `actspec delta` prints: the training, and what a delta action takes away, as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from actspec.diagnostics import Diagnostic, many, one_line
from actspec.learn.delta.train import Parts, Trained, TrainOptions
from actspec.learn.delta.validate import HORIZON, Judged, Pair, Validation
from actspec.report.tables import table
from actspec.report.terminal import diagnostic_record

TRAIN, VALIDATE = "actspec-delta-train/1", "actspec-delta-validate/1"


def _pair(pair: Pair) -> dict[str, float]:
    return {"position": pair.position, "velocity": pair.velocity}


def _judged(errors: Judged) -> dict[str, Any]:
    return {
        "uncorrected": _pair(errors.uncorrected),
        "corrected": _pair(errors.corrected),
        "improvement": _pair(errors.improvement),
    }


def _share(value: float | None) -> str:
    return "-" if value is None else f"{100.0 * value:.3g} %"


def train_lines(trained: Trained, options: TrainOptions, parts: Parts, joints: int) -> Iterator[str]:
    """What held-out rows say."""
    what = "whole recordings" if parts.whole else "the last fifth"
    yield (
        f"{many(joints, 'joint')}, one network per {options.per}: {trained.rows} rows to train on, "
        f"{len(parts.unseen)} held out ({what})"
    )
    yield from table(_rows([("", trained.judged)], heading="held out"))
    yield f"seed {options.seed}, {many(trained.epochs, 'epoch')}, best after {trained.best}, {trained.seconds:.1f} s"


def _rows(errors: Sequence[tuple[str, Judged]], heading: str) -> list[list[str]]:
    rows = [[heading, "position", "corrected", "removed", "velocity", "corrected", "removed"]]
    for name, e in errors:
        rows.append(
            [
                one_line(name) or "all",
                f"{e.uncorrected.position:.3g}",
                f"{e.corrected.position:.3g}",
                _share(e.improvement.position),
                f"{e.uncorrected.velocity:.3g}",
                f"{e.corrected.velocity:.3g}",
                _share(e.improvement.velocity),
            ]
        )
    return rows


def train_record(
    trained: Trained,
    options: TrainOptions,
    parts: Parts,
    period: float,
    paths: Mapping[str, str],
    findings: Sequence[Diagnostic],
) -> dict[str, Any]:
    """As JSON; SI units."""
    held = {"rows": len(parts.unseen), "logs": list(parts.logs), "whole_recordings": parts.whole}
    return {
        "format": TRAIN,
        "files": dict(paths),
        "per": options.per,
        "max_delta": options.max_delta,
        "period": period,
        "rows": trained.rows,
        "validation": {**_judged(trained.judged), **held},
        "seed": options.seed,
        "epochs": trained.epochs,
        "best_epoch": trained.best,
        "seconds": trained.seconds,
        "findings": [diagnostic_record(item) for item in findings],
    }


def validate_lines(found: Validation) -> Iterator[str]:
    """A row a joint, then all, and what the limit has to do with it."""
    joints = [(joint.joint, joint.errors) for joint in found.joints]
    yield from table(_rows([*joints, ("", found.errors)], heading="next row"))
    share = found.errors.improvement
    yield f"{found.grade}: {_share(min(share.position, share.velocity))} of the error is taken away, {found.rows} rows"
    best = (("within the limit", found.at_limit), ("within twice of it", found.at_twice))
    for words, pair in best:
        shares = f"{_share(pair.position)} of position, {_share(pair.velocity)} of velocity"
        yield f"the best correction {words} takes away {shares}"
    yield f"at the limit: {_share(found.share_at_limit)} of the corrections"
    if found.replay is None:
        yield f"no replay: no stretch of {HORIZON:g} s without a gap"
    else:
        count = many(found.replays, "replay")
        gone = _share(found.replay)
        yield f"commands replayed for {HORIZON:g} s, {count}: {gone} of the position's error is taken away"


def validate_record(found: Validation, findings: Sequence[Diagnostic]) -> dict[str, Any]:
    """As JSON; SI units, null is unknown."""
    return {
        "format": VALIDATE,
        **_judged(found.errors),
        "grade": found.grade,
        "removable": {"at_limit": _pair(found.at_limit), "at_twice": _pair(found.at_twice)},
        "share_at_limit": found.share_at_limit,
        "replay": {"horizon": HORIZON, "improvement": found.replay, "count": found.replays},
        "joints": [
            {"joint": joint.joint, **_judged(joint.errors), "share_at_limit": joint.share_at_limit}
            for joint in found.joints
        ],
        "rows": found.rows,
        "diverged": found.diverged,
        "findings": [diagnostic_record(item) for item in findings],
    }
