"""yourdfpy: a written URDF loaded by a reader that is not ours, which has no drive that could give a torque.

It expands entities, recovers from broken XML without a word and looks for meshes. So it gets what our own parser
took, joints and names of links alone, in a process of its own.
"""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from importlib.util import find_spec
from typing import Any

from actspec.diagnostics import RobotError, shortened
from actspec.files import FAULTS
from actspec.ir import ActuatorSet, JointKind
from actspec.libraries import extra_line
from actspec.processes import IsolatedCall, LostError
from actspec.robot.xml import open_document
from actspec.robot.xml_tree import Element
from actspec.verify.agreement import Row, TargetFiles, alike
from actspec.verify.engines.asking import EngineMissing, EngineRefused
from actspec.verify.fields import engine_rows
from actspec.verify.readback import Figures, FileFigures

TIME_LIMIT = 60.0
"""Chosen: seconds for its import, of thirty packages, and one file."""

_KINDS = {"revolute": JointKind.HINGE, "continuous": JointKind.HINGE, "prismatic": JointKind.SLIDE}

Joints = Mapping[str, tuple[str, Mapping[str, float]]]
"""Joint to its type and its fields in SI; what the format takes for absent is 0, of a limit infinity."""


def urdf_rows(target: TargetFiles, actuators: ActuatorSet, asked: Figures, fresh: FileFigures) -> list[Row]:
    """Rows of the file that is verified, as yourdfpy reads it.

    Args:
        target: The target.
        actuators: What the spec asks for.
        asked: The same as figures, of `readback.spec_figures`.
        fresh: What actspec writes.

    Raises:
        EngineMissing: yourdfpy is not installed.
        EngineRefused: yourdfpy does not take the file.
    """
    engine, joints = _load(target.path(target.files[0]))
    known = {actuator.joint for actuator in actuators.joints if actuator.joint in fresh.figures}
    rows = []
    for members in alike(actuators):
        wrong: dict[tuple[str, str], list[str]] = {}
        for actuator in (actuator for actuator in members if actuator.joint in known):
            kind, _ = joints.get(actuator.joint, ("", {}))
            if not kind:
                wrong.setdefault(("VFY109", f"{engine} finds no such joint"), []).append(actuator.joint)
            elif _KINDS.get(kind) is not actuator.kind:
                message = f"the joint is of type {kind} in {engine}, and should be a {actuator.kind.value}"
                wrong.setdefault(("VFY110", message), []).append(actuator.joint)
        rows += [
            Row(
                *(target.name, members[0].group, names[0], len(names), "joint", "", None, 0.0, False),
                engine=engine,
                code=code,
                message=message,
            )
            for (code, message), names in wrong.items()
        ]
    figures = {name: figures for name, (_, figures) in joints.items() if name in known}
    rows += engine_rows(target, actuators, asked, fresh, figures, engine)
    return rows


def _load(path: str) -> tuple[str, Joints]:
    if find_spec("yourdfpy") is None:
        reason = "yourdfpy, which reads the file a second time, is not installed"
        raise EngineMissing(reason, extra_line("urdf"), setup=True)
    try:
        text = sanitised(path)
    except (RobotError, *FAULTS) as err:
        raise EngineRefused(f"it is not given to it: {shortened(str(err), 300)}") from err
    with IsolatedCall(_joints, TIME_LIMIT, "yourdfpy") as call:
        try:
            found = call(text)
        except LostError as err:
            raise EngineRefused(str(err)) from err
    if isinstance(found, str):
        raise EngineRefused(shortened(found, 300))
    return found


def sanitised(path: str) -> bytes:
    """A URDF as our parser takes it: joints with all that they have, links with their names.

    Raises: as `open_document`, which refuses a DOCTYPE that could define an entity.
    """
    from lxml import etree

    def copied(element: Element) -> Any:
        values = {name: value for name, value in element.values.items() if ":" not in name}
        made = etree.Element(element.tag, values)
        made.extend([copied(child) for child in element.children if ":" not in child.tag])
        return made

    root = open_document(path).root
    made = etree.Element("robot", {"name": root.values.get("name", "")})
    for element in root.children:
        if element.tag == "link":
            etree.SubElement(made, "link", {"name": element.values.get("name", "")})
        elif element.tag == "joint":
            made.append(copied(element))
    return etree.tostring(made, encoding="utf-8")


def _joints(text: bytes) -> tuple[str, Joints] | str:
    """In the other process: what yourdfpy reads, or why it does not."""
    import logging

    import yourdfpy

    logging.disable()
    off = ("build_scene_graph", "load_meshes", "build_collision_scene_graph", "load_collision_meshes")
    try:
        robot = yourdfpy.URDF.load(io.BytesIO(text), **dict.fromkeys(off, False)).robot
        joints = {joint.name: (str(joint.type), dict(_fields(joint))) for joint in robot.joints}
    except Exception as err:
        return f"{type(err).__name__}: {err}"
    return f"yourdfpy {yourdfpy.__version__}", joints


def _fields(joint: Any) -> Any:
    limit, dynamics = joint.limit, joint.dynamics
    for name, attribute, nothing in (
        ("effort_limit", "effort", math.inf),
        ("velocity_limit", "velocity", math.inf),
        ("position_low", "lower", -math.inf),
        ("position_high", "upper", math.inf),
    ):
        said = getattr(limit, attribute, None)
        yield name, nothing if said is None else float(said)
    for name, attribute in (("joint_damping", "damping"), ("frictionloss", "friction")):
        yield name, float(getattr(dynamics, attribute, None) or 0.0)
