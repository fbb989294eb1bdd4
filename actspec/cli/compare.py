"""`actspec compare`: what each part of an actuator's model changes, joint by joint."""

from __future__ import annotations

import argparse
import math
import os
from typing import TYPE_CHECKING

from actspec.cli.options import (
    add_fail_on,
    add_force,
    add_format,
    add_specs,
    add_variant,
    describe,
    quantity_of,
)
from actspec.diagnostics import (
    EXIT_CLEAN,
    EXIT_FINDINGS,
    Collector,
    Diagnostic,
    SpecError,
    one_line,
)
from actspec.libraries import extra_line
from actspec.units import Kind

if TYPE_CHECKING:
    from actspec.study.compare import Comparison

LEAST = 0.01
"""Shortest course [s]. Chosen: a few control steps of any machine, so that there is something to see."""
MOST = 60.0
"""Longest course [s]. Chosen: the slowest joints of a machine settle in a few seconds."""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Let each distinct actuator of a spec, alone on its inertia, follow a step, a swing and a chirp: as PD and "
        "limit, that with one further part of its model (filter, delay, torque-speed line, network), and all of it; by "
        "the law, and in MuJoCo at the spec's step.",
        "actspec compare robots/a1.yaml --delay 10ms --plot a1.svg",
        "0 nothing at or above --fail-on; 1 findings; 2 could not run",
    )
    add_specs(command)
    add_variant(command)
    command.add_argument(
        "--joint",
        action="append",
        default=[],
        metavar="NAME",
        help="only this joint, or pattern; may be repeated",
    )
    command.add_argument(
        "--filter", metavar="FREQUENCY", help="low-pass of the command, where the spec has none: 30Hz"
    )
    command.add_argument("--delay", metavar="TIME", help="of the command, where the spec has none: 10ms")
    command.add_argument("--duration", default="1s", metavar="TIME", help="of each course; default 1s")
    command.add_argument(
        "--plot",
        action="append",
        default=[],
        metavar="FILE",
        help="write pictures, as .svg, .png or .pdf; may be repeated",
    )
    add_force(command)
    add_fail_on(command)
    add_format(command, "markdown")


def run(arguments: argparse.Namespace) -> int:
    """Compare, print, draw."""
    from actspec import api
    from actspec.cli.options import failing, joints_named
    from actspec.output import write_files
    from actspec.owned import check_free
    from actspec.report import compare as report
    from actspec.report.figures import drawn
    from actspec.report.terminal import Progress, print_diagnostics, print_json, print_lines
    from actspec.spec.variants import named
    from actspec.study.compare import compare, simulator_of
    from actspec.study.variants import Assumed

    out = Collector()
    cutoff, delay, duration = (
        None if text is None else quantity_of(text, kind, option, "CMP010", out, least=least, most=most)
        for text, kind, option, least, most in (
            (arguments.filter, Kind.FREQUENCY, "--filter", 0.0, math.inf),
            (arguments.delay, Kind.TIME, "--delay", 0.0, MOST),
            (arguments.duration, Kind.TIME, "--duration", LEAST, MOST),
        )
    )
    _check_plots(arguments.plot, out)
    out.raise_if_failed(SpecError)
    for path in arguments.plot:
        check_free(path, arguments.spec, arguments.force)
    assert duration is not None

    found: list[Comparison] = []
    for path in arguments.spec:
        spec = api.load(named(path, arguments.variant))
        robot = api.load_robot(spec)
        actuators = api.resolve(spec, robot)
        joints = [joint.joint for joint in joints_named(actuators, arguments.joint, "--joint")]
        with Progress("simulating") as progress:
            found.append(
                compare(
                    actuators,
                    robot,
                    simulator_of(spec, out),
                    spec=path,
                    joints=joints,
                    given=Assumed(cutoff, delay),
                    duration=duration,
                    progress=progress.step,
                )
            )
    findings: list[Diagnostic] = [item for one in found for item in one.findings]
    charts = [chart for one in found for chart in report.charts(one)]
    pictures = [(path, drawn(charts, path)) for path in arguments.plot] if charts else []
    write_files(pictures, force=arguments.force)
    if arguments.output_format == "json":
        print_json(report.record(found, findings))
    else:
        shown = report.lines if arguments.output_format == "text" else report.markdown
        for number, one in enumerate(found):
            print_lines([*[""] * bool(number), *shown(one)])
        print_diagnostics(findings)
        for path, _ in pictures:
            print(f"wrote {one_line(path)}")
    return EXIT_FINDINGS if failing(findings, arguments.fail_on) else EXIT_CLEAN


def _check_plots(paths: list[str], out: Collector) -> None:
    from importlib.util import find_spec

    from actspec.report.figures import SUFFIXES

    for number, path in enumerate(paths):
        if path.casefold() in map(str.casefold, paths[:number]):
            out.error("CMP011", f"'{path}' is named twice", where="--plot", help="one picture a file")
        suffix = os.path.splitext(path)[1].lower()
        if suffix not in SUFFIXES:
            out.error(
                "CMP011", f"'{path}' is no picture", where="--plot", help=f"one of {', '.join(SUFFIXES)}"
            )
        elif suffix != ".svg" and find_spec("matplotlib") is None:
            help = f"{extra_line('report')}, or write an .svg"
            out.error(
                "CMP012", f"{suffix} needs matplotlib, which is not installed", where="--plot", help=help
            )
        if os.path.isdir(path) or not os.path.isdir(os.path.dirname(path) or os.curdir):
            out.error("CMP011", f"'{path}' cannot be written: there is no such folder", where="--plot")
