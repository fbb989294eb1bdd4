"""Whether what the spec accepts is still lost: a stale or misspelt key of `accept` takes nothing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, listed, nearest
from actspec.simulators import DEFAULT_VERSIONS
from actspec.spec.rules.robot import SPEC_ITSELF

if TYPE_CHECKING:
    from actspec.spec.validate import Spec
    from actspec.targets.base import Approximation, Emission, TargetOptions


def check_accepted(
    spec: Spec,
    simplified: Sequence[Approximation],
    targets: Sequence[TargetOptions],
    emissions: Sequence[Emission],
    collector: Collector,
) -> None:
    """Warn where a compiled target has no loss of a name that `accept` has (SPEC164).

    A target that is compiled at another version than the spec's is left out: its losses may be others.

    Args:
        spec: The spec.
        simplified: What it simplifies itself.
        targets: What was compiled.
        emissions: What each made, in the same order.
        collector: Takes the warnings.
    """
    lost = {
        options.name: dict.fromkeys(loss.field for loss in emission.approximations)
        for options, emission in zip(targets, emissions, strict=True)
        if options.version == _version(spec, options)
    }
    lost[SPEC_ITSELF] = dict.fromkeys(loss.field for loss in simplified)
    for key in spec.model.accept:
        target, _, field = key.partition(".")
        if target not in lost or field in lost[target]:
            continue
        guess = nearest(field, list(lost[target]))
        whose = "the spec itself" if target == SPEC_ITSELF else f"the target '{target}'"
        others = f"its losses are {listed(lost[target])}" if lost[target] else "it loses nothing"
        collector.warning(
            "SPEC164",
            f"{whose} has no approximation of this name: nothing is accepted by it",
            where=f"accept.{key}",
            span=spec.document.spans.key(("accept", key)),
            help=f"did you mean '{target}.{guess}'?" if guess else f"remove it; {others}",
        )


def _version(spec: Spec, options: TargetOptions) -> str:
    entry = spec.model.targets.get(options.name)
    return (entry.version if entry is not None else None) or DEFAULT_VERSIONS.get(options.kind, "")
