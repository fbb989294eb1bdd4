"""Import files in tests: the robot that they describe, its spec, and small MJCFs to import."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from actspec.audit.build import case_of
from actspec.audit.read import read_files
from actspec.draft import DraftedSpec, draft
from actspec.draft.combine import Combined, combine
from actspec.draft.reading import read_robot_files
from actspec.draft.sources import targets_of
from actspec.readings.dynamics import RobotDynamics, dynamics_of
from actspec.readings.versions import Versions
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate

NASTY = [
    'quote"s',
    "it's",
    "back\\slash\\",
    "back\\slash's",
    "a: b",
    "a #b",
    "# hash",
    "- dash",
    "&anchor",
    "*alias",
    "!tag",
    "{a: b}",
    "[x]",
    "yes",
    "null",
    "1e3",
    "0x1F",
    "~",
    "line\nbreak",
    "tab\there",
    " lead",
    "trail ",
    "per%cent",
    "@at",
    "`tick`",
    "д",
    "関節",
    "\u2028sep",
    "\x85next",
    "\ufeffbom",
    "😀",
    "a|b",
    "(((((",
    "(a+)+$",
    ".*",
    "^x$",
    "]",
    "{{ jinja }}",
    "{% if %}",
    "${shell}",
    "--><!--",
    "x" * 150,
]
"""Names that break YAML, patterns or templates."""

INERTIAL = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'


@dataclass(frozen=True)
class Imported:
    """What `actspec import` makes of files.

    Attributes:
        combined: The robot.
        draft: Its spec.
        data: What the spec's YAML holds; it is valid.
    """

    combined: Combined
    draft: DraftedSpec
    data: dict[str, Any]


def mjcf(joints: str, actuators: str = "", head: str = "", tail: str = "") -> str:
    """A chain of bodies, one for each line of `joints`."""
    lines = [line.strip() for line in joints.strip().split("\n")]
    body = "".join(f"<body>\n{line}\n{INERTIAL}" for line in lines) + "</body>" * len(lines)
    section = f"<actuator>\n{actuators}\n</actuator>" if actuators else ""
    return f'<mujoco model="robot">{head}<worldbody>{body}</worldbody>{section}{tail}</mujoco>'


def write(folder: Path, **files: str) -> list[Path]:
    """Write files whose keyword is their name with `_` for the dot before the ending."""
    paths = []
    for key, text in files.items():
        stem, _, ending = key.rpartition("_")
        paths.append(folder / f"{stem}.{ending}")
        paths[-1].write_text(text, encoding="utf-8")
    return paths


CURVED = """from isaaclab.actuators import DelayedPDActuator, DelayedPDActuatorCfg
from isaaclab.utils import configclass

class UnitreeActuator(DelayedPDActuator):
    pass

@configclass
class UnitreeActuatorCfg(DelayedPDActuatorCfg):
    class_type: type = UnitreeActuator
    X1: float = 1e9
    X2: float = 1e9
    Y1: float = 1e9
    Y2: float | None = None
    Fs: float = 0.0
    Fd: float = 0.0
    Va: float = 0.01
"""
"""A class with the fields of unitree_rl_lab's."""


def imported(
    paths: Sequence[Path],
    folder: Path,
    robot: str | None = None,
    versions: Versions | None = None,
    damping: str | None = None,
) -> Imported:
    """Import files into a spec that stands in `folder`."""
    versions = versions or Versions()
    readings, _ = read_robot_files([str(path) for path in paths], robot, versions)
    readings = tuple(replace(r, reference=os.path.relpath(r.path, folder)) for r in readings)
    combined = combine(readings)
    model = "none" if combined.model is None else combined.model.reference
    found = draft(combined, model, targets_of(readings, combined, versions), damping)
    return Imported(combined, found, validate(document_from_text(found.text)).document.data)


def bare(node: Any) -> Any:
    """Values without the source beside them."""
    if isinstance(node, dict):
        if "value" in node:
            assert set(node) <= {"value", "source"}
            return node["value"]
        return {key: bare(value) for key, value in node.items()}
    return [bare(item) for item in node] if isinstance(node, list) else node


def dynamics(path: Path, *beside: Path, versions: Versions | None = None) -> RobotDynamics:
    """What acts on the joints of the first robot of a file, a configuration's read on the joints of files beside it."""
    readings = read_files([str(path), *map(str, beside)], jobs=1)
    assert readings[0].readable, readings[0].reason
    case = case_of(readings, versions or Versions(), {})
    return dynamics_of(case.artifacts[0], case.rows_of(0))


def urdf_of(*names: str) -> str:
    """A URDF with hinges of these names, all at the base."""
    return (
        "<robot name='leg'><link name='base'/>"
        + "".join(
            f"<link name='{name}_link'/><joint name='{name}' type='revolute'><parent link='base'/><axis xyz='0 1 0'/>"
            f"<child link='{name}_link'/><limit lower='-2' upper='2' effort='9' velocity='9'/></joint>"
            for name in names
        )
        + "</robot>"
    )
