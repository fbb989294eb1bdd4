"""The plan applied to the author's text: comments, includes, classes and untouched lines stay; and its head."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from actspec.diagnostics import Collector
from actspec.ir import ActuatorSet, JointActuator, Quantity
from actspec.robot.view import RobotView
from actspec.robot.xml_edit import (
    AppendChild,
    Edit,
    RemoveElement,
    ReplaceElement,
    SetAttribute,
    exact_number,
)
from actspec.robot.xml_tree import Element, XmlDocument
from actspec.simulators.mujoco import MujocoDialect
from actspec.targets.base import Approximation
from actspec.targets.kit.provenance import sections, with_origin, written_by, xml_head
from actspec.targets.kit.python_text import grouped
from actspec.targets.mujoco.actuator_xml import actuator_xml
from actspec.targets.mujoco.plan import JointEdit, Plan

ACTUATOR_TAGS = frozenset(
    {
        "general",
        "motor",
        "position",
        "velocity",
        "intvelocity",
        "damper",
        "cylinder",
        "muscle",
        "adhesion",
        "dcmotor",
        "pid",
        "plugin",
        "orientation",
    }
)


@dataclass(frozen=True, slots=True)
class Anchors:
    """Where a plan's edits go in the text.

    Attributes:
        joints: Joint to its element.
        actuators: Elements of the actuators, in the model's order.
        keys: Elements of the keyframes, in order.
        sensors: Sensors and other elements that name an actuator: (element, attribute).
        explicit: Whether the main default class holds numbers of an actuator.
        inherits_range: Whether one of these is `inheritrange`, which overrides a control range.
    """

    joints: dict[str, Element]
    actuators: tuple[Element, ...]
    keys: tuple[Element, ...]
    sensors: tuple[tuple[Element, str], ...]
    explicit: bool
    inherits_range: bool


def find_anchors(document: XmlDocument, robot: RobotView, plan: Plan, collector: Collector) -> Anchors:
    """Find the elements that a plan edits; those that cannot be edited are errors."""
    joints: dict[str, Element] = {}
    copied: set[str] = set()
    for element, inside in _body_elements(document):
        name = element.get("name")
        if element.tag in ("joint", "freejoint") and name:
            joints[name] = element
            if inside:
                copied.add(name)
    actuators = tuple(child for section in document.sections("actuator") for child in section.children)
    keys = document.keyframes()
    help = "use `--canonical` to write MuJoCo's own, expanded form of the model"
    for edit in plan.joints:
        if edit.joint not in joints or edit.joint in copied:
            joint = robot.joint(edit.joint)
            collector.at(edit.joint, joint.span if joint is not None else None).error(
                "MJC004",
                f"'{edit.joint}' comes from <replicate> or <attach>: its text cannot be edited alone",
                help,
            )
        elif document.is_repeated(joints[edit.joint]):
            collector.at(edit.joint, document.span(joints[edit.joint])).error(
                "MJC005", f"'{edit.joint}' is in a file that is included more than once", help
            )
    if len(actuators) != len(robot.actuators) and (plan.replaced or plan.removed):
        collector.error(
            "MJC006",
            f"the text has {len(actuators)} actuators, the model {len(robot.actuators)}: some come from <replicate> "
            "or <attach>",
            help=help,
        )
    elif plan.replaced and any(document.is_repeated(actuators[r.index]) for r in plan.replaced):
        collector.error("MJC005", "actuators are in a file that is included more than once", help=help)
    if plan.keys and max(key.index for key in plan.keys) >= len(keys):
        collector.error("MJC006", f"the text has {len(keys)} keyframes, the model more", help=help)
    else:
        for key in plan.keys:
            if not all(map(math.isfinite, (*(key.ctrl or ()), *(key.act or ())))):
                collector.at(keys[key.index].get("name") or "", document.span(keys[key.index])).error(
                    "MJC033", "a joint's position or a control in this keyframe is no finite number"
                )
    sensors = []
    for section in (*document.sections("sensor"), *document.sections("custom")):
        for element in _below(section):
            if element.get("actuator") in plan.renamed:
                sensors.append((element, "actuator"))
            if element.get("objtype") == "actuator" and element.get("objname") in plan.renamed:
                sensors.append((element, "objname"))
    defaults = _main_default_actuators(document)
    inherits_range = any(element.get("inheritrange") for element in defaults)
    return Anchors(joints, actuators, keys, tuple(sensors), bool(defaults), inherits_range)


def text_edits(document: XmlDocument, plan: Plan, anchors: Anchors, dialect: MujocoDialect) -> list[Edit]:
    """The plan as edits of the text, in the words of a dialect."""
    edits: list[Edit] = []
    for joint in plan.joints:
        edits += _joint_edits(anchors.joints[joint.joint], joint, dialect)
    for entry in plan.replaced:
        element = anchors.actuators[entry.index]
        edits.append(ReplaceElement(element, actuator_xml(entry.drive, dialect, explicit=anchors.explicit)))
    edits += [RemoveElement(anchors.actuators[index]) for index in plan.removed]
    if plan.added:
        lines = [actuator_xml(drive, dialect, explicit=anchors.explicit) for drive in plan.added]
        sections = [s for s in document.sections("actuator") if not document.is_repeated(s)]
        if sections and sections[-1] is document.sections("actuator")[-1]:
            edits += [AppendChild(sections[-1], line) for line in lines]
        else:
            body = "".join(f"\n  {line}" for line in lines)
            edits.append(AppendChild(document.root, f"<actuator>{body}\n</actuator>"))
    for element, attribute in anchors.sensors:
        edits.append(SetAttribute(element, attribute, plan.renamed[element.get(attribute) or ""]))
    edits += _options(document, plan)
    holds_act = plan.holds_act(dialect)
    if not holds_act:
        edits += [SetAttribute(key, "act", None) for key in anchors.keys if key.get("act") is not None]
    for key in plan.keys:
        element = anchors.keys[key.index]
        for name, values in (("ctrl", key.ctrl), ("act", key.act if holds_act else None)):
            if values is not None:
                text = " ".join(exact_number(value) for value in values)
                edits.append(SetAttribute(element, name, text if values else None))
    return edits


def joint_attributes(edit: JointEdit, damping: int) -> Iterator[tuple[str, str]]:
    """What an edit states of a joint, as attributes.

    Args:
        edit: The edit.
        damping: Coefficients of damping that are written: at most three.
    """
    if edit.springdamper_off:
        yield "springdamper", "0 0"
    for name, value in (
        ("stiffness", edit.stiffness),
        ("damping", edit.damping),
        ("armature", edit.armature),
        ("frictionloss", edit.frictionloss),
    ):
        if value is not None:
            numbers = value[:damping] if isinstance(value, tuple) else (value,)
            yield name, " ".join(map(exact_number, numbers))
    if edit.effort is not None:
        yield "actuatorfrcrange", f"{exact_number(-edit.effort)} {exact_number(edit.effort)}"
        yield "actuatorfrclimited", "true"


def _joint_edits(element: Element, edit: JointEdit, dialect: MujocoDialect) -> Iterator[Edit]:
    # Numbers that are not written come from the class: an author's `0.5 0` keeps its zero.
    stated = len((element.get("damping") or "").split()) > 1 and dialect.polynomials
    whole = stated or (edit.damping is not None and any(edit.damping[1:]))
    for name, text in joint_attributes(edit, 3 if whole else 1):
        yield SetAttribute(element, name, text)


def _options(document: XmlDocument, plan: Plan) -> Iterator[Edit]:
    """Each on the option that states it last, else on the last option, else on a new one."""
    step = None if plan.timestep is None else exact_number(plan.timestep)
    options = document.sections("option")
    new = []
    for name, text in (("timestep", step), ("integrator", plan.integrator)):
        if text is None:
            continue
        stating = [option for option in options if option.get(name) is not None]
        own = [option for option in stating or options if not document.is_repeated(option)]
        if own:
            yield SetAttribute(own[-1], name, text)
        else:
            new.append(f'{name}="{text}"')
    if new:
        yield AppendChild(document.root, f"<option {' '.join(new)}/>")


def _body_elements(document: XmlDocument) -> Iterator[tuple[Element, bool]]:
    """Elements of the body tree, with whether a replicate or attach is above them."""
    stack = [(section, False) for section in document.sections("worldbody")]
    while stack:
        element, inside = stack.pop()
        yield element, inside
        inside = inside or element.tag in ("replicate", "attach")
        stack.extend((child, inside) for child in element.children)


def _below(element: Element) -> Iterator[Element]:
    for child in element.children:
        yield child
        yield from _below(child)


def _main_default_actuators(document: XmlDocument) -> tuple[Element, ...]:
    """Actuators of the main default class; every top-level section adds to it, whatever it is called."""
    return tuple(
        child
        for default in document.sections("default")
        for child in default.children
        if child.tag in ACTUATOR_TAGS
    )


def _user(element: Element) -> tuple[float, ...]:
    try:
        return tuple(float(part) for part in (element.get("user") or "").split())
    except ValueError:
        return ()


def users_of(anchors: Anchors, plan: Plan) -> Plan:
    """The plan with the user data of replaced actuators, which only the text knows."""
    return replace(
        plan,
        replaced=tuple(
            replace(entry, drive=replace(entry.drive, user=_user(anchors.actuators[entry.index])))
            for entry in plan.replaced
        ),
    )


LEFT_OUT = (
    "peak_torque",
    "continuous_torque",
    "torque_constant",
    "reflected_inertia",
    "action_scale",
    "default_position",
)
"""Numbers that MuJoCo's drive and joint are not made of."""


def header(
    actuators: ActuatorSet, approximations: tuple[Approximation, ...], dialect: MujocoDialect, source: str
) -> str:
    """The comment's text, one XML comment.

    Args:
        actuators: What was compiled.
        approximations: What the target lost.
        dialect: MuJoCo version that is written.
        source: File name of the robot's model.
    """
    head = [
        written_by(f" for MuJoCo {dialect.text}"),
        *actuators.spec_lines,
        f"model {source}",
        f"physics_dt {with_origin(actuators.physics_dt)}",
    ]
    joints = [
        (
            f"{group} ({members[0].level.value}, {members[0].command.value}): {', '.join(m.joint for m in members)}",
            lines,
        )
        for (group, *lines), members in grouped(actuators.joints, lambda a: (a.group, *_entries(a)))
    ]
    shown = [actuators.physics_dt, *(q for a in actuators.joints for _, q in _shown(a))]
    said = sections(actuators, approximations, "Approximations (what this target cannot hold):", shown)
    return xml_head(head, [*joints, *said])


def _shown(actuator: JointActuator) -> Iterator[tuple[str, Quantity]]:
    return ((name, quantity) for name, quantity in actuator.quantities() if name not in LEFT_OUT)


def _entries(actuator: JointActuator) -> Iterator[str]:
    delay = actuator.delay
    for name, quantity in _shown(actuator):
        reach = ""
        if name == "delay" and delay is not None and delay.low != delay.high:
            reach = f", range {delay.low * 1e3:g} to {delay.high * 1e3:g} ms"
        if not name.startswith("command_range"):
            yield f"{name} {with_origin(quantity)}{reach}"
    if actuator.command_range is not None:
        low, high = actuator.command_range
        yield f"command_range {with_origin(low)} to {with_origin(high)}"
