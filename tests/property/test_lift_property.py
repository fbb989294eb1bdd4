"""Random specs: what a target's files say, lifted, is what the spec resolves to."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any
from xml.sax.saxutils import quoteattr

import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

from actspec.diagnostics import EmitError, Severity
from actspec.ir import ActuatorSet, JointActuator
from actspec.lift import Lifted, lift_config, lift_newton, lift_robot
from actspec.readings.python.read import read_python
from actspec.readings.read import read_file
from actspec.robot.read_mjcf_text import read_mjcf_text
from actspec.robot.read_urdf import read_urdf
from actspec.robot.usda import layer_of
from actspec.robot.view import ModelFile, RobotView
from actspec.robot.xml import parse_document
from actspec.spec.models import KINDS
from tests.compiling import view_of
from tests.property.lift_fields import CANONICAL, EXACT, HOLDS, NO_FIELDS, OF_THE_SET, SINGLE, UNREAD, check
from tests.property.targets_oracle import DIALECTS, STEP, Drive, drives, emitted, resolved, robots
from tests.property.test_plan_property import Robot
from tests.property.test_plan_property import robots as mjcf_robots

SPECS = {"mujoco": 30, "urdf": 20, "isaaclab": 40, "mjlab": 20, "deploy": 20, "newton": 25}
"""Random specs of each target."""

RELEASES = ("3.2", "3.5", "3.7", "3.9", "3.11", "3.12", "3.17", "4.0")
NEW_WORDS = re.compile(r"<(?:position|general|motor)[^>]*(?:damping|armature)=")
"""Actuator-level damping and armature: no file of a release before 3.7 has them."""

COMPILED = ("3.2", "3.5", "3.12", "3.17", "4.0")
"""Dialects that the installed MuJoCo reads as they are meant; `<dcmotor>` of 3.7 to 3.11 it does not."""


def many(target: str) -> Callable[[Any], Any]:
    """Run a test on the specs of a target, the same ones every time."""
    return settings(
        max_examples=SPECS[target],
        derandomize=True,
        deadline=None,
        database=None,
        phases=[Phase.explicit, Phase.generate],
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
    )


@pytest.mark.parametrize("target", HOLDS)
def test_the_table_knows_every_field(target: str) -> None:
    """A field that the IR gains is in every target's row, or is named as one that no file has."""
    asked = {field.name for field in fields(JointActuator)} - NO_FIELDS
    split = {"delay_range", "delay_sampling"}
    assert set(HOLDS[target]) == asked | split | set(OF_THE_SET)


def test_the_table_knows_every_target() -> None:
    """A new kind of target has a row, or a reason why not."""
    assert set(KINDS) <= set(HOLDS) | set(UNREAD)


# --- configurations -------------------------------------------------------------------------------


POSES = st.none() | st.sampled_from([-1.8, 0.4])


@st.composite
def policies(draw: st.DrawFn) -> tuple[float | None, float | None, int | None]:
    """Action scale, default pose of the first group's joints, decimation."""
    return draw(st.none() | st.sampled_from([0.25, 1.0])), draw(POSES), draw(st.none() | st.integers(1, 20))


def asked_of(
    groups: list[Drive], policy: tuple[float | None, float | None, int | None]
) -> tuple[ActuatorSet, RobotView]:
    """Groups of a robot that the spec lists, with what a policy needs."""
    scale, pose, decimation = policy
    robot = {}
    if pose is not None:
        unit = "m" if groups[0].slide else "rad"
        robot["default_pose"] = {re.escape(name): f"{pose} {unit}" for name in groups[0].joints}
    return resolved(
        groups,
        robot=robot,
        timing={} if decimation is None else {"decimation": decimation},
        actuators={} if scale is None else {"action_scale": scale},
    )


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A folder for what is emitted."""
    return tmp_path_factory.mktemp("lift")


@pytest.mark.slow
@given(groups=robots(), policy=policies(), dialect=st.sampled_from(DIALECTS),
       cls=st.sampled_from(["auto", "implicit", "custom"]))  # fmt: skip
@many("isaaclab")
def test_isaaclab(place: Any, groups: list[Drive], policy: Any, dialect: Any, cls: str) -> None:
    """Isaac Lab's cfgs, all classes and versions, by the reader that runs nothing."""
    version, sim, backend, _ = dialect
    cls = "auto" if version == "3.0" and cls == "custom" else cls
    actuators, robot = asked_of(groups, policy)
    emission = emitted(
        actuators, robot, kind="isaaclab", version=version, isaac_sim=sim, backend=backend, class_=cls
    )
    lifted = lifted_module(place, emission.files[0].data, robot)
    check("isaaclab", actuators, lifted.actuators, emission.approximations)


@pytest.mark.slow
@given(groups=robots(), policy=policies(), version=st.sampled_from(["1.0", "1.2", "1.3", "1.6"]))
@many("mjlab")
def test_mjlab(place: Any, groups: list[Drive], policy: Any, version: str) -> None:
    """mjlab's cfgs with their action scale and pose, wrapped delays of old versions among them."""
    actuators, robot = asked_of(groups, policy)
    emission = emitted(actuators, robot, kind="mjlab", version=version)
    lifted = lifted_module(place, emission.files[0].data, robot)
    check("mjlab", actuators, lifted.actuators, emission.approximations)


def lifted_module(place: Any, data: bytes, robot: RobotView) -> Lifted:
    """A module, read and lifted; its head says what it was written for."""
    path = place / "bot_cfg.py"
    path.write_bytes(data)
    reading = read_python(str(path))
    assert reading.reason is None
    (artifact,) = reading.artifacts
    lifted = lift_config(artifact, robot.joints, physics_dt=STEP)
    assert lifted.left_alone == ()
    return lifted


@pytest.mark.slow
@given(groups=robots(), policy=policies())
@many("deploy")
def test_deploy(place: Any, groups: list[Drive], policy: Any) -> None:
    """The robot side's file names its joints itself, and has the clamp, the delay and the ranges too."""
    actuators, robot = asked_of(groups, policy)
    emission = emitted(actuators, robot, kind="deploy", version="")
    path = place / "bot_deploy.yaml"
    path.write_bytes(emission.files[0].data)
    reading = read_file(str(path))
    assert reading.reason is None
    (artifact,) = reading.artifacts
    lifted = lift_config(artifact)
    assert lifted.left_alone == ()
    check("deploy", actuators, lifted.actuators, emission.approximations)


@pytest.mark.slow
@given(groups=robots(), version=st.sampled_from(["1.2", "1.3", "1.4", "1.8"]))
@many("newton")
def test_newton(groups: list[Drive], version: str) -> None:
    """Newton's overlay: joints by the paths of their prims."""
    pytest.importorskip("pxr", reason="usd-core is not installed")
    actuators, robot = resolved(groups)
    names = [actuator.joint for actuator in actuators.joints]
    paths = {name: f"/World/bot/joints/j{k}" for k, name in enumerate(names)}
    stated = {re.escape(name): path for name, path in paths.items()}
    emission = emitted(
        actuators, robot, kind="newton", version=version, root="/World/bot", joint_paths=stated
    )
    layer = layer_of(emission.files[0].data, "bot_newton.usda")
    views = [joint for joint in robot.joints if joint.name in paths]
    lifted = lift_newton(layer, views, paths, STEP)
    assert lifted.left_alone == ()
    check("newton", actuators, lifted.actuators, emission.approximations, SINGLE)


# --- robot files ----------------------------------------------------------------------------------


@st.composite
def mjcfs(draw: st.DrawFn) -> tuple[Robot, list[Drive], list[str]]:
    """A robot with classes, actuators and includes of its own, groups for some joints, and the other joints."""
    robot = draw(mjcf_robots())
    managed = draw(st.sets(st.sampled_from(sorted(robot.joints)), min_size=1))
    groups = []
    for name, kind in robot.joints.items():
        if name in managed:
            groups.append(replace(draw(drives((name,))), slide=kind == "slide"))
    return robot, groups, [name for name in robot.joints if name not in managed]


@pytest.mark.slow
@given(
    made=mjcfs(),
    dt=st.sampled_from([None, "2 ms", "5 ms"]),
    old=st.sampled_from(RELEASES),
    new=st.sampled_from(RELEASES[2:]),
    canonical=st.integers(0, 5).map(lambda number: number == 0),
)
@many("mujoco")
def test_mujoco(made: Any, dt: str | None, old: str, new: str, canonical: bool) -> None:
    """MJCF of eight releases, by the compiled reader where the installed MuJoCo takes it, and from the text."""
    source, groups, others = made
    version = new if NEW_WORDS.search(source.text) else old
    canonical = canonical and version in COMPILED
    view = view_of(source.text, includes=source.includes, folder="")
    timing = {"physics_dt": dt} if dt else {}
    actuators, _ = resolved(groups, view=view, robot={"unmanaged": others}, timing=timing)
    try:
        emission = emitted(actuators, view, kind="mujoco", version=version, canonical=canonical)
    except EmitError as err:
        # Polynomial damping of a joint, which an old release has no words for.
        assert {item.code for item in err.diagnostics if item.severity is Severity.ERROR} <= {"MJC003"}
        assume(False)
    written = {**source.includes, **{file.path: file.data.decode() for file in emission.files}}
    main = written.pop("robot.xml").replace("../drives.xml", "drives.xml")
    included = {name: inner for name, inner in written.items() if f'"{name}"' in main}
    files = [ModelFile("robot.xml", "", main.encode())]
    files += [ModelFile(name, name, inner.encode()) for name, inner in included.items()]
    views = [read_mjcf_text(parse_document(tuple(files)), "asked for")]
    if version in COMPILED:
        views.append(view_of(main, includes=included, folder=""))
    for again in views:
        lifted = lift_robot(again).actuators
        kept = replace(lifted, joints=tuple(a for a in lifted.joints if a.joint not in others))
        check("mujoco", actuators, kept, emission.approximations, CANONICAL if canonical else EXACT)


@st.composite
def urdfs(draw: st.DrawFn) -> tuple[str, list[Drive]]:
    """A URDF of up to six joints with what it states of limits and friction, and groups for all of them."""
    groups = draw(robots())
    text = '<robot name="bot"><link name="l0"/>'
    number = 0
    for drive in groups:
        for name in drive.joints:
            number += 1
            kind = "prismatic" if drive.slide else draw(st.sampled_from(["revolute", "continuous"]))
            text += (
                f'<link name="l{number}"/><joint name={quoteattr(name, {chr(10): "&#10;"})} type="{kind}">'
            )
            text += f'<parent link="l{number - 1}"/><child link="l{number}"/><axis xyz="0 1 0"/>'
            if kind != "continuous" or draw(st.booleans()):
                text += f'<limit lower="-1" upper="1.5" effort="{draw(st.sampled_from(["7", "0", "12.5"]))}"'
                text += f' velocity="{draw(st.sampled_from(["3", "21.5"]))}"/>'
            if draw(st.booleans()):
                damping = draw(st.sampled_from(["", ' damping="0.3"']))
                text += f"<dynamics{damping}" + draw(st.sampled_from(["", ' friction="0.2"'])) + "/>"
            text += "</joint>"
    return text + "</robot>", groups


@pytest.mark.slow
@given(made=urdfs())
@many("urdf")
def test_urdf(made: tuple[str, list[Drive]]) -> None:
    """Limits and friction of a URDF, on joints with and without such elements."""
    text, groups = made
    robot = read_urdf((ModelFile("bot.urdf", "", text.encode()),))
    actuators, _ = resolved(groups, view=robot)
    emission = emitted(actuators, robot, kind="urdf", version="")
    lifted = lift_robot(read_urdf((ModelFile("out/bot.urdf", "", emission.files[0].data),)))
    check("urdf", actuators, lifted.actuators, emission.approximations)
