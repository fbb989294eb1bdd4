"""An ablation as text, Markdown and JSON."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from actspec.diagnostics import Diagnostic, listed, many, one_line
from actspec.report.tables import escaped, markdown_table, table
from actspec.report.terminal import diagnostic_record
from actspec.study.ablation import NAMES, Change
from actspec.study.replay import Tracking
from actspec.study.trainings import Training
from actspec.study.variants import NO_NETWORK, Missing
from actspec.units import format_number

FORMAT = "actspec-ablation/1"


@dataclass(frozen=True, slots=True)
class Variant:
    """A variant that was made.

    Attributes:
        name: Its name.
        spec: Path of its spec.
        changes: From the spec for the first one, from the first one for the others.
        files: What it was compiled to, and the spec.
        train: The command that trains it; None: no task is known.
    """

    name: str
    spec: str
    changes: tuple[Change, ...]
    files: tuple[str, ...]
    train: str | None


@dataclass(frozen=True, slots=True)
class Ablation:
    """What was made and found.

    Attributes:
        spec: Path of the spec.
        log: Of the log; None: none was given.
        task: mjlab's; None: none is known.
        joints: How many the robot has.
        variants: In the order of `NAMES`.
        missing: What others lack, joint by joint.
        tracking: By variant and joint; empty without a log.
        training: By variant; empty without results.
        findings: What is doubtful.
    """

    spec: str
    log: str | None
    task: str | None
    joints: int
    variants: tuple[Variant, ...]
    missing: tuple[Missing, ...]
    tracking: tuple[Tracking, ...]
    training: tuple[Training, ...]
    findings: tuple[Diagnostic, ...]


def record(found: Ablation) -> dict[str, Any]:
    """As JSON; SI units, null is unknown."""
    return {
        "format": FORMAT,
        "spec": found.spec,
        "log": found.log,
        "task": found.task,
        "variants": [
            {
                "name": variant.name,
                "spec": variant.spec,
                "changes": [
                    {"field": c.field, "was": c.was, "is": c.becomes, "joints": list(c.joints)}
                    for c in variant.changes
                ],
                "files": list(variant.files),
                "train": variant.train,
            }
            for variant in found.variants
        ],
        "missing": [{"variant": m.variant, "joint": m.joint, "reason": m.reason} for m in found.missing],
        "tracking": [asdict(row) for row in found.tracking],
        "training": [
            {**asdict(row), "seeds": list(row.seeds), "iterations": list(row.iterations)}
            for row in found.training
        ],
        "findings": [diagnostic_record(item) for item in found.findings],
    }


def lines(found: Ablation) -> Iterator[str]:
    """What there is, how it follows, how it trained."""
    for variant in found.variants:
        yield f"{variant.name}: {one_line(variant.spec)}"
        yield from (f"  {text}" for text in _changed(variant, found.joints))
    yield from _after_gap(_missing(found))
    for title, rows in _tables(found):
        yield ""
        yield f"{title}:"
        yield from table(rows)
    trained = {training.variant for training in found.training}
    left = [v.train for v in found.variants if v.train is not None and v.name not in trained]
    if left:
        yield ""
        yield f"to train in mjlab ({found.task}), each with several seeds:"
        yield from (f"  {one_line(command)}" for command in left)


def markdown(found: Ablation) -> Iterator[str]:
    """The same as Markdown."""
    yield f"### Variants of {escaped(found.spec)}"
    yield ""
    rows = [["variant", "changes"]]
    rows += [[escaped(v.name), escaped("; ".join(_changed(v, found.joints)))] for v in found.variants]
    yield from markdown_table(rows)
    yield from _after_gap(f"- {escaped(line)}" for line in _missing(found))
    for title, cells in _tables(found):
        yield ""
        yield f"**{title[0].upper()}{escaped(title[1:])}**"
        yield ""
        yield from markdown_table([[escaped(cell) for cell in row] for row in cells], 1)


def _whose(joints: Sequence[str], of: int) -> str:
    return f"all {of} joints" if len(joints) == of > 1 else listed(map(one_line, joints), 4)


def _changed(variant: Variant, of: int) -> Iterator[str]:
    """What is different, equal changes of several joints once."""
    by_field: dict[tuple[str, ...], list[Change]] = {}
    for change in variant.changes:
        by_field.setdefault(change.joints, []).append(change)
    for joints, changes in by_field.items():
        parts = (f"{c.field} {one_line(c.was)} -> {one_line(c.becomes)}" for c in changes)
        yield f"{_whose(joints, of)}: {', '.join(parts)}"


def _missing(found: Ablation) -> Iterator[str]:
    """Equal reasons once; that a spec has no network is nothing to mend."""
    by_reason: dict[tuple[str, str], list[str]] = {}
    for lacking in found.missing:
        if lacking.reason != NO_NETWORK:
            by_reason.setdefault((lacking.variant, lacking.reason), []).append(lacking.joint)
    for (variant, reason), joints in by_reason.items():
        yield f"not in {variant}: {_whose(joints, found.joints)}: {one_line(reason)}"


def _tables(found: Ablation) -> Iterator[tuple[str, list[list[str]]]]:
    """What was followed and what was trained, a row a variant."""
    if found.tracking:
        rows = [["variant", "RMSE, mean", "worst", "at", "peak, of all", "saturated, worst"]]
        for name in NAMES:
            mine = [row for row in found.tracking if row.variant == name]
            if mine:
                worst = max(mine, key=lambda row: row.rmse)
                shares = [row.saturated for row in mine if row.saturated is not None]
                rows.append(
                    [
                        name,
                        _figure(math.fsum(row.rmse for row in mine) / len(mine)),
                        _figure(worst.rmse),
                        one_line(worst.joint),
                        _figure(max(row.peak_torque for row in mine)),
                        "?" if not shares else f"{100.0 * max(shares):.1f} %",
                    ]
                )
        joints = len({row.joint for row in found.tracking})
        yield f"commands of {one_line(found.log or '')} followed by {many(joints, 'joint')}, each alone", rows
    if found.training:
        rows = [["variant", "reward", "std", "tracking error", "std", "episode", "seeds", "iterations"]]
        rows += [
            [
                row.variant,
                *map(_figure, (row.reward, row.reward_std, row.tracking_error, row.tracking_error_std)),
                _figure(row.episode_length),
                str(len(row.seeds)),
                "-".join(map(str, dict.fromkeys(row.iterations))),
            ]
            for row in found.training
        ]
        yield "trained", rows


def _figure(value: float | None) -> str:
    return "?" if value is None else format_number(value, 3)


def _after_gap(texts: Iterator[str]) -> Iterator[str]:
    shown = list(texts)
    if shown:
        yield ""
        yield from shown
