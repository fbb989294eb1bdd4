"""The MuJoCo target: a robot's MJCF with the spec's actuators, and the proof that it is the plan."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import actspec
from actspec.diagnostics import Collector, EmitError, RobotError, Span, listed
from actspec.ir import ActuatorSet
from actspec.robot.view import ModelFile, ModelFormat, RobotView
from actspec.targets.base import Emission, EmittedFile, TargetOptions
from actspec.targets.mujoco.apply_spec import apply_to_spec
from actspec.targets.mujoco.apply_text import Anchors, find_anchors, text_edits, users_of
from actspec.targets.mujoco.canonical import canonical_files
from actspec.targets.mujoco.check import differences, outside_plan
from actspec.targets.mujoco.drive import Form
from actspec.targets.mujoco.header import header
from actspec.targets.mujoco.paths import layout, written_files
from actspec.targets.mujoco.plan import Plan, plan_model, unchanged_controls, with_keys
from actspec.targets.mujoco.readback import check_readback
from actspec.targets.versions import MUJOCO_RELEASES, MujocoDialect, UnknownVersion, mujoco_dialect

if TYPE_CHECKING:
    import mujoco

    from actspec.robot.xml import XmlDocument

REPORT = "this is an error of the compiler: please report it with the spec and the model"


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Compile a robot's actuators into its MJCF.

    The plan is applied twice, to the loaded MjSpec and to the author's text; the two compiled models
    must be equal in every field, and equal to the original in every field that the plan leaves.

    Args:
        actuators: What the spec asks for, resolved against `robot`.
        robot: The robot, read from an MJCF or a URDF.
        options: Version, output folder and form.

    Raises:
        EmitError: the target cannot be written, with every reason.
    """
    from actspec.robot.xml import parse_document

    collector = Collector()
    dialect = _dialect(options, collector)
    if robot.format is ModelFormat.NONE:
        collector.error(
            "MJC009",
            "the MuJoCo target needs a model to edit, and the spec has `model: none`",
            where="robot.model",
            help="name an MJCF or a URDF, or leave the target out",
        )
        raise EmitError(collector.sorted())
    source = os.path.basename(robot.path)
    if options.canonical or robot.format is ModelFormat.URDF:
        robot = canonical_files(robot, collector)
    document = parse_document(robot.files)
    planned = plan_model(actuators, robot, dialect, options.name, collector)
    collector.raise_if_failed(EmitError)

    original = _compiled(robot.files)
    plan = with_keys(planned.plan, robot, original, unchanged_controls(planned.plan, robot))
    anchors = find_anchors(document, robot, plan, collector)
    unlimited = [
        drive.joint for drive in plan.drives if drive.form is Form.DCMOTOR and drive.effort_limit is None
    ]
    if anchors.explicit and unlimited:
        collector.error(
            "MJC019",
            "a dcmotor without effort_limit takes the force range of the file's main default class: "
            f"{listed(unlimited)}",
            help="state effort_limit, or give the class a name",
        )
    clamped = [d.joint for d in plan.drives if d.control_limited and d.form is not Form.DCMOTOR]
    if anchors.inherits_range and clamped:
        collector.error(
            "MJC022",
            f"inheritrange in the file's main default class would override command_range: {listed(clamped)}",
            help="give the class a name",
        )
    collector.raise_if_failed(EmitError)
    plan = users_of(anchors, plan)
    if not plan.holds_act(dialect) and any(key.act for key in plan.keys):
        collector.warning(
            "MJC021",
            f"keyframes of MuJoCo {dialect.text} cannot hold a filter's state beside a dcmotor: it starts at 0",
            span=Span(robot.path),
            help="reset with actspec.runtime.reset, or compile for MuJoCo 3.16 or later",
        )

    installed = installed_dialect()
    edited = _edited(robot.files, plan, installed, f"actspec {actuators.robot}", anchors.explicit)
    strayed = outside_plan(original, edited, plan, robot)
    if strayed:
        collector.error(
            "MJC090", f"the edit reaches fields outside of its plan: {listed(strayed, 4)}", help=REPORT
        )
    main_name = f"{os.path.splitext(os.path.basename(robot.path))[0]}.xml"
    comment = header(
        actuators,
        planned.approximations,
        f"MuJoCo {dialect.text}",
        source,
        f"actspec {actspec.__version__}",
    )
    files = _write(document, plan, anchors, dialect, options.folder, main_name, comment, collector)
    # Another dialect's words cannot be compiled here: the same plan in the installed one is checked.
    checked = (
        files
        if _same_words(dialect, installed)
        else _write(document, plan, anchors, installed, options.folder, main_name, comment, collector)
    )
    _check_text(checked, edited, collector)
    collector.raise_if_failed(EmitError)
    for fault in check_readback(actuators, _read_back(checked)):
        collector.add(fault)
    collector.raise_if_failed(EmitError)
    emitted = tuple(
        EmittedFile(os.path.basename(file.path), file.data)
        for file in files
        if os.path.dirname(file.path) == options.folder
    )
    # Its Euler integrator takes joint damping implicitly, and nothing of an actuator.
    explicit = frozenset(drive.joint for drive in plan.drives) if robot.integrator == "Euler" else frozenset()
    return Emission(emitted, planned.approximations, collector.sorted(), explicit)


def _dialect(options: TargetOptions, collector: Collector) -> MujocoDialect:
    try:
        return mujoco_dialect(options.version)
    except UnknownVersion as err:
        collector.error(
            "MJC007",
            err.message,
            where=options.where("version"),
            span=options.span("version"),
            help=err.help,
        )
        raise EmitError(collector.sorted()) from None


def installed_dialect() -> MujocoDialect:
    """Dialect of the MuJoCo that is installed here; one that is newer than the table counts as its last row."""
    import mujoco

    text = ".".join(mujoco.__version__.split(".")[:2])
    numbers = tuple(int(part) for part in text.split(".") if part.isdigit())
    if numbers > MUJOCO_RELEASES[-1]:
        text = "{}.{}".format(*MUJOCO_RELEASES[-1])
    return mujoco_dialect(text)


def _same_words(target: MujocoDialect, installed: MujocoDialect) -> bool:
    """Whether both versions write a plan in the same words."""
    return (
        target.dcmotor is installed.dcmotor
        and target.native_delay == installed.native_delay
        and target.polynomials == installed.polynomials
        and target.general_input == installed.general_input
        and target.keyframe_act == installed.keyframe_act
    )


def _compiled(files: Sequence[ModelFile]) -> mujoco.MjModel:
    from actspec.robot.mjspec import compile_spec, open_spec

    return compile_spec(open_spec(files, format=ModelFormat.MJCF), files)


def _edited(
    files: Sequence[ModelFile], plan: Plan, dialect: MujocoDialect, note: str, explicit: bool
) -> mujoco.MjModel:
    from actspec.robot.mjspec import compile_spec, open_spec

    spec = open_spec(files, format=ModelFormat.MJCF)
    apply_to_spec(spec, plan, dialect, note, explicit=explicit)
    try:
        return compile_spec(spec, files)
    except RobotError as err:
        raise EmitError(err.diagnostics) from err


def _write(
    document: XmlDocument,
    plan: Plan,
    anchors: Anchors,
    dialect: MujocoDialect,
    folder: str,
    main_name: str,
    comment: str,
    collector: Collector,
) -> tuple[ModelFile, ...]:
    """The edited text, all files of the model, in one dialect."""
    from actspec.robot.xml_edit import InsertBefore, apply_edits

    edits = text_edits(document, plan, anchors, dialect)
    where = layout(document, edits, folder, main_name)
    try:
        edited = apply_edits(document, [InsertBefore(document.root, comment), *edits, *where.edits])
    except ValueError as err:
        collector.error(
            "MJC008",
            f"the text cannot be edited: {err}",
            span=Span(document.files[0].path),
            help="use `--canonical` to write MuJoCo's own form of the model",
        )
        raise EmitError(collector.sorted()) from err
    return written_files(document, edited, where, folder)


def _check_text(files: tuple[ModelFile, ...], edited: mujoco.MjModel, collector: Collector) -> None:
    """The written text must be the edited model, in every field."""
    try:
        written = _compiled(files)
    except RobotError as err:
        for item in err.diagnostics:
            collector.error("MJC091", f"the written model does not compile: {item.message}", help=REPORT)
        return
    found = differences(edited, written)
    if found:
        collector.error(
            "MJC091",
            f"the written text differs from the edited model in {len(found)} fields: {listed(found, 4)}",
            help=REPORT,
        )


def _read_back(files: tuple[ModelFile, ...]) -> RobotView:
    from actspec.robot.read_mjcf import read_mjcf

    return read_mjcf(files, inertia=False)
