"""Joints of an MJCF that an equality holds: followers of another joint, and members of a closed loop."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from actspec.diagnostics import one_line
from actspec.robot.xml_tree import Element, XmlDocument


@dataclass(slots=True)
class _Body:
    """A body: its parent, its joints, and whether it floats (free or mocap)."""

    parent: _Body | None
    joints: list[str] = field(default_factory=list)
    loose: bool = False


def coupled_joints(document: XmlDocument | None) -> dict[str, str]:
    """Joint to the one that an MJCF's `<equality><joint>` makes it follow; "" for a fixed position."""
    return {
        element.get("joint1") or "": element.get("joint2") or ""
        for element in _equalities(document)
        if element.tag == "joint"
    }


def loop_joints(document: XmlDocument | None) -> dict[str, str]:
    """Joint to the closed loop that it is in, in words: `the closed loop 'ankle' (connect)`.

    A loop is a `<connect>` or `<weld>` of two bodies of the robot with the joints between them. What holds a body
    to the world, to a mocap body or to something that floats freely closes none.
    """
    if document is None:
        return {}
    bodies: dict[str, _Body] = {}
    sites: dict[str, _Body] = {}
    world = _Body(None)
    for section in document.sections("worldbody"):
        _read(section, world, bodies, sites)
    found: dict[str, str] = {}
    for element in _equalities(document):
        if element.tag not in ("connect", "weld"):
            continue
        ends = [
            bodies.get(element.get(f"body{one}") or "") or sites.get(element.get(f"site{one}") or "")
            for one in "12"
        ]
        names = [element.get(f"body{one}") or element.get(f"site{one}") or "" for one in "12"]
        called = element.get("name")
        words = f"'{one_line(called)}'" if called else f"of {one_line(names[0])} and {one_line(names[1])}"
        for joint in _between(*ends):
            found.setdefault(joint, f"the closed loop {words} ({element.tag})")
    return found


def _equalities(document: XmlDocument | None) -> Iterator[Element]:
    for section in () if document is None else document.sections("equality"):
        yield from (element for element in section.children if element.get("active") != "false")


def _read(element: Element, body: _Body, bodies: dict[str, _Body], sites: dict[str, _Body]) -> None:
    """The bodies below an element; frames and replicas are no bodies."""
    pending = [(element, body)]
    while pending:
        parent, home = pending.pop()
        for child in parent.children:
            if child.tag == "body":
                own = _Body(home, loose=child.get("mocap") == "true")
                bodies.setdefault(child.get("name") or "", own)
                pending.append((child, own))
            elif child.tag in ("joint", "freejoint"):
                home.loose = home.loose or child.tag == "freejoint" or child.get("type") == "free"
                home.joints.append(child.get("name") or "")
            elif child.tag == "site":
                sites.setdefault(child.get("name") or "", home)
            else:
                pending.append((child, home))


def _between(one: _Body | None, other: _Body | None) -> Iterator[str]:
    """Joints on the way from one body to the other; none where a floating body is on it."""
    if one is None or other is None:
        return
    ways = [list(_up(one)), list(_up(other))]
    shared = {id(body) for body in ways[0]} & {id(body) for body in ways[1]}
    way = [body for body in (*ways[0], *ways[1]) if id(body) not in shared]
    if not any(body.loose for body in way):
        yield from (joint for body in way for joint in body.joints)


def _up(body: _Body) -> Iterator[_Body]:
    while body.parent is not None:
        yield body
        body = body.parent
