"""`actspec lock` as a user meets it: the file, what changed since, exit codes."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from actspec.audit.lock import _hash
from actspec.cli.main import main
from tests.audit.robots import CFG, LEG, SPEC
from tests.schemas import fits

SINCE = "leg.xml (leg) since actspec.lock:\n"
LAST = "policies trained before need re-evaluation; `actspec lock` records the new dynamics\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, with the same robot in three files."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "leg.xml").write_text(LEG)
    (tmp_path / "leg.yaml").write_text(SPEC)
    (tmp_path / "leg_cfg.py").write_text(CFG)
    return tmp_path


def lock(path: str = "actspec.lock") -> Any:
    """The lock."""
    return json.loads(Path(path).read_text("utf-8"))


def test_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    """It is sorted, has the form of its schema, relative paths, figures and hashes, and is the same each time."""
    assert main(["lock", "leg.yaml", str(Path("leg.xml").resolve()), "./leg_cfg.py"]) == 0
    assert capsys.readouterr().err == "actspec.lock: 6 joints of 3 files\n"
    first = Path("actspec.lock").read_bytes()
    found = lock()
    fits("lock", found)
    assert list(found["files"]) == ["leg.xml", "leg.yaml", "leg_cfg.py"]
    knee = found["files"]["leg.xml"]["robots"]["leg"]["joints"]["knee"]
    assert (knee["kp"], knee["kd"], knee["joint_damping"], knee["total_damping"]) == (100.0, 3.0, 1.0, 4.0)
    assert knee["effort_limit"] == 30.0
    assert found["files"]["leg.yaml"]["robots"]["leg"]["settings"]["control_dt"] == 0.02
    assert main(["lock"]) == 0
    assert Path("actspec.lock").read_bytes() == first


def test_check(capsys: pytest.CaptureFixture[str]) -> None:
    """A change is told in words with exit code 1, and is gone when the lock is written anew."""
    main(["lock", "leg.xml", "leg.yaml"])
    assert main(["lock", "--check"]) == 0
    assert capsys.readouterr().out == "actspec.lock: no change in what it records\n"
    before = Path("actspec.lock").read_bytes()
    Path("leg.xml").write_text(LEG.replace('kv="3"', 'kv="3.72"'))
    assert main(["lock", "--check"]) == 1
    # 4.72 / 4 = 1.18
    gain = "    drive gain kd 3 -> 3.72 N*m*s/rad (+24 %)\n"
    total = "    total damping 4 -> 4.72 N*m*s/rad (+18 %)\n"
    assert capsys.readouterr().out == f"{SINCE}  hip, knee:\n{gain}{total}{LAST}"
    assert Path("actspec.lock").read_bytes() == before
    assert main(["lock", "--check", "leg.yaml"]) == 0
    assert main(["lock"]) == 0
    assert main(["lock", "--check"]) == 0


def test_a_configuration_that_states_no_figure(capsys: pytest.CaptureFixture[str]) -> None:
    """Gains left to the USD, as of Isaac Lab's Digit, beside a setting that is no joint's: nothing has changed until
    something does.
    """
    text = """from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg

LEG_CFG = ArticulationCfg(
    soft_joint_pos_limit_factor=0.9,
    actuators={"all": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=None, damping=None)},
)
"""
    Path("leg_cfg.py").write_text(text)
    main(["lock", "leg_cfg.py"])
    capsys.readouterr()
    assert main(["lock", "--check"]) == 0
    assert capsys.readouterr().out == "actspec.lock: no change in what it records\n"
    Path("leg_cfg.py").write_text(text.replace("damping=None", "damping=4.0"))
    assert main(["lock", "--check"]) == 1
    assert "    drive gain kd unknown -> 4 N*m*s/rad\n" in capsys.readouterr().out


def test_check_of_a_file_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    """It cannot be added; one that is there can."""
    main(["lock", "leg.xml"])
    capsys.readouterr()
    assert main(["lock", "--check", "nope.yaml"]) == 2
    said = capsys.readouterr().err
    assert (
        "nope.yaml: LCK003: is not in the lock, and there is no such file\n" in said and "help:" not in said
    )
    assert main(["lock", "--check", "leg.yaml"]) == 2
    assert (
        "leg.yaml: LCK003: is not in the lock\n  help: add it with `actspec lock" in capsys.readouterr().err
    )


def test_check_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    """`--check` gives the same JSON as diff."""
    main(["lock", "leg.xml"])
    Path("leg.xml").write_text(LEG.replace('armature="0.01"', 'armature="0.02"'))
    capsys.readouterr()
    assert main(["lock", "--check", "--output-format", "json"]) == 1
    record = json.loads(capsys.readouterr().out)
    fits("diff", record)
    changes = record["robots"][0]["changes"]
    assert [(c["joint"], c["field"], c["old"], c["new"], c["unit"]) for c in changes] == [
        ("hip", "armature", 0.01, 0.02, "kg*m^2"),
        ("knee", "armature", 0.01, 0.02, "kg*m^2"),
    ]


@pytest.mark.parametrize(
    "old, new, same",
    [
        ('kp="100"', 'kp="100.00000000000001"', True),
        ('kp="100"', 'kp="100.0000001"', True),
        ('kp="100"', 'kp="100.000001"', False),
        ("<worldbody>", "<!-- a leg -->\n<worldbody>", True),
        ('<geom size="0.1"/>', '<geom size="0.1" density="2000"/>', True),
    ],
    ids=["last digit", "tenth digit", "ninth digit", "comment", "links"],
)
def test_what_a_hash_is_of(old: str, new: str, same: bool) -> None:
    """Nine digits of the actuators' figures; not the text, nor the links."""
    main(["lock", "leg.xml"])
    before = lock()["files"]["leg.xml"]["robots"]["leg"]["hash"]
    Path("leg.xml").write_text(LEG.replace(old, new))
    assert main(["lock", "--check"]) == (0 if same else 1)
    main(["lock"])
    assert (lock()["files"]["leg.xml"]["robots"]["leg"]["hash"] == before) is same


def test_a_figure_that_nine_digits_round() -> None:
    """15.89524265 is written as 15.8952427, 3e-9 more; what was locked is what is there."""
    Path("leg.xml").write_text(LEG.replace('kp="100"', 'kp="15.89524265"'))
    main(["lock", "leg.xml"])
    assert main(["lock", "--check"]) == 0


def test_joints_and_robots_come_and_go(capsys: pytest.CaptureFixture[str]) -> None:
    """A joint that has another name, and a configuration that is gone, are changes."""
    head, _, body = CFG.partition("LEG_CFG")
    Path("leg_cfg.py").write_text(f"{head}LEG_CFG{body}\nOLD_CFG{body}")
    main(["lock", "leg.xml", "leg_cfg.py"])
    Path("leg.xml").write_text(LEG.replace('"knee"', '"shin"'))
    Path("leg_cfg.py").write_text(CFG.replace('"knee"', '"shin"'))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    out = capsys.readouterr().out
    assert out == (
        f"{SINCE}  joints added: shin\n  joints removed: knee\n"
        "leg_cfg.py (LEG_CFG) since actspec.lock:\n  joints added: shin\n  joints removed: knee\n"
        f"leg_cfg.py (OLD_CFG) since actspec.lock:\n  robot removed, with joints: hip, knee\n{LAST}"
    )


DEPLOY = """motor_idx: [3, 4, 5]
kps: [100, 150, 40]
kds: [2, 4, 2]
ang_vel_scale: 0.25
"""
"""As of unitree_rl_gym: which joint an entry is of, no file says."""


def test_what_is_not_recorded_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    """Equal keys of several files are one line; four of them and two files, then how many more."""
    more = "".join(f"{name}_scale: 1.0\n" for name in ("lin_vel", "height", "cmd", "gait"))
    for name in "abc":
        Path(f"{name}.yaml").write_text(DEPLOY + more)
    Path("other.yaml").write_text(DEPLOY)
    assert main(["lock", "a.yaml", "b.yaml", "c.yaml", "other.yaml"]) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("  not in it")]
    assert lines == [
        "  not in it, as part of no joint's figures: ang_vel_scale, lin_vel_scale, height_scale, cmd_scale and 1 more "
        "of a.yaml (a), b.yaml (b) and 1 more",
        "  not in it, as part of no joint's figures: ang_vel_scale of other.yaml (other)",
    ]


def test_lists_without_names(capsys: pytest.CaptureFixture[str]) -> None:
    """They are recorded by place, in the order of the file, and so are the motors that a joint is sent to."""
    Path("deploy.yaml").write_text(DEPLOY)
    assert main(["lock", "deploy.yaml"]) == 0
    # 3 places, 3 kp, 3 kd; the single number is of no joint.
    assert capsys.readouterr().err == (
        "actspec.lock: 0 joints, 9 numbers that no joint is named for of 1 file\n"
        "  not in it, as part of no joint's figures: ang_vel_scale of deploy.yaml (deploy)\n"
    )
    fits("lock", lock())
    assert main(["lock", "--check"]) == 0
    Path("deploy.yaml").write_text(DEPLOY.replace("[3, 4", "[4, 3").replace("40]", "400]"))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    assert capsys.readouterr().out == (
        "deploy.yaml (deploy) since actspec.lock:\n"
        "  entry 1 of motor_idx 3 -> 4\n  entry 2 of motor_idx 4 -> 3\n  entry 3 of kps 40 -> 400 (x10)\n"
        f"{LAST}"
    )
    kept = lock()
    kept["files"]["deploy.yaml"]["robots"]["deploy"]["entries"]["entry 3 of kps"] = 400.0
    Path("actspec.lock").write_text(json.dumps(kept))
    assert main(["lock", "--check"]) == 2
    assert "do not match their hash" in capsys.readouterr().err


def test_a_folder(capsys: pytest.CaptureFixture[str]) -> None:
    """The robot files in it are recorded, and what is none is passed over; parts of a model are in the model."""
    Path("robots/parts").mkdir(parents=True)
    Path("robots/leg.xml").write_text(
        LEG.replace("<worldbody>", '<include file="parts/more.xml"/><worldbody>')
    )
    Path("robots/parts/more.xml").write_text("<mujocoinclude><size nuserdata='1'/></mujocoinclude>")
    Path("robots/__init__.py").write_text("")
    Path("robots/notes.yaml").write_text("a: 1\n")
    Path("robots/leg_cfg.py").write_text(CFG)
    assert main(["lock", "robots", "leg.yaml"]) == 0
    assert capsys.readouterr().err == "actspec.lock: 6 joints of 3 files\n"
    assert list(lock()["files"]) == ["leg.yaml", "robots/leg.xml", "robots/leg_cfg.py"]
    assert main(["lock", "--check"]) == 0
    Path("robots/leg_cfg.py").write_text(CFG.replace("100.0", "150.0"))
    capsys.readouterr()
    assert main(["lock", "--check", "robots"]) == 1
    assert "robots/leg_cfg.py (LEG_CFG) since actspec.lock:" in capsys.readouterr().out
    Path("empty").mkdir()
    assert main(["lock", "empty", "-o", "other.lock"]) == 2
    assert "DIF001: nothing to record: it has no file that ends in" in capsys.readouterr().err
    assert not Path("other.lock").exists()


@pytest.mark.parametrize("settings", ["actspec.toml", "pyproject.toml"])
def test_excluded_files_of_a_folder(settings: str, capsys: pytest.CaptureFixture[str]) -> None:
    """What the settings exclude is passed over in a folder, and recorded where it is named."""
    Path("robots/old").mkdir(parents=True)
    for name in ("robots/leg.xml", "robots/old/leg.xml", "robots/copy.xml"):
        Path(name).write_text(LEG)
    head = "[audit]" if settings == "actspec.toml" else "[tool.actspec.audit]"
    Path(settings).write_text(f'{head}\nexclude = ["old", "copy.*"]\n')
    assert main(["lock", "robots"]) == 0
    assert list(lock()["files"]) == ["robots/leg.xml"]
    assert main(["lock", "robots", "robots/copy.xml"]) == 0
    assert list(lock()["files"]) == ["robots/copy.xml", "robots/leg.xml"]
    capsys.readouterr()
    Path(settings).write_text(f'{head}\nexclude = ["robots/*"]\n')
    assert main(["lock", "robots", "-o", "other.lock"]) == 2
    assert "nothing to record: exclude leaves out all" in capsys.readouterr().err


def test_what_a_class_inherits(capsys: pytest.CaptureFixture[str]) -> None:
    """The class is recorded; what is not beside it is not."""
    Path("gym_cfg.py").write_text(GYM)
    main(["lock", "gym_cfg.py"])
    said = capsys.readouterr().err
    inherits = "not known without running it: what it inherits: LeggedRobotCfg comes from legged_gym"
    assert f"\n  LegCfg of gym_cfg.py is recorded but for a part, {inherits}" in said
    assert "not in it" not in said
    Path("new_cfg.py").write_text(GYM)
    main(["diff", "gym_cfg.py", "new_cfg.py"])
    assert f"  not compared: a part of LegCfg, {inherits}" in capsys.readouterr().out


def test_a_pose_that_nobody_states(capsys: pytest.CaptureFixture[str]) -> None:
    """It is not in a lock; a lock of an older actspec has 0 there, which is no change."""
    main(["lock", "leg.yaml"])
    kept = lock()
    robot = kept["files"]["leg.yaml"]["robots"]["leg"]
    assert all("default_position" not in entry for entry in robot["joints"].values())
    for entry in robot["joints"].values():
        entry["default_position"] = 0.0
        del entry["hash"]
        entry["hash"] = _hash(entry)
    del robot["orders"], robot["entries"]
    hashes = {name: entry["hash"] for name, entry in robot["joints"].items()}
    robot["hash"] = _hash({"settings": robot["settings"], "joints": hashes})
    Path("actspec.lock").write_text(json.dumps(kept))
    assert main(["lock", "--check"]) == 0
    Path("leg.yaml").write_text(
        SPEC.replace("model: leg.xml", 'model: leg.xml, default_pose: {"hip": 0.3 rad}')
    )
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    assert "  hip:\n    default position 0 -> 0.3 rad\n" in capsys.readouterr().out


def test_blocks_of_one_name(capsys: pytest.CaptureFixture[str]) -> None:
    """Two blocks with gains below one key, as of unitree_rl_lab, are two robots of the lock."""
    text = "FSM:\n  Stand: {kp: [60, 60], kd: [5, 5]}\n  Walk: {kp: [30, 30], kd: [1, 1]}\n"
    Path("fsm.yaml").write_text(text)
    main(["lock", "fsm.yaml"])
    assert list(lock()["files"]["fsm.yaml"]["robots"]) == ["FSM", "FSM 2"]
    assert main(["lock", "--check"]) == 0
    Path("fsm.yaml").write_text(text.replace("[60, 60]", "[66, 66]"))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    assert "stiffness kp 60 -> 66 N*m/rad (+10 %)" in capsys.readouterr().out


def test_which_actuator_drives_which_joint(capsys: pytest.CaptureFixture[str]) -> None:
    """A lock has the controls in their order, and what each drives."""
    main(["lock", "leg.xml"])
    Path("leg.xml").write_text(
        LEG.replace('"hip" joint="hip"', '"hip" joint="x"')
        .replace('joint="knee"', 'joint="hip"')
        .replace('joint="x"', 'joint="knee"')
    )
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    swapped = "  ctrl[0], actuator hip, drives hip -> knee\n  ctrl[1], actuator knee, drives knee -> hip\n"
    assert capsys.readouterr().out == f"{SINCE}{swapped}{LAST}"


def test_versions_are_kept(capsys: pytest.CaptureFixture[str]) -> None:
    """A lock remembers what its files are meant for, so that a check reads them alike."""
    both = CFG.replace("friction=0.2", "friction=0.2, dynamic_friction=0.2")
    Path("leg_cfg.py").write_text(both)
    main(["lock", "leg_cfg.py", "-t", "isaaclab==2.3", "-t", "isaac_sim==5.1"])
    found = lock()
    assert found["versions"] == {"isaac_sim": "5.1", "isaaclab": "2.3"}
    assert found["files"]["leg_cfg.py"]["robots"]["LEG_CFG"]["joints"]["hip"]["frictionloss"] == 0.2
    assert main(["lock", "--check"]) == 0
    capsys.readouterr()
    Path("leg_cfg.py").write_text(both.replace("=0.2", "=0.3"))
    assert main(["lock", "--check"]) == 1
    assert "dry friction 0.2 -> 0.3 N*m (+50 %)" in capsys.readouterr().out


def test_in_another_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Paths are relative to the lock, so that it is checked from anywhere."""
    (tmp_path / "locks").mkdir()
    assert main(["lock", "leg.xml", "-o", "locks/a.lock"]) == 0
    assert list(lock("locks/a.lock")["files"]) == ["../leg.xml"]
    monkeypatch.chdir(tmp_path / "locks")
    assert main(["lock", "--check", "-o", "a.lock"]) == 0
    assert main(["lock", "--check", "-o", "a.lock", "../leg.xml"]) == 0


@pytest.mark.parametrize(
    "edit, message",
    [
        (lambda d: d["files"].update({"/etc/passwd": {}}), "LCK002: '/etc/passwd' is no relative path"),
        (lambda d: d["files"].update({"C:/x": {}}), "LCK002: 'C:/x' is no relative path"),
        (
            lambda d: d.update(format="actspec-lock/2"),
            "LCK001: has the format actspec-lock/2, and this actspec",
        ),
        (lambda d: d.update(format="other"), "LCK001: is not a dynamics lock"),
        (lambda d: d.update(files=[]), "LCK002: `files` is not as actspec writes it"),
        (lambda d: d.update(versions={"isaaclab": "x"}), "AUD004"),
        (lambda d: d["files"]["leg.xml"].update(kind="usd"), "LCK002: the entry of 'leg.xml' is not as"),
        (
            lambda d: joint(d).update(kd=4.0),
            "LCK002: leg.xml, leg: the figures of knee do not match their hash",
        ),
        (lambda d: joint(d).update(kd=True), "LCK002: leg.xml, leg: knee is not as actspec writes it"),
        (lambda d: joint(d).update(kd=10**400), "LCK002: leg.xml, leg: knee is not as actspec writes it"),
        (lambda d: joint(d).update(colour=1.0), "LCK002: leg.xml, leg: knee is not as actspec writes it"),
        (lambda d: joint(d).update(axis="0 1"), "LCK002: leg.xml, leg: knee is not as actspec writes it"),
        (lambda d: joint(d).update(axis="0 x 1"), "LCK002: leg.xml, leg: knee is not as actspec writes it"),
        (lambda d: joint(d).update(axis="0 nan 1"), "LCK002: leg.xml, leg: knee is not as actspec writes it"),
        (lambda d: joint(d).update(axis=[0, 0, 1]), "LCK002: leg.xml, leg: knee is not as actspec writes it"),
        (
            lambda d: d["files"]["leg.xml"]["robots"]["leg"]["settings"].update(physics_dt=1.0),
            "LCK002: leg.xml, leg: the joints do not match their hash",
        ),
    ],
    ids=[
        "absolute",
        "drive",
        "newer",
        "format",
        "list",
        "version",
        "kind",
        "edited",
        "truth",
        "huge",
        "field",
        "axis of two",
        "axis of a word",
        "axis of nan",
        "axis as a list",
        "settings",
    ],
)
def test_a_lock_that_is_none(edit: Any, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A lock that somebody edited, or that is something else, is told; nothing outside is read."""
    main(["lock", "leg.xml"])
    found = lock()
    edit(found)
    Path("actspec.lock").write_text(json.dumps(found))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 2
    assert message in capsys.readouterr().err


def joint(found: Any) -> Any:
    """The knee of a lock."""
    return found["files"]["leg.xml"]["robots"]["leg"]["joints"]["knee"]


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--check"], "actspec.lock: LCK001: there is no such lock"),
        ([], "actspec.lock: LCK001: there is no such lock"),
        (["leg.xml", "-o", "leg.yaml"], "leg.yaml:1:1: LCK001: is not a dynamics lock"),
        (["leg.xml", "-o", "."], ".: LCK001: cannot be read: a folder"),
        (["leg.xml", "-o", "no/actspec.lock"], "no/actspec.lock: LCK001: cannot be written"),
        (["none.xml"], "none.xml: DIF001: cannot be read"),
    ],
    ids=["check", "again", "no lock", "folder", "no folder", "no file"],
)
def test_what_cannot_be_locked(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str], folder: Path
) -> None:
    """It says why with exit code 2; a file that is no lock is never written over."""
    assert main(["lock", *arguments]) == 2
    assert capsys.readouterr().err.startswith(message)
    assert (folder / "leg.yaml").read_text() == SPEC
    assert not (folder / "actspec.lock").exists()


def test_a_file_that_is_not_locked(capsys: pytest.CaptureFixture[str]) -> None:
    """A file that the lock does not have cannot be checked."""
    main(["lock", "leg.xml"])
    capsys.readouterr()
    assert main(["lock", "--check", "leg.yaml"]) == 2
    assert capsys.readouterr().err.startswith("leg.yaml: LCK003: is not in the lock")


@pytest.mark.skipif(os.name == "nt", reason="names are Unicode there")
def test_a_name_that_is_not_utf8() -> None:
    """A file's name may be any bytes; the lock is UTF-8 all the same, and finds the file again."""
    name = os.fsdecode(b"leg\xff.xml")
    try:
        Path(name).write_text(LEG)
    except OSError:
        pytest.skip("this file system takes UTF-8 alone")
    # A file that is called so, and the other one.
    Path("leg\\xff.xml").write_text(LEG)
    assert main(["lock", name, "leg\\xff.xml", "leg.xml"]) == 0
    assert list(lock()["files"]) == ["leg.xml", "leg\\x5cxff.xml", "leg\\xff.xml"]
    assert main(["lock", "--check"]) == 0


@pytest.mark.parametrize("arguments", [["--check"], []])
def test_a_file_that_was_renamed(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """The lock has a name that no file has any more: the message says how it gets the new one."""
    main(["lock", "-o", "a.lock", "leg.xml"])
    Path("leg.xml").rename("limb.xml")
    capsys.readouterr()
    assert main(["lock", "-o", "a.lock", *arguments]) == 2
    err = capsys.readouterr().err
    assert err.startswith(
        "leg.xml: DIF001: cannot be read: there is no such file or folder\n  help: a.lock has this"
    )
    assert "`actspec lock -o a.lock FILE...`" in err
    assert main(["lock", "-o", "a.lock", "limb.xml"]) == 0
    assert main(["lock", "-o", "a.lock", "--check"]) == 0


def test_a_lock_from_before_command_gains(capsys: pytest.CaptureFixture[str]) -> None:
    """A servo that settles at its target has no such figure in a lock; one that does not has."""
    main(["lock", "leg.xml"])
    assert "command_gain" not in Path("actspec.lock").read_text()
    servo = '<position name="knee" joint="knee" kp="100" kv="3"'
    general = '<general name="knee" joint="knee" gainprm="150" biastype="affine" biasprm="0 -100 -3"'
    Path("leg.xml").write_text(LEG.replace(servo, general))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    assert capsys.readouterr().out == f"{SINCE}  knee:\n    command gain over kp 1 -> 1.5 (+50 %)\n{LAST}"
    main(["lock"])
    assert joint(lock())["command_gain"] == 1.5
    assert main(["lock", "--check"]) == 0


@pytest.mark.parametrize(
    "old, new, told",
    [
        (
            'name="knee" joint="knee"',
            'gear="-1" name="knee" joint="knee"',
            "command gain over kp 1 -> -1: a positive control drives the joint the other way",
        ),
        (
            'name="knee" range',
            'axis="0 0 -1" name="knee" range',
            "axis in the base's frame 0 0 1 -> 0 0 -1: its positive positions, speeds and torques are the other way",
        ),
    ],
    ids=["gear", "axis"],
)
def test_directions(old: str, new: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A lock keeps them; one of an older actspec has no axes and gears, and says nothing of them."""
    main(["lock", "leg.xml"])
    kept = lock()
    Path("leg.xml").write_text(LEG.replace(old, new))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    assert capsys.readouterr().out == f"{SINCE}  knee:\n    {told}\n{LAST}"
    robot = kept["files"]["leg.xml"]["robots"]["leg"]
    for entry in robot["joints"].values():
        del entry["axis"], entry["gear"], entry["hash"]
        entry["hash"] = _hash(entry)
    del robot["orders"], robot["entries"]
    hashes = {name: entry["hash"] for name, entry in robot["joints"].items()}
    robot["hash"] = _hash({"settings": robot["settings"], "joints": hashes})
    Path("actspec.lock").write_text(json.dumps(kept))
    # Where a servo settles it has always had.
    assert main(["lock", "--check"]) == ("gain" in told)


def test_an_edited_lock_is_written_anew() -> None:
    """What is broken in the figures does not stand in the way of a new lock."""
    main(["lock", "leg.xml"])
    found = lock()
    joint(found)["kd"] = 4.0
    Path("actspec.lock").write_text(json.dumps(found))
    assert main(["lock"]) == 0
    assert main(["lock", "--check"]) == 0


@pytest.mark.parametrize(
    "edit, message",
    [
        (lambda d: d["files"].pop("leg.xml"), "the names of its files do not match their hash"),
        (lambda d: d["files"].clear(), "the names of its files do not match their hash"),
        (lambda d: d["files"].update(a=d["files"].pop("leg.xml")), "the names of its files do not match"),
        (lambda d: (d["files"].pop("leg.xml"), d.update(hash=None)), "the names of its files do not match"),
        (lambda d: (d["files"].clear(), d.pop("hash")), "it has no files: an edit or a merge lost them"),
    ],
    ids=["one", "all", "another name", "no text", "all, and the hash"],
)
def test_a_lock_that_lost_files(edit: Any, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Neither checked nor recorded anew from what is left; named files make it whole."""
    main(["lock", "leg.xml", "leg_cfg.py"])
    found = lock()
    edit(found)
    text = json.dumps(found, indent=1)
    Path("actspec.lock").write_text(text)
    line = next(i for i, one in enumerate(text.splitlines(), 1) if '"files":' in one)
    for arguments in (["lock", "--check"], ["lock"]):
        capsys.readouterr()
        assert main(arguments) == 2
        assert capsys.readouterr().err.startswith(f"actspec.lock:{line}:2: LCK002: {message}")
        assert Path("actspec.lock").read_text() == text
    assert main(["lock", "leg.xml", "leg_cfg.py"]) == 0
    assert main(["lock", "--check"]) == 0


def test_a_lock_from_before_the_hash_of_its_files(capsys: pytest.CaptureFixture[str]) -> None:
    """It is checked as before, with a warning; writing it again adds the hash."""
    main(["lock", "leg.xml"])
    new = Path("actspec.lock").read_bytes()
    found = lock()
    del found["hash"]
    fits("lock", found)
    Path("actspec.lock").write_text(json.dumps(found))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 0
    told = capsys.readouterr().err
    assert told.startswith("actspec.lock: LCK007 [warning]: it has no hash of the names of its files")
    assert main(["lock"]) == 0
    assert Path("actspec.lock").read_bytes() == new


@pytest.mark.parametrize(
    "dt, told", [("0.02", "control period 0.02 -> 0.03 s"), ("0.002", "dt 0.002 -> 0.03")]
)
def test_a_lock_from_before_dt(dt: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    """What it never had is no change; a new lock has it."""
    rate = "" if dt == "0.02" else "rate: 3\n"
    Path("deploy.yaml").write_text(f"joint_names: [hip, knee]\nkps: [100, 150]\ndt: {dt}\n{rate}")
    main(["lock", "deploy.yaml"])
    said = capsys.readouterr().err
    assert ("deploy.yaml:3:5: DEPLOY005 [info] dt: 0.002 s is a step" in said) is (dt == "0.002")
    found = lock()
    del found["hash"]
    robot = found["files"]["deploy.yaml"]["robots"]["deploy"]
    robot["settings"].pop("control_dt", None)
    robot["entries"].pop("dt", None)
    robot["hash"] = _hash(
        {
            **{key: robot[key] for key in ("settings", "orders", "entries")},
            "joints": {name: one["hash"] for name, one in robot["joints"].items()},
        }
    )
    Path("actspec.lock").write_text(json.dumps(found))
    assert main(["lock", "--check"]) == 0
    main(["lock"])
    assert main(["lock", "--check"]) == 0
    Path("deploy.yaml").write_text(Path("deploy.yaml").read_text().replace(f"dt: {dt}", "dt: 0.03"))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    assert told in capsys.readouterr().out


BY_KEY = CFG.replace('["hip", "knee"]', '["[a-z]*_hip", "[a-z]*_knee"]').replace(
    "    actuators=",
    '    init_state=ArticulationCfg.InitialStateCfg(joint_pos={"left_.*": 0.1, "right_.*": 0.3}),\n    actuators=',
)
"""A pose by keys that are no patterns of the group."""


def test_what_is_stated_by_pattern(capsys: pytest.CaptureFixture[str]) -> None:
    """A pose whose joints no file names is in it, key by key."""
    Path("leg_cfg.py").write_text(BY_KEY)
    main(["lock", "leg_cfg.py"])
    fits("lock", lock())
    robot = lock()["files"]["leg_cfg.py"]["robots"]["LEG_CFG"]
    assert robot["by_key"]["default_position"] == [
        {"key": "left_.*", "value": 0.1},
        {"key": "right_.*", "value": 0.3},
    ]
    assert main(["lock", "--check"]) == 0
    Path("leg_cfg.py").write_text(BY_KEY.replace("0.3", "-0.3"))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    since = "leg_cfg.py (LEG_CFG) since actspec.lock:\n"
    assert capsys.readouterr().out == f"{since}  right_.*:\n    default position 0.3 -> -0.3 rad\n{LAST}"


def test_a_lock_from_before_what_is_stated_by_pattern(capsys: pytest.CaptureFixture[str]) -> None:
    """It has none of it, which is no change; a new lock has it."""
    Path("leg_cfg.py").write_text(BY_KEY)
    main(["lock", "leg_cfg.py"])
    found = lock()
    robot = found["files"]["leg_cfg.py"]["robots"]["LEG_CFG"]
    del robot["by_key"]
    robot["hash"] = _hash(
        {
            **{key: robot[key] for key in ("settings", "orders", "entries")},
            "joints": {name: one["hash"] for name, one in robot["joints"].items()},
        }
    )
    Path("actspec.lock").write_text(json.dumps(found))
    fits("lock", found)
    Path("leg_cfg.py").write_text(BY_KEY.replace("0.3", "-0.3"))
    assert main(["lock", "--check"]) == 0
    Path("leg_cfg.py").write_text(BY_KEY.replace("30.0", "31.0"))
    assert main(["lock", "--check"]) == 1
    assert "effort limit 30 -> 31 N*m" in capsys.readouterr().out


@pytest.mark.parametrize(
    "by_key", [[], {"kp": {}}, {"nope": []}, {"kp": [{"key": "a"}]}, {"kp": [{"key": 1, "value": 2.0}]}]
)
def test_what_is_stated_by_pattern_is_checked(by_key: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """What actspec never writes there is an error at its line."""
    Path("leg_cfg.py").write_text(BY_KEY)
    main(["lock", "leg_cfg.py"])
    found = lock()
    found["files"]["leg_cfg.py"]["robots"]["LEG_CFG"]["by_key"] = by_key
    Path("actspec.lock").write_text(json.dumps(found, indent=2))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 2
    assert "LCK002: leg_cfg.py, LEG_CFG: is not as actspec writes it" in capsys.readouterr().err


GYM = """from legged_gym.envs.base.legged_robot_config import LeggedRobotCfg


class LegCfg(LeggedRobotCfg):
    class init_state(LeggedRobotCfg.init_state):
        default_joint_angles = {"hip": 0.1, "knee": -0.2}

    class control(LeggedRobotCfg.control):
        control_type = "P"
        stiffness = {"hip": 30.0, "knee": 30.0}
        damping = {"hip": 0.8, "knee": 0.8}
"""
ZERO = "    stiffness kp 30 -> 0 N*m/rad\n    drive gain kd 0.8 -> 0 N*m*s/rad\n"


@pytest.mark.parametrize("beside", [[], ["leg.xml"]], ids=["alone", "with its model"])
@pytest.mark.parametrize(
    "old, new", [('stiffness = {"hip"', 'stiffness = {"hpi"'), ('{"hip": 30', '{"hp": 30')]
)
def test_a_key_of_legged_gym_that_no_joint_has(
    old: str, new: str, beside: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """legged_gym gives the hip kp 0 and kd 0, whatever its damping; lock, diff and audit say so alike."""
    for folder in ("a", "b"):
        Path(folder).mkdir()
    Path("gym_cfg.py").write_text(GYM)
    Path("a/gym_cfg.py").write_text(GYM)
    main(["lock", "gym_cfg.py", *beside])
    assert old in GYM
    Path("gym_cfg.py").write_text(GYM.replace(old, new))
    Path("b/gym_cfg.py").write_text(GYM.replace(old, new))
    for arguments in (["lock", "--check"], ["diff", "a/gym_cfg.py", "b/gym_cfg.py"]):
        capsys.readouterr()
        assert main(arguments) == 1
        out = capsys.readouterr().out
        assert f"\n  hip:\n{ZERO}" in out
        assert "joints" not in out and "knee" not in out
    if beside:
        main(["audit", "gym_cfg.py", "leg.xml"])
        assert "hip: no key of stiffness is part of the name of this joint" in capsys.readouterr().out


def test_joints_without_a_key_of_legged_gym(capsys: pytest.CaptureFixture[str]) -> None:
    """Of damping too; a lock of an older actspec has no such joint, and does not take it for a new one."""
    Path("gym_cfg.py").write_text(GYM.replace('"hip": 30.0, ', "").replace('"hip": 0.8, ', ""))
    main(["lock", "gym_cfg.py"])
    found = lock()
    robot = found["files"]["gym_cfg.py"]["robots"]["LegCfg"]
    figures = {name: robot["joints"]["hip"][name] for name in ("kp", "kd", "default_position")}
    # kd is 0 as kp, though no key of damping is the hip's.
    assert figures == {"kp": 0.0, "kd": 0.0, "default_position": 0.1}
    assert main(["lock", "--check"]) == 0
    del found["hash"], robot["joints"]["hip"]
    record = {key: one for key, one in robot.items() if key not in ("hash", "joints")}
    hashes = {name: one["hash"] for name, one in robot["joints"].items()}
    robot["hash"] = _hash({**record, "joints": hashes})
    Path("actspec.lock").write_text(json.dumps(found))
    capsys.readouterr()
    main(["lock", "--check"])
    assert "added: hip" not in capsys.readouterr().out


def test_two_branches_that_record_another_robot_each() -> None:
    """The hash is of names alone: entries of two locks are put together without a conflict in it."""
    main(["lock", "leg.xml", "leg_cfg.py"])
    before = lock()
    Path("leg.xml").write_text(LEG.replace('kv="3"', 'kv="3.72"'))
    main(["lock"])
    assert lock() != before
    assert lock()["hash"] == before["hash"]


@pytest.mark.skipif(os.sep != "/", reason="no such names here")
@pytest.mark.parametrize("name", ["a:b.xml", "C:x.xml", "a\\b.xml", "a\nb.xml", os.fsdecode(b"caf\xe9.xml")])
def test_files_of_any_name(name: str) -> None:
    """What is locked is checked again, whatever its name has."""
    Path(name).write_text(LEG)
    assert main(["lock", name]) == 0
    assert main(["lock", "--check"]) == 0


UNKNOWABLE = """from isaaclab.assets import ArticulationCfg

LEG_CFG = ArticulationCfg(
    actuators={"a": ImplicitActuatorCfg(joint_names_expr=["a"], stiffness=10**10**10)},
)
"""
REFUSED = """<mujoco model="one">
  <worldbody><body><joint name="a" armature="1e400"/><geom size=".1"/></body></worldbody>
  <actuator>
    <position joint="a" kp="inf" forcerange="-1e309 20"/>
  </actuator>
</mujoco>
"""


def test_nothing_is_read(capsys: pytest.CaptureFixture[str]) -> None:
    """A lock that would guard nothing says so, with the reason; one of a file with joints does not."""
    Path("bad_cfg.py").write_text(UNKNOWABLE)
    Path("none.urdf").write_text('<robot name="r"><link name="a"/></robot>')
    assert main(["lock", "bad_cfg.py", "none.urdf", "leg.xml", "leg_cfg.py", "leg.yaml"]) == 0
    said = capsys.readouterr().err
    none = "no joint is recorded of this file, so that no change of one will be seen"
    assert f"bad_cfg.py:4:21: LCK005 [warning]: {none}: actuators.a: not known without running it" in said
    assert f"none.urdf: LCK005 [warning]: {none}\n" in said
    assert said.count("LCK") == 2


def test_a_refused_model(capsys: pytest.CaptureFixture[str]) -> None:
    """What MuJoCo refuses is recorded from its text, which is said; what is infinite is no figure, but for limits."""
    Path("one.xml").write_text(REFUSED)
    assert main(["lock", "one.xml"]) == 0
    said = capsys.readouterr().err
    assert (
        "one.xml:4: LCK004 [warning]: the model does not compile, and is recorded from its text alone" in said
    )
    left = "stiffness kp of a (inf), armature of a (inf)"
    assert f"one.xml:4:5: LCK006 [warning]: what is not finite is left out as unknown: {left}" in said
    joint = lock()["files"]["one.xml"]["robots"]["one"]["joints"]["a"]
    assert not {"kp", "armature"} & set(joint) and joint["gear"] == 1.0
    assert main(["lock", "--check"]) == 0
    Path("one.xml").write_text(REFUSED.replace('kp="inf"', 'kp="40"'))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    assert "stiffness kp unknown -> 40 N*m/rad" in capsys.readouterr().out


def test_no_limit_is_infinite(capsys: pytest.CaptureFixture[str]) -> None:
    """An actuator without a force range has no limit, which is no missing figure."""
    text = REFUSED.replace('armature="1e400"', "").replace('kp="inf" forcerange="-1e309 20"', 'kp="40"')
    Path("one.xml").write_text(text)
    assert main(["lock", "one.xml"]) == 0
    assert capsys.readouterr().err == "actspec.lock: 1 joint of 1 file\n"
    joint = lock()["files"]["one.xml"]["robots"]["one"]["joints"]["a"]
    assert joint["effort_limit"] == "Infinity" and joint["kp"] == 40.0
