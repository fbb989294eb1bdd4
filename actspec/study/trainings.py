"""Results of trainings of variants, as `train.py` leaves them, and their means."""

from __future__ import annotations

import hashlib
import os
import statistics
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from actspec.diagnostics import Collector, Span, did_you_mean, listed, one_line, shortened
from actspec.files import FAULTS, NotRegular, TooLarge, read_regular, why

RUNS, RESULT = "runs", "result.json"
MOST_BYTES = 1 << 20
"""Of a result. Chosen: one has 300 bytes."""
FIGURES = ("reward", "tracking_error", "episode_length")


class Result(BaseModel):
    """One training, as its file has it."""

    model_config = ConfigDict(strict=True, allow_inf_nan=False, frozen=True)

    variant: str
    seed: Annotated[int, Field(ge=0)]
    iterations: Annotated[int, Field(ge=1)]
    reward: float | None = None
    """Of an episode; None: none ended."""
    tracking_error: float | None = None
    """As the task logs it; None: it does not."""
    episode_length: float | None = None
    """[steps]; None: none ended."""
    spec_sha256: str | None = None
    """Of the spec that was trained with; None: the file does not tell."""


@dataclass(frozen=True, slots=True)
class Training:
    """The trainings of one variant.

    Attributes:
        variant: Its name.
        reward: Mean over the seeds; None: no result has one.
        reward_std: Standard deviation of a sample of them; None: fewer than two.
        tracking_error: Mean.
        tracking_error_std: As of the reward.
        episode_length: Mean [steps].
        seeds: Whose results there are.
        iterations: Of the shortest and the longest.
    """

    variant: str
    reward: float | None
    reward_std: float | None
    tracking_error: float | None
    tracking_error_std: float | None
    episode_length: float | None
    seeds: tuple[int, ...]
    iterations: tuple[int, int]


def collect(
    folder: str, specs: Mapping[str, bytes], names: Sequence[str], out: Collector
) -> tuple[Training, ...]:
    """What was trained so far.

    Args:
        folder: Of the ablation.
        specs: Variant to the bytes of its spec, as they are now.
        names: Of every variant that there may be.
        out: Takes what is wrong with a result, which is then left out, and what makes means doubtful.
    """
    results: dict[str, dict[int, Result]] = {}
    paths: dict[tuple[str, int], str] = {}
    for path in _files(os.path.join(folder, RUNS)):
        found = _read(path, names, out)
        if found is None:
            continue
        first = paths.setdefault((found.variant, found.seed), path)
        if first != path:
            message = f"is another result of {found.variant} with seed {found.seed}: it is left out"
            out.warning("ABL021", message, span=Span(path), help=f"the first is {one_line(first)}")
            continue
        results.setdefault(found.variant, {})[found.seed] = found
        now = specs.get(found.variant)
        if now is None:
            message = f"is of {found.variant}, which there is not now"
            out.warning("ABL022", message, span=Span(path), help="give the options that it was made with")
        elif found.spec_sha256 not in (None, hashlib.sha256(now).hexdigest()):
            message = f"was trained with another spec of {found.variant} than the present one"
            out.warning("ABL022", message, span=Span(path), help="train again: python train.py ... --force")
    trainings = tuple(_mean(name, list(results[name].values())) for name in names if name in results)
    lengths = {length for training in trainings for length in training.iterations}
    if len(lengths) > 1:
        said = listed(f"{t.variant} {'-'.join(map(str, dict.fromkeys(t.iterations)))}" for t in trainings)
        message = f"trainings of different lengths are no comparison: {said} iterations"
        out.warning("ABL023", message, span=Span(os.path.join(folder, RUNS)))
    return trainings


def _files(runs: str) -> Iterator[str]:
    """Results, in the order of their folders' names."""
    try:
        names = sorted(os.listdir(runs))
    except OSError:
        return
    for name in names:
        path = os.path.join(runs, name, RESULT)
        if os.path.lexists(path):
            yield path


def _read(path: str, names: Sequence[str], out: Collector) -> Result | None:
    """One result; None, with the reason said, where it is none."""
    help = None
    try:
        found = Result.model_validate_json(read_regular(path, MOST_BYTES))
    except ValidationError as err:
        first = err.errors(include_url=False)[0]
        where = ".".join(map(str, first["loc"]))
        fault = f"{where}: {first['msg']}" if where else first["msg"]
    except (NotRegular, TooLarge, *FAULTS) as err:
        fault = f"cannot be read: {why(err)}"
    else:
        if found.variant in names:
            return found
        fault = f"variant: there is no {shortened(found.variant)!r}"
        help = did_you_mean(found.variant, list(names), f"variants: {listed(names)}")
    out.warning("ABL020", f"{one_line(fault)}; the result is left out", span=Span(path), help=help)
    return None


def _mean(variant: str, results: Sequence[Result]) -> Training:
    results = sorted(results, key=lambda result: result.seed)
    means: dict[str, float | None] = {}
    spreads: dict[str, float | None] = {}
    for key in FIGURES:
        values = [value for result in results if (value := getattr(result, key)) is not None]
        means[key] = statistics.mean(values) if values else None
        spreads[key] = statistics.stdev(values) if len(values) > 1 else None
    lengths = [result.iterations for result in results]
    return Training(
        variant,
        means["reward"],
        spreads["reward"],
        means["tracking_error"],
        spreads["tracking_error"],
        means["episode_length"],
        tuple(result.seed for result in results),
        (min(lengths), max(lengths)),
    )
