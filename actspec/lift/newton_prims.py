"""Which prims of a Newton overlay are of which joint: the joint's own and the actuators that target it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from actspec.diagnostics import shortened
from actspec.ir import JointKind
from actspec.robot.usda import UsdaLayer, UsdaPrim
from actspec.robot.view import JointView

ACTUATOR = "NewtonActuator"
TARGETS = "newton:targets"
_KINDS = {"PhysicsRevoluteJoint": JointKind.HINGE, "PhysicsPrismaticJoint": JointKind.SLIDE}
_AXES = {"angular": JointKind.HINGE, "linear": JointKind.SLIDE}


@dataclass(frozen=True, slots=True)
class NewtonJoint:
    """One joint of an overlay.

    Attributes:
        name: Of the joint.
        view: The joint in the robot's file; None: not at hand.
        kind: Hinge or slide; None: neither the file nor the robot says.
        prim: The joint's own prim; None: the overlay has none.
        actuators: The actuators that target it, in the file's order.
    """

    name: str
    view: JointView | None
    kind: JointKind | None
    prim: UsdaPrim | None
    actuators: tuple[UsdaPrim, ...]


def newton_joints(
    layer: UsdaLayer, joints: Sequence[JointView | str] | None, prims: Mapping[str, str] | None
) -> tuple[tuple[NewtonJoint, ...], tuple[str, ...]]:
    """The joints of an overlay, and remarks on what of it is no joint's.

    Args:
        layer: The overlay.
        joints: As in `lift_newton`.
        prims: Likewise.
    """
    targeted, remarks = _targeted(layer)
    views = {joint if isinstance(joint, str) else joint.name: joint for joint in joints or ()}
    views = {
        name: view
        for name, view in views.items()
        if isinstance(view, str) or view.kind in (JointKind.HINGE, JointKind.SLIDE)
    }
    paths = _named(layer, targeted) if prims is None else dict(prims)
    found = []
    for name in views or paths:
        path = paths.get(name, "")
        view = views.get(name)
        joint = None if view is None or isinstance(view, str) else view
        prim = layer.prims.get(path)
        kind = joint.kind if joint is not None else None if prim is None else _kind(prim)
        found.append(NewtonJoint(name, joint, kind, prim, tuple(targeted.pop(path, ()))))
    strays = [f"actuators at {shortened(path)}, which is none of the joints" for path in targeted]
    return tuple(found), (*remarks, *strays)


def _targeted(layer: UsdaLayer) -> tuple[dict[str, list[UsdaPrim]], list[str]]:
    """Joints' paths to the actuators that are in force there."""
    found: dict[str, list[UsdaPrim]] = {}
    remarks = []
    for prim in layer.prims.values():
        if prim.type != ACTUATOR or not prim.active:
            continue
        if prim.specifier != "def":
            remarks.append(f"{shortened(prim.path)} is no def: left to the stage, if it has one")
            continue
        attribute = prim.attributes.get(TARGETS)
        targets = attribute.value if attribute is not None and isinstance(attribute.value, tuple) else ()
        if not targets:
            remarks.append(f"{shortened(prim.path)} has no target, which Newton refuses")
            continue
        if len(targets) > 1:
            remarks.append(f"{shortened(prim.path)} has {len(targets)} targets: Newton takes the first")
        found.setdefault(str(targets[0]), []).append(prim)
    return found, remarks


def _named(layer: UsdaLayer, targeted: Mapping[str, Sequence[UsdaPrim]]) -> dict[str, str]:
    """Names of the joints to their paths: the last name, or the whole path where two end alike."""
    paths = dict.fromkeys([prim.path for prim in layer.prims.values() if _is_joint(prim)] + list(targeted))
    last = [path.rpartition("/")[2] for path in paths]
    return {name if last.count(name) == 1 else path: path for name, path in zip(last, paths, strict=True)}


def _is_joint(prim: UsdaPrim) -> bool:
    return prim.type in _KINDS or any(
        api == "NewtonJointAPI" or api.startswith("PhysicsDriveAPI:") for api in prim.apis
    )


def _kind(prim: UsdaPrim) -> JointKind | None:
    """What a prim's type says, else the axis of its drive."""
    if prim.type in _KINDS:
        return _KINDS[prim.type]
    kinds = {_AXES[axis] for axis in _axes(prim) if axis in _AXES}
    return kinds.pop() if len(kinds) == 1 else None


def _axes(prim: UsdaPrim) -> Iterator[str]:
    yield from (api.partition(":")[2] for api in prim.apis if api.startswith("PhysicsDriveAPI:"))
    yield from (name.split(":")[1] for name in prim.attributes if name.startswith("drive:"))
