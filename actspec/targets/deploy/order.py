"""The order of joints that a deploy target states."""

from __future__ import annotations

from collections.abc import Sequence

from actspec.diagnostics import Collector, listed, nearest, shortened
from actspec.spec.models import DeployTarget
from actspec.targets.base import TargetOptions


def check_sdk_order(options: TargetOptions, managed: Sequence[str], collector: Collector) -> None:
    """Report where an SDK's order, if one is stated, does not name exactly the managed joints, each once.

    Args:
        options: With the order.
        managed: The joints that the spec manages.
        collector: Takes what is wrong.
    """
    seen: set[str] = set()
    meant: set[str] = set()
    order = options.of(DeployTarget).joint_order
    if not order:
        return
    guesses = {name: nearest(name, managed) for name in order if name is not None and name not in managed}
    unnamed = [name for name in managed if name not in order and name not in guesses.values()]
    for index, name in enumerate(order):
        entry = f"joint_order[{index}]"
        place = options.at(entry, collector)
        if name is None:
            continue
        if name in seen:
            # Where another is missing, this stands in its place: one mistake, told once.
            left = [other for other in unnamed if other not in meant]
            guess = nearest(name, left) or next(iter(left), None)
            meant |= {guess} if guess else set()
            place.error(
                "DEP002",
                f"'{shortened(name)}' is named twice",
                f"did you mean '{guess}', which is missing?"
                if guess
                else "name every joint that the spec manages once",
            )
        elif name not in managed:
            guess = guesses[name]
            help = f"did you mean '{guess}'?" if guess else f"the joints are: {listed(managed)}"
            meant |= {guess} if guess else set()
            words = name.split()
            if len(words) > 1 and not {*words} - {*managed}:
                meant |= {*words}
                help = f"separate them by a comma: {', '.join(words)}"
            place.error("DEP001", f"'{shortened(name)}' is not a joint that the spec manages", help)
        seen.add(name)
    # A misspelt name is told as such, not as one that is missing too.
    missing = [name for name in managed if name not in seen | meant]
    if missing:
        options.at("joint_order", collector).error(
            "DEP003",
            f"{len(missing)} of {len(managed)} managed joints missing: {listed(missing)}",
            "name every joint that the spec manages once",
        )
