"""The randomisation ranges of a joint, those from the identification as numbers."""

from __future__ import annotations

from actspec.ir import Quantity, Randomization
from actspec.resolution.inputs import JointInputs
from actspec.spec.models import Randomize
from actspec.spec.paths import Path, dotted
from actspec.spec.rules.randomization import RANDOMIZED_KINDS, UNFITTED, range_of


def randomizations(inputs: JointInputs) -> tuple[Randomization, ...]:
    """Every range of the joint's group, in the spec's order."""
    found = []
    for field, entry in inputs.stated.group.randomize.items():
        path: Path = ("actuators", inputs.stated.binding.group, "randomize", field)
        span = inputs.stated.spec.document.spans.key(path)
        every = None
        if entry.every is not None:
            every = (float(entry.every[0].value), float(entry.every[1].value))
        if entry.from_ is not None:
            fitted = _fitted(inputs, field, path)
            if fitted is None:
                continue
            operation, low, high = "abs", *_spread(fitted, field, entry)
        else:
            operation = next(key for key in ("scale", "add", "abs") if getattr(entry, key) is not None)
            low, high = _range(inputs, field, entry, (*path, operation))
        found.append(
            Randomization(field, operation, low, high, entry.distribution, entry.when, every, entry.per, span)
        )
    return tuple(found)


def _range(inputs: JointInputs, field: str, entry: Randomize, path: Path) -> tuple[float, float]:
    """The written range in SI units."""
    ends = range_of(entry, field)
    assert isinstance(ends, tuple)
    for end in ends:
        inputs.check_unit(end, f"the range of {field} has {end.written}", path)
    return float(ends[0].value or 0.0), float(ends[1].value or 0.0)


def _fitted(inputs: JointInputs, field: str, path: Path) -> Quantity | None:
    """The fitted value that a range is taken from; None after an error."""
    fitted = None if field in UNFITTED else inputs.identified(field, RANDOMIZED_KINDS[field])
    if fitted is None or fitted.std is None:
        inputs.reports.error(
            "RES007",
            inputs.joint.name,
            f"no identified standard deviation of {field} to take the range from",
            dotted(path),
            inputs.stated.spec.span(*path),
            "state the range as scale, add or abs",
        )
        return None
    return fitted


def _spread(fitted: Quantity, field: str, entry: Randomize) -> tuple[float, float]:
    """The fitted value -+ sigma std; for a gaussian (mean, sigma std)."""
    sigma = 1.0 if entry.sigma is None else entry.sigma.value or 1.0
    mean, half = fitted.require(), sigma * (fitted.std or 0.0)
    if entry.distribution == "gaussian":
        return mean, half
    return (mean - half if field == "encoder_bias" else max(0.0, mean - half)), mean + half
