"""`actspec show`: every value of a joint with unit, origin, source, formula, and what it overrides."""

from __future__ import annotations

import argparse

from actspec import api
from actspec.cli.options import add_format, add_variant, describe, joints_named
from actspec.diagnostics import EXIT_CLEAN, many, shell_word
from actspec.report.show import details, joint_record, overview
from actspec.report.terminal import print_diagnostics, print_json, print_lines
from actspec.spec.variants import named


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Show the actuators of a spec, fitted to its robot. Without a joint one line a joint; with one every value "
        "with unit, origin, source, place and formula, and the values that it overrides.",
        "actspec show robots/a1.yaml FR_calf_joint",
        "0 shown; 2 could not",
    )
    command.add_argument("spec", metavar="SPEC", help="actuator spec (YAML)")
    command.add_argument("joint", nargs="?", metavar="JOINT", help="joint, or a pattern of joints")
    add_variant(command)
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Show one joint, those that a pattern matches, or all."""
    path = named(arguments.spec, arguments.variant)
    actuators = api.resolve(path)
    joints = joints_named(actuators, [] if arguments.joint is None else [arguments.joint], "JOINT")
    if arguments.output_format == "json":
        print_json({"format": "actspec-actuators/1", "joints": [joint_record(joint) for joint in joints]})
        return EXIT_CLEAN
    print_diagnostics(actuators.diagnostics)
    if arguments.joint is None:
        count = many(len(joints), "joint")
        print_lines(
            [f"{actuators.title}: {count}; `actspec show {shell_word(path)} JOINT` shows every value"]
        )
        print_lines(overview(joints))
    for number, joint in enumerate(joints if arguments.joint is not None else ()):
        print_lines(["", *details(joint, actuators.approximations)][not number :])
    return EXIT_CLEAN
