"""The deploy file: orders, index maps, numbers, what is unknown, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from actspec.api import load, load_robot
from actspec.diagnostics import EmitError
from actspec.resolution import resolve
from actspec.robot.load import listed_robot
from actspec.robot.read_urdf import read_urdf
from actspec.robot.view import ModelFile, isaac_order
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import Emission
from actspec.targets.deploy.emit import emit, index_map, scalar
from tests.compiling import spec_text, target_options, view_of

# The right leg stands first, a body without a joint is between the base and the left one, and `waist` comes last.
BIPED = """<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="trunk">
      <freejoint name="base"/>
      <geom size="0.1"/>
      <body name="r_leg">
        <joint name="r_hip" range="-1 1"/><joint name="r_roll" axis="1 0 0"/>
        <geom size="0.1"/>
        <body name="r_shank"><joint name="r_knee" range="0 2.5"/><geom size="0.1"/></body>
      </body>
      <body name="bracket">
        <geom size="0.1"/>
        <body name="l_leg">
          <joint name="l_hip" range="-1 1"/><geom size="0.1"/>
          <body name="l_shank"><joint name="l_knee" range="0 2.5"/><geom size="0.1"/></body>
        </body>
      </body>
      <body name="head"><joint name="a_waist" type="slide"/><geom size="0.1"/></body>
    </body>
  </worldbody>
</mujoco>"""

LEGS = """  legs:
    joints: ["[lr]_(hip|knee)"]
    level: ideal_pd
    kp: 25 N*m/rad
    kd: 0.5 N*m*s/rad
    effort_limit: 24 N*m
    velocity_limit: unknown
    action_scale: 0.25
    delay: {nominal: 5 ms, range: [0 ms, 10 ms]}
    overrides: {l_knee: {kp: 36 N*m/rad}}
"""
REST = 'unmanaged: ["r_roll", "a_waist"], default_pose: {".*_knee": 1.2 rad}'


def emission(
    actuators: str = LEGS, *, robot: str = REST, order: tuple[str | None, ...] = (), **rest: str
) -> Emission:
    """Compile the `actuators` of a spec against BIPED, or against no model where `robot` says so."""
    timing = rest.get("timing", "{physics_dt: 5 ms, decimation: 4}")
    text = spec_text(actuators, robot=robot, timing=timing)
    listed = "model: none" in robot
    if listed:
        text = text.replace("model: robot.xml, ", "")
    spec = validate(document_from_text(text, "spec.yaml"))
    view = listed_robot(spec) if listed else view_of(rest.get("model", BIPED))
    options = target_options("deploy", name="robot_side", joint_order=order)
    return emit(resolve(spec, view), view, options)


def deployed(*args: Any, **rest: Any) -> dict[str, Any]:
    """The same, read back as YAML."""
    (file,) = emission(*args, **rest).files
    found = yaml.safe_load(file.data)
    assert isinstance(found, dict)
    return found


def test_numbers_in_the_robots_order() -> None:
    """Every list is in the model's order, with what is not known as null."""
    found = deployed()
    assert found["format"] == "actspec-deploy/1"
    assert found["robot"] == "probe"
    assert found["order"]["robot"] == ["r_hip", "r_knee", "l_hip", "l_knee"]
    assert found["kp"] == [25.0, 25.0, 25.0, 36.0]
    assert found["kd"] == [0.5] * 4
    assert found["effort_limit"] == [24.0] * 4
    assert found["velocity_limit"] == [None] * 4
    assert found["position_lower"] == [-1.0, 0.0, -1.0, 0.0]
    assert found["position_upper"] == [1.0, 2.5, 1.0, 2.5]
    assert found["default_position"] == [0.0, 1.2, 0.0, 1.2]
    assert found["action_scale"] == [0.25] * 4
    assert found["command"] == ["position"] * 4
    assert found["policy_delay"] == {"nominal": [0.005] * 4, "low": [0.0] * 4, "high": [0.01] * 4}
    # 5 ms x 4.
    assert found["timing"] == {"physics_dt": 0.005, "decimation": 4, "control_dt": 0.02}


def test_orders_and_maps() -> None:
    """Isaac's order is breadth-first with ties by name, and every map takes one order to the other."""
    sdk = ("l_hip", "l_knee", "r_hip", "r_knee")
    found = deployed(order=sdk)
    # Below the base: a_waist, l_hip, r_hip; then l_knee and r_roll; then r_knee, which hangs on r_roll.
    assert found["order"]["isaac"] == ["l_hip", "r_hip", "l_knee", "r_knee"]
    assert found["order"]["sdk"] == list(sdk)
    assert found["index"]["robot_to_isaac"] == [2, 0, 3, 1]
    assert found["index"]["isaac_to_robot"] == [1, 3, 0, 2]
    assert found["index"]["robot_to_sdk"] == [2, 3, 0, 1]
    for name, index in found["index"].items():
        source, result = name.split("_to_")
        assert [found["order"][source][i] for i in index] == found["order"][result], name


def test_an_sdk_that_leaves_a_number_out() -> None:
    """A gap is an entry of the SDK's order and of the maps to it; in the maps from it, its number is left out."""
    sdk = (None, "l_hip", "l_knee", None, "r_hip", "r_knee")
    found = deployed(order=sdk)
    assert found["order"]["sdk"] == list(sdk)
    assert found["index"]["robot_to_sdk"] == [None, 2, 3, None, 0, 1]
    # The robot's order is r_hip, r_knee, l_hip, l_knee.
    assert found["index"]["sdk_to_robot"] == [4, 5, 1, 2]
    for name, index in found["index"].items():
        source, result = name.split("_to_")
        taken = [None if i is None else found["order"][source][i] for i in index]
        assert taken == found["order"][result], name
    (file,) = emission(order=sdk).files
    text = file.data.decode("utf-8")
    assert "# a_to_b: values_b = [None if i is None else values_a[i] for i in a_to_b]\n" in text
    assert "`joint_order` says; null: a number of the SDK that is no joint here.\n" in text
    (file,) = emission(order=sdk[1:3] + sdk[4:]).files
    assert "# a_to_b: values_b = [values_a[i] for i in a_to_b]\n" in file.data.decode("utf-8")


def test_depth_counts_unmanaged_joints() -> None:
    """A joint that the spec does not manage still takes its level in the tree."""
    view = view_of(BIPED)
    everything = [joint.name for joint in view.joints if joint.name != "base"]
    assert isaac_order(view, everything) == ("a_waist", "l_hip", "r_hip", "l_knee", "r_roll", "r_knee")


def test_order_of_the_a1() -> None:
    """The A1 as Isaac Lab lists it: hips, thighs, calves, each FL, FR, RL, RR; its MJCF begins with FR."""
    spec = load(Path(__file__).resolve().parents[3] / "robots" / "a1.yaml")
    robot = load_robot(spec)
    legs, parts = ("FL", "FR", "RL", "RR"), ("hip", "thigh", "calf")
    wanted = [f"{leg}_{part}_joint" for part in parts for leg in legs]
    assert isaac_order(robot, wanted) == tuple(wanted)


def chain(names: list[str], tip: str = "") -> str:
    """Bodies that hang on each other, one joint each, and what hangs on the last."""
    for name in reversed(names):
        tip = f'<body><joint name="{name}"/><geom size="0.1"/>{tip}</body>'
    return tip


def test_order_of_the_g1() -> None:
    """The 29 joints of a G1 come in the order of Unitree's own deploy file for Isaac Lab.

    Source: `joint_ids_map` of unitree_rl_lab's G1, 29 joints: for each joint in Isaac Lab's order its number
    in the SDK's, which is the model's.
    """
    leg = ["hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll"]
    arm = [
        "shoulder_pitch",
        "shoulder_roll",
        "shoulder_yaw",
        "elbow",
        "wrist_roll",
        "wrist_pitch",
        "wrist_yaw",
    ]
    sides = [
        [[f"{side}_{part}_joint" for part in parts] for side in ("left", "right")] for parts in (leg, arm)
    ]
    arms = "".join(map(chain, sides[1]))
    waist = chain(["waist_yaw_joint", "waist_roll_joint", "waist_pitch_joint"], arms)
    legs = "".join(map(chain, sides[0]))
    text = f"<mujoco><worldbody><body><freejoint/><geom size='0.1'/>{legs}{waist}</body></worldbody></mujoco>"
    view = view_of(text)
    own = [joint.name for joint in view.joints]
    assert len(own) == 29
    order = isaac_order(view, own)
    assert order is not None
    published = [0, 6, 12, 1, 7, 13, 2, 8, 14, 3, 9, 15, 22, 4, 10, 16, 23, 5, 11, 17, 24, 18, 25, 19, 26, 20]
    assert list(index_map(own, order)) == [*published, 27, 21, 28]


def test_order_of_a_urdf() -> None:
    """A fixed joint takes no level, and the order of the text does not matter."""
    limit = '<limit lower="0" upper="1" effort="1" velocity="1"/>'
    ends = {"b": ("base", "lb"), "a": ("plate", "la"), "a2": ("tip", "la2"), "c": ("lb", "lc")}
    joints = "".join(
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>{limit}</joint>'
        for name, (parent, child) in reversed(ends.items())
    )
    fixed = "".join(
        f'<joint name="f_{child}" type="fixed"><parent link="{parent}"/><child link="{child}"/></joint>'
        for parent, child in (("base", "plate"), ("la", "tip"))
    )
    links = "".join(f'<link name="{n}"/>' for n in ("base", "plate", "tip", "lb", "la", "la2", "lc"))
    data = f'<robot name="r">{links}{joints}{fixed}</robot>'.encode()
    view = read_urdf((ModelFile("/models/r.urdf", "", data),))
    assert {joint.name: joint.parent for joint in view.joints} == {"a": "", "b": "", "a2": "a", "c": "b"}
    assert isaac_order(view, list(ends)) == ("a", "b", "a2", "c")


def test_urdf_with_a_circle() -> None:
    """Links that hang on each other end the search."""
    joints = "".join(
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/></joint>'
        for name, kind, parent, child in (
            ("x", "fixed", "two", "one"),
            ("y", "fixed", "one", "two"),
            ("z", "continuous", "one", "three"),
        )
    )
    links = "".join(f'<link name="{n}"/>' for n in ("one", "two", "three"))
    view = read_urdf((ModelFile("/models/r.urdf", "", f'<robot name="r">{links}{joints}</robot>'.encode()),))
    assert [(joint.name, joint.parent) for joint in view.joints] == [("z", "")]


def test_robot_without_a_tree() -> None:
    """Without a model nobody knows the tree: no order and no map of Isaac's, and no order of its own making."""
    found = deployed(
        LEGS.replace("[lr]_(hip|knee)", ".*"),
        robot="model: none, joints: [r_hip, l_knee]",
        timing="{physics_dt: 5 ms}",
    )
    assert found["order"] == {"robot": ["r_hip", "l_knee"], "isaac": None, "sdk": None}
    assert set(found["index"].values()) == {None}
    assert found["position_lower"] == [None, None]
    assert found["timing"] == {"physics_dt": 0.005, "decimation": None, "control_dt": None}


def test_a_control_period_that_nobody_states() -> None:
    """Four steps of MuJoCo's default are no rate; a period that is stated is one, whatever the step."""
    legs, robot = LEGS.replace("[lr]_(hip|knee)", ".*"), "model: none, joints: [r_hip, l_knee]"
    found = deployed(legs, robot=robot, timing="{decimation: 4}")
    assert found["timing"] == {"physics_dt": 0.002, "decimation": 4, "control_dt": None}
    found = deployed(legs, robot=robot, timing="{control_dt: 25 ms}")
    assert found["timing"] == {"physics_dt": 0.002, "decimation": None, "control_dt": 0.025}


def test_a_control_period_that_is_no_number_of_the_models_steps() -> None:
    """The file says why there is no decimation: 25 ms are 12.5 of its 2 ms."""
    model = BIPED.replace("<worldbody>", '<option timestep="0.002"/><worldbody>', 1)
    (file,) = emission(model=model, timing="{control_dt: 25 ms}").files
    line = "  decimation: null  # physics steps in one control step; 12.5 are no whole number"
    assert line in file.data.decode().splitlines()


def test_unstated_is_null() -> None:
    """A delay or scale that nobody states, and a gain that the command has no use for, are null."""
    spec = "  legs: {joints: ['[lr]_(hip|knee)'], level: ideal_pd, command: effort}"
    found = deployed(spec)
    for name in ("kp", "kd", "effort_limit", "action_scale"):
        assert found[name] == [None] * 4, name
    assert (found["policy_delay"], found["command_range"]) == (None, None)


@pytest.mark.parametrize(
    "delay, low, high",
    [("unknown", None, None), ("{nominal: unknown, range: [0 ms, 10 ms]}", 0.0, 0.01)],
    ids=["unknown", "range"],
)
def test_unknown_delay_is_not_zero(delay: str, low: float | None, high: float | None) -> None:
    """Nobody knows the nominal: null, and its ends too unless a range states them."""
    found = deployed(LEGS.replace("{nominal: 5 ms, range: [0 ms, 10 ms]}", delay))
    assert found["policy_delay"] == {"nominal": [None] * 4, "low": [low] * 4, "high": [high] * 4}


def test_command_range() -> None:
    """The clamp of the command is the robot's to apply: its ends by joint, null where a joint has none."""
    spec = LEGS.replace(
        "overrides: {l_knee: {",
        "command_range: [-1 rad, 2 rad]\n    overrides: {l_knee: {command_range: none, ",
    )
    assert deployed(spec)["command_range"] == {"low": [-1.0, -1.0, -1.0, None], "high": [2.0, 2.0, 2.0, None]}
    text = emission(spec).files[0].data.decode("utf-8")
    assert (
        "# clamp of the command before it is sent; rad; authored: r_hip, r_knee, l_hip; none: l_knee\n"
        in text
    )
    assert deployed(LEGS)["command_range"] is None


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("position", "command = default_position + action_scale x action; authored"),
        ("velocity", "command = action_scale x action; authored"),
        ("effort", "command = action_scale x action; authored"),
    ],
)
def test_what_an_action_becomes(command: str, said: str) -> None:
    """A pose is added to positions alone."""
    gains = {"position": "kp: 25, kd: 1", "velocity": "kd: 1", "effort": "effort_limit: 9"}[command]
    legs = f"  legs: {{joints: ['[lr]_(hip|knee)'], level: ideal_pd, command: {command}, {gains}, action_scale: 2}}"
    assert f"# {said}\n" in emission(legs).files[0].data.decode("utf-8")


def test_what_an_action_becomes_where_commands_differ() -> None:
    """Joints of both kinds are named."""
    legs = (
        "  hips: {joints: ['._hip'], level: ideal_pd, kp: 25, kd: 1, action_scale: 2}\n"
        "  knees: {joints: ['._knee'], level: ideal_pd, command: velocity, kd: 1, action_scale: 3}"
    )
    assert (
        "# command = default_position + action_scale x action at r_hip, l_hip; "
        "command = action_scale x action at r_knee, l_knee; authored\n"
    ) in emission(legs).files[0].data.decode("utf-8")


def test_nothing_is_an_approximation() -> None:
    """A torque-speed line, friction and armature are the motor's own on the robot: nothing is lost."""
    spec = LEGS.replace("ideal_pd", "dc_motor\n    motor: line\n    friction: {coulomb: 0.2 N*m}")
    assert emission(spec).approximations == ()


def test_units_and_origins_are_said() -> None:
    """Each list has its unit and origin, by joint where they differ."""
    sliding = "  neck: {joints: [a_waist], level: ideal_pd, kp: 9 N/m, kd: 1 N*s/m, effort_limit: 5 N}\n"
    (file,) = emission(LEGS + sliding, robot='unmanaged: ["r_roll"]').files
    text = file.data.decode("utf-8")
    assert "drive stiffness; N*m/rad at r_hip, r_knee, l_hip, l_knee; N/m at a_waist; authored\n" in text
    assert (
        "speed limit of the joint; rad/s at r_hip, r_knee, l_hip, l_knee; m/s at a_waist; unknown\n" in text
    )
    assert "# Not managed by the spec, and in no order below: r_roll\n" in text


@pytest.mark.parametrize(
    "order, expected",
    [
        (
            ("l_hip", "l_knee", "r_hip", "r_kneee"),
            ["DEP001 targets.robot_side.joint_order[3]: 'r_kneee' is not a joint that the spec manages"],
        ),
        (
            ("l_hip", "l_knee", "r_kneee"),
            [
                "DEP003 targets.robot_side.joint_order: 1 of 4 managed joints missing: r_hip",
                "DEP001 targets.robot_side.joint_order[2]: 'r_kneee' is not a joint that the spec manages",
            ],
        ),
        (
            ("l_hip", "l_knee", "r_hip", "r_knee", "l_hip"),
            ["DEP002 targets.robot_side.joint_order[4]: 'l_hip' is named twice"],
        ),
        (
            ("l_hip", "l_knee", "r_hip", "l_knee"),
            ["DEP002 targets.robot_side.joint_order[3]: 'l_knee' is named twice"],
        ),
        (
            ("l_hip", "l_knee", "l_hip"),
            [
                "DEP003 targets.robot_side.joint_order: 1 of 4 managed joints missing: r_knee",
                "DEP002 targets.robot_side.joint_order[2]: 'l_hip' is named twice",
            ],
        ),
        (
            ("l_hip", "l_hip", "r_hip", "r_kneee"),
            [
                "DEP002 targets.robot_side.joint_order[1]: 'l_hip' is named twice",
                "DEP001 targets.robot_side.joint_order[3]: 'r_kneee' is not a joint that the spec manages",
            ],
        ),
        (
            ("l_hip", "l_knee r_knee", "r_hip"),
            [
                "DEP001 targets.robot_side.joint_order[1]: 'l_knee r_knee' is not a joint that the spec manages"
            ],
        ),
        (
            (None, "l_hip", "l_knee", None, "r_hip"),
            ["DEP003 targets.robot_side.joint_order: 1 of 4 managed joints missing: r_knee"],
        ),
        (
            ("l_hip", "l_knee", "r_hip"),
            ["DEP003 targets.robot_side.joint_order: 1 of 4 managed joints missing: r_knee"],
        ),
        (
            ("l_hip", "l_knee", "r_hip", "r_knee", "r_roll"),
            ["DEP001 targets.robot_side.joint_order[4]: 'r_roll' is not a joint that the spec manages"],
        ),
    ],
    ids=[
        "misspelt",
        "misspelt and missing",
        "twice",
        "one in place of another",
        "one of two missing",
        "one in place of another, and one misspelt",
        "no comma",
        "gaps",
        "missing",
        "unmanaged",
    ],
)
def test_sdk_order_is_checked(order: tuple[str | None, ...], expected: list[str]) -> None:
    """An SDK order names every managed joint once and no other; the nearest name is offered."""
    with pytest.raises(EmitError) as caught:
        emission(order=order)
    found = caught.value.diagnostics
    assert sorted(f"{d.code} {d.where}: {d.message}" for d in found) == sorted(expected)
    if "r_kneee" in order:
        assert "did you mean 'r_knee'?" in [d.help for d in found]
    if order[1:] == ("l_knee", "r_hip", "l_knee"):
        assert [d.help for d in found] == ["did you mean 'r_knee', which is missing?"]
    if "l_knee r_knee" in order:
        assert [d.help for d in found] == ["separate them by a comma: l_knee, r_knee"]


@pytest.mark.parametrize(
    "name",
    [
        "on",
        "1e3",
        "a: b",
        "#x",
        "null",
        "tab\t",
        "line\nbreak",
        'q"\\',
        "ünï",
        "\U0001f916",
        "\x07",
        " x ",
        "~",
        "-",
        "0x1f",
        "e5",
    ],
    ids=ascii,
)
def test_strings_survive(name: str) -> None:
    """Whatever a joint is called, it reads back as itself."""
    assert yaml.safe_load(f"{scalar(name)}") == name
    assert yaml.safe_load(f"[{scalar(name)}, 1]") == [name, 1]
    assert scalar(name).isascii()
    assert "\n" not in scalar(name)


@pytest.mark.parametrize("value", [1e-5, 1.5e-7, 3e20, 0.1, -0.0, 12.0, float("inf"), -float("inf"), 7, None])
def test_numbers_survive(value: float | None) -> None:
    """Numbers read back as numbers: YAML 1.1 takes 1e-05 for a word."""
    found = yaml.safe_load(scalar(value))
    assert found == value
    assert type(found) is type(value)


def test_hostile_names_and_titles() -> None:
    """A name or a source's title with a line break stays in its string or its comment."""
    model = BIPED.replace('name="r_hip"', 'name="r_hip&#10;kp: [0]"')
    spec = LEGS.replace('["[lr]_(hip|knee)"]', "['r_hip[\\s\\S]*', r_knee, '[l]_(hip|knee)']")
    found = deployed(spec, model=model)
    assert found["order"]["robot"][0] == "r_hip\nkp: [0]"
    assert found["kp"] == [25.0, 25.0, 25.0, 36.0]


def test_same_input_same_bytes() -> None:
    """Two runs write the same bytes."""
    assert emission().files == emission().files
    assert emission().files[0].path == "probe_deploy.yaml"
