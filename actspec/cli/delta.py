"""`actspec delta`: corrections of a policy's actions from logs of the robot, and what they take away of the error."""

from __future__ import annotations

import argparse

from actspec.cli.options import Lines, add_force, add_format, describe
from actspec.cli.recordings import add_logs, read_all, seconds_of, warned
from actspec.diagnostics import EXIT_CLEAN, EXIT_FINDINGS, Collector, shortened
from actspec.ir import JointKind
from actspec.logs import LogError
from actspec.report.terminal import Progress, print_diagnostics, print_json, print_lines
from actspec.units import Kind, UnitError, parse_quantity

MOST = 1.0
"""Largest limit of a correction [rad or m]. Chosen: a policy's whole action is smaller."""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the subcommands and what their help says."""
    describe(
        command,
        "Delta action: a network that corrects a policy's actions so that the simulated robot goes where the real one "
        "went. See docs/delta-action.md.",
        'actspec delta train robots/a1.yaml walk.csv -o nets/delta --max-delta "0.1 rad"',
        "0 done; 1 findings, or a poor delta action; 2 could not run, nothing was written",
    )
    parts = command.add_subparsers(dest="part", metavar="PART", required=True)
    for name, words, add in (
        ("train", "train a delta action", _add_train),
        ("validate", "show what a delta action takes away", _add_validate),
    ):
        add(parts.add_parser(name, help=words, formatter_class=Lines))


def _add_base(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--base",
        choices=("fixed",),
        help="the base was held, whatever the logs say of it: the robot was hung up",
    )


def _add_train(command: argparse.ArgumentParser) -> None:
    describe(
        command,
        "Train a delta action on a policy's logs and write it as ONNX, TorchScript and manifest. The last recordings "
        "are held out; of a single one its last fifth.",
        'actspec delta train robots/a1.yaml walk.csv -o nets/delta --max-delta "0.1 rad"',
        "0 written; 1 written, with a warning; 2 nothing was written",
    )
    add_logs(command)
    command.add_argument("-o", "--output", required=True, metavar="DIR/NAME", help="of the three files")
    command.add_argument(
        "--max-delta", default="0.1 rad", metavar="ANGLE", help='largest correction; default "0.1 rad"'
    )
    command.add_argument(
        "--per",
        choices=("joint", "robot"),
        default="joint",
        help="one network shared by joints, or one for all",
    )
    _add_base(command)
    command.add_argument("--seed", type=int, default=0, metavar="K", help="of weights and batches; default 0")
    command.add_argument(
        "--epochs", type=int, metavar="N", help="passes over the rows; default: by their number"
    )
    command.add_argument("--max-time", metavar="TIME", help='of the training, e.g. "60 s"')
    add_force(command)
    add_format(command)


def _add_validate(command: argparse.ArgumentParser) -> None:
    describe(
        command,
        "Judge a delta action on logs that it was not trained on: errors of the next row with and without it, what the "
        "best correction of each row would take away, and commands replayed for 1 s.",
        "actspec delta validate robots/a1.yaml other.csv --network nets/delta.json",
        "0 good or fair; 1 poor; 2 could not run",
    )
    add_logs(command)
    command.add_argument("--network", required=True, metavar="MANIFEST", help="NAME.json")
    _add_base(command)
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Run a subcommand."""
    return {"train": _train, "validate": _validate}[arguments.part](arguments)


def _train(arguments: argparse.Namespace) -> int:
    from actspec.learn.delta.files import manifest_entries, write_delta
    from actspec.learn.delta.samples import collect
    from actspec.learn.delta.train import TrainOptions, split, train
    from actspec.learn.delta.validate import check_gain, check_limit
    from actspec.learn.files import check_output
    from actspec.learn.libraries import require
    from actspec.report.delta import train_lines, train_record
    from actspec.sysid.stand import Stand

    _check_numbers(arguments)
    limit, slides = _max_delta(arguments.max_delta)
    max_time = seconds_of(arguments.max_time, "--max-time")
    options = TrainOptions(limit, arguments.per, arguments.seed, arguments.epochs, max_time)
    check_output(arguments.output, force=arguments.force)
    require("scipy", "torch", "onnx")
    logs, actuators, robot = read_all(arguments)
    out = Collector()
    if slides is not None and slides is not (actuators.joints[0].kind is JointKind.SLIDE):
        message = f"{arguments.max_delta} is a correction of {'slides' if slides else 'hinges'}, the joints are others"
        raise LogError.of("LRN050", message, where="--max-delta")
    check_limit(limit, out)
    samples = collect(Stand(robot, actuators), logs, arguments.base, out)
    parts = split(samples)
    with Progress("training") as progress:
        trained = train(samples, parts, options, progress.step)
    errors = trained.judged
    check_gain(trained.judged, out)
    entries = manifest_entries(actuators, robot, samples, logs, options.per, errors, parts)
    paths = write_delta(arguments.output, trained.layers, entries, force=arguments.force)
    if arguments.output_format == "json":
        print_json(train_record(trained, options, parts, entries["period"], paths, out.sorted()))
    else:
        print_diagnostics(out.sorted())
        print_lines(train_lines(trained, options, parts, len(samples.joints)))
        print_lines(["wrote " + ", ".join(paths.values())])
    return warned(out)


def _validate(arguments: argparse.Namespace) -> int:
    from actspec.learn.delta.files import check_fit, read_delta
    from actspec.learn.delta.samples import collect
    from actspec.learn.delta.validate import check_limit, validate
    from actspec.learn.libraries import require
    from actspec.report.delta import validate_lines, validate_record
    from actspec.sysid.stand import Stand

    require("scipy", "onnx")
    network = read_delta(arguments.network)
    logs, actuators, robot = read_all(arguments)
    out = Collector()
    check_limit(network.manifest.max_delta, out)
    samples = collect(Stand(robot, actuators), logs, arguments.base, out)
    delta = check_fit(network, actuators, robot, samples, out)
    out.raise_if_failed(LogError)
    with Progress("rolling out") as progress:
        found = validate(samples, delta, network.manifest.max_delta, progress.step)
    if arguments.output_format == "json":
        print_json(validate_record(found, out.sorted()))
    else:
        print_diagnostics(out.sorted())
        print_lines(validate_lines(found))
    return EXIT_FINDINGS if found.grade == "poor" else EXIT_CLEAN


def _check_numbers(arguments: argparse.Namespace) -> None:
    for name, least in (("epochs", 1), ("seed", 0)):
        value = getattr(arguments, name)
        if value is not None and not least <= value <= 2**31:
            message = f"--{name} must be at least {least} and at most {2**31}, got {shortened(str(value))}"
            raise LogError.of("LRN050", message, where=f"--{name}")


def _max_delta(text: str) -> tuple[float, bool | None]:
    """The largest correction [rad or m], and whether it is that of slides; None: its unit does not tell."""
    try:
        found = parse_quantity(text, Kind.POSITION)
    except UnitError as err:
        raise LogError.of("LRN050", err.message, where="--max-delta", help=err.help) from err
    if not 0.0 < found.value <= MOST:
        message = f"--max-delta must be above 0 and at most {MOST:g} rad, got {text}"
        raise LogError.of("LRN050", message, where="--max-delta", help='write --max-delta "0.1 rad"')
    return found.value, found.linear
