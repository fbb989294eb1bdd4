"""`actspec verify --setup`: the real simulators' packages, in a folder of their own."""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from actspec.diagnostics import EXIT_CLEAN, EXIT_FAILED, Collector
from actspec.targets.base import TargetOptions
from actspec.verify.agreement import VerifyError
from actspec.verify.environments import (
    SIZE,
    TIME,
    EngineUnavailableError,
    cache_folder,
    find_frameworks,
    prepare_frameworks,
    prepare_release,
    release_folder,
    unusable,
)

FRAMEWORKS = ("isaaclab", "mjlab", "newton")
"""Kinds of target whose packages are in the one environment."""

NEEDED = 6 << 30
"""Bytes that must be free: what is installed, and what pip needs on the way. Chosen: twice the size and a bit."""


def set_up(arguments: argparse.Namespace) -> int:
    """Say what would be installed, ask, and install it."""
    folder = cache_folder()
    targets = _targets(arguments)
    releases = list(_releases(targets, folder))
    kinds = {options.kind for options in targets}
    wanted = not arguments.spec or bool(kinds & set(FRAMEWORKS))
    why = unusable() if wanted else None
    if why is not None:
        help = "run actspec with one of these; MuJoCo needs none"
        raise VerifyError.of("VFY003", why, where="--setup", help=help)
    there = find_frameworks(folder) if wanted else None
    if there is not None:
        print(f"prepared: {there.folder}")
    frameworks = wanted and there is None
    if not frameworks and not releases:
        print("nothing is missing")
        return EXIT_CLEAN
    print("\n".join(_plan(folder, frameworks, releases)))
    if frameworks:
        _check_space(folder)
    if not arguments.yes and not _agreed():
        return EXIT_FAILED
    try:
        for version in releases:
            print(f"installed: {prepare_release('mujoco', version, folder, _say)}")
        if frameworks:
            print(f"installed: {prepare_frameworks(folder, say=_say).folder}")
    except EngineUnavailableError as err:
        help = "nothing is left half made; pip's own settings decide where packages come from"
        raise VerifyError.of("VFY003", f"not installed: {err}", where="--setup", help=help) from err
    return EXIT_CLEAN


def _say(text: str) -> None:
    """What is done now, on stderr; it may take minutes."""
    print(f"  {text} ...", file=sys.stderr, flush=True)


def _targets(arguments: argparse.Namespace) -> list[TargetOptions]:
    """The targets of the specs that are named."""
    from actspec.api import load
    from actspec.targets.choose import choose_targets

    found: list[TargetOptions] = []
    for path in arguments.spec:
        found += choose_targets(load(path), arguments.target, None, False, Collector())
    return found


def _releases(targets: Sequence[TargetOptions], folder: Path) -> Iterator[str]:
    """MuJoCo releases that the targets are for and that are not here."""
    from actspec.verify.engines.mujoco import release_for

    versions = dict.fromkeys(release_for(o.version) for o in targets if o.kind == "mujoco")
    for version in versions:
        if version is not None and not release_folder("mujoco", version, folder).is_dir():
            yield version


def _plan(folder: Path, frameworks: bool, releases: Sequence[str]) -> Iterator[str]:
    yield f"to be installed below {folder}, with pip; your own environment is not touched:"
    for version in releases:
        yield f"  MuJoCo {version}: 30 MB"
    if frameworks:
        yield f"  Isaac Lab 2.2 and 2.3, mjlab, Newton, MuJoCo 3.11, torch: {SIZE}, {TIME}"
        yield "  (several GB more where pip's index brings the torch for graphics cards)"
    yield "set ACTSPEC_ENGINES for another folder; remove the folder to uninstall"


def _check_space(folder: Path) -> None:
    """Raises: VerifyError: the disk is too full."""
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    free = shutil.disk_usage(there).free
    if free < NEEDED:
        message = f"{folder} has {free / 1e9:.1f} GB left, and {NEEDED / 1e9:.1f} GB are needed on the way"
        help = "set ACTSPEC_ENGINES to a folder on another disk"
        raise VerifyError.of("VFY003", message, where="--setup", help=help)


def _agreed() -> bool:
    """Whether the user wants it; asked on a terminal alone."""
    if not sys.stdin.isatty():
        print("use --yes to install it", file=sys.stderr)
        return False
    try:
        return input("install? [y/N] ").strip().lower() in ("y", "yes")
    except EOFError:
        return False
