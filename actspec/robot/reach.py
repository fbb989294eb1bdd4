"""Joints that an actuator moves without driving them directly: over a tendon, a site or a crank.

Its force at them depends on the pose, so nothing is said of its size.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from actspec.robot.model_lists import ModelLists
    from actspec.robot.xml_tree import XmlDocument

_INDIRECT = frozenset({"tendon", "site", "slidercrank"})


def reached_joints(model: ModelLists, index: int, transmission: str) -> list[int]:
    """Joints that feel an actuator's force over a tendon, a site or a crank, in the model's order.

    A fixed tendon reaches its joints. A spatial one, a site and a crank reach what lies between the two bodies that
    they pull at, for a site without `refsite` what lies between its body and the world.

    Args:
        model: Compiled.
        index: Of the actuator.
        transmission: As `ActuatorView.transmission`.
    """
    if transmission not in _INDIRECT:
        return []
    first, second = model.actuator_trnid[index]
    if transmission == "tendon":
        joints = _of_tendon(model, first)
    else:
        bodies = model.site_bodyid
        joints = _between(model, bodies[first], bodies[second] if second >= 0 else 0)
    return sorted(joints)


def moved_joints(model: ModelLists, index: int, transmission: str) -> list[int] | None:
    """Joints that an actuator drives, directly or not; None: it may be any. Arguments as in `reached_joints`."""
    if transmission in _INDIRECT:
        return reached_joints(model, index, transmission)
    return [model.actuator_trnid[index][0]] if transmission in ("joint", "jointinparent") else None


def _of_tendon(model: ModelLists, tendon: int) -> set[int]:
    import mujoco

    wrap = mujoco.mjtWrap
    start = model.tendon_adr[tendon]
    found: set[int] = set()
    body: int | None = None
    for at in range(start, start + model.tendon_num[tendon]):
        kind, target = model.wrap_type[at], model.wrap_objid[at]
        if kind == int(wrap.mjWRAP_JOINT):
            found.add(target)
        elif kind == int(wrap.mjWRAP_PULLEY):
            # The branches of a pulley begin anew.
            body = None
        else:
            bodies = model.site_bodyid if kind == int(wrap.mjWRAP_SITE) else model.geom_bodyid
            if body is not None:
                found |= _between(model, body, bodies[target])
            body = bodies[target]
    return found


def _between(model: ModelLists, one: int, other: int) -> set[int]:
    """Joints that move two bodies against each other."""
    apart = _above(model, one) ^ _above(model, other)
    first, count = model.body_jntadr, model.body_jntnum
    return {joint for body in apart for joint in range(first[body], first[body] + count[body])}


def _above(model: ModelLists, body: int) -> set[int]:
    """A body and those that it hangs on, without the world."""
    found = set()
    while body:
        found.add(body)
        body = model.body_parentid[body]
    return found


def reached_by_text(document: XmlDocument, transmission: str, target: str) -> tuple[str, ...] | None:
    """The same from the text alone.

    Args:
        document: Of the model.
        transmission: As `ActuatorView.transmission`.
        target: Likewise.

    Returns: Names of joints; None where it may be any.
    """
    if transmission not in _INDIRECT:
        return ()
    if transmission == "tendon":
        for section in document.sections("tendon"):
            for tendon in section.children:
                if tendon.tag == "fixed" and tendon.get("name") == target:
                    names = (child.get("joint") for child in tendon.children if child.tag == "joint")
                    return tuple(name for name in names if name)
    return None
