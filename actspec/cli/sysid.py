"""`actspec sysid`: commands for an experiment, a virtual robot that follows them, the fit of a log, and its report."""

from __future__ import annotations

import argparse
import math
from dataclasses import fields
from typing import Any

from actspec import api
from actspec.cli import sysid_import, sysid_report
from actspec.cli.options import Lines, add_force, add_format, describe, joints_named, natural, quantity_of
from actspec.cli.recordings import add_logs, read_logs, warned
from actspec.diagnostics import EXIT_CLEAN, Collector, ResolveError, Span, listed, many
from actspec.libraries import extra_line
from actspec.report.terminal import Progress, print_diagnostics, print_json, print_lines
from actspec.sysid.identified import METHODS
from actspec.units import Kind

FLAWS: tuple[tuple[str, str, Kind, float, str], ...] = (
    ("--position-noise", "position_noise", Kind.POSITION, math.inf, '"0.5 mrad"'),
    ("--velocity-noise", "velocity_noise", Kind.SPEED, math.inf, '"0.05 rad/s"'),
    ("--torque-noise", "torque_noise", Kind.RATIO, math.inf, '"2 %%" of its root mean square'),
    ("--velocity-filter", "velocity_filter", Kind.FREQUENCY, math.inf, "40Hz, the cutoff of a low-pass"),
    ("--jitter", "jitter", Kind.RATIO, 0.45, '"15 %%" of the time between rows'),
    ("--dropped", "dropped", Kind.RATIO, 0.9, '"1 %%" of the rows'),
    ("--play", "play", Kind.POSITION, math.inf, '"0.3 deg", between joint and encoder'),
    ("--sag", "sag", Kind.RATIO, 1.0, '"10 %%" of the torque-speed line, at full torque'),
    ("--torque-scale", "torque_scale", Kind.RATIO, math.inf, '"5 %%" too much torque in the log'),
    ("--torque-constant", "torque_constant", Kind.TORQUE_CONSTANT, math.inf, '"0.1 N*m/A": log the current'),
)
"""Options of `simulate`: name, field of `Flaws`, kind, largest value, example."""
MOST_BITS = 40
"""Of an encoder. Chosen: finer than the ten digits of a log."""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the subcommands and what their help says."""
    describe(
        command,
        "From a robot's log to the figures of a spec: design an experiment, try it on a virtual robot, fit the log.",
        "actspec sysid fit robots/a1.yaml hip.csv -o results/hip.yaml",
        "0 done; 1 written, with a warning; 2 nothing was written",
    )
    parts = command.add_subparsers(dest="part", metavar="PART", required=True)
    _add_design(parts.add_parser("design", help="write commands for an experiment", formatter_class=Lines))
    _add_simulate(
        parts.add_parser(
            "simulate", help="let the spec follow commands as a robot would", formatter_class=Lines
        )
    )
    _add_fit(parts.add_parser("fit", help="fit logs", formatter_class=Lines))
    sysid_report.add_arguments(parts.add_parser("report", help="show a fit on a page", formatter_class=Lines))
    sysid_import.add_arguments(
        parts.add_parser("import", help="take results of another tool", formatter_class=Lines)
    )


def _add_design(command: argparse.ArgumentParser) -> None:
    describe(
        command,
        "Write commands for an experiment, held to range, speed and torque by simulating the spec, with the response "
        "that the spec would have.",
        "actspec sysid design robots/a1.yaml -o chirp.csv --experiment chirp --joint FR_thigh_joint",
        "0 written; 2 not",
    )
    command.add_argument("spec", metavar="SPEC", help="actuator spec (YAML)")
    command.add_argument("-o", "--output", required=True, metavar="LOG", help="log of commands, .csv or .npz")
    add_force(command)
    command.add_argument(
        "--experiment",
        required=True,
        choices=("chirp", "multisine", "steps", "friction", "random"),
        help="what the command does",
    )
    _add_joint(command, "all")
    command.add_argument(
        "--duration", default="20 s", metavar="TIME", help="of one joint's part; default 20 s"
    )
    command.add_argument("--rate", default="500 Hz", metavar="RATE", help="of the commands; default 500 Hz")
    command.add_argument("--together", action="store_true", help="move all joints at once")
    command.add_argument("--linear", action="store_true", help="let a chirp's frequency grow linearly")
    command.add_argument(
        "--seed", type=natural, default=0, metavar="N", help="of phases and levels; default 0"
    )


def _add_joint(command: argparse.ArgumentParser, which: str) -> None:
    command.add_argument(
        "--joint",
        action="extend",
        nargs="+",
        default=[],
        metavar="JOINT",
        help=f"joints or patterns; default: {which}",
    )


def _add_simulate(command: argparse.ArgumentParser) -> None:
    describe(
        command,
        "Let the spec follow a log's commands in place of the robot, in finer steps than a fit takes, and log what "
        "its sensors would read. The same seed gives the same bytes.",
        "actspec sysid simulate robots/a1.yaml --command chirp.csv -o log.csv --seed 1 --position-noise '0.5 mrad'",
        "0 written; 2 not",
    )
    command.add_argument("spec", metavar="SPEC", help="actuator spec (YAML)")
    command.add_argument(
        "--command", required=True, metavar="LOG", dest="commands", help="log with the commands"
    )
    command.add_argument("-o", "--output", required=True, metavar="LOG", help="the new log, .csv or .npz")
    add_force(command)
    command.add_argument("--seed", type=natural, required=True, metavar="N", help="of all noise")
    command.add_argument(
        "--encoder-bits", type=natural, default=0, metavar="N", help="over one turn, e.g. 14"
    )
    for name, field, *_, example in FLAWS:
        command.add_argument(name, dest=field, metavar="VALUE", help=f"e.g. {example}")


def _add_fit(command: argparse.ArgumentParser) -> None:
    describe(
        command,
        "Fit kp, kd, armature, friction, delay and encoder bias of every joint in the logs, with intervals, and say "
        "what the logs cannot tell. What is free follows from what was logged: see docs/sysid.md.",
        "actspec sysid fit robots/a1.yaml hip.csv -o results/hip.yaml",
        "0 written; 1 written, with a warning; 2 nothing was written",
    )
    add_logs(command)
    command.add_argument("-o", "--output", metavar="RESULTS", help="results file to write (YAML)")
    command.add_argument(
        "--method",
        choices=METHODS,
        default=METHODS[0],
        help="motion of all figures at once (default), spectra, steps, or constant speeds",
    )
    _add_joint(command, "all that a log's commands move")
    command.add_argument("--free", default="", metavar="F,...", help="fields to fit beside the usual ones")
    command.add_argument(
        "--validate",
        action="append",
        default=[],
        metavar="LOG",
        help="log that the fit does not see: its position error is the held-out one; may be given again",
    )
    command.add_argument("--hold", default="", metavar="F,...", help="fields to hold at the spec's")
    add_force(command)
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Run a subcommand."""
    parts = {
        "design": _design,
        "simulate": _simulate,
        "fit": _fit,
        "report": sysid_report.run,
        "import": sysid_import.run,
    }
    if arguments.part in ("fit", "report"):
        _need_scipy()
    return parts[arguments.part](arguments)


def _need_scipy() -> None:
    from actspec.logs import LogError

    try:
        import scipy.signal  # noqa: F401
    except ImportError as err:
        help = extra_line("sysid")
        raise LogError.of("SYS002", "a fit needs scipy, which is not installed", help=help) from err


def _design(arguments: argparse.Namespace) -> int:
    from actspec.logs import LogError, check_log_path, write_log
    from actspec.owned import check_free
    from actspec.sysid.design import design
    from actspec.sysid.stand import standing

    check_free(arguments.output, [arguments.spec], arguments.force, again=True)
    check_log_path(arguments.output)
    out = Collector()
    duration = quantity_of(arguments.duration, Kind.TIME, "--duration", "SYS042", out)
    rate = quantity_of(arguments.rate, Kind.FREQUENCY, "--rate", "SYS042", out)
    out.raise_if_failed(LogError)
    assert duration is not None and rate is not None
    spec = api.load(arguments.spec)
    robot = api.load_robot(spec)
    resolved = api.resolve(spec, robot)
    actuators = joints_named(resolved, arguments.joint, "--joint")
    made = design(
        standing(robot, resolved),
        actuators,
        arguments.experiment,
        path=arguments.output,
        duration=duration,
        rate=rate,
        together=arguments.together,
        linear=arguments.linear,
        seed=arguments.seed,
    )
    write_log(made.log, force=arguments.force)
    shown = [
        f"{joint} +-{size:.3g} {'m' if made.log.joints[joint].linear else 'rad'} ({made.limited_by[joint]})"
        for joint, size in made.amplitudes.items()
    ]
    rows = f"{len(made.log.time)} rows, {made.log.time[-1]:.4g} s"
    print_lines([f"wrote {arguments.output}: {rows}; limited by: {listed(shown)}"])
    return EXIT_CLEAN


def _simulate(arguments: argparse.Namespace) -> int:
    from actspec.logs import LogError, check_log_path, load_log, write_log
    from actspec.owned import check_free
    from actspec.sysid.stand import standing
    from actspec.sysid.virtual import Flaws, follow

    check_free(arguments.output, [arguments.spec, arguments.commands], arguments.force, again=True)
    check_log_path(arguments.output)
    out = Collector()
    values: dict[str, Any] = {
        field: quantity_of(text, kind, name, "SYS042", out, zero=True, most=most)
        for name, field, kind, most, _ in FLAWS
        if (text := getattr(arguments, field)) is not None
    }
    if arguments.encoder_bits > MOST_BITS:
        message = f"must be at most {MOST_BITS}, got {arguments.encoder_bits}"
        out.error("SYS042", message, where="--encoder-bits")
    out.raise_if_failed(LogError)
    assert set(values) <= {field.name for field in fields(Flaws)}
    commands = load_log(arguments.commands)
    spec = api.load(arguments.spec)
    robot = api.load_robot(spec)
    actuators = api.resolve(spec, robot)
    found = [joint for joint in actuators.joints if joint.joint in commands.joints]
    unknown = [name for name in commands.joints if name not in {joint.joint for joint in found}]
    if unknown or not found:
        message = f"the spec has no joint {listed(unknown)}"
        raise ResolveError.of("SYS021", message, Span(arguments.commands, 1))
    with Progress("simulating") as progress:
        log = follow(
            standing(robot, actuators, commands),
            found,
            commands,
            arguments.output,
            Flaws(**values, bits=arguments.encoder_bits),
            arguments.seed,
            progress.step,
        )
    write_log(log, force=arguments.force)
    print_lines([f"wrote {arguments.output}: {len(log.time)} rows of {many(len(found), 'joint')}"])
    return EXIT_CLEAN


def _fit(arguments: argparse.Namespace) -> int:
    from actspec.logs import check_results_path
    from actspec.output import write_text
    from actspec.owned import check_free
    from actspec.report.sysid import sysid_lines, sysid_record
    from actspec.sysid.methods import fit_by
    from actspec.sysid.results import results_text
    from actspec.sysid.work import FitOptions

    output = arguments.output
    if output is not None:
        check_results_path(output)
        check_free(output, [arguments.spec, *arguments.log, *arguments.validate], arguments.force)
    read = read_logs(arguments.log, "SYS035", arguments.validate)
    logs, validation = read[: len(arguments.log)], read[len(arguments.log) :]
    spec = api.load(arguments.spec)
    robot = api.load_robot(spec)
    actuators = api.resolve(spec, robot)
    joints = [joint.joint for joint in joints_named(actuators, arguments.joint, "--joint")]
    options = FitOptions(
        *(frozenset(found) for found in (_names(arguments.free), _names(arguments.hold), joints))
    )
    found = fit_by(arguments.method, actuators, robot, logs, options, validation)
    if output is not None:
        write_text(output, results_text(found, logs, spec.document), force=arguments.force)
    if arguments.output_format == "json":
        print_json(sysid_record(found, output))
    else:
        print_diagnostics(found.findings)
        print_lines(sysid_lines(found))
        if output is not None:
            print_lines([f"wrote {output}"])
    return warned(found.findings)


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",") if name.strip()]
