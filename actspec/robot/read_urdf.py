"""URDF to RobotView: limits and friction from the text, order and inertia from MuJoCo.

MuJoCo's own reading of the text is not used for a limit: it takes `effort="0"` and an absent
effort both as "no limit", and treats the limits of a continuous joint differently by version.
The base is fixed to the world, as MuJoCo imports a URDF, so inertia_free of a floating-base
robot is that of the robot with its base held.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, RobotError, Span, in_quotes, listed, many, nearest
from actspec.joints import JointKind
from actspec.robot.inertia import POSES, known_inertia
from actspec.robot.view import JointView, ModelFile, ModelFormat, RobotView
from actspec.robot.xml_tree import NUMBER, report_behind
from actspec.units import format_number

if TYPE_CHECKING:
    import mujoco

    from actspec.robot.xml_tree import Element, XmlDocument

_KINDS = {
    "revolute": JointKind.HINGE,
    "continuous": JointKind.HINGE,
    "prismatic": JointKind.SLIDE,
    "floating": JointKind.FREE,
    # No type of URDF; Bullet, RaiSim and MuJoCo read it.
    "spherical": JointKind.BALL,
}
_TYPES = (*_KINDS, "fixed", "planar")
_UNITS = {
    JointKind.HINGE: ("N*m", "rad/s"),
    JointKind.SLIDE: ("N", "m/s"),
    JointKind.FREE: ("N", "m/s"),
    JointKind.BALL: ("N*m", "rad/s"),
}

EXPAND = "xacro ROBOT.urdf.xacro -o ROBOT.urdf, and name that"
"""What to do with a xacro."""


def unexpanded(document: XmlDocument) -> Iterator[Element]:
    """Elements that xacro has yet to expand. What it made may still name its namespace."""
    prefixes = {"xacro"}
    for element in document.walk():
        prefixes.update(
            name.partition(":")[2]
            for name, value in element.values.items()
            if name.startswith("xmlns:") and "xacro" in value
        )
        if element.tag.partition(":")[0] in prefixes and ":" in element.tag:
            yield element


def is_xacro(document: XmlDocument) -> bool:
    """Whether a file that is called a URDF is a xacro: by its root's namespace, and a macro or figure that it computes.

    Includes, arguments and properties that nothing uses leave the joints as its text has them.
    """
    idle = ("arg", "property", "include")
    own = frozenset(unexpanded(document))
    return any(
        name.startswith("xmlns:") and "xacro" in value for name, value in document.root.values.items()
    ) and any(
        element.tag.partition(":")[2] not in idle
        if element in own
        else any("${" in value for value in element.values.values())
        for element in document.walk()
    )


def read_urdf(
    files: Sequence[ModelFile],
    document: XmlDocument | None = None,
    *,
    refusal: str | None = None,
    poses: int = POSES,
    shapes: bool = True,
) -> RobotView:
    """Read a URDF.

    An absent attribute is not in `stated`; its value in the view is the URDF default, 0 or no
    limit. Fixed joints are left out; so are planar ones, which have no JointKind, with a note.

    Args:
        files: The one file.
        document: The same file parsed, if the caller has it.
        refusal: Why MuJoCo must not see it, which is wanted for order and inertia; None: it may.
        poses: As in `read_mjcf`.
        shapes: Likewise.

    Raises: RobotError: a joint is malformed; all such places at once.
    """
    from actspec.robot.mjspec import compiled_model
    from actspec.robot.xml import parse_document

    if document is None:
        document = parse_document(tuple(files))
    out = Collector()
    report_behind(document, out)
    joints = _joints(document, out)
    _check_depth(document, out)
    out.raise_if_failed(RobotError)
    model = masses = refused_at = None
    reason = refusal or ""
    if refusal is None:
        try:
            compiled = compiled_model(document, ModelFormat.URDF, shapes=shapes)
            model = compiled.model
            masses, reason = known_inertia(model, compiled.meshes, poses)
        except RobotError as err:
            # Other tools may take it.
            refusal = reason = err.diagnostics[0].message
            refused_at = err.diagnostics[0].span
    if model is not None:
        order = _order(model)
        known = {name: index for index, name in enumerate(order)}
        joints = [replace(joint, **order[joint.name]) if joint.name in order else joint for joint in joints]
        # MuJoCo goes through the tree; a joint that it does not have keeps its place at the end.
        joints.sort(key=lambda joint: known.get(joint.name, len(known)))
    return RobotView(
        name=document.root.get("name") or "",
        path=files[0].path,
        format=ModelFormat.URDF,
        joints=tuple(joints),
        inertia=masses,
        inertia_reason=reason,
        files=tuple(files),
        diagnostics=tuple(out),
        refusal=refusal,
        refused_at=refused_at,
        mass=_mass(document),
    )


def _mass(document: XmlDocument) -> float | None:
    """The sum of the masses that links state [kg].

    None where one is no number, and where links that fixed joints hold together have a shape and none has a mass.
    """
    stated: list[str] = []
    shaped: set[str] = set()
    weighed: set[str] = set()
    for link in document.root.children:
        if link.tag == "link":
            masses = [mass for part in link.children if part.tag == "inertial" for mass in part.children]
            stated.extend(own := [mass.get("value") or "" for mass in masses if mass.tag == "mass"])
            if own:
                weighed.add(link.get("name") or "")
            elif any(part.tag in ("visual", "collision") for part in link.children):
                shaped.add(link.get("name") or "")
    held = _held_by(_links(document), lambda joint: joint.get("type") == "fixed") if shaped else {}
    if {held.get(link, link) for link in shaped} - {held.get(link, link) for link in weighed}:
        return None
    return sum(map(float, stated)) if all(NUMBER.fullmatch(text.strip()) for text in stated) else None


def _held_by(links: Mapping[str, tuple[Element, str]], holds: Callable[[Element], bool]) -> dict[str, str]:
    """Each link that hangs on joints that hold it, with the first above it that does not; a circle ends where it
    closes.
    """
    found: dict[str, str] = {}
    for link in links:
        way: dict[str, None] = {}
        while link in links and link not in found and link not in way and holds(links[link][0]):
            way[link] = None
            link = links[link][1]
        found.update(dict.fromkeys(way, found.get(link, link)))
    return found


def _joints(document: XmlDocument, out: Collector) -> list[JointView]:
    found: list[JointView] = []
    names: dict[str, Element] = {}
    planar: list[str] = []
    unnamed = 0
    for element in document.root.children:
        if element.tag != "joint":
            continue
        name = element.get("name")
        span = document.span(element)
        if not name:
            unnamed += 1
            continue
        if name in names:
            first = document.span(names[name])
            out.error(
                "ROBOT121",
                f"a second joint has this name; the first is in line {first.line}",
                where=name,
                span=span,
            )
            continue
        names[name] = element
        kind = element.get("type") or ""
        if kind not in _TYPES:
            out.error(
                "ROBOT122",
                f"type {in_quotes(kind)} is not a URDF joint type",
                where=name,
                span=span,
                help=f"did you mean {nearest(kind, _TYPES) or listed(_TYPES)}?",
            )
        elif kind == "planar":
            planar.append(name)
        elif kind != "fixed":
            found.append(_joint(element, name, kind, document, out))
    if unnamed:
        out.info(
            "ROBOT113",
            f"{many(unnamed, 'joint')} without a name left out",
            span=document.span(document.root),
        )
    if planar:
        out.info("ROBOT113", f"planar joints left out: {listed(planar)}", span=document.span(document.root))
    balls = [joint.name for joint in found if joint.kind is JointKind.BALL]
    if balls:
        message = f"spherical joints, which not every reader of URDF knows: {listed(balls, 3)}"
        out.info("ROBOT113", message, span=document.span(document.root))
    _zero_limits(found, out)
    found = _with_parents(found, document)
    for joint in found:
        if joint.mimic is not None and joint.mimic not in names:
            out.warning(
                "ROBOT124",
                f"mimics {in_quotes(joint.mimic)}, which is not a joint",
                where=joint.name,
                span=joint.span,
            )
    return found


MOST_IN_CHAIN = 1000
"""Chosen: links one behind the other. MuJoCo takes 2 s for so many, and a minute for three times as many."""


def _check_depth(document: XmlDocument, out: Collector) -> None:
    """Report a chain of links that is too long."""
    links = _links(document)
    depths: dict[str, int] = {}
    for link in links:
        way = []
        while link in links and link not in depths:
            # A circle ends where it closes.
            depths[link] = 0
            way.append(link)
            link = links[link][1]
        depth = depths.get(link, 0)
        for one in reversed(way):
            depth += 1
            depths[one] = depth
            if depth > MOST_IN_CHAIN:
                message = f"more than {MOST_IN_CHAIN} links in a chain"
                out.error("ROBOT002", message, where=one, span=document.span(links[one][0]))
                return


def _links(document: XmlDocument) -> dict[str, tuple[Element, str]]:
    """Child link to the joint that moves it, and to its parent link; the first joint of a link counts."""
    links: dict[str, tuple[Element, str]] = {}
    for element in document.root.children:
        if element.tag == "joint":
            ends = {part.tag: part.get("link") or "" for part in reversed(element.children)}
            if ends.get("child"):
                links.setdefault(ends["child"], (element, ends.get("parent", "")))
    return links


def _with_parents(joints: list[JointView], document: XmlDocument) -> list[JointView]:
    """Each joint with the one that it hangs on, over fixed and floating ones; a circle ends where it closes."""
    links = _links(document)
    moving = {joint.name for joint in joints if joint.kind is not JointKind.FREE}
    held = _held_by(links, lambda joint: (joint.get("name") or "") not in moving)
    found = []
    for joint in joints:
        link = links[joint.body][1] if joint.body in links else ""
        above = links.get(held.get(link, link))
        moved = "" if above is None else above[0].get("name") or ""
        found.append(replace(joint, parent=moved if moved in moving and moved != joint.name else ""))
    return found


def _joint(element: Element, name: str, kind: str, document: XmlDocument, out: Collector) -> JointView:
    parts = {child.tag: child for child in reversed(element.children)}
    limit, dynamics, mimic = parts.get("limit"), parts.get("dynamics"), parts.get("mimic")
    span = document.span(element)

    def number(part: Element | None, attribute: str) -> float | None:
        text = part.get(attribute) if part is not None else None
        if part is None or text is None:
            return None
        if not NUMBER.fullmatch(text.strip()):
            out.error(
                "ROBOT120",
                f"<{part.tag} {attribute}> must be a number, got {in_quotes(text)}",
                where=name,
                span=document.span(part),
                help=f"this is a xacro, which is not expanded here: {EXPAND}" if "${" in text else None,
            )
            return None
        return float(text)

    lower, upper = number(limit, "lower"), number(limit, "upper")
    effort, velocity = number(limit, "effort"), number(limit, "velocity")
    damping, friction = number(dynamics, "damping"), number(dynamics, "friction")
    joint_kind = _KINDS[kind]
    place = document.span(limit) if limit is not None else span
    values = {
        "damping": damping, "frictionloss": friction, "effort": effort, "velocity": velocity,
        "range": lower if lower is not None else upper,
    }  # fmt: skip
    stated = {field for field, value in values.items() if value is not None}
    places = {
        field: document.span(part)
        for part, names in ((limit, ("effort", "velocity", "range")), (dynamics, ("damping", "frictionloss")))
        for field in names
        if part is not None and field in stated
    }
    _judge_limit(effort, velocity, joint_kind, name, place, out)
    child = parts.get("child")
    return JointView(
        name=name,
        kind=joint_kind,
        span=span,
        body=(child.get("link") or "") if child is not None else "",
        range=_range(lower, upper, kind, name, place, out),
        damping=damping or 0.0,
        frictionloss=friction or 0.0,
        effort_range=_effort_range(effort),
        velocity_limit=velocity if velocity is not None and 0.0 <= velocity < math.inf else None,
        stated=frozenset(stated),
        mimic=mimic.get("joint") if mimic is not None else None,
        places=places,
    )


def _judge_limit(
    effort: float | None, velocity: float | None, kind: JointKind, name: str, span: Span, out: Collector
) -> None:
    for what, value, unit in zip(("effort", "velocity"), (effort, velocity), _UNITS[kind], strict=True):
        if value is not None and value < 0:
            # SDF writes no limit so.
            report, way = (out.info, ", which is no limit in SDF") if value == -1.0 else (out.warning, "")
            message = f"limit {what} must be >= 0 {unit}, got {format_number(value)}{way}; judged as no limit"
            report("ROBOT123", message, where=name, span=span)


def _zero_limits(joints: Sequence[JointView], out: Collector) -> None:
    """Warn of limits of 0, once for all joints that have them: a hand has one figure on each."""
    for at, (what, why, help) in enumerate(_ZERO):
        alike: dict[str, list[JointView]] = {}
        for joint in joints:
            if (joint.effort_range == (0.0, 0.0), joint.velocity_limit == 0.0)[at]:
                alike.setdefault(_UNITS[joint.kind][at], []).append(joint)
        for unit, having in alike.items():
            count = f" at {len(having)} joints" if len(having) > 1 else ""
            message = f"limit {what} is 0 {unit}{count}: {why}"
            where = listed((joint.name for joint in having), 3)
            out.warning("ROBOT125", message, where=where, span=having[0].places[what], help=help)


_ZERO = (
    (
        "effort",
        "MuJoCo reads it as no limit, other importers as a dead joint",
        "state the actuator's limit, or leave the attribute out",
    ),
    (
        "velocity",
        "importers disagree whether that is no limit or a locked joint",
        "state the joint's limit, or leave the attribute out",
    ),
)
"""Limits of a URDF, what it makes of 0, and what to write."""


def _effort_range(effort: float | None) -> tuple[float, float] | None:
    if effort is None or not 0.0 <= effort < math.inf:
        return None
    return 0.0 - effort, effort


def _range(
    lower: float | None, upper: float | None, kind: str, name: str, span: Span, out: Collector
) -> tuple[float, float] | None:
    if kind not in ("revolute", "prismatic") or (lower is None and upper is None):
        return None
    low, high = lower or 0.0, upper or 0.0
    if low > high:
        # Bullet's own files write it so, and its importer frees a joint whose limits are the wrong way round.
        free = (low, high) == (1.0, -1.0)
        report, way = (out.info, ", as Bullet's files free a joint") if free else (out.warning, "")
        message = (
            f"limit lower {format_number(low)} is above upper {format_number(high)}{way}; "
            "MuJoCo and Bullet take it as no limit"
        )
        report("ROBOT123", message, where=name, span=span)
    return (low, high) if low < high and (low > -math.inf or high < math.inf) else None


def _order(model: mujoco.MjModel) -> dict[str, dict[str, Any]]:
    """Fields of a view that only the whole tree tells, by joint in MuJoCo's order."""
    import mujoco

    from actspec.robot.compiled import joint_axes

    free = (int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL))
    axes = joint_axes(model, in_world=True)
    found = {}
    for index in range(model.njnt):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, index)
        if name:
            scalar = int(model.jnt_type[index]) not in free
            position = float(model.qpos0[model.jnt_qposadr[index]]) if scalar else 0.0
            dof = int(model.jnt_dofadr[index])
            found[name] = {"dof": dof, "reference_position": position, "tree": 0, **axes[index]}
    return found
