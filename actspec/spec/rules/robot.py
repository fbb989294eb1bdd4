"""Rules of `robot` and of the keys into `sources`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from actspec.diagnostics import nearest
from actspec.spec.models import Robot, Source
from actspec.spec.paths import Path
from actspec.spec.rules.breaches import Breaches, check_pattern, is_folder_name


def check_robot(robot: Robot, breaches: Breaches) -> None:
    """Name, joints and patterns of `robot`."""
    if robot.model != "none" and robot.joints:
        breaches.error("SPEC120", "`joints` are listed only where `model: none`", ("robot", "joints"))
    if robot.model == "none" and not robot.joints:
        breaches.error(
            "SPEC120",
            "a robot without a model needs its joints",
            ("robot", "model"),
            "write `joints: [name, ...]`, or name a model",
        )
    if not is_folder_name(robot.name):
        breaches.error(
            "SPEC124",
            f"the name {robot.name!r} cannot be a folder's name",
            ("robot", "name"),
            "use letters, digits, '-', '_' and '.'",
        )
    names = [joint if isinstance(joint, str) else joint.name for joint in robot.joints]
    for index, name in enumerate(names):
        if name in names[:index]:
            breaches.error("SPEC121", f"the joint '{name}' is listed twice", ("robot", "joints", index))
    for index, pattern in enumerate(robot.unmanaged):
        check_pattern(pattern, ("robot", "unmanaged", index), breaches)
    for pattern in robot.default_pose:
        check_pattern(pattern, ("robot", "default_pose", pattern), breaches, key=True)


def check_sources(data: Any, sources: Mapping[str, Source], breaches: Breaches) -> None:
    """Every `source:` beside a value names one of the spec's."""
    for path, key in _source_keys(data):
        if key not in sources:
            guess = nearest(key, sorted(sources))
            breaches.error(
                "SPEC123",
                f"no source is named '{key}'",
                path,
                f"did you mean '{guess}'?" if guess else "add it to `sources`",
            )


def _source_keys(node: Any, path: Path = ()) -> Iterator[tuple[Path, str]]:
    """Every `source:` that stands beside a `value:`."""
    if isinstance(node, Mapping):
        if "value" in node and isinstance(node.get("source"), str):
            yield (*path, "source"), node["source"]
        for key, value in node.items():
            yield from _source_keys(value, (*path, key))
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from _source_keys(value, (*path, index))
