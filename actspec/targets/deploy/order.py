"""An SDK's order of the joints, and the index maps between orders."""

from __future__ import annotations

from collections.abc import Sequence

from actspec.diagnostics import Collector, listed, nearest, shortened
from actspec.targets.base import TargetOptions


def check_sdk_order(options: TargetOptions, managed: Sequence[str], collector: Collector) -> None:
    """Report where an SDK's order does not name exactly the managed joints, each once.

    Args:
        options: With the order.
        managed: The joints that the spec manages.
        collector: Takes what is wrong.
    """
    seen: set[str] = set()
    for index, name in enumerate(options.joint_order):
        entry = f"joint_order[{index}]"
        where, span = options.where(entry), options.span(entry)
        if name is None:
            continue
        if name in seen:
            collector.error(
                "DEP002",
                f"'{shortened(name)}' is named twice",
                where=where,
                span=span,
                help="name every joint that the spec manages once",
            )
        elif name not in managed:
            guess = nearest(name, managed)
            collector.error(
                "DEP001",
                f"'{shortened(name)}' is no joint that the spec manages",
                where=where,
                span=span,
                help=f"did you mean '{guess}'?" if guess else f"the joints are: {listed(managed)}",
            )
        seen.add(name)
    missing = [name for name in managed if name not in seen]
    if missing:
        collector.error(
            "DEP003",
            f"{len(missing)} of {len(managed)} managed joints missing: {listed(missing)}",
            where=options.where("joint_order"),
            span=options.span("joint_order"),
            help="name every joint that the spec manages once",
        )


def index_map(source: Sequence[str | None], result: Sequence[str | None]) -> tuple[int | None, ...]:
    """Where each entry of one order stands in another: `result[i] = source[index_map(source, result)[i]]`.

    A gap of `result` has None, and one of `source` nobody's index.
    """
    place = {name: index for index, name in enumerate(source) if name is not None}
    return tuple(None if name is None else place[name] for name in result)
