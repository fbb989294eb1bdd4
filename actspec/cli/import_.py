"""`actspec import`: a spec from what MJCF, URDF, configurations and deploy files say."""

from __future__ import annotations

import argparse
import os
import posixpath
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.cli.options import add_force, add_packages, add_versions, configured_versions, describe
from actspec.diagnostics import (
    EXIT_CLEAN,
    Collector,
    Diagnostic,
    Severity,
    Span,
    listed,
    many,
    one_line,
    shell_word,
)
from actspec.files import name_in_file
from actspec.output import write_text
from actspec.owned import check_free
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.draft import DraftedSpec
    from actspec.draft.combine import Combined, Disagreement
    from actspec.draft.sources import DraftTarget
    from actspec.ir import Network
    from actspec.readings.versions import Versions
    from actspec.spec.validate import Spec

_SCHEME = "package://"
CANONICAL = "compile with --canonical"
"""Begins the remark beside targets of a model of which only MuJoCo's own form can be written."""
_POSE = "default_pose"
"""The one field that a file states for many joints at once."""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Write the spec of one robot from what its files say, each number with its file. Where they disagree, the "
        "training configuration counts before the deploy file, and that before the robot files. Runs none of them.",
        "actspec import robot.xml robot_cfg.py -o robot.yaml",
        "0 written; 2 could not",
    )
    command.add_argument(
        "file", nargs="+", metavar="FILE", help="MJCF, URDF, cfg .py or deploy YAML of one robot"
    )
    command.add_argument("-o", "--output", metavar="SPEC", help="file to write (default: standard output)")
    command.add_argument("--robot", metavar="NAME", help="this robot of a file that has several")
    command.add_argument(
        "--joints",
        metavar="FILE|LIST",
        help="names of the joints, where a configuration has patterns and no robot file is at hand (they stand in a "
        "USD): IO_descriptors.yaml, a URDF, any file with them, or a,b,c",
    )
    command.add_argument(
        "--damping",
        choices=("as-kd", "as-friction"),
        help="what joint damping is where a drive has no kd: its kd, or friction (default: a comment asks)",
    )
    add_packages(command)
    add_force(command)
    add_versions(command)


def run(arguments: argparse.Namespace) -> int:
    """Import the files."""
    versions = configured_versions(arguments.target)
    return import_files(
        arguments.file,
        arguments.output,
        arguments.robot,
        versions,
        bool(arguments.force),
        joints=arguments.joints,
        damping=arguments.damping,
        packages=arguments.package,
    )


def import_files(
    files: Sequence[str],
    output: str | None,
    robot: str | None,
    versions: Versions,
    force: bool,
    *,
    joints: str | None = None,
    damping: str | None = None,
    packages: Sequence[tuple[str, str]] = (),
) -> int:
    """Read files of one robot, write its spec, and say what became of what.

    Args:
        files: As the user names them; `package://DIST/path` too.
        output: The spec to write; None: it goes to stdout, and what there is to say to stderr.
        robot: Name of the robot where a file has several.
        versions: What the files are meant for.
        force: Replace a file that is there.
        joints: File or list that names the joints; None: the files do.
        damping: As in `draft`.
        packages: ROS packages and their folders, which the spec is to name.
    """
    from actspec.report.terminal import print_diagnostics, print_lines

    if output is not None:
        check_free(output, files, force, again=True)
    found = drafted(
        files, output or "spec.yaml", robot, versions, joints=joints, damping=damping, packages=packages
    )
    spec = found.spec
    if output is not None:
        check_free(output, found.sources, force, again=True)
    print_diagnostics(_warnings(found.combined.disagreements))
    if output is None:
        sys.stdout.write(spec.text)
    else:
        write_text(output, spec.text, force=force)
    print_lines(_told(found, output), sys.stderr if output is None else sys.stdout)
    return EXIT_CLEAN


@dataclass(frozen=True, slots=True)
class Drafted:
    """A spec of robot files, not written.

    Attributes:
        spec: Its text.
        combined: What the files say together.
        targets: What it can be compiled to.
        files: Those that say something of it, as the user named them.
        sources: Every file that was read.
        stops: What stops a compile to any target until it is mended; "": nothing.
    """

    spec: DraftedSpec
    combined: Combined
    targets: tuple[DraftTarget, ...]
    files: tuple[str, ...]
    sources: tuple[str, ...]
    stops: str


def drafted(
    files: Sequence[str],
    path: str,
    robot: str | None,
    versions: Versions,
    *,
    joints: str | None = None,
    damping: str | None = None,
    packages: Sequence[tuple[str, str]] = (),
) -> Drafted:
    """The spec of robot files, as it stands at a path; arguments as of `import_files`. What the readers say is printed.

    Raises: ActspecError: the files cannot be read, or are none of one robot.
    """
    from actspec.draft import draft
    from actspec.draft.combine import combine
    from actspec.draft.reading import read_robot_files
    from actspec.draft.sources import targets_of
    from actspec.report.terminal import print_diagnostics
    from actspec.robot.load import find_model
    from actspec.spec.document import document_from_text
    from actspec.spec.validate import validate

    found = {find_model(file, "") if file.startswith(_SCHEME) else file: file for file in files}
    readings, said = read_robot_files(list(found), robot, versions, joints)
    print_diagnostics(said)
    sources = tuple(file for r in readings for file in (r.path, *r.includes))
    folder = os.path.dirname(os.path.abspath(path))
    # What names the joints may state the steps too, and is none of the files.
    found |= {r.path: r.path for r in readings if r.path not in found}
    named_so = tuple(dict.fromkeys(found[r.path] for r in readings))
    readings = tuple(replace(r, reference=_reference(found[r.path], folder)) for r in readings)
    combined = _placed(combine(readings), folder)
    reference = "none" if combined.model is None else combined.model.reference
    targets = targets_of(readings, combined, versions)
    named = {name: _reference(at, folder) for name, at in packages} if combined.model is not None else {}
    spec = draft(combined, reference, targets, damping, named)
    served, stops = _served(spec.text, path, targets)
    if served != targets:
        targets = served
        spec = draft(combined, reference, targets, damping, named)
    # Whatever the files were, what is written is a valid spec.
    validate(document_from_text(spec.text, path))
    return Drafted(spec, combined, tuple(targets), named_so, sources, stops)


def _reference(file: str, folder: str) -> str:
    """What a spec in a folder names a file by."""
    if file.startswith(_SCHEME):
        return file
    try:
        found = os.path.relpath(os.path.abspath(file), folder).replace(os.sep, "/")
    except ValueError:
        # Another drive of Windows: no relative path leads there.
        return os.path.abspath(file)
    return f"./{found}" if found == "none" else name_in_file(found)


def _placed(combined: Combined, folder: str) -> Combined:
    """The robot with its networks named from the spec's folder; a remark says which are to be copied below it."""
    joints, notes = [], dict(combined.notes)
    for joint in combined.actuators.joints:
        network = joint.network
        if network is not None:
            named, said = _placed_network(network, folder)
            joint = replace(joint, network=named)
            if said:
                notes[joint.joint] = (*notes.get(joint.joint, ()), *said)
        joints.append(joint)
    return replace(combined, actuators=replace(combined.actuators, joints=tuple(joints)), notes=notes)


def _placed_network(network: Network, folder: str) -> tuple[Network, list[str]]:
    """A network named from the spec's folder, and what is to be put there."""
    said = []
    names: dict[str, str | None] = {}
    for key, found in (("file", network.file), ("manifest", network.manifest)):
        reference = _reference(found, folder) if found and os.path.isfile(found) else found
        # A folder that nobody knows is none of the spec's.
        known = reference if reference is None or "{" not in reference else posixpath.basename(reference)
        names[key] = known and _below(known, folder)
        if found and not os.path.isfile(found):
            which = "it" if found == names[key] else one_line(found)
            said.append(f"its network is not here: put {which} at {names[key]}, from the spec's folder")
        elif reference != names[key]:
            said.append(f"a spec names networks below its folder: copy {reference} to {names[key]} there")
    file = names["file"]
    if not file:
        said.append("where its network lies could not be read: write its path as network.file")
    if names["manifest"] is None and network.stated:
        own = f"{posixpath.splitext(file or 'network')[0]}.json"
        if os.path.isfile(os.path.join(folder, own)):
            names["manifest"] = own
        else:
            said.append(f"its manifest: save as {own}, and name it as network.manifest, {_stated(network)}")
    elif names["manifest"] is None:
        said.append(
            "no file states the manifest of its network: write it, and name it as network.manifest; `actspec schema "
            "network` has its keys"
        )
    return replace(network, file=file, manifest=names["manifest"]), said


def _stated(network: Network) -> str:
    """What a configuration states of a network's manifest, and what is missing."""
    text = f"what the configuration states, {network.stated}"
    if network.lacking:
        text += f", and what it does not: {listed(network.lacking)}"
    if '"unknown"' in network.stated:
        text += "; tap_period is the physics step of its training, which no file states"
    return text


def _below(name: str, folder: str) -> str:
    """A name that leads to a file below a spec's folder: the same where it does."""
    from actspec.spec.document import path_inside

    if path_inside(name, folder, Collector().at(""), "") is not None:
        return name
    below = posixpath.normpath(name.replace("\\", "/"))
    while below.startswith("../"):
        below = below[3:]
    return below if name.startswith("../") else posixpath.basename(below)


def _warnings(disagreements: Sequence[Disagreement]) -> Iterator[Diagnostic]:
    """One for each figure that two files give differently; of the poses of two files, the first stands for all."""
    poses: dict[tuple[str | None, str | None], list[Disagreement]] = {}
    for item in disagreements:
        files = item.taken.source, item.lost.source
        if item.field != _POSE:
            yield _warning(item, "")
        else:
            poses.setdefault(files, []).append(item)
    for first, *others in poses.values():
        count = sum(len(other.joints) for other in others)
        yield _warning(first, f"; the poses of {count} other joints differ too" if count else "")


def _warning(item: Disagreement, more: str) -> Diagnostic:
    taken, lost = (format_quantity(q.value, q.unit) for q in (item.taken, item.lost))
    who = f"{listed(map(one_line, item.joints), 4)}: " if item.joints else ""
    place = item.lost.span or Span(item.lost.source or "another file")
    told = f"{who}{item.field} is {taken} here, which is used, and {lost} in {place}{more}"
    return Diagnostic("DRF010", Severity.WARNING, told, "", item.taken.span)


def _served(text: str, path: str, targets: Sequence[DraftTarget]) -> tuple[tuple[DraftTarget, ...], str]:
    """The targets, those marked that the spec cannot be compiled to, and what stops a compile to all that are left.

    Where none of them serves a robot without a model, a fragment may; where nothing does, all stay as they are.
    """
    from actspec.spec.document import document_from_text
    from actspec.spec.validate import validate

    spec = validate(document_from_text(text, path))
    meant = [target.name for target in targets if not target.left_out]
    # One that fails with all others tells nothing of which it is: most serve all.
    refused = _refusal(spec, meant)
    if not refused:
        return tuple(targets), ""
    if not _refusal(spec, meant, canonical=True):
        return tuple(
            t._replace(remark=f"{CANONICAL}: {refused}") if t.name == "mujoco" else t for t in targets
        ), ""
    why = {name: told for name in meant if (told := _refusal(spec, [name]))}
    marked = [t._replace(left_out=t.left_out or why.get(t.name, "")) for t in targets]
    if len(why) < len(meant):
        return tuple(marked), ""
    fragments = {t.name: fragment for t in targets if (fragment := t.as_fragment())}
    if fragments and not _refusal(spec, list(fragments)):
        return tuple(fragments.get(t.name, t) for t in marked), ""
    return tuple(targets), next(iter(why.values()), "")


def _refusal(spec: Spec, names: Sequence[str], canonical: bool = False) -> str:
    """Why a spec cannot be compiled to targets, and what to do; "" where it can."""
    from actspec import api
    from actspec.diagnostics import ActspecError

    try:
        api.compile(spec, targets=names, canonical=canonical)
    except ActspecError as err:
        first = next(item for item in err.diagnostics if item.severity is Severity.ERROR)
        help = f" ({one_line(first.help)})" if first.help else ""
        return f"{first.code}: {one_line(first.message)}{help}"
    return ""


def _told(found: Drafted, output: str | None) -> Iterator[str]:
    spec, combined, targets = found.spec, found.combined, found.targets
    joints = sum(spec.groups.values())
    start = f"wrote {one_line(output)}: " if output is not None else f"{spec.robot}: "
    yield (
        f"{start}{many(joints, 'joint')} in {many(len(spec.groups), 'group')} "
        f"({listed(spec.groups)}), from {', '.join(map(one_line, found.files))}"
    )
    for why, left in combined.reasons().items():
        yield f"  unmanaged, {one_line(why)}: {listed(map(one_line, left))}"
    remarks: dict[str, list[str]] = {}
    for joint, texts in combined.notes.items():
        for text in texts:
            remarks.setdefault(text, []).extend([joint] if joint else [])
    for text, names in remarks.items():
        yield f"  {listed(map(one_line, names), 4)}: {one_line(text)}" if names else f"  {one_line(text)}"
    for text in spec.inferred:
        yield f"  {one_line(text)}"
    for (field, why), lacking in spec.unknown.items():
        said = f"{field} is left out, {one_line(why)}" if why else f"no file states {field}"
        yield f"  {said}: {listed(lacking)}"
    left_out: dict[str, list[str]] = {}
    for target in targets:
        if target.left_out:
            left_out.setdefault(target.left_out, []).append(target.name)
    for why, lost in left_out.items():
        one = len(lost) == 1
        yield f"  target{'s' * (not one)} {listed(lost)} {'is' if one else 'are'} left out: {one_line(why)}"
    for target in targets:
        if target.remark and not target.left_out:
            yield f"  target {target.name}: {one_line(target.remark)}"
    if found.stops:
        yield f"  compile stops until that is mended: {found.stops}"
    if output is not None:
        needed = [field for field in ("kp", "kd") if any(field == lacking for lacking, _ in spec.unknown)]
        yield f"next: check it{', state ' + ' and '.join(needed) if 'kp' in needed else ''}, then"
        canonical = any(target.remark.startswith(CANONICAL) for target in targets)
        yield from commands(output, "show", "compile --canonical" if canonical else "compile")


def commands(path: str, *names: str) -> list[str]:
    """Commands to go on with, ready to paste."""
    return [f"  actspec {name} {shell_word(path)}" for name in names]
