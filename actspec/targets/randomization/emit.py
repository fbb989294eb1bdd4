"""The randomisation target: one file a stack, and what each loses.

Ranges are checked here, in `actspec.sample` and, as far as the text of a robot tells nominal values, by `validate`.
"""

from __future__ import annotations

from importlib import import_module

from actspec.diagnostics import Collector, EmitError, nearest, one_line
from actspec.ir import ActuatorSet
from actspec.robot.view import RobotView
from actspec.sampling import check_ranges
from actspec.simulators import UnknownVersion
from actspec.spec.models import RandomizationTarget
from actspec.targets.base import Approximation, Emission, EmittedFile, TargetOptions
from actspec.targets.kit.events import StackWriter

STACKS = {
    "isaaclab": "actspec.targets.isaaclab.randomization",
    "mjlab": "actspec.targets.mjlab.randomization",
    "playground": "actspec.targets.mujoco.playground",
    "json": "actspec.targets.randomization.record",
}
"""What randomisation can be written for, to the module whose `write` makes the file; imported when it is used.

`write` takes a `StackWriter`; None: there is nothing to draw there, or an error.
"""


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Write a robot's ranges for every stack that is asked for; see `choose.Emit`.

    `version` is of the one stack that is asked for, else each stack has its default.

    Raises: EmitError: a range cannot be drawn from, or a stack or version is not known.
    """
    collector = Collector()
    stacks = _stacks(options, collector)
    check_ranges(actuators, collector)
    collector.raise_if_failed(EmitError)
    files: list[EmittedFile] = []
    lost: list[Approximation] = []
    empty: list[str] = []
    for stack in stacks:
        writer = StackWriter(stack, actuators, robot, options, collector)
        try:
            made = import_module(STACKS[stack]).write(writer)
        except UnknownVersion as err:
            options.at(err.key, collector).error("RND013", err.message, err.help)
            continue
        lost += writer.losses.items
        if made is not None:
            files.append(made)
        else:
            empty.append(stack)
    collector.raise_if_failed(EmitError)
    if empty:
        stated = any(actuator.randomize for actuator in actuators.joints)
        why = "none of the spec's ranges can be drawn there" if stated else "the spec has no `randomize`"
        collector.at(f"targets.{options.name}").info(
            "RND015",
            f"no file for {', '.join(empty)} is written: {why}",
            "state randomize in a group, or leave the stack out of `for`",
        )
    return Emission(tuple(files), tuple(lost), collector.sorted())


def _stacks(options: TargetOptions, collector: Collector) -> tuple[str, ...]:
    asked = options.of(RandomizationTarget).for_ or ()
    for index, stack in enumerate(asked):
        if stack not in STACKS:
            guess = nearest(stack, list(STACKS))
            option = f"for[{index}]"
            options.at(option, collector).error(
                "RND011",
                f"no randomisation can be written for '{one_line(stack)}'",
                (f"did you mean '{guess}'? " if guess else "") + f"known: {', '.join(STACKS)}",
            )
    chosen = tuple(stack for stack in STACKS if stack in asked) if asked else tuple(STACKS)
    versioned = [stack for stack in chosen if stack != "json"]
    if options.version and len(versioned) != 1:
        options.at("version", collector).error(
            "RND012",
            f"version '{one_line(options.version)}' could be that of {' or '.join(versioned) or 'no stack'}",
            "write a target for each stack: {target: randomization, for: [isaaclab], version: ...}",
        )
    return chosen
