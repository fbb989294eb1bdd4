"""Options that several commands share, how help is laid out, and what `--target NAME==VERSION` means."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from actspec.ir import ActuatorSet, JointActuator
    from actspec.readings.versions import Versions


class Lines(argparse.HelpFormatter):
    """Help whose description and epilog keep their line breaks."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        filled = (
            textwrap.fill(
                line, width, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False
            )
            for line in text.splitlines()
        )
        return "\n".join(filled)


def describe(command: argparse.ArgumentParser, what: str, example: str, exits: str) -> None:
    """What the help of a command says around its options.

    Args:
        command: Its parser.
        what: What it does.
        example: A command line.
        exits: Its exit codes.
    """
    command.description = what
    command.epilog = f"example: {example}\nexit codes: {exits}"


def add_specs(command: argparse.ArgumentParser, count: str = "+") -> None:
    """Add the specs that a command works on."""
    command.add_argument("spec", nargs=count, metavar="SPEC", help="actuator spec (YAML)")


def add_variant(command: argparse.ArgumentParser) -> None:
    """Add the choice among a spec's variants."""
    command.add_argument(
        "--variant",
        metavar="NAME",
        help="this variant of the spec; the same as SPEC#NAME (default: as it stands)",
    )


def add_targets(command: argparse.ArgumentParser) -> None:
    """Add the choice among a spec's targets."""
    command.add_argument(
        "-t",
        "--target",
        action="append",
        default=[],
        metavar="TARGET",
        help="only this target of the spec, or KIND==VERSION such as mujoco==3.11; may be repeated",
    )


def add_versions(command: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """Add what files are meant for."""
    command.add_argument(
        "-t",
        "--target",
        action="append",
        default=[],
        metavar="NAME==VERSION",
        help="what the files are for: mujoco, isaaclab, isaac_sim, mjlab with a version, or backend==newton; may be "
        "repeated",
    )


def add_format(command: argparse.ArgumentParser, *more: str) -> None:
    """Add the form of the output: text, json and what else there is."""
    formats = ("text", "json", *more)
    command.add_argument("--output-format", choices=formats, default="text", help="default: text")


def configured_versions(targets: Sequence[str]) -> Versions:
    """The versions of the settings file, with those that a user names in their place.

    Raises: AuditError: either is wrong.
    """
    from actspec.audit.rules import all_rules
    from actspec.audit.settings import load_settings, named_versions
    from actspec.diagnostics import AuditError, Collector

    out = Collector()
    named = named_versions(targets, out)
    out.raise_if_failed(AuditError)
    return overridden(load_settings(all_rules()).versions, named)


def overridden(versions: Versions, by: Versions) -> Versions:
    """Versions with those of `by` in their place where it states any."""
    given = {name: getattr(by, name) for name in by.__dataclass_fields__}
    return replace(versions, **{name: value for name, value in given.items() if value is not None})


def joints_named(actuators: ActuatorSet, patterns: Sequence[str], option: str) -> tuple[JointActuator, ...]:
    """The joints that names or patterns match, in the robot's order.

    Args:
        actuators: The spec, resolved.
        patterns: None: all joints.
        option: That gives them, for messages.

    Raises:
        ResolveError: a pattern is none, or matches no joint.
    """
    from actspec.diagnostics import Collector, ResolveError, listed
    from actspec.patterns import PatternError, match_names, suggest_pattern

    names = [joint.joint for joint in actuators.joints]
    wanted: set[str] = set() if patterns else set(names)
    out = Collector()
    for pattern in patterns:
        help: str | None = f"joints: {listed(names)}"
        message = f"'{pattern}' matches no joint that the spec manages"
        try:
            found = set(match_names(pattern, names)) or ({pattern} & set(names))
            guess = suggest_pattern(pattern, names)
            help = f"did you mean '{guess}'?" if guess else help
        except PatternError as err:
            found, message, help = {pattern} & set(names), err.message, err.help
        if not found:
            out.error("BIND001", message, where=option, help=help)
        wanted |= found
    out.raise_if_failed(ResolveError)
    return tuple(joint for joint in actuators.joints if joint.joint in wanted)
