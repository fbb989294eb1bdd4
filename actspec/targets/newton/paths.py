"""Where the joints' prims are in the stage that the overlay is laid on.

Two converters of Newton's project decide what a path is where the spec does not say (`root`, `joint_paths`):
mujoco-usd-converter nests each joint in its body, `/MODEL/Geometry/BODY/.../BODY/JOINT`, with the actuators in
`/MODEL/Physics`; urdf-usd-converter has all joints in `/ROBOT/Physics`. A name that cannot be a prim's as it is gets
another one there, which is not guessed here.
Source: mujoco-usd-converter 0.8.0 and urdf-usd-converter 0.3.4, run on robots/ and read.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, RobotError, listed, shortened
from actspec.ir import ActuatorSet
from actspec.robot.view import ModelFormat, RobotView
from actspec.spec.models import NewtonTarget
from actspec.targets.base import TargetOptions
from actspec.targets.kit.joint import pattern_of
from actspec.targets.newton.usda import is_identifier, path_text, prim_path

if TYPE_CHECKING:
    import mujoco

Path = tuple[str, ...]

JOINT = "{joint}"
"""What stands for the joint's name in a path of the spec."""


@dataclass(frozen=True, slots=True)
class StagePaths:
    """Where things are in the stage.

    Attributes:
        root: The robot's prim.
        joints: Each managed joint's prim.
        converted: Joints whose path is a converter's, the spec stating none.
    """

    root: Path
    joints: dict[str, Path]
    converted: frozenset[str]


_STATE = 'state `joint_paths`, e.g. {".*": "joints/{joint}"}'


def lay_out(
    actuators: ActuatorSet, robot: RobotView, options: TargetOptions, collector: Collector
) -> StagePaths:
    """Path of the robot's prim and of each managed joint's; not all after an error."""
    names = [actuator.joint for actuator in actuators.joints]
    root = _root(robot, options, collector)
    if not root:
        return StagePaths(root, {}, frozenset())
    found = _stated(names, root, options, collector)
    left = [name for name in names if name not in found]
    if left and not collector.failed:
        found |= _converted(left, robot, root, options, collector)
    owners: dict[Path, list[str]] = {}
    for name in (name for name in names if name in found):
        owners.setdefault(found[name], []).append(name)
    for path, shared in owners.items():
        if len(shared) > 1:
            options.at("joint_paths", collector).error(
                "NWT010",
                f"{listed(shared)} have one path, {shortened(path_text(path))}",
                f"write {JOINT} where the joint's name belongs",
            )
    return StagePaths(root, found, frozenset(left))


def _root(robot: RobotView, options: TargetOptions, collector: Collector) -> Path:
    """The robot's prim; empty after an error."""
    stated = options.of(NewtonTarget).root
    if stated is not None:
        found = prim_path(stated)
        if found is None:
            options.at("root", collector).error(
                "NWT008",
                f"'{shortened(stated)}' is not a valid USD prim path",
                "write names behind slashes, e.g. /World/Robot",
            )
        return found or ()
    if is_identifier(robot.name):
        return (robot.name,)
    collector.at(options.where("root")).error(
        "NWT009",
        f"the robot's name '{shortened(robot.name)}' is not a valid USD prim name, so the path of its prim is unknown",
        "state `root`, the path of the robot's prim, e.g. /World/Robot",
    )
    return ()


def _stated(names: list[str], root: Path, options: TargetOptions, collector: Collector) -> dict[str, Path]:
    """The paths that the spec states."""
    paths = options.of(NewtonTarget).joint_paths or {}
    found: dict[str, Path] = {}
    faulty: set[str] = set()
    for name, pattern in pattern_of(list(paths), names, "joint_paths", "NWT011", options, collector).items():
        text = paths[pattern].replace(JOINT, name)
        path = prim_path(text if text.startswith("/") else f"{path_text(root)}/{text}")
        if path is not None:
            found[name] = path
        elif pattern not in faulty:
            faulty.add(pattern)
            place = collector.at(
                options.where(f"joint_paths.{pattern}"), options.span(f"joint_paths[{pattern}]")
            )
            place.error(
                "NWT008",
                f"'{shortened(text)}' is not a valid USD prim path (joint {shortened(name)})",
                "write names of letters, digits and _ between slashes, as the stage has them",
            )
    return found


def _converted(
    names: list[str], robot: RobotView, root: Path, options: TargetOptions, collector: Collector
) -> dict[str, Path]:
    """The paths that a converter gives to the joints."""
    place = collector.at(options.where("joint_paths"))
    if robot.format is ModelFormat.NONE:
        place.error(
            "NWT009", "the spec names no model, so it is unknown where the joints are in the stage", _STATE
        )
        return {}
    candidates: dict[str, Path] = {}
    if robot.format is ModelFormat.MJCF:
        candidates = _in_bodies(robot, root)
    else:
        counts = Counter(joint.name for joint in robot.joints)
        candidates = {name: (*root, "Physics", name) for name in names if counts[name] == 1}
    unsure = [name for name in names if not all(map(is_identifier, candidates.get(name, ("",))))]
    if unsure:
        place.error(
            "NWT009",
            f"{listed(unsure)}: the converter's path is unknown, because a name on it is not a valid USD prim name or "
            "not unique in its body",
            _STATE,
        )
    return {name: path for name, path in candidates.items() if name in names and name not in unsure}


def _in_bodies(robot: RobotView, root: Path) -> dict[str, Path]:
    """Joints nested in their bodies; a name that is not unique among the prims of a body is left out."""
    from actspec.robot.mjspec import open_spec, quiet

    try:
        with quiet():
            spec = open_spec(robot.files, format=robot.format)
            return dict(_below(spec.worldbody, (*root, "Geometry")))
    except RobotError:
        return {}


def _below(body: mujoco.MjsBody, path: Path) -> Iterator[tuple[str, Path]]:
    names = Counter(item.name for kind in (body.geoms, body.sites, body.joints, body.bodies) for item in kind)
    for joint in body.joints:
        if names[joint.name] == 1:
            yield joint.name, (*path, joint.name)
    for child in body.bodies:
        unique = child.name and names[child.name] == 1
        # An empty name is none that a prim could have: nothing below it is taken.
        yield from _below(child, (*path, child.name if unique else ""))


def converted_actuators(robot: RobotView, layout: StagePaths) -> list[Path]:
    """Prims that mujoco-usd-converter makes of a model's own actuators on driven joints.

    Newton's MuJoCo solver would have them act beside the NewtonActuators.
    """
    counts = Counter(actuator.name for actuator in robot.actuators)
    return [
        (*layout.root, "Physics", actuator.name)
        for actuator in robot.actuators
        if actuator.target in layout.converted
        and actuator.is_direct
        and is_identifier(actuator.name)
        and counts[actuator.name] == 1
    ]
