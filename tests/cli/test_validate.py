"""`actspec validate` holds a spec to the joints that the text of its model names, or says why it did not."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from actspec.cli.main import main

ROOT = Path(__file__).resolve().parents[2]

MJCF = """<mujoco>
  <default><default class="leg"><joint type="hinge"/></default></default>
  <worldbody>
    <body><freejoint name="base"/><geom size="1"/>
      <body childclass="leg"><joint name="hip"/><geom size="1"/>
        <body><joint name="knee"/><geom size="1"/><body><joint name="tail"/><geom size="1"/></body></body>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="hip"/><motor joint="knee"/></actuator>
</mujoco>
"""
URDF = """<robot name="leg"><link name="a"/><link name="b"/><link name="c"/>
  <joint name="hip" type="revolute"><parent link="a"/><child link="b"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
  <joint name="knee" type="continuous"><parent link="b"/><child link="c"/></joint>
</robot>
"""


def spec(model: str, *groups: str, more: str = "") -> str:
    """A spec of groups, each with a pattern."""
    text = f"actspec: 1\nrobot: {{name: leg, model: {model}{more}}}\nactuators:\n"
    return text + "".join(
        f"  g{at}: {{joints: ['{pattern}'], level: ideal_pd, command: effort}}\n"
        for at, pattern in enumerate(groups)
    )


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with models."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "leg.xml").write_text(MJCF, encoding="utf-8")
    (tmp_path / "leg.urdf").write_text(URDF, encoding="utf-8")
    (tmp_path / "herd.xml").write_text(
        MJCF.replace(
            "<worldbody>", '<worldbody><replicate count="2"><body><geom size="1"/></body></replicate>'
        ),
        encoding="utf-8",
    )
    (tmp_path / "broken.xml").write_text("<mujoco>", encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("model", ["leg.xml", "leg.urdf"])
@pytest.mark.parametrize(
    "groups, said",
    [
        (["hip", "kne"], "leg.yaml:5:17: BIND001 actuators.g1.joints[0]: the pattern 'kne' matches no joint"),
        (
            ["hip|knee", "knee"],
            "leg.yaml:4:17: BIND002 actuators.g0.joints[0]: the joint 'knee' is in two groups",
        ),
        (["hip"], "leg.yaml:3:1: BIND005 actuators: 1 joint of"),
    ],
    ids=["matches nothing", "in two groups", "in none"],
)
def test_joints_of_the_text(
    folder: Path, model: str, groups: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """What a compile would find of patterns and joints is found, at its place."""
    (folder / "leg.yaml").write_text(spec(model, *groups), encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 2
    out, err = capsys.readouterr()
    assert out == "" and said in err
    if groups[1:] == ["kne"]:
        assert "did you mean 'knee'?" in err


@pytest.mark.parametrize("model", ["leg.xml", "leg.urdf"])
def test_a_spec_that_fits(folder: Path, model: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Every joint in one group: nothing but the summary."""
    (folder / "leg.yaml").write_text(spec(model, "hip", "knee"), encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 0
    assert capsys.readouterr() == ("leg.yaml: valid: leg, 2 groups\n", "")


def test_a_xacro_whose_joints_are_there(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Properties make no joints, and what xacro made may name its namespace."""
    head = '<robot name="leg" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:property name="a" value="1"/>'
    (folder / "leg.urdf").write_text(URDF.replace('<robot name="leg">', head), encoding="utf-8")
    (folder / "leg.yaml").write_text(spec("leg.urdf", "hip", "knee"), encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 0
    assert capsys.readouterr() == ("leg.yaml: valid: leg, 2 groups\n", "")


@pytest.mark.parametrize("inertia", ["joint", "reflected"])
@pytest.mark.parametrize("model", ["leg.xml", "leg.urdf"])
def test_a_gain_of_the_joints_inertia_waits_for_a_compilation(
    folder: Path, model: str, inertia: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is said of it, nor of a kd that follows from it; where no model tells inertia it is refused."""
    group = (
        "joints: [hip, knee], level: ideal_pd, effort_limit: 1, armature: 0.01 kg*m^2,\n"
        "  kp: {derive: natural_frequency, frequency: 6 Hz, inertia: joint},\n"
        f"  kd: {{derive: damping_ratio, ratio: 1, inertia: {inertia}}}"
    )
    text = "actspec: 1\nrobot: {{name: leg, model: {}}}\nactuators: {{g: {{{}}}}}\n"
    (folder / "leg.yaml").write_text(text.format(model, group), encoding="utf-8")
    assert main(["validate", "leg.yaml", "--strict"]) == 0
    assert capsys.readouterr() == ("leg.yaml: valid: leg, 1 group\n", "")
    (folder / "leg.yaml").write_text(text.format("none, joints: [hip, knee]", group), encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 2
    assert "RES003 actuators.g.kp: " in capsys.readouterr().err


def test_accept_of_a_check_that_finds_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is a warning, but of a check that needs the inertia, which the text of a model does not tell."""
    accept = "accept:\n  spec.SPEC183: why\n  spec.SPEC191: why\n"
    (folder / "leg.yaml").write_text(spec("leg.xml", "hip", "knee") + accept, encoding="utf-8")
    assert main(["validate", "leg.yaml", "--strict"]) == 0
    out, err = capsys.readouterr()
    assert out == "leg.yaml: valid: leg, 2 groups\n"
    assert err.startswith(
        "leg.yaml:7:3: SPEC164 [warning] accept.spec.SPEC183: SPEC183 finds nothing in this spec"
    )
    assert err.count("SPEC164") == 1


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("spec182", "SPEC162 accept.spec.spec182: no check of a spec's numbers is called spec182\n"
         "  help: did you mean 'spec.SPEC182'?"),
        ("STB102", "SPEC162 accept.spec.STB102: no check of a spec's numbers is called STB102\n"
         "  help: remove it: --strict refuses nothing of STB102"),
        ("gear_below_one", "SPEC164 [warning] accept.spec.gear_below_one: the spec itself has no approximation of this "
         "name: nothing is accepted by it\n  help: did you mean 'spec.SPEC182'?"),
        ("linkage", "SPEC164 [warning] accept.spec.linkage: the spec itself has no approximation of this name: nothing "
         "is accepted by it\n  help: remove it; it loses nothing"),
    ],
)  # fmt: skip
def test_accept_of_what_the_spec_does_not_lose(
    folder: Path, key: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """What compile says of a key of the spec itself is told without it."""
    accept = f"accept:\n  spec.{key}: why\n"
    (folder / "leg.yaml").write_text(spec("leg.xml", "hip", "knee") + accept, encoding="utf-8")
    main(["validate", "leg.yaml"])
    assert capsys.readouterr().err == f"leg.yaml:7:3: {said}\n"
    (folder / "leg.yaml").write_text(
        spec("leg.xml", "hip", "knee") + accept + "variants: {a: {}}\n", encoding="utf-8"
    )
    main(["validate", "leg.yaml"])
    # A warning may be what another variant needs.
    assert capsys.readouterr().err == f"leg.yaml:7:3: {said}\n" * ("SPEC162" in said)


def test_listed_joints(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without a model the spec's own joints are those to match."""
    (folder / "leg.yaml").write_text(spec("none", "hip", more=", joints: [hip, knee]"), encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 2
    assert "BIND005 actuators: 1 joint of 'leg' in no group: knee" in capsys.readouterr().err


@pytest.mark.parametrize(
    "model, why",
    [
        (
            "package://no-such-distribution/a.xml",
            "the model 'package://no-such-distribution/a.xml' is not installed",
        ),
        ("herd.xml", "its <replicate> makes joints that its text does not name"),
    ],
)
def test_what_it_could_not_read(
    folder: Path, model: str, why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A model that cannot be read cheaply leaves the spec valid, and the summary says what was not checked."""
    (folder / "leg.yaml").write_text(spec(model, "no_such_joint"), encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 0
    out, err = capsys.readouterr()
    start = f"leg.yaml: valid: leg, 1 group (not checked against the joints of {model}: "
    assert out.startswith(start) and why in out and err == ""


@pytest.mark.parametrize(
    ("model", "code", "said"),
    [
        pytest.param(
            "package://no-such-distribution/a.xml",
            1,
            "--strict: not checked against the joints of a model: the model 'package://no-such-distribution/a.xml' is "
            "not installed: there is no distribution 'no-such-distribution' here\n"
            "  help: pip install no-such-distribution\n",
            id="not installed",
        ),
        pytest.param("herd.xml", 0, "", id="only a compilation tells"),
    ],
)
def test_what_strict_makes_of_it(
    folder: Path, model: str, code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A check that did not run for want of a package is a finding; what this command never reads is none."""
    (folder / "leg.yaml").write_text(spec(model, "no_such_joint"), encoding="utf-8")
    assert main(["validate", "--strict", "leg.yaml"]) == code
    assert capsys.readouterr().err == said


@pytest.mark.parametrize(
    ("model", "said"),
    [
        ("broken.xml", "broken.xml:1:9: ROBOT004: the file ends before <mujoco>"),
        (
            "leg.usd",
            "leg.usd:1:1: ROBOT104: this is a USD, which is not read as a robot's model\n"
            "  help: name the MJCF or URDF that it was made of; or write `model: none`, and the `joints`",
        ),
        ("crate.usd", "crate.usd:1:1: ROBOT104: this is a USD"),
        ("packed.usdz", "packed.usdz:1:1: ROBOT104: this is a USD"),
        (
            "macro.xacro",
            "macro.xacro:2:3: ROBOT104: <xacro:macro> has to be expanded by xacro first: it may make joints\n"
            "  help: xacro ROBOT.urdf.xacro -o ROBOT.urdf, and name that",
        ),
        ("parts.xacro", "parts.xacro:2:3: ROBOT104: <x:include> has to be expanded by xacro first"),
        ("page.xml", "page.xml:1:1: ROBOT104: the root element is <html>"),
    ],
)
def test_a_model_that_is_no_model(
    folder: Path, model: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """An error as for `compile`, at its place in the model, without --strict too."""
    (folder / "leg.usd").write_text("#usda 1.0\n", encoding="utf-8")
    (folder / "crate.usd").write_bytes(b"PXR-USDC\0\x08\0\xff")
    (folder / "packed.usdz").write_bytes(b"PK\x03\x04\xff")
    xacro = '<robot name="leg" xmlns:{0}="http://ros.org/wiki/xacro">\n  <{0}:{1} name="leg"/></robot>'
    (folder / "macro.xacro").write_text(xacro.format("xacro", "macro"), encoding="utf-8")
    (folder / "parts.xacro").write_text(xacro.format("x", "include"), encoding="utf-8")
    (folder / "page.xml").write_text("<html/>", encoding="utf-8")
    (folder / "leg.yaml").write_text(spec(model, "no_such_joint"), encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith(said) and err.count(": ROBOT") == 1
    assert main(["compile", "leg.yaml"]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("model", "said"),
    [
        (
            "legg.urdf",
            "leg.yaml:2:27: ROBOT101 robot.model: there is no model 'legg.urdf'\n  help: did you mean 'leg.urdf'?\n",
        ),
        ("no/leg.urdf", "leg.yaml:2:27: ROBOT101 robot.model: there is no model 'no/leg.urdf': its folder"),
    ],
)
def test_a_model_that_is_not_there(
    folder: Path, model: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """An error as for `compile`, and the only one: nothing is held to joints that nobody knows."""
    (folder / "leg.yaml").write_text(spec(model, "no_such_joint"), encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith(said) and err.count("leg.yaml:") == 1


def test_as_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Programs get the same."""
    (folder / "leg.yaml").write_text(spec("leg.xml", "hip"), encoding="utf-8")
    assert main(["validate", "leg.yaml", "--output-format", "json"]) == 2
    (record,) = json.loads(capsys.readouterr().out)["files"]
    assert record["valid"] is False
    assert "BIND005" in [item["code"] for item in record["diagnostics"]]


@pytest.mark.slow
def test_no_simulator_is_imported() -> None:
    """The model's text is enough: start-up stays what it was."""
    code = (
        "import sys; from actspec.cli.main import main; main(['validate', 'robots/a1.yaml']);"
        "print([m for m in ('mujoco', 'numpy', 'lxml') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "robots/a1.yaml: valid: unitree_a1, 1 group\n[]\n"


@pytest.mark.parametrize(
    ("pose", "more", "expected"),
    [
        ("1.04 rad", "", (0, "")),
        ("1.2 rad", "", (0, "SPEC190 [warning]")),
        ("1.2 rad", "accept: {spec.SPEC190: stretched on purpose}\n", (0, "")),
        ("20 rad", "", (2, "SPEC190")),
    ],
)
def test_pose_against_the_text(
    folder: Path, pose: str, more: str, expected: tuple[int, str], capsys: pytest.CaptureFixture[str]
) -> None:
    """The hip turns from 0 to 1 rad; 0.05 rad beyond are let through, 1.2 rad is 0.2 outside, 20 rad are degrees."""
    text = spec("leg.urdf", "hip|knee", more=f", default_pose: {{hip: {pose}, knee: 6 rad}}")
    Path("leg.yaml").write_text(text + more, encoding="utf-8")
    code = main(["validate", "leg.yaml"])
    said = capsys.readouterr().err
    assert code == expected[0]
    assert expected[1] in said and said.count("SPEC190") == bool(expected[1])


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ("command: effort, effort_limit: 2 N*m", (0, [])),
        # 20 N*m*s/rad at the motor's 2 rad/s, of 3 N*m; 2.1 rad of a range of 1 rad.
        ("motor: m, command: effort, friction: {viscous: 20}", (0, ["FRC106"])),
        ("kp: 1, kd: 0.1, action_scale: 2.1", (0, ["SPEC193"])),
        # 3 N*m turn 9e-7 kg*m^2 with 3.3e6 rad/s^2; without a motor it may be the wing of a fly.
        ("motor: m, kp: 1, kd: 0.1, armature: 9e-7", (0, ["SPEC191"])),
        ("motor: m, kp: 1, kd: 0.1, armature: 1.1e-6", (0, [])),
        ("kp: 1, kd: 0.1, effort_limit: 3, armature: 9e-7", (0, [])),
        ("command: effort, effort_limit: 2 N", (2, ["RES001"])),
        ("command: position, kd: 0.1", (2, ["RES005"])),
    ],
)
def test_what_the_joints_tell(
    folder: Path, fields: str, expected: tuple[int, list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    """The spec is resolved against the text: what cannot be at its joints is found without a simulator."""
    motor = "motors: {m: {side: joint, stall_torque: 3 N*m, no_load_speed: 2 rad/s}}\n"
    text = spec("leg.urdf", "hip", more=", unmanaged: [knee]").replace("command: effort", fields)
    Path("leg.yaml").write_text(
        text.replace("ideal_pd", "dc_motor" if "motor" in fields else "ideal_pd") + motor, "utf-8"
    )
    code = main(["validate", "leg.yaml", "--output-format", "json"])
    (record,) = json.loads(capsys.readouterr().out)["files"]
    assert (code, [item["code"] for item in record["diagnostics"]]) == expected


@pytest.mark.parametrize(
    ("targets", "expected"),
    [
        ("mujoco: {version: '3.12'}, mjlab: {}, deploy: {joint_order: [knee, null, hip]}", []),
        ("deploy: {}", []),
        ("mujoco: {version: '9.9'}", ["MJC007 targets.mujoco.version"]),
        ("isaaclab: {version: '0.1'}", ["ISL001 targets.isaaclab.version"]),
        ("deploy: {joint_order: [knee, hipp]}", ["DEP001 targets.deploy.joint_order[1]"]),
        ("deploy: {joint_order: [knee]}", ["DEP003 targets.deploy.joint_order"]),
        # All at once.
        (
            "mjlab: {version: '9.9'}, deploy: {joint_order: [knee]}",
            ["MJL007 targets.mjlab.version", "DEP003 targets.deploy.joint_order"],
        ),
    ],
)
def test_options_of_targets(
    folder: Path, targets: str, expected: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """Versions that nobody knows, and joints in an order, are found without writing anything."""
    Path("leg.yaml").write_text(spec("leg.urdf", "hip|knee") + f"targets: {{{targets}}}\n", encoding="utf-8")
    assert main(["validate", "leg.yaml", "--output-format", "json"]) == (2 if expected else 0)
    (record,) = json.loads(capsys.readouterr().out)["files"]
    assert [f"{item['code']} {item['where']}" for item in record["diagnostics"]] == expected


def test_a_version_is_told_where_the_model_cannot_be_read(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = spec("herd.xml", "hip") + "targets: {mujoco: {version: '9.9'}, deploy: {joint_order: [no]}}\n"
    Path("leg.yaml").write_text(text, encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 2
    assert capsys.readouterr().err.count("leg.yaml:") == 1


def test_nothing_is_told_twice(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A warning of the spec beside an error of the joints."""
    motor = "motors: {m: {gear_ratio: 0.5}}\n"
    Path("leg.yaml").write_text(spec("leg.urdf", "hip", "kne") + motor, encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 2
    said = capsys.readouterr().err
    assert said.count("SPEC182") == 1 and said.count("BIND001") == 1


def variants(**texts: str) -> str:
    """Variants by their names."""
    return "variants:\n" + "".join(f"  {name}: {text}\n" for name, text in texts.items())


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        pytest.param(
            {"a": "{robot: {model: leg.urdf}}", "b": "{actuators: {g1: {joints: [kne]}}}"},
            [
                "leg.yaml:8:33: BIND001 actuators.g1.joints[0] (variant b): the pattern 'kne' matches no joint of "
                "'MuJoCo Model'\n  help: did you mean 'knee'? (matches knee)"
            ],
            id="a pattern",
        ),
        pytest.param(
            {"a": "{robot: {model: long.xml}}", "b": "{}", "c": "{robot: {model: long.xml}}"},
            [
                "leg.yaml:5:17: BIND001 actuators.g1.joints[0] (variants a, c): the pattern 'knee' matches no joint of "
                "'MuJoCo Model'\n  help: did you mean 'knee.*'? (matches knee_2)"
            ],
            id="the same in two of three",
        ),
        pytest.param(
            {"a": "{robot: {model: log.xml}}"},
            [
                "leg.yaml:7:22: ROBOT101 robot.model (variant a): there is no model 'log.xml'\n"
                "  help: did you mean 'long.xml'?"
            ],
            id="a model that is not there",
        ),
        pytest.param(
            {"a": "{robot: {packages: {legs: no}}}"},
            [
                "leg.yaml:7:32: ROBOT101 (variant a): there is no folder 'no' of the package 'legs'\n  help: write the "
                "package's own folder, relative to the spec's, the one with its package.xml; or name it with --package "
                "legs=FOLDER"
            ],
            id="a package that is not there",
        ),
    ],
)
def test_variants_are_held_to_their_models(
    folder: Path, texts: dict[str, str], said: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """What `--variant` finds is found without it, once, with the names of the variants that have it."""
    (folder / "long.xml").write_text(MJCF.replace("knee", "knee_2"), encoding="utf-8")
    (folder / "leg.yaml").write_text(spec("leg.xml", "hip", "knee") + variants(**texts), encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 2
    out, err = capsys.readouterr()
    assert (out, err) == ("", "\n".join(said) + "\n")
    for name in texts:
        concerned = f"variant {name})" in err or f"variants {name}," in err or f", {name})" in err
        assert main(["validate", "leg.yaml", "--variant", name]) == (2 if concerned else 0)


def test_a_fault_of_the_spec_itself_is_no_variants(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is told once and names no variant, and what is wrong in a variant alone is told beside it."""
    text = spec("leg.xml", "hip", "kne") + variants(a="{}", b="{robot: {model: log.xml}}")
    (folder / "leg.yaml").write_text(text, encoding="utf-8")
    assert main(["validate", "leg.yaml"]) == 2
    err = capsys.readouterr().err
    assert err.count("BIND001 actuators.g1.joints[0]: ") == err.count("BIND001") == 1
    assert err.count("ROBOT101 robot.model (variant b): ") == err.count("ROBOT101") == 1


def test_what_is_doubtful_in_a_variant(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The hip turns from 0 to 1 rad: 1.2 rad are a warning, with --strict a refusal; a variant's summary names none."""
    pose = "{robot: {default_pose: {hip: 1.2 rad}}}"
    text = spec("leg.urdf", "hip|knee") + "variant: c\n" + variants(a=pose, b="{robot: {model: herd.xml}}")
    (folder / "leg.yaml").write_text(text, encoding="utf-8")
    unread = (
        "not checked against the joints of herd.xml: its <replicate> makes joints that its text does not name"
    )
    assert main(["validate", "leg.yaml"]) == 0
    out, err = capsys.readouterr()
    assert out == f"leg.yaml: valid: leg, 1 group, variants a, b, c (variant b: {unread})\n"
    assert err.startswith("leg.yaml:7:35: SPEC190 [warning] robot.default_pose (variant a): hip: ")
    assert main(["validate", "leg.yaml", "--strict"]) == 1
    out, err = capsys.readouterr()
    assert out.startswith("leg.yaml: valid, but not to --strict: leg, 1 group, variants a, b, c")
    assert "--strict: 1 number that can hardly be right\n" in err
    assert main(["validate", "leg.yaml#b", "--strict"]) == 0
    assert capsys.readouterr() == (f"leg.yaml#b: valid: leg, 1 group ({unread})\n", "")
    assert main(["validate", "leg.yaml#c", "--strict"]) == 0
    assert capsys.readouterr() == ("leg.yaml#c: valid: leg, 1 group\n", "")
