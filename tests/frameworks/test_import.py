"""The robots of Isaac Lab and mjlab, imported and compiled back: every figure of every drive is the framework's own."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from actspec import api
from actspec.audit.build import case_of
from actspec.audit.read import read_files
from actspec.diagnostics import ActspecError
from actspec.ir import Level
from actspec.readings.artifact import Artifact, FileKind
from actspec.readings.dynamics import JointDynamics, RobotDynamics, dynamics_of
from actspec.readings.python.read import read_python
from actspec.readings.versions import Versions
from tests.frameworks.prepare import Frameworks
from tests.importing import dynamics, imported, mjcf

VERSIONS = Versions(isaaclab="2.3", isaac_sim="5.1", mjlab="1.6")

FIGURES = (
    "kp", "kd", "effort_limit", "velocity_limit", "stall_torque", "no_load_speed", "armature", "frictionloss",
    "joint_damping", "delay", "delay_low", "delay_high",
)  # fmt: skip
"""What is compared. The pose and the action scale belong to other parts of a task (docs/isaaclab-target.md)."""

TOLERANCE = 1e-6
"""Relative; Isaac Lab's text has 6 digits or more of every number."""

REFUSED = {"the network has no manifest": "its network is on a server"}
"""Why a robot does not compile as it is imported."""


def names_of(pattern: str) -> list[str]:
    """Some joint names that a pattern of a configuration matches, at least one."""
    try:
        from re import _parser as parser  # type: ignore[attr-defined]
    except ImportError:
        import sre_parse as parser
    return list(dict.fromkeys("".join(parts) for parts in _texts(parser.parse(pattern))))[:8]


def _texts(tokens: Any) -> Iterator[list[str]]:
    yield from (list(parts) for parts in product(*(_choices(str(op), value) for op, value in tokens)))


def _choices(op: str, value: Any) -> list[str]:
    if op == "LITERAL":
        return [chr(value)]
    if op == "ANY":
        return ["x"]
    if op == "IN":
        return [c for kind, item in value for c in _choices(str(kind), item)]
    if op == "RANGE":
        return [chr(code) for code in range(value[0], value[1] + 1)][:3]
    if op == "MAX_REPEAT":
        least, most, inner = value
        count = max(int(least), min(1, int(most)))
        return ["".join(parts) * count for parts in _texts(inner)]
    if op == "SUBPATTERN":
        return ["".join(parts) for parts in _texts(value[-1])]
    if op == "BRANCH":
        return ["".join(parts) for branch in value[1] for parts in _texts(branch)]
    raise AssertionError(f"a pattern with {op}: teach the test")


def model_for(artifact: Artifact) -> str:
    """An MJCF with joints that a configuration selects, as a chain without actuators."""
    assert artifact.config is not None
    patterns = [pattern for group in artifact.config.groups for pattern in group.joints or ()]
    names = list(dict.fromkeys(name for pattern in patterns for name in names_of(pattern)))
    return mjcf("\n".join(f'<joint name="{name}"/>' for name in names)).replace(
        'model="robot"', 'model="probe"'
    )


def read_back(path: Path, model: Path, name: str | None = None) -> RobotDynamics:
    """What a configuration does to the joints of a model."""
    case = case_of(read_files([str(path), str(model)], jobs=1), VERSIONS, {})
    found = [
        index
        for index, artifact in enumerate(case.artifacts)
        if artifact.config is not None and artifact.config.groups and name in (None, artifact.name)
    ]
    return dynamics_of(case.artifacts[found[0]], case.rows_of(found[0]))


def apart(old: JointDynamics, new: JointDynamics) -> list[str]:
    """Figures that the configuration states, and that the compiled one has otherwise."""
    found = []
    for name in FIGURES:
        figures = [side.figures[name].value if name in side.figures else None for side in (old, new)]
        if figures[0] is not None and (
            figures[1] is None or not math.isclose(figures[0], figures[1], rel_tol=TOLERANCE, abs_tol=1e-12)
        ):
            found.append(f"{name} {figures[0]} -> {figures[1]}")
    return found


def compiled_back(paths: Sequence[Path], folder: Path, robot: str, target: str) -> tuple[int, list[str]]:
    """Import a robot, compile it to its own framework, and compare; joints compared, and what differs."""
    found = imported(paths, folder, robot, VERSIONS)
    spec = folder / "spec.yaml"
    spec.write_text(found.draft.text, encoding="utf-8")
    done = api.compile(spec, targets=[target], output=str(folder / "out"))
    (emission,) = done.emissions
    module = folder / "out" / target / emission.files[0].path
    module.parent.mkdir(parents=True, exist_ok=True)
    module.write_bytes(emission.files[0].data)
    old, new = read_back(paths[0], paths[1], robot), read_back(module, paths[1])
    lost = {(loss.joint, loss.field) for loss in done.approximations}
    wrong = [
        f"{robot} {name}: {text}"
        for name, joint in old.joints.items()
        if name in new.joints
        for text in apart(joint, new.joints[name])
        if (name, text.partition(" ")[0]) not in lost
    ]
    managed = {joint.joint for joint in done.actuators.joints}
    wrong += [f"{robot} {name}: is gone" for name in managed if name not in new.joints]
    return len(managed), wrong


def of_spec(path: Path, model: Path, folder: Path, robot: str) -> list[str]:
    """What an imported spec has otherwise than its configuration.

    A drive without gains is a torque in the spec, and has none; a limit of 0 or infinity is unknown there.
    """
    old, new = read_back(path, model, robot), dynamics(folder / "spec.yaml")
    return [
        f"{robot} {name}: {text} in the spec"
        for name, joint in old.joints.items()
        if name in new.joints
        for text in apart(joint, new.joints[name])
        if not re.search(r" (0\.0|inf) -> None$", text)
    ]


def test_isaaclab_robots(frameworks: Frameworks, tmp_path: Path) -> None:
    """Every robot of the release compiles back to its own limits, gains, lines, armatures and friction."""
    root = frameworks.isaaclab("2.3.2.post1").parent / "isaaclab_assets" / "isaaclab_assets" / "robots"
    joints, robots, refused, wrong = 0, 0, dict[str, list[str]](), list[str]()
    for path in sorted(root.glob("*.py")):
        for artifact in read_python(str(path)).artifacts:
            if artifact.config is None or not any(group.joints for group in artifact.config.groups):
                continue
            folder = tmp_path / f"{path.stem}_{artifact.name}"
            folder.mkdir()
            model = folder / f"{artifact.name}.xml"
            model.write_text(model_for(artifact), encoding="utf-8")
            try:
                count, found = compiled_back([path, model], folder, artifact.name, "isaaclab")
            except ActspecError as err:
                why = [reason for text, reason in REFUSED.items() if text in str(err)]
                assert why, (artifact.name, str(err))
                refused.setdefault(why[0], []).append(artifact.name)
                # The spec has the numbers nevertheless.
                wrong += of_spec(path, model, folder, artifact.name)
                continue
            joints, robots, wrong = joints + count, robots + 1, wrong + found
    # Implicit drives whose limit is infinite or left out: compile warns that the USD's counts (ISL034).
    assert [text for text in wrong if not re.search(r"effort_limit (inf|0\.0) -> None$", text)] == []
    assert sorted(refused.pop("its network is on a server")) == [
        "ANYMAL_B_CFG",
        "ANYMAL_C_CFG",
        "ANYMAL_D_CFG",
        "UNITREE_GO1_CFG",
    ]
    assert refused == {}
    # Spot is one of them: its knee's limit by the angle is the peak of its table.
    assert robots == 44 and joints > 200


@pytest.mark.slow
@pytest.mark.parametrize(
    "module, model, robot, joints",
    [
        ("unitree_go1/go1_constants.py", "unitree_go1/xmls/go1.xml", "GO1_ARTICULATION", 12),
        ("unitree_g1/g1_constants.py", "unitree_g1/xmls/g1.xml", "G1_ARTICULATION", 29),
        ("i2rt_yam/yam_constants.py", "i2rt_yam/xmls/yam.xml", "ARTICULATION", 7),
    ],
    ids=["go1", "g1", "yam"],
)
def test_mjlab_robots(
    mjlab_installed: Path, module: str, model: str, robot: str, joints: int, tmp_path: Path
) -> None:
    """Every robot of mjlab, with its own MJCF, compiles back to its own numbers."""
    root = mjlab_installed / "mjlab" / "asset_zoo" / "robots"
    assert compiled_back([root / module, root / model], tmp_path, robot, "mjlab") == (joints, [])


def test_networks_stay_networks(frameworks: Frameworks, tmp_path: Path) -> None:
    """A robot with an actuator network is imported as one, its network named as it was."""
    path = frameworks.isaaclab("2.3.2.post1").parent / "isaaclab_assets/isaaclab_assets/robots/unitree.py"
    (artifact,) = (a for a in read_python(str(path)).artifacts if a.name == "UNITREE_GO1_CFG")
    assert artifact.kind is FileKind.CFG
    model = tmp_path / "go1.xml"
    model.write_text(model_for(artifact), encoding="utf-8")
    found = imported([path, model], tmp_path, "UNITREE_GO1_CFG", VERSIONS)
    levels = {joint.level for joint in found.combined.actuators.joints}
    assert levels == {Level.ACTUATOR_NET}
    (group,) = found.data["actuators"].values()
    assert re.fullmatch(r"\{ISAACLAB_NUCLEUS_DIR\}/.*unitree_go1\.pt", group["network"]["file"])
