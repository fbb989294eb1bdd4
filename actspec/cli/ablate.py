"""`actspec ablate`: variants of a spec that differ in one part of the model each, to train beside each other."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import actspec
from actspec.cli.options import (
    add_canonical,
    add_fail_on,
    add_force,
    add_format,
    add_variant,
    describe,
    failing,
    quantity_of,
)
from actspec.diagnostics import (
    EXIT_CLEAN,
    EXIT_FINDINGS,
    Collector,
    EmitError,
    Severity,
    Span,
    SpecError,
    one_line,
    shell_word,
)
from actspec.files import FAULTS, noting, read_regular
from actspec.spec.yaml_text import MAX_BYTES
from actspec.targets.base import Emission, EmittedFile, TargetOptions
from actspec.units import Kind

if TYPE_CHECKING:
    from actspec.ir import ActuatorSet
    from actspec.output import Compilation, Output
    from actspec.report.ablation import Variant
    from actspec.spec.models import SpecModel
    from actspec.spec.validate import Spec
    from actspec.study.ablation import Plain
    from actspec.study.replay import Tracking

TRAIN, RECORD = "train.py", "ablation.json"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Write a spec for each variant of a robot's actuators, compiled for MuJoCo and mjlab: PD and limit, and that "
        "with one thing more (torque-speed line, filter, the spec's randomisation, network); a script that trains them "
        "in mjlab; how each follows the commands of a log; and, run again, what was trained.",
        "actspec ablate robots/go1.yaml rollout.csv -o ablation --filter 8Hz",
        "0 nothing at or above --fail-on; 1 findings; 2 nothing was written",
    )
    command.add_argument("spec", metavar="SPEC", help="actuator spec (YAML)")
    command.add_argument(
        "log", nargs="?", metavar="LOG", help="CSV, NPZ or Parquet: its commands are given to every variant"
    )
    add_variant(command)
    command.add_argument("-o", "--output", required=True, metavar="DIR", help="folder to write to")
    command.add_argument(
        "--filter", metavar="FREQUENCY", help="low-pass of the command, where the spec has none: 8Hz"
    )
    command.add_argument(
        "--task", metavar="TASK", help="mjlab's task to train on; default: its own for a Go1 and a G1"
    )
    add_canonical(command)
    add_force(command)
    add_fail_on(command)
    add_format(command, "markdown")


def run(arguments: argparse.Namespace) -> int:
    """Plan, compile, replay, collect, write, print."""
    from actspec import api, output
    from actspec.logs import load_log
    from actspec.report import ablation as report
    from actspec.report.terminal import Progress, json_text, print_diagnostics, print_json, print_lines
    from actspec.spec.variants import named
    from actspec.study.ablation import NAMES, variant_specs
    from actspec.study.replay import replay
    from actspec.study.trainings import collect
    from actspec.study.variants import Assumed
    from actspec.targets.mjlab.training import task_of

    out = Collector()
    cutoff = None
    if arguments.filter is not None:
        cutoff = quantity_of(arguments.filter, Kind.FREQUENCY, "--filter", "ABL001", out)
    _check_options(arguments, out)
    out.raise_if_failed(SpecError)
    arguments.spec = named(arguments.spec, arguments.variant)
    spec = api.load(arguments.spec)
    log = None if arguments.log is None else load_log(arguments.log)
    actuators = api.resolve(spec, api.load_robot(spec))
    planned, missing = variant_specs(spec, actuators, Assumed(cutoff, None))
    if not planned:
        message = f"has no variant: {missing[0].joint}: {missing[0].reason}"
        raise SpecError.of("ABL002", message, Span(arguments.spec), help="state kp and kd")
    made: dict[str, Compilation] = {}
    with Progress("compiling") as progress:
        for done, (name, data) in enumerate(planned.items()):
            progress.step(done, len(planned))
            made[name] = _compiled(spec, name, data, arguments, out)
    tracking: tuple[Tracking, ...] = ()
    if log is not None:
        with Progress("replaying") as progress, progress.ticking():
            tracking = replay({name: one.actuators for name, one in made.items()}, log, out)
    training = collect(
        arguments.output, {name: _text_of(one) for name, one in made.items()}, list(NAMES), out
    )
    task = arguments.task or task_of(actuators.robot)
    files = {name: output.outputs(compilation) for name, compilation in made.items()}
    script = _script(made, task, arguments, out)
    found = report.Ablation(
        arguments.spec,
        arguments.log,
        task,
        len(actuators.joints),
        tuple(_variants(made, files, actuators, task, arguments)),
        missing,
        tracking,
        training,
        out.sorted(),
    )
    record = report.record(found)
    top = [*script, EmittedFile(RECORD, json_text(record).encode())]
    whole = [
        *(file for group in files.values() for file in group),
        *output.outputs(_beside(next(iter(made.values())), top, arguments.output, alone=True)),
    ]
    output.write(tuple(whole), force=arguments.force)
    if arguments.output_format == "json":
        print_json(record)
    else:
        shown = report.lines if arguments.output_format == "text" else report.markdown
        print_diagnostics(found.findings)
        print_lines(shown(found))
        if arguments.output_format == "text":
            changed = sum(file.changed for file in whole)
            print(f"\nwrote {changed} of {len(whole)} files in {one_line(arguments.output)}")
    return EXIT_FINDINGS if failing(found.findings, arguments.fail_on) else EXIT_CLEAN


def _check_options(arguments: argparse.Namespace, out: Collector) -> None:
    folder = arguments.output
    if not folder or "\0" in folder or (os.path.lexists(folder) and not os.path.isdir(folder)):
        out.error(
            "ABL001", f"'{one_line(folder)}' is no folder", where="--output", help="name a folder to write to"
        )
    task = arguments.task
    if task is not None and (not task.strip() or not task.isprintable()):
        out.error(
            "ABL001",
            f"{one_line(task)!r} is no name",
            where="--task",
            help="such as Mjlab-Velocity-Flat-Unitree-Go1",
        )


def _compiled(
    spec: Spec, name: str, data: Plain, arguments: argparse.Namespace, out: Collector
) -> Compilation:
    """A variant with the files of its targets, and those of its own folder last, the spec the first of them.

    Raises: ActspecError: it cannot be compiled for MuJoCo.
    """
    from actspec import api
    from actspec.draft.plain import yaml_text
    from actspec.spec.document import document_from_text
    from actspec.spec.validate import validate
    from actspec.study.ablation import NAMES, moved

    path = _spec_path(arguments.output, name, spec)
    folder = os.path.dirname(path)
    origin = os.path.basename(arguments.spec)
    head = f"{name} of {origin}: {NAMES[name][1]}.\nWritten by actspec {actspec.__version__}."
    base = os.path.dirname(spec.document.path)
    text = yaml_text(moved(data, base, folder), head)
    variant = replace(validate(document_from_text(text, path, folder)), results=spec.results)
    own = {os.path.basename(path): text.encode("utf-8")}
    for named, results in spec.results.items():
        own[os.path.normpath(named)] = read_regular(results.document.path, MAX_BYTES)
    own |= _networks(variant, base)
    variant = replace(variant, model=_reading(variant.model, base))
    targets = list(_targets(variant, folder, arguments.canonical, drawn=name == "D_ideal_pd_dr"))
    try:
        found = api.compile(variant, targets=targets)
    except EmitError as err:
        # What mjlab cannot run MuJoCo may.
        found = api.compile(variant, targets=targets[:1])
        first = next(item for item in err.diagnostics if item.severity is Severity.ERROR)
        message = f"{name} is not written for mjlab: {first.message}"
        out.warning("ABL003", message, where=first.where, help=first.help)
    for item in found.diagnostics:
        told = any((item.code, item.where, item.message) == (i.code, i.where, i.message) for i in out)
        if item.severity is not Severity.INFO and item.code not in ("SPEC164", "SPEC165") and not told:
            out.add(item)
    return _beside(found, [EmittedFile(name, held) for name, held in own.items()], folder)


def _networks(spec: Spec, base: str) -> dict[str, bytes]:
    """Files of a variant's networks, by their name below the folder of the spec that it is made from."""
    from actspec.spec.network import files_beside, named_files
    from actspec.targets.kit.network import MAX_NETWORK

    found = {}
    for _, named in named_files(spec.model):
        for name in (named, *files_beside(named, base)):
            with suppress(*FAULTS):  # compiling says what is wrong with a file that it needs
                found[os.path.normpath(name)] = read_regular(os.path.join(base, name), MAX_NETWORK)
    return found


def _reading(model: SpecModel, base: str) -> SpecModel:
    """A variant's model that reads its networks where they lie now."""
    groups = {}
    for name, group in model.actuators.items():
        if group.network is not None:
            lie = {
                key: os.path.abspath(os.path.join(base, path))
                for key in ("file", "manifest")
                if (path := getattr(group.network, key)) is not None
            }
            group = group.model_copy(update={"network": group.network.model_copy(update=lie)})
        groups[name] = group
    return model.model_copy(update={"actuators": groups})


def _targets(spec: Spec, folder: str, canonical: bool, *, drawn: bool) -> Iterator[TargetOptions]:
    """MuJoCo and mjlab at the spec's versions, each in the folder of its kind; mjlab's events where a variant draws."""
    from actspec.spec.models import RandomizationTarget
    from actspec.targets.choose import choose_targets

    version = ""
    for kind in ("mujoco", "mjlab"):
        own = [
            target
            for target in choose_targets(spec, (), folder, canonical, Collector())
            if target.kind == kind
        ]
        found = own[0] if own else choose_targets(spec, (kind,), folder, canonical, Collector())[0]
        version = found.version
        yield replace(found, name=kind, folder=os.path.join(folder, kind))
    if drawn:
        kind = "randomization"
        given = RandomizationTarget.model_validate({"for": ["mjlab"]})
        yield TargetOptions(kind, kind, version, None, os.path.join(folder, kind), given=given)


def _beside(
    found: Compilation, files: Sequence[EmittedFile], folder: str, *, alone: bool = False
) -> Compilation:
    """A compilation with more files, in a folder of their own manifest; `alone`: with these and no others."""
    options = TargetOptions("ablation", "ablation", "", None, folder)
    targets, emissions = ((), ()) if alone else (found.targets, found.emissions)
    return replace(found, targets=(*targets, options), emissions=(*emissions, Emission(tuple(files), ())))


def _text_of(made: Compilation) -> bytes:
    """The spec of a variant."""
    return made.emissions[-1].files[0].data


def _spec_path(folder: str, name: str, spec: Spec) -> str:
    from actspec.targets.kit.python_text import identifier

    return os.path.join(folder, name, f"{identifier(spec.model.robot.name).lower()}.yaml")


def _variants(
    made: Mapping[str, Compilation],
    files: Mapping[str, Sequence[Output]],
    actuators: ActuatorSet,
    task: str | None,
    arguments: argparse.Namespace,
) -> Iterator[Variant]:
    """What is told of each."""
    from actspec.output import MANIFEST
    from actspec.report.ablation import Variant
    from actspec.study.ablation import FIRST, changes

    script = shell_word(os.path.join(arguments.output, TRAIN))
    for name, compilation in made.items():
        before = made[FIRST].actuators if FIRST in made and name != FIRST else actuators
        after = _with_networks_of(compilation.actuators, actuators)
        trains = task is not None and any(target.kind == "mjlab" for target in compilation.targets)
        yield Variant(
            name,
            _spec_path(arguments.output, name, compilation.spec),
            changes(before, after),
            tuple(file.path for file in files[name] if os.path.basename(file.path) != MANIFEST),
            f"python {script} {name} --seed 0" if trains else None,
        )


def _with_networks_of(variant: ActuatorSet, actuators: ActuatorSet) -> ActuatorSet:
    """A variant whose networks are named as the spec does that it is made from."""
    own = {actuator.joint: actuator.network for actuator in actuators.joints}
    joints = (replace(a, network=a.network and own[a.joint]) for a in variant.joints)
    return replace(variant, joints=tuple(joints))


def _script(
    made: Mapping[str, Compilation], task: str | None, arguments: argparse.Namespace, out: Collector
) -> list[EmittedFile]:
    """The script that trains; none where no variant is written for mjlab, or where somebody has edited it."""
    from actspec.output import Origin, Output, is_ours
    from actspec.targets.mjlab.training import train_text

    runs = {
        name: one.actuators
        for name, one in made.items()
        if any(target.kind == "mjlab" for target in one.targets)
    }
    if not runs:
        return []
    first = next(iter(made.values())).spec
    if task is None:
        message = f"mjlab has no task of its own for '{one_line(first.model.robot.name)}': {TRAIN} needs one"
        help = "--task NAME of one that is registered with mjlab, whose robot has these joints"
        out.info("ABL031", message, help=help)
    name = os.path.basename(_spec_path(arguments.output, "", first))
    data = train_text(runs, task, name, os.path.basename(arguments.spec)).encode("utf-8")
    path = os.path.join(arguments.output, TRAIN)
    if os.path.isfile(path) and not arguments.force:
        with noting():  # not to be copied
            old = read_regular(path, MAX_BYTES)
        if old != data and not is_ours(
            Output("ablation", arguments.output, path, data, old, Origin(name, ""))
        ):
            out.info(
                "ABL030", "was edited: it stays as it is", span=Span(path), help="--force writes it anew"
            )
            return []
    return [EmittedFile(TRAIN, data)]
