"""Every robot file that we have: imported, compiled as imported and as servos, and compared line by line.

The files are those below ACTSPEC_CORPUS (default: `shared/corpus` beside the repository) and the
MJCFs of the mjlab distribution, where there is one.
"""

from __future__ import annotations

import difflib
import os
import re
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import pytest

from actspec import api
from actspec.diagnostics import ActspecError, Severity
from actspec.ir import JointKind
from actspec.readings.dynamics import JointDynamics
from actspec.readings.joint import read_joint
from actspec.resolution.quantities import finite_limit
from actspec.robot.load import load_robot
from actspec.robot.view import ModelFormat, RobotView
from actspec.robot.xml import parse_document
from actspec.robot.xml_tree import Element
from actspec.spec.plausible import BY_CODE
from tests.importing import Imported, dynamics, imported

ROOT = Path(__file__).resolve().parents[2]
CORPUS = Path(os.environ.get("ACTSPEC_CORPUS", ROOT.parent / "shared" / "corpus"))

TOLERANCE = 1e-9
"""Relative; computed numbers are written with 12 digits."""

UNREADABLE = {
    "a closing tag whose element is closed already": "not XML",
    "it has no hinge or slide joint with a name: there is nothing to draft": "no robot",
    "the root element is <": "no robot",
}
"""Why a file may not be imported."""

ABSORBED = ("command_low", "command_high")
"""Clamp of a torque motor's command: at its effort limit it is that limit, outside of it nothing."""

NO_GAINS = {
    f"{gain} is unknown, and MuJoCo needs a number: the file has no servo to keep" for gain in ("kp", "kd")
}
"""Why the spec of a model without servos does not compile as it is."""

REFUSED = (
    "MuJoCo refuses the model: URDF joint parent or child missing",
    "MuJoCo refuses the model: error 'inertia must have positive eigenvalues' in fullinertia",
)
"""Why a URDF cannot become an MJCF at all: the file is wrong."""

EDITED = frozenset({"joint", "option", "key", "compiler", "include"})
"""Elements that a plan may edit, beside those in `actuator`."""

COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)


def _files() -> list[Path]:
    found = [path for path in sorted(CORPUS.rglob("*")) if path.suffix in (".xml", ".urdf")]
    try:
        wheel = metadata.distribution("mjlab")
    except metadata.PackageNotFoundError:
        return found
    listed = [file for file in wheel.files or () if file.suffix == ".xml"]
    return found + sorted(Path(str(wheel.locate_file(file))) for file in listed)


FILES = _files()


def _label(path: Path) -> str:
    return "/".join(path.parts[-4:])


@dataclass(frozen=True)
class Case:
    """A file, and what is imported of it.

    Attributes:
        path: The file.
        folder: Where its spec stands.
        robot: The file, read.
        found: The import.
    """

    path: Path
    folder: Path
    robot: RobotView
    found: Imported


@pytest.fixture(scope="module", params=FILES, ids=_label)
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Case:
    """A file and its spec, once for all tests of it; skips what gives none for a reason that we know."""
    path, folder = request.param, tmp_path_factory.mktemp("corpus")
    try:
        return Case(path, folder, load_robot(str(path)), imported([path], folder))
    except ActspecError as err:
        known = [why for text, why in UNREADABLE.items() if text in str(err)]
        assert known, str(err)
        pytest.skip(known[0])


def compiled(text: str, folder: Path, canonical: bool) -> api.Compilation:
    """Compile a spec's text from a folder of its own."""
    spec = folder / "spec.yaml"
    spec.write_text(text, encoding="utf-8")
    return api.compile(spec, output=str(folder / "out"), canonical=canonical)


def written(compilation: api.Compilation, folder: Path) -> dict[str, RobotView]:
    """The robot file of each target, written and read again."""
    found = {}
    for options, emission in zip(compilation.targets, compilation.emissions, strict=True):
        target = folder / "out" / options.name
        for file in emission.files:
            (target / file.path).parent.mkdir(parents=True, exist_ok=True)
            (target / file.path).write_bytes(file.data)
        found[options.name] = load_robot(str(target / emission.files[0].path))
    return found


def reasons(err: ActspecError) -> set[str]:
    """What the errors say, the joints left out."""
    return {
        re.sub(r"^[^:]*: (?=k[pd] is unknown)", "", item.message)
        for item in err.diagnostics
        if item.severity is Severity.ERROR
    }


def servos(text: str, robot: RobotView) -> str:
    """A spec with kp 20 and kd 0.5 for every joint, so that the editor has something to write."""
    slides = any(joint.kind is JointKind.SLIDE for joint in robot.joints)
    kp, kd = ("20", "0.5") if slides else ("20 N*m/rad", "0.5 N*m*s/rad")
    text = re.sub(r"(?m)^    kp: unknown.*$", f"    kp: {kp}", text)
    text = re.sub(r"(?m)^    kd: unknown.*$", f"    kd: {kd}", text)
    return text.replace("    command: effort\n", f"    command: position\n    kp: {kp}\n    kd: {kd}\n")


def effective(robot: RobotView, joint: str) -> dict[str, float]:
    """What acts on a joint."""
    view = robot.joint(joint)
    assert view is not None
    reading = read_joint(robot, joint)
    own = [drive.view for drive in reading.drives]
    limit = finite_limit(reading.drive_limit)
    return {
        "kp": sum(a.kp for a in own),
        "kd": sum(a.kd for a in own),
        "viscous": view.damping + sum(a.gear**2 * a.damping[0] for a in own),
        "coulomb": view.frictionloss,
        "armature": view.armature + sum(a.gear**2 * a.armature for a in own),
        "limit": 0.0 if limit is None else limit.require(),
    }


def check_text(before: RobotView, after: RobotView) -> None:
    """Comments are all there, in order; lines that no edited element is on are there byte for byte."""
    old_lines, new_lines = editable(before), editable(after)
    for index, (old, new) in enumerate(zip(before.files, after.files, strict=True)):
        comments = COMMENT.findall(new.data)
        # The first comment of the main file is actspec's own.
        added = len(comments[0].splitlines()) if index == 0 else 0
        assert (comments[1:] if index == 0 else comments) == COMMENT.findall(old.data)
        first, second = old.data.splitlines(keepends=True), new.data.splitlines(keepends=True)
        if index == 0:
            start = new.data.count(b"\n", 0, new.data.index(comments[0]))
            del second[start : start + added]
        matcher = difflib.SequenceMatcher(None, first, second, autojunk=False)
        for tag, i, j, k, m in matcher.get_opcodes():
            if tag == "equal":
                continue
            for line in range(i, j):
                assert line + 1 in old_lines[index], f"{old.path}: {first[line]!r} is gone"
            for line in range(k, m):
                original = line + 1 + (added if index == 0 and line >= start else 0)
                assert original in new_lines[index], f"{new.path}: {second[line]!r} is new"


def editable(robot: RobotView) -> list[set[int]]:
    """Lines of each file that hold an element which a plan may edit."""
    document = parse_document(robot.files)
    lines: list[set[int]] = [set() for _ in robot.files]

    def add(element: Element, whole: bool) -> None:
        data = robot.files[element.file].data
        end = element.end if whole else element.open_end
        lines[element.file].update(
            range(element.line, element.line + data.count(b"\n", element.start, end) + 1)
        )

    for element in document.walk():
        if element.tag in EDITED:
            add(element, element.tag != "option")
        elif element.tag == "actuator":
            add(element, False)
            last = robot.files[element.file].data.count(b"\n", 0, element.end) + 1
            lines[element.file].add(last)
            for child in element.children:
                add(child, True)
    for include in document.includes:
        add(include.element, True)
    return lines


# Of hundreds of files: not in the quick subset.
pytestmark = [pytest.mark.slow, pytest.mark.skipif(not FILES, reason="no corpus")]


def unlike(one: JointDynamics, other: JointDynamics) -> dict[str, tuple[float | None, float | None]]:
    """Figures in which two joints differ; a figure that one of them lacks is None."""
    found = {}
    for name in {**one.figures, **other.figures}:
        values = [side.figures[name].value if name in side.figures else None for side in (one, other)]
        if values[0] is None or values[1] is None or values[0] != pytest.approx(values[1], rel=TOLERANCE):
            found[name] = (values[0], values[1])
    return {name: pair for name, pair in found.items() if pair != (None, None)}


def outside(joint: JointDynamics) -> bool:
    """Whether the clamp of a torque motor's command never acts before its effort limit."""
    limit = joint.figures["effort_limit"].value
    ends = [joint.figures[name].value for name in ABSORBED if name in joint.figures]
    return limit is not None and all(end is not None and abs(end) >= limit for end in ends)


def test_compiling_an_import_changes_nothing(case: Case) -> None:
    """Compiled as it is, a spec leaves what acts on every joint as it was; else its gains are unknown.

    The one thing that goes is the clamp of a torque motor's command that its effort limit holds already.
    """
    robot, found = case.robot, case.found
    try:
        compilation = compiled(found.draft.text, case.folder, False)
    except ActspecError as err:
        unknown = reasons(err)
        assert not robot.actuators
        assert unknown == NO_GAINS or (len(unknown) == 1 and unknown <= set(REFUSED))
        return
    before = dynamics(case.path)
    for target, after in written(compilation, case.folder).items():
        assert [joint.name for joint in after.joints] == [joint.name for joint in robot.joints]
        assert [a.name for a in after.actuators] == [a.name for a in robot.actuators]
        assert after.timestep == robot.timestep
        if target == "mujoco":
            check_text(robot, after)
        now = dynamics(Path(after.path))
        assert list(now.joints) == list(before.joints)
        for name, old in before.joints.items():
            new = now.joints[name]
            assert new.control == old.control, name
            apart = unlike(old, new)
            if old.control == "motor" and outside(old):
                apart = {field: pair for field, pair in apart.items() if field not in ABSORBED}
            assert apart == {}, (name, found.combined.notes.get(name))


def test_canonical_form_changes_nothing(case: Case) -> None:
    """In MuJoCo's own form what acts on every joint is as it was, too."""
    robot = case.robot
    if robot.format is not ModelFormat.MJCF or not robot.actuators:
        pytest.skip("no MJCF with actuators")
    (after,) = written(compiled(case.found.draft.text, case.folder, True), case.folder).values()
    for joint in robot.joints:
        assert effective(after, joint.name) == pytest.approx(effective(robot, joint.name), rel=TOLERANCE)


def test_an_import_is_plausible(case: Case) -> None:
    """No number of a published robot is doubted."""
    spec = case.folder / "spec.yaml"
    spec.write_text(case.found.draft.text, encoding="utf-8")
    assert [str(item) for item in api.resolve(spec).diagnostics if item.code in BY_CODE] == []


def test_import_as_servos(case: Case) -> None:
    """With gains, every file compiles to servos with these gains; passive values and limits stay."""
    robot, found = case.robot, case.found
    text = servos(found.draft.text, robot)
    if "  mujoco: {" not in text:
        text += '  mujoco: {version: "3.12"}\n'
    for canonical in (False, True):
        try:
            compilation = compiled(text, case.folder, canonical)
        except ActspecError as err:
            assert robot.format is ModelFormat.URDF
            assert reasons(err) <= set(REFUSED)
            continue
        after = written(compilation, case.folder)["mujoco"]
        managed = {actuator.joint for actuator in compilation.actuators.joints}
        assert len(managed) == sum(found.draft.groups.values())
        for joint in robot.joints:
            expected = effective(robot, joint.name)
            if joint.name in managed:
                expected.update(kp=20.0, kd=0.5)
            assert effective(after, joint.name) == pytest.approx(expected, rel=TOLERANCE), joint.name
        if not canonical and robot.format is ModelFormat.MJCF:
            check_text(robot, after)
