"""Options that several commands share, how help is laid out, and what `--target NAME==VERSION` means."""

from __future__ import annotations

import argparse
import math
import os
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import takewhile
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import nearest

if TYPE_CHECKING:
    from actspec.diagnostics import Collector, Diagnostic
    from actspec.ir import ActuatorSet, JointActuator
    from actspec.readings.versions import Versions
    from actspec.units import Kind


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


class Command(argparse.ArgumentParser):
    """A command whose optional arguments may stand behind options too: `show SPEC --variant NAME JOINT`.

    It ends by itself where it does not know an option, with its own usage and the option of nearly that name.
    """

    _mixing = False

    def __init__(self, **settings: Any) -> None:
        # An option that is cut short may be a misspelt one, or another one in the next release.
        super().__init__(allow_abbrev=False, **settings)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as err:
            near = nearest(str(value), [str(one) for one in action.choices or ()])
            if near is not None:
                raise argparse.ArgumentError(action, f"{err.message}; did you mean {near!r}?") from None
            raise

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse does; where it leaves arguments over, and no option among them, with options taken out first."""
        found, rest = super().parse_known_args(args, namespace)
        # `--` and parts of a command have an order that counts.
        unknown = [text for text in takewhile("--".__ne__, rest) if text.startswith("-")]
        if unknown and self._subparsers is None:
            names = [name[2:] for name in self._option_string_actions if name.startswith("--")]
            near = nearest(unknown[0].partition("=")[0].lstrip("-"), names)
            guess = "" if near is None else f"; did you mean --{near}?"
            self.error(f"unrecognized arguments: {' '.join(rest)}{guess}")
        plain = self._mixing or self._subparsers is not None or namespace is not None or "--" in args
        if plain or not rest:
            return found, rest
        self._mixing = True
        try:
            return self.parse_known_intermixed_args(args)
        finally:
            self._mixing = False


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


def add_packages(command: argparse.ArgumentParser) -> None:
    """Add where ROS packages lie."""
    command.add_argument(
        "--package",
        action="append",
        default=[],
        type=_package,
        metavar="NAME=FOLDER",
        help="where the meshes lie that a URDF names by package://NAME/path, as `robot.packages` of the spec; may be "
        "repeated",
    )


def _package(text: str) -> tuple[str, str]:
    """A package and its folder.

    Raises: argparse.ArgumentTypeError: the text is not that, or there is no such folder.
    """
    name, equals, folder = text.partition("=")
    if not (name and equals and folder):
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=FOLDER")
    if "\0" in folder or not os.path.isdir(folder):
        raise argparse.ArgumentTypeError(f"there is no folder {folder!r} of the package {name!r}")
    return name, folder


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


def add_canonical(command: argparse.ArgumentParser) -> None:
    """Add that the model is written in MuJoCo's own form."""
    command.add_argument(
        "--canonical", action="store_true", help="write MuJoCo's own form, not the author's text"
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


FAIL_ON = ("error", "warning", "info", "never")
"""From which severity on a command exits with 1."""


def add_force(
    command: argparse.ArgumentParser | argparse._ArgumentGroup,
    help: str = "replace files that actspec did not write",
) -> None:
    """Add that files of others may be replaced."""
    command.add_argument("--force", action="store_true", help=help)


def add_fail_on(command: argparse.ArgumentParser) -> None:
    """Add from which severity on findings make the exit code 1."""
    command.add_argument(
        "--fail-on", choices=FAIL_ON, default="warning", help="exit 1 from this severity on; default: warning"
    )


def failing(findings: Iterable[Diagnostic], fail_on: str) -> bool:
    """Whether a finding is at or above a severity of `--fail-on`."""
    from actspec.diagnostics import SEVERITIES, Severity

    if fail_on == "never":
        return False
    least = SEVERITIES.index(Severity(fail_on))
    return any(SEVERITIES.index(item.severity) >= least for item in findings)


def quantity_of(
    text: str,
    kind: Kind,
    option: str,
    code: str,
    out: Collector,
    *,
    zero: bool = False,
    least: float = 0.0,
    most: float = math.inf,
) -> float | None:
    """A number of an option, in SI; None: it is none, which `out` is given.

    Args:
        text: With its unit, `30Hz`.
        kind: Of quantity.
        option: For messages.
        code: Of the diagnostic.
        out: Takes it.
        zero: Whether 0 is one.
        least: Smallest [SI].
        most: Largest [SI].
    """
    from actspec.units import Kind, UnitError, format_number, parse_quantity

    try:
        value = parse_quantity(text, kind).value
    except UnitError as err:
        out.error(code, err.message, where=option, help=err.help)
        return None
    if value < 0.0 or value == math.inf or (value == 0.0 and not zero):
        out.error(code, f"must be {'at least' if zero else 'above'} 0, got {text}", where=option)
        return None
    if not least <= value <= most:
        bound, word = (most, "most") if value > most else (least, "least")
        unit = "" if kind is Kind.RATIO else f" {kind.rotary_unit}"
        out.error(code, f"must be at {word} {format_number(bound)}{unit}, got {text}", where=option)
        return None
    return value


def quantity_needed(
    text: str, kind: Kind, option: str, code: str, *, zero: bool = False, most: float = math.inf
) -> float:
    """The same for a command that reads recordings, where nothing else is asked at once.

    Raises: LogError: it is none.
    """
    from actspec.diagnostics import Collector
    from actspec.logs import LogError

    out = Collector()
    value = quantity_of(text, kind, option, code, out, zero=zero, most=most)
    out.raise_if_failed(LogError)
    assert value is not None
    return value


def natural(text: str) -> int:
    """A whole number from 0 on, as a seed is, for argparse.

    Raises: argparse.ArgumentTypeError: the text is none.
    """
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise argparse.ArgumentTypeError(f"{text!r} is no whole number from 0 to 999999999")
    return int(text)


def configured_versions(targets: Sequence[str]) -> Versions:
    """The versions of the settings file, with those that a user names in their place; a newer one than known is told.

    Raises: AuditError: either is wrong.
    """
    from actspec.audit.rules import all_rules
    from actspec.audit.settings import beyond_known, load_settings, named_versions
    from actspec.diagnostics import AuditError, Collector
    from actspec.report.terminal import print_diagnostics

    out = Collector()
    named = named_versions(targets, out)
    out.raise_if_failed(AuditError)
    versions = overridden(load_settings(all_rules()).versions, named)
    print_diagnostics(beyond_known(versions))
    return versions


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
