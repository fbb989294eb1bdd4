"""`actspec diagnose`: is the simulated actuator good enough, by logs, and what to do about it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from actspec.cli.options import add_fail_on, add_format, add_variant, describe, failing
from actspec.diagnostics import EXIT_CLEAN, EXIT_FINDINGS
from actspec.study.level import TASKS

if TYPE_CHECKING:
    from actspec.logs import Log
    from actspec.study.level import Answers


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Judge a spec by logs of a rollout or a robot: how near to the motor's bounds each joint works, which law "
        "gives the logged torque, what to do next and what it costs, and which model level is enough.",
        "actspec diagnose robots/a1.yaml rollout.csv --task run --robot yes --torque-sensor no",
        "0 nothing at or above --fail-on; 1 findings; 2 could not run",
    )
    command.add_argument("spec", metavar="SPEC", help="actuator spec (YAML)")
    command.add_argument(
        "log", nargs="*", metavar="LOG", help="CSV, NPZ or Parquet; its sidecar lies beside it"
    )
    add_variant(command)
    command.add_argument(
        "--against", metavar="LOG", help="another log of the same commands: a robot's beside a simulation's"
    )
    command.add_argument("--task", choices=TASKS, help="what the policy is to do")
    command.add_argument("--robot", choices=("yes", "no"), help="whether there is a robot")
    command.add_argument(
        "--torque-sensor", choices=("yes", "no"), help="whether it measures torque, or motor current"
    )
    command.add_argument(
        "--transfer",
        type=float,
        metavar="SHARE",
        help="score on the robot over that in simulation, such as 0.7",
    )
    add_fail_on(command)
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Read, judge, print."""
    from actspec import api
    from actspec.report.diagnosis import lines, record
    from actspec.report.terminal import print_diagnostics, print_json, print_lines
    from actspec.spec.variants import named
    from actspec.study.diagnose import diagnose

    answers = answers_of(arguments)
    spec = api.load(named(arguments.spec, arguments.variant))
    logs, against = logs_of(arguments)
    robot = api.load_robot(spec)
    actuators = api.resolve(spec, robot)
    found = diagnose(actuators, robot, arguments.spec, logs, against, answers)
    if arguments.output_format == "json":
        print_json(record(found))
    else:
        print_diagnostics((*found.notes, *found.findings))
        print_lines(lines(found))
    return EXIT_FINDINGS if failing(found.findings, arguments.fail_on) else EXIT_CLEAN


def logs_of(arguments: argparse.Namespace) -> tuple[list[Log], Log | None]:
    """The logs of the command line, and the one that they are held against.

    Raises: LogError: one cannot be read, or none or several are to be held against another.
    """
    from actspec.logs import LogError, load_log

    if arguments.against is not None and len(arguments.log) != 1:
        message = f"needs one log to hold it to, got {len(arguments.log)}"
        raise LogError.of("DGN011", message, where="--against")
    logs = [load_log(path) for path in arguments.log]
    return logs, None if arguments.against is None else load_log(arguments.against)


def answers_of(arguments: argparse.Namespace) -> Answers:
    """What the user says.

    Raises: LogError: `--transfer` is no share.
    """
    from actspec.logs import LogError
    from actspec.study.level import Answers

    transfer = arguments.transfer
    if transfer is not None and not 0.0 <= transfer < 100.0:
        raise LogError.of("DGN011", f"must be from 0 on, such as 0.7, got {transfer:g}", where="--transfer")
    robot, sensor = (_said(answer) for answer in (arguments.robot, arguments.torque_sensor))
    return Answers(arguments.task, robot, sensor, transfer)


def _said(answer: str | None) -> bool | None:
    return None if answer is None else answer == "yes"
