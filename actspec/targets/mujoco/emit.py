"""The MuJoCo target: a robot's MJCF with the spec's actuators, and the proof that it is the plan."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import (
    Collector,
    Diagnostic,
    EmitError,
    Place,
    RobotError,
    Severity,
    Span,
    listed,
    many,
    nearest,
    one_line,
)
from actspec.fields import is_placeholder
from actspec.ir import ActuatorSet
from actspec.robot.assets import STAND_IN, base_name
from actspec.robot.load import names_in
from actspec.robot.mjspec import compile_spec, open_spec
from actspec.robot.read_mjcf import read_mjcf
from actspec.robot.view import ModelFile, ModelFormat, RobotView
from actspec.robot.xml import parse_document
from actspec.robot.xml_edit import InsertBefore, SetAttribute, apply_edits
from actspec.simulators import DEFAULT_VERSIONS, text_of
from actspec.simulators.mujoco import KEYFRAME_ACT, MujocoDialect, installed_dialect
from actspec.targets.base import NOT_LOADED, Emission, EmittedFile, PathError, TargetOptions
from actspec.targets.check import mujoco_row
from actspec.targets.kit.joint import unlimited_joints
from actspec.targets.mujoco.apply_spec import apply_to_spec
from actspec.targets.mujoco.apply_text import Anchors, find_anchors, header, text_edits, users_of
from actspec.targets.mujoco.check import check_readback, differences, outside_plan
from actspec.targets.mujoco.drive import Form
from actspec.targets.mujoco.networks import runtime_files
from actspec.targets.mujoco.paths import (
    layout,
    not_there,
    package_of,
    packages_named,
    unread,
    unresolved,
    written_files,
)
from actspec.targets.mujoco.plan import Plan, integrator_for, plan_model, unchanged_controls, with_keys

if TYPE_CHECKING:
    import mujoco

    from actspec.robot.xml_tree import XmlDocument

REPORT = "this is an error of the compiler: please report it with the spec and the model"


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Compile a robot's actuators into its MJCF, or without a model into a fragment that one includes.

    The plan is applied twice, to the loaded MjSpec and to the author's text; the two compiled models
    must be equal in every field, and equal to the original in every field that the plan leaves. A
    fragment is held to the plan in a bench, a model with the listed joints alone.

    See `choose.Emit`.
    """
    collector = Collector()
    dialect = mujoco_row(options, collector)
    installed = installed_dialect()
    if "version" not in (options.spans or {}) and options.version == DEFAULT_VERSIONS["mujoco"]:
        _say_which_loads(dialect, installed, options, collector)
    if robot.format is ModelFormat.NONE:
        return _emit_fragment(actuators, robot, dialect, options, collector)
    given, source, packages = robot.path, os.path.basename(robot.path), robot.packages
    author = parse_document(robot.files)
    is_urdf = robot.format is ModelFormat.URDF
    if options.canonical or is_urdf:
        robot = canonical_files(robot, collector)
    document = parse_document(robot.files)
    place = collector.at("robot.model", Span(given))
    _say_lacking_meshes(document, packages, place)
    _say_unused_packages(document, author, packages, place)
    _say_missing_meshes(document, packages, place, is_urdf)
    _say_unread_meshes(document, author, packages, collector)
    bare, lost = plan_model(actuators, robot, dialect, options.name, collector)
    collector.raise_if_failed(EmitError)
    bare = replace(bare, integrator=integrator_for(actuators, robot, document, collector))

    original = compiled_model(robot.files)
    plan = with_keys(bare, robot, original, unchanged_controls(bare, robot))
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
        collector.at("", Span(robot.path)).warning(
            "MJC021",
            f"keyframes of MuJoCo {dialect.text} cannot hold a filter's state beside a dcmotor: it starts at 0",
            f"reset with actspec.runtime.reset, or compile for MuJoCo {text_of(KEYFRAME_ACT)} or later",
        )

    edited = _edited(robot.files, plan, installed, f"actspec {actuators.robot}", anchors.explicit)
    strayed = outside_plan(original, edited, plan, robot)
    if strayed:
        collector.error(
            "MJC090", f"the edit reaches fields outside of its plan: {listed(strayed, 4)}", help=REPORT
        )
    main_name = f"{os.path.splitext(os.path.basename(robot.path))[0]}.xml"
    comment = header(actuators, lost, dialect, source)
    files = _write(document, plan, anchors, dialect, options.folder, main_name, packages, comment, collector)
    # Another dialect's words cannot be compiled here: the same plan in the installed one is checked.
    checked = (
        files
        if dialect.words == installed.words
        else _write(
            document, plan, anchors, installed, options.folder, main_name, packages, comment, collector
        )
    )
    check_written(checked, edited, actuators, collector)
    emitted = tuple(
        EmittedFile(os.path.basename(file.path), file.data)
        for file in files
        if os.path.dirname(file.path) == options.folder
    )
    step = actuators.physics_dt.require()
    emitted += tuple(runtime_files(actuators, plan.drives, main_name, step, collector))
    collector.raise_if_failed(EmitError)
    # Its Euler integrator takes joint damping implicitly, and nothing of an actuator.
    euler = robot.integrator == "Euler" and plan.integrator is None
    explicit = frozenset(drive.joint for drive in plan.drives) if euler else frozenset()
    return Emission(emitted, lost, collector.sorted(), explicit, _unlimited(actuators, robot, plan))


def _unlimited(actuators: ActuatorSet, robot: RobotView, plan: Plan) -> frozenset[str]:
    """Joints without any limit; that of the file's own actuator is kept where the spec's is unknown."""
    return unlimited_joints(actuators, robot) & {
        d.joint for d in plan.drives if d.effort_limit is None or is_placeholder(d.effort_limit)
    }


def _say_lacking_meshes(document: XmlDocument, packages: Mapping[str, str], place: Place) -> None:
    """Report meshes that are named by package and not found."""
    strange, absent = unresolved(document, packages)
    if strange:
        near = {name: nearest(name, list(packages)) for name in dict.fromkeys(map(package_of, strange))}
        meant = [f"`{name}` for `{key}`" for name, key in near.items() if key is not None]
        help = f"did you mean {listed(meant, 4)} in `robot.packages` or --package?"
        if len(meant) != len(near):
            help = (
                "name its folder in `robot.packages: {NAME: folder}` or with --package NAME=FOLDER, or keep the URDF "
                "inside the folder of its package, which has the package's name or its package.xml"
            )
        place.warning(
            "MJC029",
            f"MuJoCo cannot open {_meshes(strange)} of a package in whose folder the model does not lie: "
            f"{listed(strange, 4)}",
            help,
        )
    if absent:
        one = len(absent) == 1
        place.warning(
            "MJC029",
            f"{_meshes(absent)} {'is' if one else 'are'} not in the folder of {'its' if one else 'their'} package, and "
            f"MuJoCo cannot open: {listed(absent, 4)}",
            _near(absent) or _looked_in(absent),
        )


def _say_unused_packages(
    document: XmlDocument, author: XmlDocument, packages: Mapping[str, str], place: Place
) -> None:
    """Report packages that no file of the model is named by; of a mesh that is not found it is said there."""
    named = packages_named(author)
    told = frozenset(map(package_of, unresolved(document, packages)[0]))
    for name in sorted(packages.keys() - named):
        guess = nearest(name, sorted(named - packages.keys()))
        if guess not in told:
            place.collector.add(
                Diagnostic(
                    "MJC035",
                    Severity.WARNING if guess else Severity.INFO,
                    f"the model names no file by the package '{name}', which `robot.packages` or --package has",
                    place.where,
                    place.span,
                    f"did you mean '{guess}'?" if guess else None,
                )
            )


def _say_missing_meshes(
    document: XmlDocument, packages: Mapping[str, str], place: Place, is_urdf: bool
) -> None:
    """Report meshes that a model names by path and that are not there: what is written does not load without them.

    Of an MJCF, whose own paths are kept, that is of the place where it is compiled, and is told as such.
    """
    lost = not_there(document)
    if not is_urdf:
        # What it cannot read needs another name first (MJC034).
        lost = {name: folder for name, folder in lost.items() if name not in unread(document, packages)}
    if not lost:
        return
    which = "which is not there" if len(lost) == 1 else "which are not there"
    message = f"MuJoCo cannot open {_meshes(lost)}, {which}: {listed(lost, 4)}"
    if not is_urdf:
        it = "it" if len(lost) == 1 else "them"
        message += f"; without {it} it loads neither the model nor what is written"
        place.info("MJC029", message, _near(lost) or _looked_in(lost))
    else:
        folder = (
            f"{_looked_in(lost)}; put them there, or name the folder that {one_line(next(iter(lost)))} is below in "
            'the URDF: `<mujoco><compiler meshdir="FOLDER"/></mujoco>`'
        )
        place.warning("MJC029", message, _near(lost) or folder)


def _say_unread_meshes(
    document: XmlDocument, author: XmlDocument, packages: Mapping[str, str], collector: Collector
) -> None:
    """Report meshes that MuJoCo cannot read, at the first of them in the author's text; what is only seen may be none.

    Args:
        document: What is written: of a URDF MuJoCo's own form.
        author: The robot's files.
        packages: Package to its folder, as the spec has them.
        collector: Takes the diagnostic.
    """
    lost = unread(document, packages)
    if not lost:
        return
    named = frozenset(map(base_name, lost))
    # The same file may be seen first, which MuJoCo leaves out.
    solid = (mesh for shape in author.walk("collision") for form in shape.children for mesh in form.children)
    meshes = (
        e
        for e in (*solid, *author.walk("mesh"))
        if base_name(e.get("filename") or e.get("file") or "") in named
    )
    place = author.span(next(meshes, author.root))
    endings = dict.fromkeys(os.path.splitext(name)[1] or "file without an ending" for name in lost)
    no = listed(f"{end} (COLLADA)" if end.lower() == ".dae" else one_line(end) for end in endings)
    there = [one_line(base_name(other)) for other in lost.values() if other]
    it, that = ("it", "that") if len(lost) == 1 else ("them", "those")
    help = f"convert {it} to .obj or .stl beside {it}, and name {that} in {one_line(place.path)}"
    if there:
        help = f"name {listed(there, 4)}, which {'is' if len(there) == 1 else 'are'} there, in {one_line(place.path)}"
        help += "; convert the others to .obj or .stl" * (len(there) < len(lost))
    collector.at("robot.model", place).warning(
        NOT_LOADED,
        f"MuJoCo reads .obj, .stl and .msh, and no {no}: it does not load what is written, for {_meshes(lost)}: "
        f"{listed(map(one_line, lost), 4)}",
        help,
    )


def _near(lacking: Mapping[str, str]) -> str:
    """What may be meant by files that are not in their folders; "" where nothing is near."""
    guesses = {
        os.path.basename(name): nearest(os.path.basename(name), names_in(at)) for name, at in lacking.items()
    }
    meant = [f"'{guess}' for '{name}'" for name, guess in guesses.items() if guess is not None]
    return f"did you mean {listed(meant, 4)}?" if meant else ""


def _looked_in(lacking: Mapping[str, str]) -> str:
    return f"looked in {listed(dict.fromkeys(lacking.values()), 4)}"


def _meshes(names: Collection[str]) -> str:
    return f"{len(names)} mesh file{'s' * (len(names) > 1)}"


def _say_which_loads(
    dialect: MujocoDialect, installed: MujocoDialect, options: TargetOptions, collector: Collector
) -> None:
    """A version that nobody stated may be one whose words the MuJoCo that is here does not know."""
    if installed.version < dialect.version and installed.words != dialect.words:
        collector.at(f"targets.{options.name}").info(
            "MJC032",
            f"no version is stated: it is written for MuJoCo {dialect.text} and later, and {installed.text}, which is "
            "installed, may not load it",
            f'state `version: "{installed.text}"`, or compile with --target {options.name}=={installed.text}',
        )


def _emit_fragment(
    actuators: ActuatorSet,
    robot: RobotView,
    dialect: MujocoDialect,
    options: TargetOptions,
    collector: Collector,
) -> Emission:
    """The fragment for a robot without a model, after a bench that includes it: the first file loads alone."""
    from actspec.targets.mujoco.fragment import bench_xml, fragment_files, fragment_of

    if options.canonical:
        collector.at("robot.model").error(
            "MJC009",
            "`--canonical` writes MuJoCo's own form of a model, and the spec has `model: none`",
            "leave it out: a fragment to include is written, or name an MJCF or a URDF",
        )
        raise EmitError(collector.sorted())
    plan, lost = plan_model(actuators, robot, dialect, options.name, collector)
    fragment = fragment_of(plan, lost, actuators, collector)
    installed = installed_dialect()
    try:
        bare = ModelFile(robot.path, "", bench_xml(robot, {}).encode("utf-8"))
        files, checked = (
            fragment_files(fragment, robot, words, options.folder) for words in (dialect, installed)
        )
    except ValueError as err:
        collector.at("robot.joints").error(
            "MJC024",
            f"the fragment cannot be written: {err}",
            "rename the joint, in the spec and in the model",
        )
        raise EmitError(collector.sorted()) from err
    edited = _edited((bare,), fragment.plan, installed, f"actspec {actuators.robot}", True)
    check_written(checked, edited, actuators, collector)
    collector.at("robot.model", Span(robot.path)).info(
        "MJC023",
        f"the spec has `model: none`: {fragment.main_name} is no model but a fragment to include in one; "
        "its head says how",
    )
    emitted = tuple(EmittedFile(os.path.basename(file.path), file.data) for file in files)
    step = actuators.physics_dt.require()
    emitted += tuple(runtime_files(actuators, fragment.plan.drives, fragment.main_name, step, collector))
    collector.raise_if_failed(EmitError)
    return Emission(emitted, lost, collector.sorted(), unlimited=_unlimited(actuators, robot, plan))


def compiled_model(files: Sequence[ModelFile]) -> mujoco.MjModel:
    """An MJCF compiled with stand-ins for meshes, as all checks here see it."""
    return compile_spec(open_spec(files, format=ModelFormat.MJCF), files)


def _edited(
    files: Sequence[ModelFile], plan: Plan, dialect: MujocoDialect, note: str, explicit: bool
) -> mujoco.MjModel:
    spec = open_spec(files, format=ModelFormat.MJCF)
    apply_to_spec(spec, plan, dialect, note, explicit=explicit)
    try:
        return compile_spec(spec, files)
    except RobotError as err:
        # The file's own model has compiled: what it says is right.
        item = err.diagnostics[0]
        message = f"the edited model does not compile: {item.message}"
        raise EmitError.of("MJC091", message, where=item.where, help=REPORT) from err


def _write(
    document: XmlDocument,
    plan: Plan,
    anchors: Anchors,
    dialect: MujocoDialect,
    folder: str,
    main_name: str,
    packages: Mapping[str, str],
    comment: str,
    collector: Collector,
) -> tuple[ModelFile, ...]:
    """The edited text, all files of the model, in one dialect."""
    edits = text_edits(document, plan, anchors, dialect)
    try:
        where = layout(document, edits, folder, main_name, packages)
        edited = apply_edits(document, [InsertBefore(document.root, comment), *edits, *where.edits])
    except ValueError as err:
        collector.at("", Span(document.files[0].path)).error(
            "MJC008",
            f"the text cannot be edited: {err}",
            err.HELP
            if isinstance(err, PathError)
            else "use `--canonical` to write MuJoCo's own form of the model",
        )
        raise EmitError(collector.sorted()) from err
    return written_files(document, edited, where, folder)


def check_written(
    files: tuple[ModelFile, ...], edited: mujoco.MjModel, actuators: ActuatorSet, collector: Collector
) -> None:
    """Hold what is written to the edited model, and what is read back from it to the spec.

    Args:
        files: A model as it will stand, in the installed MuJoCo's words.
        edited: The model that it has to be.
        actuators: What the spec asks for.
        collector: Takes the differences.

    Raises: EmitError: there are some.
    """
    _check_text(files, edited, collector)
    collector.raise_if_failed(EmitError)
    for fault in check_readback(actuators, read_mjcf(files, inertia=False)):
        collector.add(fault)
    collector.raise_if_failed(EmitError)


def _check_text(files: tuple[ModelFile, ...], edited: mujoco.MjModel, collector: Collector) -> None:
    """The written text must be the edited model, in every field."""
    try:
        written = compiled_model(files)
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


def canonical_files(robot: RobotView, collector: Collector) -> RobotView:
    """The same robot as one MJCF in MuJoCo's own form, read again.

    From 3.16 on MuJoCo saves what the author wrote, to the last digit; before, it saves the compiled
    model with six digits, which is reported.

    Raises:
        RobotError: MuJoCo cannot open or compile the model.
    """
    from actspec.robot.assets import mesh_dependence
    from actspec.robot.mjspec import compile_spec, nameless_shapes, open_spec, open_urdf, quiet

    files: Sequence[ModelFile] = robot.files
    if robot.format is ModelFormat.URDF:
        spec, files = open_urdf(files)
    else:
        spec = open_spec(files, format=robot.format)
    discarded = bool(spec.compiler.discardvisual)
    exact = hasattr(spec.compiler, "savecanonical")
    if exact:
        spec.compiler.savecompiled = False
        spec.compiler.savecanonical = False
    else:
        collector.at("", Span(robot.path)).warning(
            "MJC014",
            "this MuJoCo saves numbers with six digits; 3.16 and later keep them all",
            "pip install --upgrade mujoco",
        )
        meshes = mesh_dependence(spec, written=True)
        if meshes is not None:
            spec = open_spec(files, format=robot.format, real_assets=True)
    compile_spec(spec, files)
    with quiet():
        text = spec.to_xml()
    path = f"{os.path.splitext(robot.path)[0]}.xml"
    main = ModelFile(path, "", text.encode("utf-8"))
    document = parse_document((main,))
    stood_in = (mesh for mesh in document.walk("mesh") if (mesh.get("file") or "").endswith(STAND_IN))
    names = [SetAttribute(mesh, "file", (mesh.get("file") or "").removesuffix(STAND_IN)) for mesh in stood_in]
    (main,) = apply_edits(document, names)
    view = read_mjcf((main,), inertia=False)
    if robot.format is ModelFormat.URDF:
        speeds = any(joint.velocity_limit is not None for joint in robot.joints)
        author = parse_document(robot.files)
        visual = len(list(author.walk("visual"))) if discarded else 0
        nameless = nameless_shapes(author)
        collector.at("", Span(robot.path)).info(
            "MJC015",
            "the URDF is written as an MJCF: its base is fixed to the world, as MuJoCo reads it"
            + (", and its velocity limits have no place there" if speeds else "")
            + (
                f"; {visual} visual{'s' * (visual > 1)} {'is' if visual == 1 else 'are'} left out"
                if visual
                else ""
            )
            + (
                f"; {many(len(nameless), 'shape')} called as one before, in line {nameless[0].line} "
                f"'{one_line(nameless[0].get('name') or '')}', {'has' if len(nameless) == 1 else 'have'} no name there"
                if nameless
                else ""
            ),
            'to keep what is only seen, write `<mujoco><compiler discardvisual="false"/></mujoco>` into the URDF'
            if visual
            else None,
        )
    # Of what is written nobody has a file yet.
    return replace(view, path=robot.path)
