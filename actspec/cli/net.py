"""`actspec net`: actuator networks from logs: what the logs hold, training, and how good a network is."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from actspec.cli.options import Lines, add_force, add_format, describe
from actspec.cli.recordings import add_logs, read_all, seconds_of, warned
from actspec.diagnostics import EXIT_CLEAN, EXIT_FINDINGS, Collector, Span, listed, one_line, shortened
from actspec.report.terminal import Progress, print_diagnostics, print_json, print_lines
from actspec.units import format_number

if TYPE_CHECKING:
    from actspec.ir import JointActuator

MOST_HIDDEN = 4096
"""Largest hidden layer. Chosen: an actuator network runs for thousands of joints in each physics step."""
DEFAULT_TAPS = 6
"""Samples of a history. Measured by benchmarks/learn.py: more tell little more of a drive without wide play."""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the subcommands and what their help says."""
    describe(
        command,
        "Actuator networks: what logs hold for one, training, how good it is, and what one of others does. See "
        "docs/networks.md.",
        "actspec net train robots/a1.yaml walk.csv chirp.csv -o nets/legs",
        "0 done; 1 findings, or a poor network; 2 could not run, nothing was written",
    )
    parts = command.add_subparsers(dest="part", metavar="PART", required=True)
    for name, words, add in (
        ("data", "show what logs hold", _add_data),
        ("train", "train a network", _add_train),
        ("evaluate", "judge a network on logs", _add_evaluate),
        ("inspect", "show what a network does", _add_inspect),
        ("convert", "write a network of others as ONNX, TorchScript and manifest", _add_convert),
    ):
        add(parts.add_parser(name, help=words, formatter_class=Lines))


def _add_samples(command: argparse.ArgumentParser) -> None:
    command.add_argument("--group", metavar="GROUP", help="of the spec; default: that of the logs' joints")
    command.add_argument(
        "--taps", type=int, metavar="N", help=f"samples of a history; default {DEFAULT_TAPS}"
    )
    command.add_argument(
        "--tap-period", metavar="TIME", help="between two samples; default: the logs' time between rows"
    )
    command.add_argument(
        "--torque-of", choices=("drive", "joint"), help="where it was measured; default: as the sidecars say"
    )


def _add_data(command: argparse.ArgumentParser) -> None:
    describe(
        command,
        "Show what logs hold for a network: minutes, rate, gaps, saturation, band and ranges of each joint, and how "
        "much of a policy's log lies outside.",
        "actspec net data robots/a1.yaml walk.csv --policy policy.csv",
        "0 nothing found; 1 findings; 2 the logs cannot be used",
    )
    add_logs(command)
    _add_samples(command)
    command.add_argument("--policy", action="append", default=[], metavar="LOG", help="log of a policy")
    add_format(command)


def _add_train(command: argparse.ArgumentParser) -> None:
    from actspec.learn.train import ACTIVATIONS

    describe(
        command,
        "Train a network on logs and write it as ONNX, TorchScript and manifest. The last recordings are held out; "
        "of a single one its last fifth.",
        'actspec net train robots/a1.yaml walk.csv chirp.csv -o nets/legs --hidden 128,128 --max-time "60 s"',
        "0 written; 1 written, with a warning; 2 nothing was written",
    )
    add_logs(command)
    command.add_argument("-o", "--output", required=True, metavar="DIR/NAME", help="of the three files")
    _add_samples(command)
    command.add_argument(
        "--torque",
        choices=("measured", "inferred"),
        default="measured",
        help="as logged, or as the model needs it for the logged motion; default measured",
    )
    _add_base(command)
    command.add_argument("--kind", choices=("mlp", "lstm"), default="mlp", help="of the network; default mlp")
    command.add_argument(
        "--hidden", metavar="N,...", help="hidden layers; default 128,128, and 32 of an LSTM"
    )
    command.add_argument("--activation", choices=ACTIVATIONS, help="of hidden layers; default elu")
    command.add_argument("--seed", type=int, default=0, metavar="K", help="of weights and batches; default 0")
    command.add_argument("--seeds", type=int, default=1, metavar="N", help="train N networks, keep the best")
    command.add_argument(
        "--epochs", type=int, metavar="N", help="passes over the rows; default: by their number"
    )
    command.add_argument("--max-time", metavar="TIME", help='of each network, e.g. "60 s"')
    add_force(command)
    add_format(command)


def _add_base(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--base",
        choices=("fixed",),
        help="the base was held: needed to infer the torque of a robot whose base is free",
    )


def _add_evaluate(command: argparse.ArgumentParser) -> None:
    describe(
        command,
        "Judge a network on logs that it was not trained on: torque errors beside the spec's laws, positions of "
        "rollouts in MuJoCo over 1 s, and how much lies outside of what it was trained on.",
        "actspec net evaluate robots/a1.yaml other.csv --network nets/legs.json",
        "0 good or fair; 1 poor, or in motion twice as far from the logs as the spec's law; 2 could not run",
    )
    add_logs(command)
    command.add_argument("--network", required=True, metavar="MANIFEST", help="NAME.json")
    command.add_argument(
        "--group", metavar="GROUP", help="of the spec; default: that of the manifest's joints"
    )
    command.add_argument("--policy", action="append", default=[], metavar="LOG", help="log of a policy")
    _add_base(command)
    command.add_argument("--html", metavar="PAGE", help="write it as a page too")
    add_force(command)
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Run a subcommand."""
    parts = {
        "data": _data,
        "train": _train,
        "evaluate": _evaluate,
        "inspect": _inspect,
        "convert": _convert,
    }
    return parts[arguments.part](arguments)


def _samples(arguments: argparse.Namespace) -> dict[str, Any]:
    """Options of the samples."""
    from actspec.logs import LogError

    taps = DEFAULT_TAPS if arguments.taps is None else arguments.taps
    if not 1 <= taps <= 100:
        raise LogError.of("LRN015", f"--taps must be 1 to 100, got {taps}", where="--taps")
    return {
        "group": arguments.group,
        "taps": tuple(range(taps)),
        "period": seconds_of(arguments.tap_period, "--tap-period"),
        "torque_of": arguments.torque_of,
    }


def _data(arguments: argparse.Namespace) -> int:
    from actspec.learn.libraries import require
    from actspec.learn.survey import survey
    from actspec.learn.windows import dataset
    from actspec.report.net import data_lines, data_record

    options = _samples(arguments)
    require("scipy")
    logs, actuators, _ = read_all(arguments)
    logs, policies = logs[: len(arguments.log)], logs[len(arguments.log) :]
    out = Collector()
    torque = any(joint.torque is not None for log in logs for joint in log.joints.values())
    data = dataset(actuators, logs, out, **options, measured=torque)
    policy = None
    if policies:
        options |= {"group": data.group, "period": data.period}
        policy = dataset(actuators, policies, out, **options, measured=False, every_joint=False)
    found = survey(data, policy, out)
    if arguments.output_format == "json":
        print_json(data_record(data, found, out.sorted()))
    else:
        print_diagnostics(out.sorted())
        print_lines(data_lines(data, found))
    return warned(out)


def _train(arguments: argparse.Namespace) -> int:
    from actspec.learn.evaluate import law_errors
    from actspec.learn.files import check_output, write_network
    from actspec.learn.libraries import require
    from actspec.learn.train import TrainOptions, train
    from actspec.learn.windows import dataset, split
    from actspec.logs import LogError
    from actspec.report.net import manifest_entries, train_lines, train_record

    options = _samples(arguments)
    lstm = arguments.kind == "lstm"
    trained_by = TrainOptions(
        arguments.kind,
        _hidden(("32" if lstm else "128,128") if arguments.hidden is None else arguments.hidden),
        arguments.activation or "elu",
        arguments.seed,
        arguments.seeds,
        arguments.epochs,
        seconds_of(arguments.max_time, "--max-time"),
    )
    for name, least in (("seeds", 1), ("epochs", 1), ("seed", 0)):
        value = getattr(arguments, name)
        if value is not None and not least <= value <= 2**31:
            message = f"--{name} must be at least {least} and at most {2**31}, got {shortened(str(value))}"
            raise LogError.of("LRN015", message, where=f"--{name}")
    if lstm:
        _check_lstm(arguments, trained_by.hidden)
    check_output(arguments.output, force=arguments.force)
    require("scipy", "torch", "onnx")
    logs, actuators, robot = read_all(arguments)
    out = Collector()
    if lstm:
        options |= _of_lstm(actuators, arguments.tap_period)
    infer = arguments.torque == "inferred"
    data = dataset(actuators, logs, out, **options, measured=not infer)
    model = None
    if infer:
        from actspec.learn.dynamics import dynamics_entries
        from actspec.learn.labels import inferred
        from actspec.sysid.stand import Stand

        stand = Stand(robot, actuators)
        with Progress("inferring torques") as progress:
            data = inferred(data, stand, logs, arguments.base, out, progress.step)
        model = dynamics_entries(robot, data.actuators)
    parts = split(data)
    if not sum(map(len, parts.train)) or not sum(map(len, parts.validate)):
        message = "too few rows with a whole history to train and to validate on"
        out.error("LRN005", message, span=Span(logs[0].path), help="log longer, or take fewer --taps")
        # With what was left out, and why.
        out.raise_if_failed(LogError)
    with Progress("training") as progress:
        trained = train(data, parts, trained_by, progress.step)
    entries, judged = manifest_entries(data, parts, trained, logs, model)
    laws = law_errors(data, parts.validate)
    _tell_law(((name, errors, laws[name]) for name, errors in judged if name), data, out)
    paths = write_network(arguments.output, trained.layers, entries, force=arguments.force)
    if arguments.output_format == "json":
        print_json(train_record(data, parts, trained, judged, laws, paths, out.sorted()))
    else:
        print_diagnostics(out.sorted())
        print_lines(train_lines(data, parts, trained, judged, laws))
        print_lines(["wrote " + ", ".join(paths.values())])
    return warned(out)


def _tell_law(joints: Any, data: Any, out: Collector) -> None:
    """Say where the spec's law is nearer to the logs; for the arguments see `behind_the_law`."""
    from actspec.fields import units_of
    from actspec.learn.evaluate import behind_the_law

    for finding in behind_the_law(joints, units_of(data.actuators[0].kind).torque):
        out.add(finding)


def _check_lstm(arguments: argparse.Namespace, hidden: tuple[int, ...]) -> None:
    """Options that an LSTM does not take."""
    from actspec.logs import LogError

    out = Collector()
    if len(set(hidden)) > 1:
        message = f"the layers of an LSTM are of one size, got {arguments.hidden}"
        out.error("LRN025", message, where="--hidden", help="write --hidden 32,32")
    for name, what in (
        ("taps", "an LSTM takes the row alone and keeps a state, not a history"),
        ("activation", "an LSTM's cells are tanh and sigmoid"),
    ):
        given = getattr(arguments, name)
        if given is not None:
            help = "leave it out, or take --kind mlp"
            out.error("LRN025", f"{what}, got --{name} {given}", where=f"--{name}", help=help)
    out.raise_if_failed(LogError)


def _of_lstm(actuators: Any, period: str | None) -> dict[str, Any]:
    """Samples of an LSTM: one a physics step, with those behind them that settle its state."""
    from actspec.learn.recurrent import TAPS
    from actspec.logs import LogError

    step = actuators.physics_dt.require()
    if period is not None and abs((seconds_of(period, "--tap-period") or step) - step) > 1e-3 * step:
        message = (
            f"an LSTM takes a sample in each physics step of {format_number(step * 1e3)} ms, got {period}"
        )
        raise LogError.of("LRN025", message, where="--tap-period", help="leave it out")
    return {"taps": TAPS, "period": step}


def _add_file(command: argparse.ArgumentParser) -> None:
    command.add_argument("file", metavar="FILE", help="network: ONNX, or TorchScript with --trust")
    command.add_argument("--trust", action="store_true", help="run a TorchScript file, which is a program")


def _add_inspect(command: argparse.ArgumentParser) -> None:
    describe(
        command,
        "Show what a network does at rest: sign of the error, order of its inputs, stiffness, damping, delay and "
        "saturation, and what contradicts its manifest.",
        "actspec net inspect unitree_go1.pt --trust",
        "0 shown; 1 it contradicts its manifest; 2 it is no network",
    )
    _add_file(command)
    command.add_argument("--manifest", metavar="NAME.json", help="its conventions")
    command.add_argument("--spec", metavar="SPEC", help="spec that names the manifest: its joints' limits")
    add_format(command)


def _add_convert(command: argparse.ArgumentParser) -> None:
    describe(
        command,
        "Write a network of others as our three files: scales go into its weights, errors come before velocities.",
        "actspec net convert unitree_go1.pt --trust --manifest go1.json -o nets/go1",
        "0 written; 1 written, and it contradicts its manifest; 2 nothing was written",
    )
    _add_file(command)
    command.add_argument("--manifest", required=True, metavar="NAME.json", help="its conventions")
    command.add_argument("-o", "--output", required=True, metavar="DIR/NAME", help="of the three files")
    add_force(command)
    add_format(command)


def _manifest_of(path: str, network: str) -> Any:
    """The manifest of a network file, which must be the one that it describes, if it says."""
    from actspec.logs import LogError
    from actspec.targets.kit.network import read_manifest

    out = Collector()
    if not os.path.isfile(path):
        raise LogError.of("LRN013", "there is no such file", Span(path), help="--manifest NAME.json")
    found = read_manifest(path, out.at("--manifest", Span(path)))
    out.raise_if_failed(LogError)
    assert found is not None
    if found.hashes and _sha256(network) not in found.hashes:
        message = (
            f"'{os.path.basename(network)}' is not the network that the manifest describes, by its sha256"
        )
        raise LogError.of("LRN013", message, Span(path), help="name the manifest that was written with it")
    return found


def _sha256(path: str) -> str:
    import hashlib

    from actspec.learn.foreign import network_bytes

    return hashlib.sha256(network_bytes(path)).hexdigest()


def _inspect(arguments: argparse.Namespace) -> int:
    from actspec.learn.foreign import read_network_file
    from actspec.learn.inspect import inspect
    from actspec.learn.libraries import require
    from actspec.report.net import inspect_lines, inspect_record

    require("onnx", *(["torch"] if arguments.trust else []))
    manifest = None if arguments.manifest is None else _manifest_of(arguments.manifest, arguments.file)
    layers = read_network_file(arguments.file, trust=arguments.trust)
    found = inspect(layers, manifest, arguments.file)
    if arguments.spec is not None:
        from actspec.learn.probes import against_joints

        members = _members(arguments.spec, arguments.manifest)
        assert manifest is not None
        wrong = [*found.contradictions, *against_joints(layers, manifest, found, members)]
        found = replace(found, contradictions=tuple(wrong))
    if arguments.output_format == "json":
        print_json(inspect_record(found, arguments.file))
    else:
        print_lines(inspect_lines(found, arguments.file))
    return EXIT_FINDINGS if found.contradictions else EXIT_CLEAN


def _members(spec: str, manifest: str | None) -> Any:
    """The joints of a spec whose network a manifest describes."""
    from actspec import api
    from actspec.logs import LogError
    from actspec.targets.kit.network import members_of

    found = members_of(api.resolve(spec).joints)
    for path, members in found.items():
        if manifest is not None and os.path.realpath(path) == os.path.realpath(manifest):
            return members
    message = (
        "--spec needs --manifest" if manifest is None else f"no group has the manifest {one_line(manifest)}"
    )
    help = f"name one of its manifests: {listed(sorted(found))}" if found else None
    raise LogError.of("LRN002", message, Span(spec), where="--spec", help=help)


def _convert(arguments: argparse.Namespace) -> int:
    from actspec.learn.files import check_output, write_network
    from actspec.learn.foreign import read_network_file
    from actspec.learn.inspect import converted, inspect
    from actspec.learn.libraries import require
    from actspec.logs import LogError
    from actspec.readings.onnx_network import NetworkFileError
    from actspec.report.net import convert_record

    require("torch", "onnx")
    sources = [arguments.file, arguments.manifest]
    check_output(arguments.output, force=arguments.force, sources=sources)
    manifest = _manifest_of(arguments.manifest, arguments.file)
    read = read_network_file(arguments.file, trust=arguments.trust)
    layers, entries = converted(read, manifest, arguments.file, arguments.manifest)
    out = Collector()
    help = "`actspec net inspect FILE` without a manifest shows what the weights tell"
    doubts = [item.text for item in inspect(read, manifest, arguments.file).contradictions]
    for text in doubts:
        out.warning("LRN034", text, span=Span(arguments.manifest), help=help)
    if doubts:
        entries["doubts"] = list(doubts)
    try:
        paths = write_network(arguments.output, layers, entries, force=arguments.force)
    except NetworkFileError as err:
        raise LogError.of("LRN013", f"cannot be written: {err}", Span(arguments.file)) from err
    if arguments.output_format == "json":
        print_json(convert_record(arguments.file, paths, out.sorted()))
    else:
        print_diagnostics(out.sorted())
        print_lines([f"wrote {', '.join(paths.values())}"])
    return warned(out)


def _evaluate(arguments: argparse.Namespace) -> int:
    from actspec.learn.evaluate import evaluate, network_of, worse_in_motion
    from actspec.learn.libraries import require
    from actspec.learn.windows import dataset
    from actspec.logs import LogError
    from actspec.report.net import evaluate_lines, evaluate_record
    from actspec.sysid.stand import Stand
    from actspec.targets.kit.network import check_joints

    require("scipy", "onnx")
    if arguments.html is not None:
        from actspec.owned import check_free

        check_free(arguments.html, [arguments.spec, *arguments.log, *arguments.policy], arguments.force)
    logs, actuators, robot = read_all(arguments)
    if not os.path.isfile(arguments.network):
        raise LogError.of(
            "LRN013", "there is no such file", Span(arguments.network), help="--network NAME.json"
        )
    step = actuators.physics_dt.require()
    stand = Stand(robot, actuators)
    law, manifest = network_of(arguments.network, actuators.joints, step)
    logs, policies = logs[: len(arguments.log)], logs[len(arguments.log) :]
    out = Collector()
    group = arguments.group or _only_group(manifest.joints, actuators.joints)
    options: dict[str, Any] = {"group": group, "taps": law.taps, "period": law.tap_period}
    if law.layers.recurrent:
        from actspec.learn.recurrent import TAPS

        options["taps"] = TAPS
    kind = manifest.torque if manifest.torque in ("drive", "joint") else None
    # A network of inferred torques needs no sensor here either.
    sensed = manifest.torque != "inferred" or any(
        j.torque is not None for log in logs for j in log.joints.values()
    )
    data = dataset(actuators, logs, out, **options, torque_of=kind, measured=sensed)
    if sensed:
        _check_kind(manifest, logs, out)
    out.raise_if_failed(LogError)
    if not sensed:
        from actspec.learn.labels import inferred

        with Progress("inferring torques") as progress:
            data = inferred(data, stand, logs, arguments.base, out, progress.step)
        message = "no torque is in the logs: the network is compared with what the model needs for the motion"
        out.info("LRN032", message)
    policy = None
    if policies:
        options["group"] = data.group
        policy = dataset(actuators, policies, out, **options, measured=False, every_joint=False)
    check_joints(manifest, [a.joint for a in data.actuators], out.at("--network", Span(arguments.network)))
    with Progress("rolling out") as progress:
        found = evaluate(data, law, manifest, stand, step, policy=policy, progress=progress.step)
    if sensed and found.closed_loop is not None:
        stand.tell(data.moved, out)
    _tell_law(((joint.joint, joint.errors, joint.baselines) for joint in found.joints), data, out)
    for finding in worse_in_motion(found):
        out.add(finding)
    if arguments.html is not None:
        from actspec.output import write_text
        from actspec.report.net_page import evaluate_page

        page = evaluate_page(found, data, law, arguments.network)
        write_text(arguments.html, page, force=arguments.force)
    if arguments.output_format == "json":
        print_json(evaluate_record(found, out.sorted()))
    else:
        print_diagnostics(out.sorted())
        print_lines(evaluate_lines(found))
    return EXIT_FINDINGS if found.grade == "poor" or any(worse_in_motion(found)) else EXIT_CLEAN


def _only_group(of: Sequence[str], joints: Sequence[JointActuator]) -> str | None:
    """The group of the joints that a manifest names, where it is one: a network is of one group."""
    groups = {joint.group for joint in joints if joint.joint in of}
    return next(iter(groups)) if len(groups) == 1 else None


def _check_kind(manifest: Any, logs: list[Any], out: Collector) -> None:
    """Torques of another place than the network's are no measure of it."""
    for log in logs:
        told = log.sidecar.torque
        own = "drive" if manifest.torque == "inferred" else manifest.torque
        if told is not None and own is not None and told != own:
            message = f"its torque is the {told}'s, the network gives the {own}'s"
            out.error("LRN007", message, span=Span(log.path), help="judge it on logs of the same torque")


def _hidden(text: str) -> tuple[int, ...]:
    from actspec.logs import LogError

    try:
        sizes = tuple(int(part) for part in text.split(","))
    except ValueError:
        sizes = ()
    if not sizes or len(sizes) > 10 or not all(1 <= size <= MOST_HIDDEN for size in sizes):
        message = f"--hidden takes sizes from 1 to {MOST_HIDDEN} with commas between them, got '{text[:40]}'"
        raise LogError.of("LRN015", message, where="--hidden", help="write --hidden 128,128")
    return sizes
