"""Which kind of actuator class each joint gets: that of the target, or of the pattern that selects the joint."""

from __future__ import annotations

from collections.abc import Mapping

from actspec.diagnostics import Collector, listed
from actspec.ir import ActuatorSet, Level
from actspec.simulators.isaaclab import IsaacLabDialect
from actspec.spec.models import IsaacLabTarget
from actspec.targets.base import TargetOptions
from actspec.targets.kit.joint import pattern_of


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
    found = pattern_of(list(stated), names, "class", "ISL002", options, collector)
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
