"""Which artifacts are one robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from actspec.diagnostics import Span
from actspec.ir import JointKind
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig, Setting
from actspec.readings.body import share_a_body
from actspec.readings.called import distinctive
from actspec.readings.joint_names import matching
from actspec.readings.pair import pair
from actspec.robot.view import JointView, ModelFile, ModelFormat, RobotView

DOG = tuple(f"{leg}_{part}_joint" for leg in ("FL", "FR", "RL", "RR") for part in ("hip", "thigh", "calf"))
ARM = ("shoulder", "elbow", "wrist")


def _joint(name: str) -> JointView:
    return JointView(
        name,
        JointKind.HINGE,
        Span("m.xml", 1),
        name,
        0,
        None,
        0.0,
        (0.0, 0.0),
        0.0,
        0.0,
        0.0,
        None,
        None,
        frozenset(),
        False,
        None,
        0.0,
    )


def model(path: str, name: str, joints: Sequence[str]) -> Artifact:
    """A model file."""
    view = RobotView(
        name,
        path,
        ModelFormat.MJCF,
        tuple(_joint(j) for j in joints),
        (),
        0.002,
        "Euler",
        (),
        None,
        "not asked for",
        (),
    )
    return Artifact(path, FileKind.MJCF, name, robot=view)


def config(
    path: str, name: str, patterns: Sequence[str], framework: Framework = Framework.ISAACLAB
) -> Artifact:
    """A cfg with one group."""
    settings = {"stiffness": Setting(1.0, Span(path, 1))}
    group = ActuatorGroup("legs", "DCMotorCfg", Span(path, 1), tuple(patterns), settings)
    return Artifact(
        path, FileKind.CFG, name, config=RobotConfig(framework, name, Span(path, 1), (group,), {})
    )


def _together(*artifacts: Artifact) -> list[tuple[int, ...]]:
    return [robot.artifacts for robot in pair(artifacts)]


LEGS = [".*_hip_joint", ".*_thigh_joint", ".*_calf_joint"]


def test_quadrupeds_of_one_vendor_are_not_mixed_up() -> None:
    """All have the same joint names, and only the names of the files tell them apart."""
    found = _together(
        model("r/go1.xml", "go1", DOG),
        model("r/go2.urdf", "go2_description", DOG),
        config("cfg/unitree.py", "UNITREE_GO2_CFG", LEGS),
        config("cfg/unitree.py", "UNITREE_GO1_CFG", LEGS),
        config("cfg/unitree.py", "UNITREE_B2_CFG", LEGS),
    )
    assert found == [(0, 3), (1, 2), (4,)]


def test_variants_of_one_robot_come_together() -> None:
    """23 of 29 joints are all of the smaller one's; `h1` and `h1_2` are two robots."""
    many = [f"j{i}" for i in range(29)]
    assert _together(model("g1_23dof.xml", "g1", many[:23]), model("g1_29dof.urdf", "g1_29dof", many)) == [
        (0, 1)
    ]
    assert _together(model("h1.xml", "h1", many[:20]), model("h1_2.xml", "h1_2", many)) == [(0,), (1,)]


def test_models_of_one_family_are_not_mixed_up() -> None:
    """`anymal_b` and `anymal_c`, both `anymal` inside, are two robots; a file called `anymal` may be the first."""
    b, c = model("b/anymal_b.urdf", "anymal", DOG), model("c/anymal_c.urdf", "anymal", DOG)
    assert _together(b, c) == [(0,), (1,)]
    assert _together(b, model("x/anymal.urdf", "anymal", DOG)) == [(0, 1)]


def test_a_share_below_four_fifths_is_another_robot() -> None:
    """3 of 4 joints of the smaller one are not enough (0.75 < 0.8), 4 of 5 are."""
    assert _together(model("a.xml", "", "abcd"), model("b.xml", "", "abcx")) == [(0,), (1,)]
    assert _together(model("a.xml", "", "abcde"), model("b.xml", "", "abcdx")) == [(0, 1)]


def test_the_only_configuration_belongs_to_the_only_robot() -> None:
    """Names may then say what they like; but every pattern must match a joint."""
    robot = model("mine/robot.xml", "spotty", DOG)
    assert _together(robot, config("x/walker_cfg.py", "WALKER_CFG", LEGS)) == [(0, 1)]
    assert _together(robot, config("x/walker_cfg.py", "WALKER_CFG", [*LEGS, ".*_foot_joint"])) == [(0,), (1,)]
    two = [config("x/walkers.py", name, LEGS) for name in ("WALKER_CFG", "RUNNER_CFG")]
    assert _together(robot, *two) == [(0,), (1,), (2,)]


def test_a_pattern_for_all_joints_says_nothing() -> None:
    """`.*` fits every robot: a humanoid's cfg does not belong to a dog because they are alone together."""
    assert _together(model("go2.xml", "go2", DOG), config("humanoid.py", "HUMANOID_CFG", [".*"])) == [
        (0,),
        (1,),
    ]
    assert _together(model("go2.xml", "go2", DOG), config("dog.py", "GO2_CFG", [".*"])) == [(0, 1)]


def test_equal_values_without_names_are_of_a_robot_with_so_many_joints() -> None:
    """Twelve equal gains are a dog's, not those of a dog with an arm of three joints, which is called the same."""
    deploy = config("deploy/go2.yaml", "go2", [".*"], Framework.DEPLOY)
    assert deploy.config is not None
    twelve = replace(
        deploy, config=replace(deploy.config, settings={"joint_count": Setting(12.0, Span("y", 1))})
    )
    dog, with_arm = model("go2.xml", "go2", DOG), model("arm/go2.xml", "go2", (*DOG, *ARM))
    assert _together(with_arm, deploy) == [(0, 1)]
    assert _together(with_arm, twelve) == [(0,), (1,)]
    assert _together(dog, twelve) == [(0, 1)]


def test_a_cfg_with_hands_belongs_to_the_model_without() -> None:
    """With the robot's name half of the patterns are enough (2 of 4), a third is not; without it all must match."""
    robot = model("g1.urdf", "g1_29dof", ["l_hip", "l_knee"])
    hands = [".*_hip", ".*_knee", ".*_thumb", ".*_index"]
    assert _together(robot, config("unitree.py", "G1_29DOF_CFG", hands)) == [(0, 1)]
    assert _together(robot, config("unitree.py", "G1_29DOF_CFG", [*hands[1:], ".*_ring"])) == [(0,), (1,)]
    assert _together(robot, config("unitree.py", "H1_CFG", hands)) == [(0,), (1,)]


def test_a_gripper_is_not_the_robot_of_the_arm_that_has_it() -> None:
    """Three of four patterns match, and two of nine joints; of a dog with that arm twelve of twenty."""
    arm, hand = "panda_joint[1-7]", ["finger_joint", "l_knuckle", ".*_knuckle"]
    gripper = model("robotiq.xml", "robotiq", ["finger_joint", "l_knuckle"])
    assert _together(gripper, config("f.py", "ROBOTIQ_CFG", [arm, *hand])) == [(0,), (1,)]
    # One that writes no joints out may be of one.
    assert _together(gripper, config("f.py", "ROBOTIQ_CFG", ["panda_joint.*", *hand])) == [(0, 1)]
    dog = model("dog.xml", "dog", DOG)
    assert _together(dog, config("d.py", "DOG_CFG", [".*_hip_joint", ".*_(thigh|calf)_joint", arm, "x"])) == [
        (0, 1)
    ]


def test_a_folder_does_not_contradict_the_file_beside_it() -> None:
    """A file called `robot.xml` goes by its folder; beside it stands a model with a name, which is in it too."""
    assert _together(model("work/dog.xml", "dog", DOG), model("work/robot.urdf", "", DOG)) == [(0, 1)]
    assert _together(model("go1/robot.xml", "", DOG), model("go2/robot.xml", "", DOG)) == [(0,), (1,)]
    assert _together(model("go1/robot.xml", "", DOG), model("x/go2.xml", "go2", DOG)) == [(0,), (1,)]


def test_where_two_robots_fit_nothing_is_guessed() -> None:
    """A cfg that is called after neither of two dogs belongs to none."""
    found = _together(
        model("go1.xml", "go1", DOG), model("go2.xml", "go2", DOG), config("c.py", "ROBOT_CFG", LEGS)
    )
    assert found == [(0,), (1,), (2,)]


def test_every_artifact_is_in_one_robot() -> None:
    """Arms and dogs, models and cfg: nobody is lost or twice."""
    artifacts = [
        model("arm.xml", "arm", ARM),
        config("unitree.py", "GO2_CFG", LEGS),
        model("go2.xml", "go2", DOG),
        model("empty.xml", "", ()),
    ]
    found = pair(artifacts)
    assert sorted(i for robot in found for i in robot.artifacts) == [0, 1, 2, 3]
    assert [robot.artifacts for robot in found if 1 in robot.artifacts] == [(1, 2)]


@pytest.mark.parametrize(
    ("path", "name", "words"),
    [
        ("unitree_robots/go2/scene.xml", "go2 scene", {"go2"}),
        ("h1_2_description/h1_2.urdf", "h1_2", {"h1_2"}),
        ("a/g1_29dof_rev_1_0.xml", "g1_29dof", {"g1"}),
        ("anymal/anymal_c.xml", "", {"anymal_c"}),
        ("go2/robot.xml", "MuJoCo Model", {"go2"}),
        ("x/robot.xml", "robot", set()),
    ],
    ids=["scene", "underscore", "dof", "letter", "folder", "nothing"],
)
def test_words_that_tell(path: str, name: str, words: set[str]) -> None:
    """What is left of a name without the words that every robot file has."""
    assert distinctive(model(path, name, ())) == words


@pytest.mark.parametrize(
    ("framework", "pattern", "selected"),
    [
        (Framework.ISAACLAB, "hip", ()),
        (Framework.ISAACLAB, ".*hip", ("l_hip",)),
        (Framework.LEGGED_GYM, "hip", ("l_hip", "hip_2")),
        (Framework.DEPLOY, "hip_2", ("hip_2",)),
        (Framework.MJLAB, "(a+)+$", ()),
    ],
    ids=["in-full", "regex", "part", "name", "refused"],
)
def test_each_framework_matches_in_its_way(
    framework: Framework, pattern: str, selected: tuple[str, ...]
) -> None:
    """The same text means other joints to Isaac Lab, legged_gym and a deploy file."""
    assert matching(framework, pattern, ("l_hip", "hip_2", "aaa")) == selected


def _with(artifact: Artifact, path: str, scales: Sequence[float]) -> Artifact:
    """The model with ranges, effort and speed limits of its own: 1 rad, 10 N*m and 20 rad/s times the scales."""
    assert artifact.robot is not None
    turn, effort, speed = scales
    joints = tuple(
        replace(
            joint,
            range=(-turn, turn),
            effort_range=(-10.0 * effort, 10.0 * effort),
            velocity_limit=20.0 * speed,
        )
        for joint in artifact.robot.joints
    )
    return replace(artifact, path=path, robot=replace(artifact.robot, path=path, joints=joints))


@pytest.mark.parametrize(
    ("scales", "count"),
    [((1.0, 9.0, 1.0), 1), ((1.0, 9.0, 0.5), 2), ((57.29577951, 1.0, 0.5), 1), ((1.5, 3.0, 0.5), 2)],
    ids=["limits wrong", "one third agrees", "in degrees", "nothing agrees"],
)
def test_figures_tell_robots_apart(scales: tuple[float, float, float], count: int) -> None:
    """Two models of one format with the same joints are one robot where half of their figures are the same."""
    base = model("one/arm.xml", "arm", ARM)
    pairs = pair([_with(base, "one/arm.xml", (1.0, 1.0, 1.0)), _with(base, "two/arm.xml", scales)])
    assert len(pairs) == count


@pytest.mark.parametrize(
    ("name", "turn", "by_hand", "count"),
    [
        ("picker", 1.0, (0, 1), 1),
        ("picker", 1.0, (0,), 2),
        ("picker", 1.5, (0, 1), 2),
        ("reacher", 1.0, (0, 1), 2),
        ("arm", 1.0, (0, 1), 1),
    ],
    ids=["one-body", "one-was-met", "another-body", "another-name", "one-kind-in-one-folder"],
)
def test_a_series_of_files_that_somebody_named(
    name: str, turn: float, by_hand: Sequence[int], count: int
) -> None:
    """`arm1.xml` and `arm2.xml`, one name inside, are one robot whose joints turn as far; in a folder nobody says so.

    Of another name they are two: nothing is known of their links, and ranges are the same on many robots.
    """
    one = _with(model("arm1.xml", "arm" if name == "arm" else "picker", ARM), "arm1.xml", (1.0, 1.0, 1.0))
    other = _with(model("arm2.xml", name, ARM), "arm2.xml", (turn, 0.1, 1.0))
    assert len(pair([one, other], by_hand=by_hand)) == count


@pytest.mark.parametrize(("heavier", "one_body"), [(4, False), (2, True)])
def test_heavier_links_are_of_the_next_robot(heavier: int, one_body: bool) -> None:
    """HyQReal 1 and 2: all ranges are equal, and 8 of 12 inertias: 0.83 in the mean, and 0.67 < 0.8 of the links.

    Of 10 of 12 the inertias agree with 0.83. Where names say that it is one robot, the mean counts.
    """
    joints = [f"joint{i}" for i in range(12)]
    ranges = dict.fromkeys(joints, (-1.0, 2.0))
    first = {"range": ranges, "inertia": dict.fromkeys(joints, (0.0785,))}
    second = {"range": ranges, "inertia": {**first["inertia"], **dict.fromkeys(joints[:heavier], (0.1389,))}}
    assert share_a_body(first, second, names=False) is one_body
    assert share_a_body(first, second, names=True)


def test_formats_are_compared_whatever_they_say() -> None:
    """An MJCF and a URDF of one name are there to be held to each other."""
    base = model("arm.xml", "arm", ARM)
    urdf = replace(_with(base, "arm.urdf", (1.5, 3.0, 0.5)), kind=FileKind.URDF)
    assert len(pair([_with(base, "arm.xml", (1.0, 1.0, 1.0)), urdf])) == 1


def test_two_robots_of_one_name_in_two_folders() -> None:
    """No figure of the MJCFs and of the URDFs agrees: each folder's two files are one robot, though an MJCF and a URDF
    of one name are compared whatever they say. A list of joints is the nearest folder's, as its joints are both's.
    """
    base = model("arm.xml", "arm", ARM)
    big, small = (1.0, 1.0, 1.0), (1.5, 3.0, 0.5)
    one = [_with(base, "big/arm.xml", big), replace(_with(base, "big/arm.urdf", big), kind=FileKind.URDF)]
    other = [
        _with(base, "small/arm.xml", small),
        replace(_with(base, "small/urdf/arm.urdf", small), kind=FileKind.URDF),
    ]
    lists = [
        _listed(path, "arm_props", ARM, FileKind.DEPLOY)
        for path in ("big/arm_props.yaml", "small/urdf/arm_props.yaml")
    ]
    for artifacts in ([*one, *other, *lists], [*lists, *other, *one], [lists[1], *one, lists[0], *other]):
        folders = [
            {artifacts[i].path.partition("/")[0] for i in robot.artifacts} for robot in pair(artifacts)
        ]
        assert sorted(map(sorted, folders)) == [["big"], ["small"]]


def test_a_scene_is_called_as_the_model_in_it() -> None:
    """A scene that was copied with another robot's name has all of its joints in the file of this one's model."""
    arm = model("arm/robot.xml", "picker", ARM)
    assert arm.robot is not None
    joints = tuple(replace(joint, span=Span("arm/robot.xml", 1)) for joint in arm.robot.joints)
    scene = replace(
        model("arm/scene.xml", "reacher_scene", ARM),
        robot=replace(arm.robot, path="arm/scene.xml", joints=joints),
    )
    assert len(pair([arm, scene])) == 1
    assert len(pair([arm, model("arm/scene.xml", "reacher_scene", ARM)])) == 2


def test_folders_tell_versions_apart() -> None:
    """`anymal.urdf` of ANYmal B and of C, by folders further up; folders that tell nothing do not part copies."""
    paths = ("anymal_b_description/urdf/anymal.xml", "anymal_c_description/urdf/anymal.xml")
    assert len(pair([model(path, "anymal", DOG) for path in paths])) == 2
    copies = ("run_1/urdf/anymal.xml", "run_2/urdf/anymal.xml", "anymal_b_description/urdf/anymal.xml")
    assert len(pair([model(path, "anymal", DOG) for path in copies])) == 1


@pytest.mark.parametrize(
    ("one", "other", "count"),
    [
        ("gr1t1_hand_x", "gr2t2_hand_x", 2),
        ("gr2t2_x7", "gr2t2d_x7", 1),
        ("kuka_kr16", "kuka_kr120", 2),
        ("dog_v2", "dog_v3", 1),
    ],
)
def test_numbers_in_names(one: str, other: str, count: int) -> None:
    """A family's robots have numbers; versions and what only adds to a name are the same robot."""
    artifacts = [model(f"{name}.xml", f"acme_{name}", ARM) for name in (one, other)]
    assert len(pair(artifacts)) == count


def test_a_scene_is_of_the_robot_that_it_includes() -> None:
    """Its own name says where the robot stands."""
    scene = model("go2/mujoco/scene_terrain.xml", "scene", DOG)
    assert scene.robot is not None
    files = (
        ModelFile("go2/mujoco/scene_terrain.xml", "", b""),
        ModelFile("go2/mujoco/go2.xml", "go2.xml", b""),
    )
    scene = replace(scene, robot=replace(scene.robot, files=files))
    assert distinctive(scene) == {"go2"}
    assert len(pair([model("a1/a1.urdf", "a1", DOG), scene])) == 2
    assert len(pair([model("go2/go2.urdf", "go2", DOG), scene])) == 1


def test_a_kind_of_robot_is_no_name() -> None:
    """A generated humanoid's cfg is not held to the one humanoid in another folder with its joints; a sibling is."""
    lite = model("assets/lite_humanoid/lite_humanoid.xml", "lite_humanoid", DOG)
    assert (
        len(
            pair(
                [
                    lite,
                    config("gen/humanoid_env.py", "PROCEDURAL_HUMANOID_CFG", [".*"]),
                    model("z.xml", "z9", ARM),
                ]
            )
        )
        == 3
    )
    assert len(pair([lite, config("gen/scene.py", "HUMANOID_CFG", LEGS), model("z.xml", "z9", ARM)])) == 3
    assert (
        len(
            pair([model("x_biped/urdf/biped.urdf", "biped", DOG), model("x_biped/xml/sf_biped.xml", "", DOG)])
        )
        == 1
    )
    assert len(pair([model("x9/biped.urdf", "biped", DOG), model("y9/sf_biped.xml", "", DOG)])) == 2


def test_a_file_that_is_called_nothing() -> None:
    """It belongs to the only robot with all of its joints, and to none where there are two."""
    deploy = model("configs/config.xml", "", DOG)
    go1, go2 = model("a/go1.xml", "go1", DOG), model("b/go2.xml", "go2", DOG)
    home = model("assets/go1/go1.xml", "go1", DOG)
    assert _together(home, replace(deploy, path="/configs/config.xml")) == [(0, 1)]
    assert _together(go1, go2, replace(deploy, path="/configs/config.xml")) == [(0,), (1,), (2,)]


def test_a_cfg_is_of_the_robot_whose_file_it_names() -> None:
    """What it is called says nothing then."""
    named = config("cfg/task.py", "ROBOT_CFG", LEGS)
    assert named.config is not None
    settings = {"model": Setting("{ROOT}/go1/urdf/go1.urdf", Span("cfg/task.py", 3))}
    named = replace(named, config=replace(named.config, settings=settings))
    assert _together(model("a/go1.urdf", "go1", DOG), model("b/go2.urdf", "go2", DOG), named) == [
        (0, 2),
        (1,),
    ]


def test_an_environment_is_of_the_robot_of_the_constant_that_it_imports() -> None:
    """It has its actuators, at their places, and its model; with another model, or actuators of its own, it is open."""

    def loading(usd: str, name: str, at: str) -> Artifact:
        found = config(at, name, LEGS)
        assert found.config is not None
        return replace(found, config=replace(found.config, settings={"model": Setting(usd, Span(at, 3))}))

    robots = model("a/trotter.urdf", "trotter", DOG), model("b/strider.urdf", "strider", DOG)
    constant = loading("loop.usd", "TROTTER_CFG", "a/trotter_cfg.py")
    task = replace(loading("loop.usd", "BoxEnvCfg", "a/trotter_cfg.py"), path="tasks/box_env_cfg.py")
    assert _together(*robots, constant, task) == [(0, 2, 3), (1,)]
    assert _together(*robots, task, constant) == [(0, 2, 3), (1,)]
    other = replace(loading("arm.usd", "BoxEnvCfg", "a/trotter_cfg.py"), path="tasks/box_env_cfg.py")
    assert _together(*robots, constant, other) == [(0, 2), (1,), (3,)]
    own = loading("loop.usd", "BoxEnvCfg", "tasks/box_env_cfg.py")
    assert _together(*robots, constant, own) == [(0, 2), (1,), (3,)]


def _mapped(path: str, keys: Sequence[str]) -> Artifact:
    """A deploy file that names its joints by the keys of its mappings."""
    stem = path.rpartition("/")[2].partition(".")[0]
    found = config(path, stem, keys, Framework.DEPLOY)
    return replace(found, kind=FileKind.DEPLOY)


def test_a_cfg_and_a_mapping_with_its_keys() -> None:
    """Without a model, equal texts are of the same joints; another robot's name, or a second file, leaves it open."""
    cfg = config("t/go2_cfg.py", "GO2_CFG", ["hip", "knee"])
    assert _together(cfg, _mapped("t/go2_deploy.yaml", ["hip", "knee"])) == [(0, 1)]
    # They are alone.
    assert _together(cfg, _mapped("t/walk.yaml", ["hip", "knee"])) == [(0, 1)]
    # One of two keys is less than 0.8; what a pattern selects is not asked.
    assert _together(cfg, _mapped("t/go2_deploy.yaml", ["hip", "ankle"])) == [(0,), (1,)]
    patterns = config("t/go2_cfg.py", "GO2_CFG", [".*hip", ".*knee"])
    assert _together(patterns, _mapped("t/go2_deploy.yaml", ["hip", "knee"])) == [(0,), (1,)]
    assert _together(patterns, _mapped("t/go2_deploy.yaml", [".*hip", ".*knee"])) == [(0, 1)]
    everything = config("t/go2_cfg.py", "GO2_CFG", [".*"])
    assert _together(everything, _mapped("t/go2_deploy.yaml", [".*"])) == [(0,), (1,)]
    other = config("t/go1_cfg.py", "GO1_CFG", ["hip", "knee"])
    assert _together(cfg, other, _mapped("t/go2_deploy.yaml", ["hip", "knee"])) == [(0, 2), (1,)]
    two = [_mapped(f"t/go2_{name}.yaml", ["hip", "knee"]) for name in ("walk", "stand")]
    assert _together(cfg, *two) == [(0,), (1,), (2,)]
    # A model has the say, as ever.
    robot = model("t/go2.xml", "go2", ["hip", "knee"])
    assert _together(robot, cfg, _mapped("t/go2_deploy.yaml", ["hip", "knee"])) == [(0, 1, 2)]


def _listed(path: str, name: str, joints: Sequence[str], kind: FileKind = FileKind.CFG) -> Artifact:
    """A configuration or deploy file that lists its joints."""
    framework = Framework.DEPLOY if kind is FileKind.DEPLOY else Framework.ISAACLAB
    found = config(path, name, joints, framework)
    assert found.config is not None
    settings = {"joint_order": Setting(tuple(joints), Span(path, 1))}
    return replace(found, kind=kind, config=replace(found.config, settings=settings))


@pytest.mark.parametrize("first", [0, 1], ids=["before both", "behind both"])
@pytest.mark.parametrize("lists", [True, False], ids=["with lists", "with patterns"])
def test_a_deploy_file_without_a_name_is_of_the_robot_with_just_its_joints(lists: bool, first: int) -> None:
    """Of 15 joints 12 are the dog's, all 15 the dog's with an arm, whichever stands first."""
    deploy = _listed("t/deploy.yaml", "deploy", (*DOG, *ARM), FileKind.DEPLOY)
    make = _listed if lists else config
    dog, armed = make("t/robots.py", "LYNX_CFG", DOG), make("t/robots.py", "TITAN_CFG", (*DOG, *ARM))
    for pair_of in ([dog, armed], [armed, dog]):
        files = [*pair_of, deploy] if first else [deploy, *pair_of]
        (both,) = (group for group in _together(*files) if len(group) > 1)
        assert {files[i].name for i in both} == {"TITAN_CFG", "deploy"}


def test_a_deploy_file_without_a_name_beside_two_robots_of_equal_joints() -> None:
    """A Go1 and a B2 have the same joints, and none is chosen; a robot and its environment are one."""
    deploy = _listed("t/deploy.yaml", "deploy", DOG, FileKind.DEPLOY)
    two = [_listed("t/unitree.py", f"UNITREE_{name}_CFG", DOG) for name in ("GO1", "B2")]
    assert _together(*two, deploy) == [(0,), (1,), (2,)]
    task = _listed("t/tracking_env_cfg.py", "TrackingCfg", DOG)
    assert _together(two[0], task, deploy) == [(0, 2), (1,)]


def test_a_deploy_file_beside_its_run_is_called_as_that() -> None:
    """`deploy.yaml` of the Go2's run is no Go1's, though every run has it in a folder `params`."""
    files = [
        _listed("one/params/env.yaml", "go1", DOG),
        _listed("one/params/deploy.yaml", "deploy", DOG, FileKind.DEPLOY),
        _listed("two/params/env.yaml", "go2", DOG),
        _listed("two/params/deploy.yaml", "deploy", DOG, FileKind.DEPLOY),
    ]
    assert [robot.artifacts for robot in pair(files, records=(0, 2))] == [(0, 1), (2, 3)]
    assert [robot.artifacts for robot in pair(files)] == [(0,), (1,), (2,), (3,)]


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("deploy/robots/go2/config/policy/velocity/v0/params/deploy.yaml", "go2"),
        ("deploy/robots/go2/config/policy/velocity/params/deploy.yaml", "go2"),
        ("deploy/robots/g1_29dof/config/policy/mimic/dance_102/params/deploy.yaml", "g1"),
        ("deploy/robots/h1_2/config/policy/velocity/v0/params/deploy.yaml", "h1_2"),
        ("logs/rsl_rl/unitree_go2_velocity/2026-01-31_10-20-30/params/deploy.yaml", "go2"),
        # The folder tells, and so does the file.
        ("robots/b2/config/policy/velocity/v0/go2/deploy.yaml", "go2"),
        ("deploy/robots/b2/config/policy/velocity/v0/params/go2.yaml", "go2"),
    ],
)
def test_a_policys_folder_is_called_as_its_robot(path: str, name: str) -> None:
    """unitree_rl_lab's program finds its file below the robot's folder, so that it can be called nothing else."""
    deploy = _listed(path, "deploy", DOG, FileKind.DEPLOY)
    assert distinctive(deploy) == {name}
    robots = [
        _listed("t/unitree.py", f"UNITREE_{one.upper()}_CFG", DOG) for one in ("go2", "b2", "g1", "h1_2")
    ]
    (both,) = (group for group in _together(*robots, deploy) if len(group) > 1)
    assert robots[both[0]].name == f"UNITREE_{name.upper()}_CFG"
