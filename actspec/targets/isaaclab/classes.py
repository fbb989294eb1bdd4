"""Which kind of actuator class each joint gets: that of the target, or of the pattern that selects the joint."""

from __future__ import annotations

from collections.abc import Mapping

from actspec.diagnostics import Collector, Place, listed, shortened
from actspec.ir import ActuatorSet, Level
from actspec.patterns import resolve_patterns
from actspec.simulators.isaaclab import IsaacLabDialect
from actspec.spec.models import IsaacLabTarget
from actspec.targets.base import TargetOptions


def classes_of(actuators: ActuatorSet, options: TargetOptions, collector: Collector) -> dict[str, str]:
    """Each joint's kind of actuator class: `auto`, `implicit` or `custom`.

    Args:
        actuators: The resolved spec.
        options: The target's.
        collector: Takes an error of each pattern that selects no joint, or one that another selects too.
    """
    stated = options.of(IsaacLabTarget).class_ or "auto"
    names = [actuator.joint for actuator in actuators.joints]
    if isinstance(stated, str):
        return dict.fromkeys(names, stated)
    matches = resolve_patterns(list(stated), names)
    for problem in matches.problems:
        _at(problem.pattern, options, collector).error("ISL002", problem.message, problem.help)
    found: dict[str, str] = {}
    for pattern, matched in zip(stated, matches.by_pattern, strict=True):
        twice = [name for name in matched if found.setdefault(name, pattern) != pattern]
        if twice:
            _at(pattern, options, collector).error(
                "ISL002",
                f"{listed(twice)}: matched by '{shortened(found[twice[0]])}' too",
                "let one pattern match each joint",
            )
    return {name: stated[found[name]] if name in found else "auto" for name in names}


def check_classes(
    actuators: ActuatorSet,
    classes: Mapping[str, str],
    dialect: IsaacLabDialect,
    options: TargetOptions,
    collector: Collector,
) -> None:
    """Report what the release, or a joint's level, cannot have."""
    place = options.at("class", collector)
    if "custom" in classes.values() and not dialect.custom:
        place.error(
            "ISL003",
            f"Isaac Lab {dialect.text} runs its actuators natively and refuses classes of one's own",
            'write class: auto, or version: "2.3"',
        )
    networks = [
        a.joint for a in actuators.joints if a.level is Level.ACTUATOR_NET and classes[a.joint] == "implicit"
    ]
    if networks:
        place.error(
            "ISL004", f"the solver's own drive cannot run a network: {listed(networks)}", "write class: auto"
        )


def _at(pattern: str, options: TargetOptions, collector: Collector) -> Place:
    return collector.at(options.where(f"class.{pattern}"), options.span(f"class[{pattern}]"))
