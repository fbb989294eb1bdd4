"""MJCF to RobotView: numbers as MuJoCo compiles them, places and classes from the author's text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from math import isnan
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, RobotError, Span
from actspec.ir import JointKind
from actspec.robot.classify import control, transmission
from actspec.robot.mjcf_elements import JointElement, Written, read_elements
from actspec.robot.view import ActuatorView, JointView, ModelFile, ModelFormat, PoseInertia, RobotView

if TYPE_CHECKING:
    import mujoco

    from actspec.robot.xml import Element, XmlDocument

_STATED = {
    "damping": ("damping",),
    "armature": ("armature",),
    "frictionloss": ("frictionloss",),
    "effort": ("actuatorfrcrange", "actuatorfrclimited"),
    "range": ("range", "limited"),
}
"""Field of `JointView.stated` to the attributes that state it."""

_INTEGRATORS = {"mjINT_EULER": "Euler", "mjINT_RK4": "RK4"}


def read_mjcf(
    files: Sequence[ModelFile], document: XmlDocument | None = None, *, inertia: bool = True
) -> RobotView:
    """Read an MJCF.

    Numbers are those that MuJoCo compiles: default classes, includes, degrees, `springdamper` and
    automatic limits are applied. Actuator-level damping and armature stay with the actuator.
    Mesh files are not needed; where a mass comes from them and they are there, they are read.

    Args:
        files: The main file, then its includes in document order.
        document: The same files parsed, if the caller has it.

    Raises: RobotError: MuJoCo refuses the model, or a number in it is nan.
    """
    from actspec.robot.mjspec import compile_spec, mesh_dependence, open_spec
    from actspec.robot.xml import parse_document

    if document is None:
        document = parse_document(tuple(files))
    spec = open_spec(files, format=ModelFormat.MJCF)
    meshes = mesh_dependence(spec)
    if meshes is not None and not meshes.missing:
        spec = open_spec(files, format=ModelFormat.MJCF, real_assets=True)
    said: list[str] = []
    model = compile_spec(spec, files, said=said)

    main = Span(files[0].path)
    out = Collector()
    for text in said:
        out.warning("ROBOT112", f"MuJoCo warns: {text}", span=main)
    written = read_elements(document)
    masses, reason = (
        inertia_of(model, meshes.body if meshes and meshes.missing else None)
        if inertia
        else (None, "not asked for")
    )
    if inertia and masses is None and any(e.get("dampratio") for e in written.actuators):
        out.warning("ROBOT114", f"a dampratio is not resolved: {reason}", span=main)
    joints = _joints(model, spec, written, main)
    unnamed = model.njnt - len(joints)
    if unnamed:
        out.info("ROBOT113", f"{unnamed} joint{'s' * (unnamed > 1)} without a name left out", span=main)
    actuators = tuple(
        _actuator(model, index, element, document, main)
        for index, element in enumerate(_actuator_elements(model, written))
    )
    for actuator in actuators:
        if actuator.transmission == "joint" and not actuator.target:
            what = f"actuator {actuator.name or actuator.index} drives a joint without a name"
            out.info("ROBOT113", what, where=actuator.name, span=actuator.span)
    _refuse_nan((*joints, *actuators), out)
    return RobotView(
        name=spec.modelname,
        path=files[0].path,
        format=ModelFormat.MJCF,
        joints=joints,
        actuators=actuators,
        timestep=float(model.opt.timestep),
        integrator=_integrator(model),
        keyframes=tuple(_object_name(model, "mjOBJ_KEY", i) for i in range(model.nkey)),
        inertia=masses,
        inertia_reason=reason,
        files=tuple(files),
        diagnostics=tuple(out),
    )


def inertia_of(model: mujoco.MjModel, mesh_body: str | None) -> tuple[PoseInertia | None, str]:
    """Mass matrices, or why there are none.

    Args:
        model: Compiled.
        mesh_body: Name of a body whose mass needs mesh files that are not there; None: no such body.
    """
    from actspec.robot.inertia import InertiaUnknown, pose_inertia
    from actspec.robot.mjspec import quiet

    if mesh_body is not None:
        return None, f"the mass of body {mesh_body!r} comes from mesh files that are not there"
    try:
        with quiet():
            return pose_inertia(model), ""
    except InertiaUnknown as err:
        return None, str(err)


def _joints(
    model: mujoco.MjModel, spec: mujoco.MjSpec, written: Written, main: Span
) -> tuple[JointView, ...]:
    import mujoco

    from actspec.robot.inertia import reference_pose

    reference = reference_pose(model)
    kinds = {
        int(mujoco.mjtJoint.mjJNT_HINGE): JointKind.HINGE,
        int(mujoco.mjtJoint.mjJNT_SLIDE): JointKind.SLIDE,
        int(mujoco.mjtJoint.mjJNT_BALL): JointKind.BALL,
        int(mujoco.mjtJoint.mjJNT_FREE): JointKind.FREE,
    }
    found = []
    for index in range(model.njnt):
        name = _object_name(model, "mjOBJ_JOINT", index)
        if not name:
            continue
        dof = int(model.jnt_dofadr[index])
        kind = kinds[int(model.jnt_type[index])]
        scalar = kind in (JointKind.HINGE, JointKind.SLIDE)
        element = written.joint(name)
        authored = spec.joint(name)
        springdamper = authored is not None and bool((authored.springdamper > 0).all())
        view = JointView(
            name=name,
            kind=kind,
            span=element.span if element else written.attachment(name) or main,
            body=_object_name(model, "mjOBJ_BODY", int(model.jnt_bodyid[index])),
            dof=dof,
            range=_pair(model.jnt_range[index]) if model.jnt_limited[index] else None,
            damping=float(model.dof_damping[dof]),
            damping_polynomial=_pair(model.dof_dampingpoly[dof]),
            stiffness=float(model.jnt_stiffness[index]),
            armature=float(model.dof_armature[dof]),
            frictionloss=float(model.dof_frictionloss[dof]),
            effort_range=_pair(model.jnt_actfrcrange[index]) if model.jnt_actfrclimited[index] else None,
            velocity_limit=None,
            stated=frozenset(),
            springdamper=springdamper,
            mimic=None,
            reference_position=float(reference[model.jnt_qposadr[index]]) if scalar else 0.0,
            parent=_parent(model, index),
        )
        found.append(_with_stated(view, element))
    return tuple(found)


def _parent(model: mujoco.MjModel, index: int) -> str:
    """The nearest named joint before this one on the way to the world; "" when there is none."""
    body = int(model.jnt_bodyid[index])
    above = index - 1
    while True:
        first = int(model.body_jntadr[body])
        for joint in range(above, first - 1, -1) if first >= 0 else ():
            name = _object_name(model, "mjOBJ_JOINT", joint)
            if name:
                return name
        if body == 0:
            return ""
        body = int(model.body_parentid[body])
        above = int(model.body_jntadr[body]) + int(model.body_jntnum[body]) - 1


def _with_stated(view: JointView, element: JointElement | None) -> JointView:
    if element is not None:
        stated = {f for f, names in _STATED.items() if not element.stated.isdisjoint(names)}
    else:
        # From an attached model, whose text is not in the document: what is not the engine's
        # default must be stated somewhere.
        values = {
            "damping": view.damping,
            "armature": view.armature,
            "frictionloss": view.frictionloss,
            "effort": view.effort_range,
            "range": view.range,
        }
        stated = {field for field, value in values.items() if value}
    if view.springdamper:
        stated.add("damping")
    return replace(view, stated=frozenset(stated))


def _actuator_elements(model: mujoco.MjModel, written: Written) -> list[Element | None]:
    """The element of each compiled actuator: by order, or by name where copies were made."""
    count = len(model.actuator_trntype)
    names = [_object_name(model, "mjOBJ_ACTUATOR", index) for index in range(count)]
    elements = written.actuators
    if len(elements) == count and all(
        (e.get("name") or "") == n for e, n in zip(elements, names, strict=True)
    ):
        return list(elements)
    named = {e.get("name"): e for e in elements if e.get("name")}
    return [named.get(name) or _copied(name, named) for name in names]


def _copied(name: str, named: dict[str | None, Element]) -> Element | None:
    originals = [key for key in named if key and name.startswith(key)]
    return named[max(originals, key=len)] if originals else None


def _actuator(
    model: mujoco.MjModel, index: int, element: Element | None, document: XmlDocument, main: Span
) -> ActuatorView:
    tag = element.tag if element is not None else ""
    kind = control(model, index, tag)
    transmitted, target = transmission(model, index)
    gear = float(model.actuator_gear[index, 0])
    # From 3.11 on an actuator may have several controls, and its own are found by address.
    address = int(model.actuator_ctrladr[index]) if hasattr(model, "actuator_ctrladr") else index
    limited = 0 <= address < len(model.actuator_ctrllimited) and bool(model.actuator_ctrllimited[address])
    return ActuatorView(
        name=_object_name(model, "mjOBJ_ACTUATOR", index),
        index=index,
        span=document.span(element) if element is not None else main,
        tag=tag,
        transmission=transmitted,
        target=target,
        control=kind.kind,
        gear=gear,
        kp=gear**2 * kind.kp,
        kd=gear**2 * kind.kd,
        gain=kind.gain,
        force_range=_pair(model.actuator_forcerange[index]) if model.actuator_forcelimited[index] else None,
        control_range=_pair(model.actuator_ctrlrange[address]) if limited else None,
        damping=(float(model.actuator_damping[index]), *_pair(model.actuator_dampingpoly[index])),
        armature=float(model.actuator_armature[index]),
        time_constant=kind.time_constant,
        delay=float(model.actuator_delay[index]),
        group=int(model.actuator_group[index]),
        offset=kind.offset,
        line=None if kind.line is None or not gear else (abs(gear) * kind.line[0], kind.line[1] / abs(gear)),
    )


def _refuse_nan(views: tuple[JointView | ActuatorView, ...], out: Collector) -> None:
    """MuJoCo takes `nan` for a number; nothing after this does."""
    for view in views:
        for field in fields(view):
            value = getattr(view, field.name)
            numbers = value if isinstance(value, tuple) else (value,)
            if any(isinstance(number, float) and isnan(number) for number in numbers):
                message = f"{field.name.replace('_', ' ')} must be a number, got nan"
                out.error("ROBOT115", message, where=view.name, span=view.span)
    out.raise_if_failed(RobotError)


def _integrator(model: mujoco.MjModel) -> str:
    import mujoco

    name = str(mujoco.mjtIntegrator(int(model.opt.integrator)).name)
    return _INTEGRATORS.get(name, name.removeprefix("mjINT_").lower())


def _object_name(model: mujoco.MjModel, kind: str, index: int) -> str:
    import mujoco

    return mujoco.mj_id2name(model, getattr(mujoco.mjtObj, kind), index) or ""


def _pair(values: Any) -> tuple[float, float]:
    return float(values[0]), float(values[1])
