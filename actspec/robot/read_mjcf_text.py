"""MJCF to RobotView from the text alone, for files that the installed MuJoCo refuses.

It reads what MuJoCo 2.3 to 4.0 would: default classes with `childclass`, includes, degrees, automatic
limits, every shortcut, dcmotor in both dialects, and `actuatorforcerange`, as 2.3 spells it. What only
a compilation tells is unknown: inertia, gains from `dampratio`, ranges from `inheritrange`, passive
damping from `springdamper`. Joints of `replicate`, `attach`, `composite` and `flexcomp` are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from actspec.diagnostics import Collector, Span, many
from actspec.joints import JointKind
from actspec.robot.compiled import reached_by_text
from actspec.robot.mjcf_actuator_text import actuator_text, class_text, numbers
from actspec.robot.mjcf_elements import JointElement, Written, read_elements
from actspec.robot.read_mjcf import nan_fields, stated_attributes, stated_fields
from actspec.robot.view import NAMELESS, ActuatorView, JointView, ModelFormat, RobotView
from actspec.robot.xml_tree import Element, XmlDocument, report_behind

_KINDS = {kind.value: kind for kind in JointKind}
_POSITIONS = {JointKind.FREE: 7, JointKind.BALL: 4}
_DEGREES_OF_FREEDOM = {JointKind.FREE: 6, JointKind.BALL: 3}
_BLANK = {
    "range": None,
    "effort_range": None,
    "force_range": None,
    "control_range": None,
    "input_range": None,
    "line": None,
    "damping_polynomial": (0.0, 0.0),
}
"""What stands in a field that is unknown and no single number."""
_OPAQUE = ("replicate", "attach", "composite", "flexcomp")


def read_mjcf_text(document: XmlDocument, refusal: str) -> RobotView:
    """Read an MJCF without MuJoCo.

    Numbers that the text does not tell are named in `unknown` of their joint or actuator; there is no
    inertia.

    Args:
        document: Parsed, with its includes in place.
        refusal: Why MuJoCo does not read it.
    """
    written = read_elements(document)
    main = Span(document.files[0].path)
    out = Collector()
    report_behind(document, out)
    compiler, option = _settings(document, "compiler"), _settings(document, "option")
    joints: list[JointView] = []
    dof = 0
    for place in written.joints:
        if not place.copied:
            joints.append(_joint(place, document, compiler, dof))
            dof += _DEGREES_OF_FREEDOM.get(joints[-1].kind, 1)
    unnamed = sum(not joint.name and joint.kind is not JointKind.FREE for joint in joints)
    if unnamed:
        out.info("ROBOT113", f"{many(unnamed, 'joint')} without a name left out", span=main)
    left_out = sorted({element.tag for element in document.walk(*_OPAQUE)})
    if left_out:
        out.info("ROBOT113", f"what {', '.join(left_out)} makes is left out", span=main)
    keys = document.keyframes()
    joints = _at_reference(joints, keys[0].get("qpos") if keys else None)
    groups = numbers(option.get("actuatorgroupdisable"), 31)
    off = {int(group) for group in groups if math.isfinite(group)}
    switches = _Switches(_flag(document, "actuation"), _flag(document, "clampctrl"), off)
    step = numbers(option.get("timestep", "0.002"), 1)
    return RobotView(
        name=document.root.get("model") or NAMELESS,
        path=document.files[0].path,
        format=ModelFormat.MJCF,
        joints=tuple(joint for joint in joints if joint.name),
        actuators=tuple(
            _actuator(index, element, document, written, _is_automatic(compiler), switches)
            for index, element in enumerate(written.actuators)
        ),
        timestep=step[0] if step and math.isfinite(step[0]) else None,
        integrator=option.get("integrator", "Euler"),
        keyframes=tuple(key.get("name") or "" for key in keys),
        pose_at=next(map(document.span, keys), None),
        inertia_reason="only its text was read, because MuJoCo refuses the file",
        files=document.files,
        diagnostics=tuple(out),
        eulerdamp=_flag(document, "eulerdamp"),
        actuation=switches.actuation,
        off_groups=frozenset(switches.off),
        refusal=refusal,
        mass=_mass(document, compiler),
    )


def _mass(document: XmlDocument, compiler: Mapping[str, str]) -> float | None:
    """The sum of the masses of all bodies in the only tree with joints [kg].

    None where one of them is that of its geoms, or is scaled, and where several trees have joints: some are objects.
    """
    trees = [replace(document, root=body) for body in _top_bodies(document)]
    trees = [tree for tree in trees if any(tree.walk("joint", "freejoint"))]
    if len(trees) != 1 or compiler.get("inertiafromgeom") == "true" or "settotalmass" in compiler:
        return None
    total = 0.0
    for body in trees[0].walk("body"):
        own = [part for part in body.children if part.tag == "inertial"]
        if not own and any(part.tag == "geom" for part in body.children):
            return None
        total += sum(math.fsum(numbers(part.get("mass"), 1)) for part in own)
    return total if math.isfinite(total) else None


def _top_bodies(document: XmlDocument) -> Iterator[Element]:
    """Bodies that hang on the world, in no order."""
    stack = list(document.sections("worldbody"))
    while stack:
        element = stack.pop()
        if element.tag == "body":
            yield element
        else:
            stack.extend(element.children)


def _settings(document: XmlDocument, tag: str) -> dict[str, str]:
    """Attributes of all sections of that tag; the last counts."""
    found: dict[str, str] = {}
    for section in document.sections(tag):
        found.update(section.values)
    return found


def _flag(document: XmlDocument, name: str) -> bool:
    on = True
    for section in document.sections("option"):
        for child in section.children:
            if child.tag == "flag" and child.get(name) is not None:
                on = child.get(name) != "disable"
    return on


@dataclass(frozen=True, slots=True)
class _Switches:
    """What `option` leaves on: actuators at all, and the clamp of controls; and the groups that are off."""

    actuation: bool
    clamp: bool
    off: set[int]


def _is_automatic(compiler: Mapping[str, str]) -> bool:
    return compiler.get("autolimits", "true") != "false"


def _joint(place: JointElement, document: XmlDocument, compiler: Mapping[str, str], dof: int) -> JointView:
    element, owners = place.element, place.owners

    def get(*names: str) -> str | None:
        return next((owners[name].get(name) for name in names if name in owners), None)

    def number(name: str) -> float:
        return (*numbers(get(name), 1), 0.0)[0]

    kind = _KINDS.get(place.type, JointKind.HINGE)
    angular = kind in (JointKind.HINGE, JointKind.BALL) and compiler.get("angle", "degree") != "radian"
    automatic = _is_automatic(compiler)
    limits = _limits(numbers(get("range"), 2), get("limited"), automatic)
    if limits is not None and angular:
        limits = (math.radians(limits[0]), math.radians(limits[1]))
    effort = _limits(
        numbers(get("actuatorfrcrange", "actuatorforcerange"), 2),
        get("actuatorfrclimited", "actuatorforcelimited"),
        automatic,
    )
    damping = (*numbers(get("damping"), 3), 0.0, 0.0, 0.0)
    reference = number("ref")
    spring = (*numbers(get("springdamper"), 2), 0.0, 0.0)
    sprung = spring[0] > 0.0 and spring[1] > 0.0
    stated, places = stated_fields(element, owners, document)
    view = JointView(
        name=place.name,
        kind=kind,
        span=place.span,
        body=place.body,
        dof=dof,
        range=limits,
        damping=damping[0],
        damping_polynomial=(damping[1], damping[2]),
        stiffness=number("stiffness"),
        armature=number("armature"),
        frictionloss=number("frictionloss"),
        effort_range=None if kind in _POSITIONS else effort,
        stated=frozenset({*stated, "damping"} if sprung else stated),
        springdamper=sprung,
        reference_position=0.0 if kind in _POSITIONS else math.radians(reference) if angular else reference,
        parent=place.parent,
        places=places,
    )
    return _without_nan(view, {"damping", "stiffness"} if sprung else set())


def _limits(ends: tuple[float, ...], limited: str | None, automatic: bool) -> tuple[float, float] | None:
    """A range that is in force; None: it is not."""
    if len(ends) != 2:
        # One number is an error, and the range is as good as unreadable.
        return (math.nan, math.nan) if ends and limited != "false" else None
    low, high = ends
    if limited in ("true", "false"):
        return (low, high) if limited == "true" else None
    return (low, high) if automatic and not low >= high else None


def _at_reference(joints: list[JointView], qpos: str | None) -> list[JointView]:
    """The joints with the positions of the first keyframe, if it has any."""
    if qpos is None:
        return joints
    count = sum(_POSITIONS.get(joint.kind, 1) for joint in joints)
    positions = numbers(qpos, count + 1)
    found = []
    at = 0
    for joint in joints:
        if joint.kind in _POSITIONS:
            found.append(joint)
        elif len(positions) == count and math.isfinite(positions[at]):
            found.append(replace(joint, reference_position=positions[at]))
        else:
            found.append(replace(joint, unknown=joint.unknown | {"reference_position"}))
        at += _POSITIONS.get(joint.kind, 1)
    return found


def _actuator(
    index: int,
    element: Element,
    document: XmlDocument,
    written: Written,
    automatic: bool,
    switches: _Switches,
) -> ActuatorView:
    text = actuator_text(class_text(written.defaults_of(element).actuators), element)
    kind = text.control(element.tag)
    stated, places = stated_attributes(element, written)

    def limits(name: str) -> tuple[float, float] | None:
        flag = text.limited.get(f"{name}limited")
        written_flag = None if flag is None else "true" if flag else "false"
        return _limits(text.ranges.get(f"{name}range", ()), written_flag, automatic)

    unknown: set[str] = set()
    if text.inherits > 0.0 or (text.gain_type == "pid" and "pos" not in text.inputs):
        unknown.update(("control_range", "input_range"))
    if text.delay and element.get("nsample") is None and "nsample" not in stated:
        unknown.add("delay")
    if text.gain_type == "dcmotor" and text.inputs == {"none"}:
        text.ranges.pop("ctrlrange", None)
    view = ActuatorView(
        name=element.get("name") or "",
        index=index,
        span=document.span(element),
        tag=element.tag,
        transmission=text.transmission,
        target=text.target,
        **kind.at_joint(text.gear, limits("ctrl") if switches.clamp else None, limits("act")),
        force_range=limits("force"),
        damping=(text.damping[0], text.damping[1], text.damping[2]),
        armature=text.armature,
        delay=text.delay,
        group=text.group,
        stated=frozenset(stated),
        places=places,
        disabled=not switches.actuation or text.group in switches.off,
        moves=reached_by_text(document, text.transmission, text.target),
    )
    return _without_nan(view, unknown)


_View = TypeVar("_View", JointView, ActuatorView)


def _without_nan(view: _View, unknown: set[str]) -> _View:
    """The view with 0 or None for every nan, and the names of such fields in `unknown`."""
    changed: dict[str, Any] = {name: _BLANK.get(name, 0.0) for name in nan_fields(view)}
    unknown.update(changed)
    return replace(view, unknown=frozenset(unknown), **changed) if unknown else view
