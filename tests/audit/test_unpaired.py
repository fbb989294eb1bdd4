"""Files that have a model's joints and are not compared with it."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.read import pending_files
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity, Span
from actspec.readings.artifact import Framework
from actspec.readings.joint_names import matching
from actspec.report import ReportOptions, render

MODEL = """<mujoco model="biped">
  <worldbody><body><joint name="hip"/><joint name="knee" axis="1 0 0"/><geom size="0.1"/></body></worldbody>
</mujoco>"""
DEPLOY = "joint_names: [{}]\nkp: [4, 5]\nkd: [1, 1]\n"


@pytest.mark.parametrize(
    ("name", "joints", "robots", "reported"),
    [
        ("walk.yaml", "hip, knee", 1, False),
        ("dep2.yaml", "hip, knee", 1, False),
        ("h1_walk.yaml", "hip, knee", 1, False),
        ("deploy.yaml", "hip, knee", 1, False),
        ("g1_walk.yaml", "hip, knee", 2, True),
        # One of two joints is less than 0.8.
        ("walk.yaml", "hip, elbow", 2, False),
    ],
    ids=["no-robot", "number", "its-name", "no-name", "another-name", "other-joints"],
)
@pytest.mark.parametrize("beside", ["h1.xml", "h1_cfg.py"])
def test_another_name(
    beside: str,
    name: str,
    joints: str,
    robots: int,
    reported: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A deploy file with the joints of what was named with it is compared, unless it is called as another robot is."""
    monkeypatch.chdir(tmp_path)
    Path("h1.xml").write_text(MODEL.replace("biped", "h1"))
    Path("h1_cfg.py").write_text(CFG.format('"hip", "kn.*"').replace("ROVER", "H1"))
    Path(name).write_text(DEPLOY.format(joints))
    with pending_files((beside, name)) as pending:
        report = audit(pending, Settings(select=("SRC103",)))
    assert len(report.case.robots) == robots
    found = [str(item).partition("\n")[0] for item in report.for_people()]
    message = f"this has the joints of {beside}, and is not compared with it: no name shows that it is the same robot"
    assert found == ([f"{name}: AUD015 [info]: {message}"] if reported else [])
    # The configuration has 9 N*m/rad at both joints, the deploy file 4 and 5; the model has no drives.
    told = [(one.finding.joint, one.finding.value, one.finding.expected) for one in report.findings]
    assert told == ([("hip", 4.0, 9.0), ("knee", 5.0, 9.0)] if robots == 1 and beside == "h1_cfg.py" else [])


def test_a_mapping_beside_patterns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The name is there, and what helps is a list: then the hip's 4 N*m/rad are compared with 9, and the knee's 5."""
    monkeypatch.chdir(tmp_path)
    Path("h1_cfg.py").write_text(CFG.format('"hip", "kn.*"').replace("ROVER", "H1"))
    mappings = "kp: {hip: 4, knee: 5}\nkd: {hip: 1, knee: 1}\n"
    Path("h1_deploy.yaml").write_text(mappings)
    report = audit(["h1_cfg.py", "h1_deploy.yaml"], Settings())
    (told,) = [one for one in report.diagnostics() if one.code == "AUD015"]
    start = "this has the joints of h1_cfg.py, and is not compared with it: "
    assert (told.message, told.help) == (
        f"{start}it has no list of joint names",
        "add joint_names: [...] with its 2 joints",
    )
    Path("h1_deploy.yaml").write_text("joint_names: [hip, knee]\n" + mappings)
    report = audit(["h1_cfg.py", "h1_deploy.yaml"], Settings(select=("SRC103",)))
    assert [one.finding.joint for one in report.findings] == ["hip", "knee"]
    assert not [one for one in report.diagnostics() if one.code == "AUD015"]


def test_two_deploy_files_of_one_configuration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Which of them runs the policy is not known: neither is compared, and both are told. Nor is one of a folder."""
    monkeypatch.chdir(tmp_path)
    Path("h1_cfg.py").write_text(CFG.format('"hip", "kn.*"').replace("ROVER", "H1"))
    for name in ("stand.yaml", "walk.yaml"):
        Path(name).write_text(DEPLOY.format("hip, knee"))
    report = audit(["h1_cfg.py", "stand.yaml", "walk.yaml"], Settings())
    assert len(report.case.robots) == 3
    told = [one for one in report.diagnostics() if one.code == "AUD015"]
    assert [one.span for one in told] == [Span("stand.yaml"), Span("walk.yaml")]
    assert [one.help for one in told] == ["write the robot's name into the file's name"] * 2
    assert len(audit(["h1_cfg.py", "walk.yaml"], Settings()).case.robots) == 1
    Path("stand.yaml").unlink()
    # A robot that is called after its file is none of one that is called otherwise, in a folder.
    spawn = 'spawn=sim_utils.UsdFileCfg(usd_path="h1.usd"),\n    actuators='
    text = Path("h1_cfg.py").read_text().replace("actuators=", spawn, 1)
    Path("h1_cfg.py").write_text("import isaaclab.sim as sim_utils\n" + text)
    assert len(audit(["."], Settings()).case.robots) == 2
    assert not any(one.code == "AUD015" for one in audit(["."], Settings()).diagnostics())


def test_an_environment_and_its_robot_are_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both in one file, and the environment's robot is that constant: a deploy file belongs to both, and not to two."""
    monkeypatch.chdir(tmp_path)
    env = """
class RoverEnvCfg(DirectRLEnvCfg):
    decimation = 4
    robot = ROVER_CFG
"""
    other = CFG.format('"hip", "kn.*"').replace("ROVER", "CRANE").partition("\n\n")[0]
    text = CFG.format('"hip", "kn.*"')
    for more, robots in ((env, 1), (env + other[other.index("CRANE") :], 4)):
        Path("train.py").write_text("from isaaclab.envs import DirectRLEnvCfg\n" + text + more)
        Path("walk.yaml").write_text(DEPLOY.format("hip, knee"))
        found = audit(["train.py", "walk.yaml"], Settings()).case.robots
        assert len(found) == robots, found


CFG = """from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg
ROVER_CFG = ArticulationCfg(
    actuators={{"legs": ImplicitActuatorCfg(joint_names_expr=[{}], stiffness=9.0, damping=1.0)}}
)
"""


@pytest.mark.parametrize(
    ("patterns", "reported"),
    [('"hip", "kn.*"', True), ('".*"', False), ('"hip", "elbow"', False)],
)
def test_a_configuration_among_several_robots(
    patterns: str, reported: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Alone with a model it is taken for its robot's; beside another robot it is said that it is not compared."""
    monkeypatch.chdir(tmp_path)
    Path("biped.xml").write_text(MODEL)
    Path("crane.xml").write_text(
        MODEL.replace("biped", "crane").replace("hip", "boom").replace("knee", "jib")
    )
    Path("train.py").write_text(CFG.format(patterns))
    said = audit(["biped.xml", "crane.xml", "train.py"], Settings(select=("SRC103",))).for_people()
    assert [item.code for item in said] == (["AUD015"] if reported else [])


def _arm(name: str, torque: float, mass: float = 3.0) -> str:
    """An arm of two joints, whose first motor is bounded."""
    return f"""<mujoco model="{name}">
  <compiler angle="radian"/>
  <worldbody>
    <body><joint name="lift" axis="0 1 0" range="-1.9 1.9"/><geom size="0.1" mass="{mass}"/>
      <body pos="0.4 0 0"><joint name="elbow" axis="0 1 0" range="-2.6 2.6"/><geom size="0.1" mass="{mass}"/></body>
    </body>
  </worldbody>
  <actuator>
    <motor joint="lift" forcerange="-{torque} {torque}"/>
    <motor joint="elbow" forcerange="-60 60"/>
  </actuator>
</mujoco>"""


def test_a_series_of_files_hides_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of three, named by hand, the third has 15 N*m where the others have 150: it is told. Not in a folder."""
    monkeypatch.chdir(tmp_path)
    Path("set").mkdir()
    files = [f"set/arm{number}.xml" for number in (1, 2, 3)]
    for file, torque in zip(files, (150, 150, 15), strict=True):
        Path(file).write_text(_arm("picker", torque))
    (found,) = audit(files, Settings(select=("SRC101",))).findings
    assert (found.finding.span.path, found.finding.joint) == ("set/arm3.xml", "lift")
    assert (found.finding.value, found.finding.expected) == (15.0, 150.0)
    report = audit(["set"], Settings(select=("SRC101",)))
    assert report.findings == ()
    # Nor does a note say how to have it: the last line does, once, and only where nobody said so already.
    hint = "no findings in 3 files; --as-named judges a folder of your own\n"
    assert render(report, "concise", ReportOptions(least=Severity.WARNING)) == hint
    assert render(report, "markdown", ReportOptions()).startswith(f"### actspec audit: {hint}")
    for own in (
        audit(["set"], Settings(as_named=True)),
        audit(files, Settings()),
        audit(["set"], Settings()),
    ):
        least = ReportOptions(least=Severity.WARNING)
        text = render(own, "concise", least)
        assert text.count("--as-named") == own.case.is_met(0), text


@pytest.mark.parametrize(
    ("name", "mass", "compared"),
    [
        ("my_picker", 3.0, True),
        ("mypicker", 3.0, True),
        ("picker_a", 3.0, True),
        # The same ranges: half of what tells a body speaks for one, half against it.
        ("picker_a", 9.0, False),
    ],
)
def test_a_model_of_another_name(
    name: str, mass: float, compared: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two models that somebody named, with the same joints and links, are compared whatever they are called."""
    monkeypatch.chdir(tmp_path)
    Path("one.xml").write_text(_arm("picker", 150))
    Path("other.xml").write_text(_arm(name, 15, mass))
    report = audit(["one.xml", "other.xml"], Settings(select=("SRC101",)))
    assert bool(report.findings) is compared
    assert report.diagnostics() == ()


def test_two_models_that_nothing_shows_to_be_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """B and C of a robot, both called so inside, with other masses: it is said that they are not compared."""
    monkeypatch.chdir(tmp_path)
    Path("crane_b.xml").write_text(_arm("crane", 150))
    Path("crane_c.xml").write_text(_arm("crane", 15, 9.0))
    report = audit(["crane_b.xml", "crane_c.xml"], Settings(select=("SRC101",)))
    assert report.findings == ()
    (said,) = report.diagnostics()
    assert said.code == "AUD015" and said.span == Span("crane_c.xml")
    assert said.message.startswith(
        "this has the joints of crane_b.xml, and is not compared with it: names, ranges"
    )
    assert said.help is not None and "`actspec diff crane_b.xml crane_c.xml`" in said.help
    assert audit(["."], Settings(select=("SRC101",))).diagnostics() == ()


def test_files_of_one_name_are_told_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two robots have a scene.xml: which one has the joints is told by its path; one name alone needs none."""
    monkeypatch.chdir(tmp_path)
    for folder, model in (
        ("h1", MODEL.replace("biped", "h1")),
        ("crane", MODEL.replace("biped", "crane").replace("hip", "boom")),
    ):
        Path(folder).mkdir()
        Path(folder, "scene.xml").write_text(model)
    Path("g1_walk.yaml").write_text(DEPLOY.format("hip, knee"))
    files = ["h1/scene.xml", "crane/scene.xml", "g1_walk.yaml"]

    def told(*names: str) -> str:
        (said,) = [one for one in audit(names, Settings()).diagnostics() if one.code == "AUD015"]
        return said.message.partition(",")[0]

    assert told(*files) == "this has the joints of h1/scene.xml"
    Path("crane/scene.xml").rename("crane/floor.xml")
    assert told(files[0], "crane/floor.xml", files[2]) == "this has the joints of scene.xml"


def test_one_of_two_configurations_of_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the other one is compared, it is told which is not, by its name and line."""
    monkeypatch.chdir(tmp_path)
    Path("biped.xml").write_text(MODEL)
    Path("train.py").write_text(CFG.format('"hip"').replace("ROVER", "BIPED") + "\n" + CFG.format('"knee"'))
    Path("crane.xml").write_text(MODEL.replace("biped", "crane"))
    (said,) = [
        one
        for one in audit(["biped.xml", "crane.xml", "train.py"], Settings()).diagnostics()
        if one.code == "AUD015"
    ]
    assert said.message.startswith(
        "`ROVER_CFG` has the joints of biped.xml, crane.xml, and is not compared with them:"
    )
    assert said.span.line == 9 and said.help == "write the robot's name into this configuration's name"


@pytest.mark.parametrize(
    ("name", "turn", "told"),
    [("picker", "-1.9", True), ("loader", "-1.9", False), ("picker", "-1.7", False)],
    ids=["one-robot", "another-name", "another-range"],
)
def test_a_model_that_calls_the_joints_otherwise(
    name: str, turn: str, told: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`elbow` and `elbow_joint` of a robot are not compared; that is said of two files that somebody named."""
    monkeypatch.chdir(tmp_path)
    Path("one.xml").write_text(_arm("picker", 150))
    other = _arm(name, 15).replace('"lift"', '"lift_joint"').replace('"elbow"', '"elbow_joint"')
    Path("other.xml").write_text(other.replace("-1.9", turn))
    report = audit(["one.xml", "other.xml"], Settings(select=("SRC101",)))
    message = "this has the joints of one.xml, and is not compared with it: it calls them otherwise"
    assert [item.message for item in report.diagnostics()] == [message] * told
    assert audit(["."], Settings(select=("SRC101",))).diagnostics() == ()


@pytest.mark.parametrize(
    ("name", "model", "compared"),
    [
        ("TROTTER_CFG", "/data/trotter.usd", False),
        ("TROTTER_12DOF_CFG", "/data/trotter_flat.usd", False),
        # One of the two may be a task's name, or say nothing.
        ("TROTTER_CFG", "/data/robot.usd", True),
        ("ROBOT_CFG", "/data/trotter.usd", True),
        ("HUMANOID_CFG", "/data/humanoid.usd", True),
        # What either calls it is in a name of the other.
        ("MY_STRIDER_CFG", "/data/my_strider.usd", True),
        ("TROTTER_CFG", "/strider/trotter.usd", True),
        ("STRID_CFG", "/data/strid.usd", True),
    ],
)
def test_a_configuration_of_another_robot(
    name: str, model: str, compared: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside the only model with its joints it is compared, unless it and the file that it loads have another name."""
    monkeypatch.chdir(tmp_path)
    Path("strider.xml").write_text(MODEL.replace("biped", "strider"))
    spawn = f'spawn=sim_utils.UsdFileCfg(usd_path="{model}"),\n    actuators='
    config = CFG.format('"hip", "knee"').replace("ROVER_CFG", name).replace("actuators=", spawn)
    Path("train.py").write_text("import isaaclab.sim as sim_utils\n" + config)
    report = audit(["strider.xml", "train.py"], Settings())
    assert [len(robot.artifacts) for robot in report.case.robots] == ([2] if compared else [1, 1])
    assert ("AUD015" in {item.code for item in report.diagnostics()}) is not compared


LISTS = "kp: [20, 20]\nkd: [{0}, {0}]\n"
"""Lists without joint names."""


def test_a_scene_is_of_the_robot_in_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene that is called after its ground keeps no file of the robot's from it, in whatever order they come."""
    monkeypatch.chdir(tmp_path)
    Path("picker.xml").write_text(_arm("picker", 150))
    Path("boxes.xml").write_text('<mujoco model="boxes"><include file="picker.xml"/></mujoco>')
    Path("picker_real.yaml").write_text("joint_names: [lift, elbow]\n" + LISTS.format(0.5))
    Path("picker_sim.yaml").write_text(LISTS.format(5))
    files = ["boxes.xml", "picker.xml", "picker_real.yaml", "picker_sim.yaml"]
    for order in (files, files[::-1]):
        (robot,) = audit(order, Settings()).case.robots
        assert len(robot.artifacts) == 4


def test_lists_that_several_robots_may_have(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lists without names in a file that is called as two robots are: it is said that they are compared with none."""
    monkeypatch.chdir(tmp_path)
    Path("picker_one.xml").write_text(_arm("picker_one", 150))
    other = _arm("picker_two", 15, 9.0).replace('range="-1.9 1.9"', 'range="-1 1"').replace("60", "6")
    Path("picker_two.xml").write_text(other.replace('range="-2.6 2.6"', 'range="-1.5 1.5"'))
    Path("picker.yaml").write_text(LISTS.format(5))
    Path("crane.yaml").write_text(LISTS.format(5))
    files = ["picker_one.xml", "picker_two.xml", "picker.yaml", "crane.yaml"]
    said = audit(files, Settings()).diagnostics()
    (told,) = (item for item in said if item.span is not None and item.span.path.endswith(".yaml"))
    assert str(told).partition("\n")[0] == (
        "picker.yaml: AUD015 [info]: this has the joints of picker_one.xml, picker_two.xml, and is not compared "
        "with them: several robots are called so"
    )
    assert told.help == "add joint_names: [...] in the order of its lists"
    said = audit(["."], Settings()).diagnostics()
    assert not any(item.span is not None and item.span.path.endswith(".yaml") for item in said)


def test_a_scene_has_the_more_exact_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene of the second picker, called `picker scene` by who copied it, is no reason to part its deploy file."""
    monkeypatch.chdir(tmp_path)
    for name in ("picker", "picker_2"):
        Path(name).mkdir()
        Path(name, f"{name}.xml").write_text(_arm(name, 150))
        Path(name, "scene.xml").write_text(
            f'<mujoco model="picker scene"><include file="{name}.xml"/></mujoco>'
        )
    Path("picker_2.yaml").write_text(LISTS.format(5))
    case = audit(["picker", "picker_2", "picker_2.yaml"], Settings()).case
    members = [{case.artifacts[index].path for index in robot.artifacts} for robot in case.robots]
    assert {"picker_2.yaml", "picker_2/picker_2.xml", "picker_2/scene.xml"} in members


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        (
            "train.py",
            CFG.format('"H.*", ".*EE"'),
            ("`ROVER_CFG` has the joints of biped.xml", "write 'h.*', '.*ee'"),
        ),
        (
            "biped_walk.yaml",
            DEPLOY.format("Hip, Knee"),
            ("this has the joints of biped.xml", "write 'hip', 'knee'"),
        ),
        # One of two, and another word.
        ("train.py", CFG.format('"HIP", ".*_shank"'), None),
    ],
)
def test_names_in_other_letters(
    file: str, text: str, said: tuple[str, str] | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No pattern matches a joint, so nothing is compared: the cause is told of files that were named."""
    monkeypatch.chdir(tmp_path)
    Path("biped.xml").write_text(MODEL)
    Path(file).write_text(text)
    found = [one for one in audit(["biped.xml", file], Settings()).diagnostics() if one.code == "AUD015"]
    why = ", and is not compared with it: its names have other capital letters"
    assert [(one.message, one.help) for one in found] == (
        [] if said is None else [(said[0] + why, f"if it is the same robot, {said[1]}")]
    )
    assert not any(one.code == "AUD015" for one in audit(["."], Settings()).diagnostics())


@pytest.mark.parametrize(
    ("name", "mass", "severity"),
    [
        ("picker", 3.0, "warning"),
        # Another robot's arm: `Joint1` and `joint1` are half of all arms'.
        ("crane", 3.0, None),
        # A maker's i7 and i10 share one word.
        ("picker_ten", 3.0, None),
        # Names and ranges alone: a note, which knows of no letters.
        ("picker", 9.0, "info"),
    ],
    ids=["one", "another-name", "a-word-of-it", "another-body"],
)
def test_joints_that_differ_in_capital_letters(
    name: str, mass: float, severity: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """MuJoCo has `Lift` beside `lift` as two joints: a limit of a tenth is compared with none, which is told."""
    monkeypatch.chdir(tmp_path)
    Path("picker.xml").write_text(_arm("picker", 150))
    Path("other.xml").write_text(
        _arm(name, 15, mass).replace('"lift"', '"Lift"').replace('"elbow"', '"Elbow"')
    )
    report = audit(["picker.xml", "other.xml"], Settings(select=("SRC101",)))
    assert report.findings == ()
    said = [(one.code, one.severity.value) for one in report.diagnostics()]
    assert said == ([("AUD015", severity)] if severity else [])
    if severity == "warning":
        assert report.diagnostics()[0].message == (
            "this has the joints of picker.xml, and is not compared with it: names differ in capital letters "
            "(`Elbow` here, `elbow` there), which MuJoCo, Isaac Lab and mjlab tell apart"
        )
    assert audit(["."], Settings(select=("SRC101",))).diagnostics() == ()


def test_engines_tell_capital_letters_apart() -> None:
    """Two joints, and no joint for a motor that spells it otherwise; patterns are matched likewise."""
    import mujoco

    both = _arm("picker", 150).replace('"elbow"', '"Lift"')
    model = mujoco.MjModel.from_xml_string(both)
    assert model.joint("lift").id != model.joint("Lift").id
    with pytest.raises(ValueError, match="unknown transmission target"):
        mujoco.MjModel.from_xml_string(both.replace('<joint name="Lift"', '<joint name="LIFT"'))
    assert matching(Framework.MJLAB, "li.*", ("lift", "Lift")) == ("lift",)


def test_a_cfg_and_a_mapping_without_a_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The robot is a USD: the knee of the deploy file has 90 / 9 = 10 times the cfg's kp, and names alone tell that."""
    monkeypatch.chdir(tmp_path)
    for pattern in ("", ".*_"):
        Path("rover_cfg.py").write_text(CFG.format(f'"{pattern}hip", "{pattern}knee"'))
        mapped = f"kp: {{{pattern}hip: 9, {pattern}knee: 90}}\nkd: {{{pattern}hip: 1, {pattern}knee: 1}}\n"
        Path("rover_deploy.yaml").write_text(mapped)
        report = audit(["rover_cfg.py", "rover_deploy.yaml"], Settings(select=("SRC103",)))
        (one,) = report.findings
        assert (one.finding.joint, one.finding.value, one.finding.expected) == (f"{pattern}knee", 90.0, 9.0)
        assert (one.severity, one.finding.span.path, one.finding.span.line) == (
            Severity.WARNING,
            "rover_deploy.yaml",
            1,
        )
