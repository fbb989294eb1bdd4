"""MJCF to RobotView: numbers as MuJoCo compiles them, places and classes from the author's text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from math import isnan
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, RobotError, Span, listed, many
from actspec.joints import JointKind
from actspec.robot.assets import unknown_inertia
from actspec.robot.attached import attached_models
from actspec.robot.compiled import (
    ModelLists,
    control,
    coupled_joints,
    joint_axes,
    moved_joints,
    named_parents,
    reached_joints,
    robot_mass,
    transmission,
)
from actspec.robot.inertia import POSES, known_inertia, reference_pose
from actspec.robot.mjcf_elements import Written, read_elements
from actspec.robot.turned import report_turned
from actspec.robot.view import ActuatorView, JointView, ModelFile, ModelFormat, RobotView
from actspec.robot.xml_tree import report_behind

if TYPE_CHECKING:
    import mujoco

    from actspec.robot.mjspec import CompiledModel
    from actspec.robot.xml_tree import Element, XmlDocument

_STATED = {
    "damping": ("damping",),
    "armature": ("armature",),
    "frictionloss": ("frictionloss",),
    # 2.3 has the words in full.
    "effort": ("actuatorfrcrange", "actuatorfrclimited", "actuatorforcerange", "actuatorforcelimited"),
    "range": ("range", "limited"),
    "axis": ("axis",),
}
"""Field of `JointView.stated` to the attributes that state it."""

_NUMBERS = (
    "jnt_range", "jnt_actfrcrange", "jnt_stiffness", "dof_damping", "dof_dampingpoly", "dof_armature",
    "dof_frictionloss", "qpos0", "key_qpos", "actuator_gear", "actuator_gainprm", "actuator_biasprm",
    "actuator_dynprm", "actuator_forcerange", "actuator_ctrlrange", "actuator_actrange",
    "actuator_damping", "actuator_dampingpoly", "actuator_armature", "actuator_delay",
)  # fmt: skip
"""Fields of a compiled model that a view is made from."""

_INTEGRATORS = {"mjINT_EULER": "Euler", "mjINT_RK4": "RK4"}


def read_mjcf(
    files: Sequence[ModelFile],
    document: XmlDocument | None = None,
    *,
    inertia: bool = True,
    poses: int = POSES,
    shapes: bool = True,
) -> RobotView:
    """Read an MJCF.

    Numbers are those that MuJoCo compiles: default classes, includes, degrees, `springdamper` and
    automatic limits are applied. Actuator-level damping and armature stay with the actuator.
    Mesh files are not needed; where a mass comes from them and they are there, they are read.

    Args:
        files: The main file, then its includes in document order.
        document: The same files parsed, if the caller has it.
        inertia: Take the mass matrices.
        poses: Sampled poses beside the reference pose.
        shapes: Show MuJoCo geoms that nothing here depends on, too. Without them it takes a third of the
            time, and what it would refuse in them goes unnoticed.

    Raises: RobotError: MuJoCo refuses the model, or a number in it is nan.
    """
    from actspec.robot.mjspec import compiled_model
    from actspec.robot.xml import parse_document

    if document is None:
        document = parse_document(tuple(files))
    compiled = compiled_model(document, ModelFormat.MJCF, shapes=shapes)
    return _view(compiled, document, inertia=inertia, poses=poses)


def read_model(model: mujoco.MjModel, path: str) -> RobotView:
    """Read a model that a program has compiled: its numbers, without the inertia and without places.

    Args:
        model: Compiled.
        path: What it is called in messages.

    Raises: RobotError: a number in it is nan.
    """
    import mujoco

    from actspec.robot.mjspec import CompiledModel
    from actspec.robot.xml import parse_document

    nothing = parse_document((ModelFile(path, "", b"<mujoco/>"),))
    compiled = CompiledModel(mujoco.MjSpec(), model, None, (), ())
    return _view(compiled, nothing, inertia=False, poses=0)


def _view(compiled: CompiledModel, document: XmlDocument, *, inertia: bool, poses: int) -> RobotView:
    spec, model = compiled.spec, compiled.model
    main = Span(document.files[0].path)
    out = Collector()
    for text in compiled.said:
        out.warning("ROBOT112", f"MuJoCo warns: {'; '.join(text.splitlines())}", span=main)
    report_behind(document, out)
    written = read_elements(document, attached_models(document))
    report_turned(written, out)
    masses, reason = known_inertia(model, compiled.meshes, poses) if inertia else (None, "not asked for")
    lists = ModelLists(model)
    weightless = unknown_inertia(model, compiled.meshes)
    ratios = _unknown_ratios(lists, compiled.ratios, weightless)
    joints = _joints(lists, spec, written, main, not reason, weightless)
    unnamed = _unnamed(lists)
    if unnamed:
        out.info("ROBOT113", f"{many(unnamed, 'joint')} without a name left out", span=main)
    switched_off = _switched_off(model)
    actuators = tuple(
        _actuator(lists, index, found, written, main, switched_off, index in ratios)
        for index, found in enumerate(_actuator_elements(lists, written))
    )
    for actuator in actuators:
        if actuator.transmission == "joint" and not actuator.target:
            what = f"actuator {actuator.name or actuator.index} drives a joint without a name"
            out.info("ROBOT113", what, where=actuator.name, span=actuator.span)
    if compiled.meshes is not None:
        for what, names in (
            ("stiffness and damping from springdamper", [j.name for j in joints if "stiffness" in j.unknown]),
            (
                "velocity gains from dampratio",
                [a.name or f"that of {a.target}" for a in actuators if a.index in ratios],
            ),
        ):
            if names:
                message = f"{what} are unknown ({listed(names)}): {compiled.meshes.reason}"
                out.warning("ROBOT114", message, span=main)
    if not _is_finite(model):
        _refuse_nan((*joints, *actuators), out)
    return RobotView(
        name=model.names.split(b"\0", 1)[0].decode(),
        path=main.path,
        format=ModelFormat.MJCF,
        joints=joints,
        actuators=actuators,
        timestep=float(model.opt.timestep),
        integrator=_integrator(model),
        keyframes=tuple(lists.name("mjOBJ_KEY", i) for i in range(model.nkey)),
        pose_at=next(map(document.span, document.keyframes()), None),
        inertia=masses,
        inertia_reason=reason,
        files=document.files,
        diagnostics=tuple(out),
        eulerdamp="EULERDAMP" not in switched_off,
        actuation="ACTUATION" not in switched_off,
        off_groups=_off_groups(model),
        coupled=coupled_joints(lists),
        mass=None if masses is None else robot_mass(lists),
    )


def _unknown_ratios(
    model: ModelLists, ratios: Sequence[tuple[mujoco.MjsActuator, float]], weightless: frozenset[int]
) -> frozenset[int]:
    """Actuators whose velocity gain MuJoCo makes of a damping ratio and an inertia that is unknown."""
    unknown = {model.dof_jntid[dof] for dof in weightless}
    found = set()
    for actuator, ratio in ratios if weightless else ():
        index = actuator.id
        if model.actuator_biasprm[index][2] != ratio:
            moved = moved_joints(model, index, transmission(model, index)[0])
            if moved is None or not unknown.isdisjoint(moved):
                found.add(index)
    return frozenset(found)


def _joints(
    model: ModelLists,
    spec: mujoco.MjSpec,
    written: Written,
    main: Span,
    masses: bool,
    weightless: frozenset[int],
) -> tuple[JointView, ...]:
    import mujoco

    reference = reference_pose(model.model).tolist()
    kinds = {
        int(mujoco.mjtJoint.mjJNT_HINGE): JointKind.HINGE,
        int(mujoco.mjtJoint.mjJNT_SLIDE): JointKind.SLIDE,
        int(mujoco.mjtJoint.mjJNT_BALL): JointKind.BALL,
        int(mujoco.mjtJoint.mjJNT_FREE): JointKind.FREE,
    }
    dofs, limited, effort_limited = model.jnt_dofadr, model.jnt_limited, model.jnt_actfrclimited
    held, mobility = model.dof_M0, model.dof_invweight0
    names = [model.name("mjOBJ_JOINT", index) for index in range(model.model.njnt)]
    parents, axes = named_parents(model, names), joint_axes(model.model)
    found = []
    for index, name in enumerate(names):
        if not name:
            continue
        dof = dofs[index]
        kind = kinds[model.jnt_type[index]]
        scalar = kind.is_scalar
        element, document = written.joint(name) or (None, written.document)
        springdamper = (element is None or "springdamper" in element.owners) and _is_sprung(spec, name)
        # Stiffness and damping are then made of 1/(M^-1)_jj.
        invented = springdamper and dof in weightless
        if element is not None:
            stated, places = stated_fields(element.element, element.owners, document)
        else:
            # From what makes joints that no text names: what is not the engine's default must be stated somewhere.
            values = {
                "damping": model.dof_damping[dof],
                "armature": model.dof_armature[dof],
                "frictionloss": model.dof_frictionloss[dof],
                "effort": effort_limited[index],
                "range": limited[index],
            }
            stated, places = {field for field, value in values.items() if value}, {}
        if springdamper:
            stated.add("damping")
        view = JointView(
            name=name,
            kind=kind,
            span=element.span if element else written.attachment(name) or main,
            body=model.name("mjOBJ_BODY", model.jnt_bodyid[index]),
            dof=dof,
            range=_pair(model.jnt_range[index]) if limited[index] else None,
            damping=0.0 if invented else model.dof_damping[dof],
            damping_polynomial=_pair(model.dof_dampingpoly[dof]),
            stiffness=0.0 if invented else model.jnt_stiffness[index],
            armature=model.dof_armature[dof],
            frictionloss=model.dof_frictionloss[dof],
            effort_range=_pair(model.jnt_actfrcrange[index]) if effort_limited[index] else None,
            stated=frozenset(stated),
            springdamper=springdamper,
            reference_position=reference[model.jnt_qposadr[index]] if scalar else 0.0,
            parent=parents[index],
            places=places,
            unknown=frozenset({"damping", "stiffness"}) if invented else frozenset(),
            axis=axes[index].get("axis"),
            point=axes[index].get("point"),
            tree=int(model.body_rootid[model.jnt_bodyid[index]]),
            # For a hinge or slide MuJoCo's `invweight0` is the diagonal of M^-1 itself.
            zero_inertia=(held[dof], 1.0 / mobility[dof])
            if masses and scalar and mobility[dof] > 0.0
            else None,
        )
        found.append(view)
    return tuple(found)


def _unnamed(model: ModelLists) -> int:
    """Joints without a name; a free one, which has no actuator anyway, is none of them."""
    import mujoco

    free = int(mujoco.mjtJoint.mjJNT_FREE)
    return sum(kind != free and not model.name("mjOBJ_JOINT", i) for i, kind in enumerate(model.jnt_type))


def _is_sprung(spec: mujoco.MjSpec, name: str) -> bool:
    authored = spec.joint(name)
    return authored is not None and bool((authored.springdamper > 0).all())


def stated_fields(
    element: Element, owners: Mapping[str, Element], document: XmlDocument
) -> tuple[set[str], dict[str, Span]]:
    """Fields of `JointView.stated`, and the places of those that a default class states.

    Args:
        element: The joint.
        owners: As in `JointElement`.
        document: What they are in.
    """
    stated, places = set(), {}
    for field, names in _STATED.items():
        for name in names:
            if name in owners:
                stated.add(field)
                if owners[name] is not element:
                    places[field] = document.span(owners[name])
                break
    return stated, places


def _actuator_elements(model: ModelLists, written: Written) -> list[tuple[Element, Written] | None]:
    """The element of each compiled actuator, and its model: by order, or by name where copies or others were made."""
    count = len(model.actuator_trntype)
    names = [model.name("mjOBJ_ACTUATOR", index) for index in range(count)]
    elements = written.actuators
    if len(elements) == count and all(
        (e.get("name") or "") == n for e, n in zip(elements, names, strict=True)
    ):
        return [(element, written) for element in elements]
    return [written.actuator(name) or _copied(name, written) for name in names]


def _copied(name: str, written: Written) -> tuple[Element, Written] | None:
    originals = [
        one for one in written.actuators if one.get("name") and name.startswith(one.get("name") or "")
    ]
    return (max(originals, key=lambda one: len(one.get("name") or "")), written) if originals else None


def _actuator(
    model: ModelLists,
    index: int,
    found: tuple[Element, Written] | None,
    written: Written,
    main: Span,
    switched_off: frozenset[str],
    invented: bool,
) -> ActuatorView:
    tag = found[0].tag if found is not None else ""
    # From 3.11 on an actuator may have several controls, and its own are found by address.
    address = model.actuator_ctrladr[index] if hasattr(model.model, "actuator_ctrladr") else index
    limited = 0 <= address < len(model.actuator_ctrllimited) and bool(model.actuator_ctrllimited[address])
    limited = limited and "CLAMPCTRL" not in switched_off
    seen = control(model, index, tag).at_joint(
        model.actuator_gear[index][0],
        _pair(model.actuator_ctrlrange[address]) if limited else None,
        _pair(model.actuator_actrange[index]) if model.actuator_actlimited[index] else None,
    )
    unknown = frozenset(name for name in ("kp", "kd") if isnan(seen[name]) or (invented and name == "kd"))
    seen.update(dict.fromkeys(unknown, 0.0))
    transmitted, target = transmission(model, index)
    stated, places = stated_attributes(*found) if found is not None else (set(), {})
    group = model.actuator_group[index]
    reached = (model.name("mjOBJ_JOINT", joint) for joint in reached_joints(model, index, transmitted))
    name = model.name("mjOBJ_ACTUATOR", index)
    # From an attached model, as its joint.
    attached = None if found is not None else written.attachment(name) or written.attachment(target)
    return ActuatorView(
        name=name,
        index=index,
        span=found[1].document.span(found[0]) if found is not None else attached or main,
        tag=tag,
        transmission=transmitted,
        target=target,
        **seen,
        force_range=_pair(model.actuator_forcerange[index]) if model.actuator_forcelimited[index] else None,
        damping=(model.actuator_damping[index], *_pair(model.actuator_dampingpoly[index])),
        armature=model.actuator_armature[index],
        delay=model.actuator_delay[index],
        group=group,
        stated=frozenset(stated),
        places=places,
        unknown=unknown,
        disabled="ACTUATION" in switched_off or group in _off_groups(model.model),
        moves=tuple(name for name in reached if name),
    )


def _off_groups(model: mujoco.MjModel) -> frozenset[int]:
    # Groups beyond 30 cannot be switched off.
    bits = int(model.opt.disableactuator)
    return frozenset(group for group in range(31) if bits >> group & 1)


def _switched_off(model: mujoco.MjModel) -> frozenset[str]:
    """What `option/flag` switches off, of what concerns actuators."""
    import mujoco

    bits, flags = mujoco.mjtDisableBit, int(model.opt.disableflags)
    return frozenset(
        name
        for name in ("ACTUATION", "CLAMPCTRL", "EULERDAMP")
        if flags & int(getattr(bits, f"mjDSBL_{name}"))
    )


def stated_attributes(element: Element, written: Written) -> tuple[set[str], dict[str, Span]]:
    """Attributes of an actuator and its default class, and the places of those that the class states.

    A class may also hold an actuator of another tag; its gains are counted, although MuJoCo from 3.16
    on does not pass them on.
    """
    owners, own = written.defaults_of(element).attributes, element.values
    places = {name: written.document.span(other) for name, other in owners.items() if name not in own}
    return {*owners, *own}, places


def _is_finite(model: mujoco.MjModel) -> bool:
    """Whether every number that a view is made from is finite."""
    import numpy as np

    return all(np.isfinite(getattr(model, name)).all() for name in _NUMBERS)


def _refuse_nan(views: tuple[JointView | ActuatorView, ...], out: Collector) -> None:
    """MuJoCo takes `nan` for a number; nothing after this does."""
    for view in views:
        for name in nan_fields(view):
            message = f"{name.replace('_', ' ')} must be a number, got nan"
            out.error("ROBOT115", message, where=view.name, span=view.span)
    out.raise_if_failed(RobotError)


def nan_fields(view: JointView | ActuatorView) -> Iterator[str]:
    """Names of the fields that are, or have in them, no number."""
    for field in fields(view):
        value = getattr(view, field.name)
        numbers = value if isinstance(value, tuple) else (value,)
        if any(isinstance(number, float) and isnan(number) for number in numbers):
            yield field.name


def _integrator(model: mujoco.MjModel) -> str:
    import mujoco

    name = str(mujoco.mjtIntegrator(int(model.opt.integrator)).name)
    return _INTEGRATORS.get(name, name.removeprefix("mjINT_").lower())


def _pair(values: Sequence[float]) -> tuple[float, float]:
    return values[0], values[1]
