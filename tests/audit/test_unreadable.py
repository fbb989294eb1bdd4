"""A file that cannot be read is a finding: it can be ignored, kept in a baseline and set to another severity."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.baseline import write_baseline
from actspec.audit.engine import audit
from actspec.audit.outcome import Means, Report
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity
from actspec.report import ReportOptions, render
from actspec.report.findings import for_people

BROKEN = "<mujoco>\n  <worldbody>\n</mujoco>\n"
NOBODYS = {
    "broken.launch.xml": "<launch><a></launch>",
    "broken.py": "def (\n",
    "broken.yaml": "a: [\n",
    "good.urdf": '<robot name="r"><link name="a"/></robot>',
}
"""What may stand in a folder of robots, and is not one that is broken."""


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("robots").mkdir()
    Path("robots/leg.xml").write_text(BROKEN)
    for name, text in NOBODYS.items():
        Path("robots", name).write_text(text)


def found(report: Report) -> list[tuple[str, str, int, Severity]]:
    """Rule, file, line and severity of what was found."""
    return [
        (item.finding.code, item.finding.span.path, item.finding.span.line, item.severity)
        for item in report.findings
        if item.finding.code == "AUD008"
    ]


def test_in_a_folder_it_is_a_note() -> None:
    """A file in a folder may be of somebody else; the audit is complete without it."""
    report = audit(["robots"], Settings())
    assert found(report) == [("AUD008", "robots/leg.xml", 3, Severity.INFO)]
    assert report.complete
    assert [item.code for item in report.diagnostics() if item.severity is Severity.ERROR] == []


def test_the_last_line_counts_it() -> None:
    """Although it is a note; of a file that was named it is an error, and of a folder with --as-named."""
    text = render(audit(["robots"], Settings()), "concise", ReportOptions(least=Severity.WARNING))
    assert (
        text == "1 note (AUD008): --notes shows it; --as-named judges a folder of your own, "
        "where those of AUD008 can be errors or warnings\n"
        "no errors or warnings in 2 files, 1 of which could not be read\n"
    )


def test_named_it_is_an_error() -> None:
    """Whoever names a file means that it can be read. The severity of the settings goes before both."""
    assert [item[3] for item in found(audit(["robots/leg.xml"], Settings()))] == [Severity.ERROR]
    lenient = Settings(severity={"AUD008": Severity.INFO})
    assert [item[3] for item in found(audit(["robots/leg.xml"], lenient))] == [Severity.INFO]


@pytest.mark.parametrize("paths", [["robots"], ["robots/leg.xml"]], ids=["folder", "file"])
@pytest.mark.parametrize("selector", ["AUD008", "unreadable-file", "AUD", "ALL"])
def test_it_is_ignored_by_file(selector: str, paths: list[str]) -> None:
    """`per-file-ignores` sets it aside under its code, family and name."""
    report = audit(paths, Settings(per_file_ignores=(("robots/*.xml", (selector,)),)))
    assert found(report) == []
    assert [item.means for item in report.suppressed] == [Means.SETTING]


def test_a_remark_in_what_can_be_read_of_it() -> None:
    """A remark of the whole file speaks about it; its other remarks are not called unused, as no rule has looked."""
    Path("robots/leg.xml").write_text(
        "<!-- actspec: ignore-file[AUD008] a template -->\n<!-- actspec: ignore-file[LIM101] why -->\n"
        + BROKEN
    )
    report = audit(["robots"], Settings())
    assert (found(report), [item.code for item in report.problems]) == ([], [])
    assert [(item.means, item.reason) for item in report.suppressed] == [(Means.INLINE, "a template")]


def test_it_is_kept_in_a_baseline() -> None:
    """Whatever is wrong with it; once it can be read the entry is stale."""
    write_baseline(audit(["robots"], Settings()).findings, "known.json")
    settings = Settings(baseline="known.json")
    Path("robots/leg.xml").write_text("<mujoco>\n  <worldbody></world>\n</mujoco>\n")
    assert found(audit(["robots"], settings)) == []
    Path("robots/leg.xml").write_text("<mujoco/>")
    assert [str(item).partition("\n")[0] for item in audit(["robots"], settings).problems] == [
        "known.json: AUD007 [warning]: AUD008 is in the baseline and is no longer found in robots/leg.xml"
    ]


def test_a_part_that_two_files_include_counts_once() -> None:
    """It is broken in one place."""
    for name in ("a", "b"):
        Path(f"robots/{name}.xml").write_text('<mujoco>\n  <include file="leg.xml"/>\n</mujoco>\n')
    assert [item[1:3] for item in found(audit(["robots"], Settings()))] == [("robots/leg.xml", 3)]


@pytest.mark.parametrize("path", ["gone.xml", "gone", "empty"])
def test_a_name_that_stands_for_nothing_is_no_finding(path: str) -> None:
    """It is a wrong command: nothing of it can be ignored."""
    Path("empty").mkdir()
    report = audit([path, "robots"], Settings(per_file_ignores=(("**", ("ALL",)),)))
    assert (report.misnamed, report.complete, found(report)) == (True, False, [])


def test_a_folder_of_files_without_their_parts_is_one_entry() -> None:
    """Five scenes, each without two includes: a finding a file, and one for people; a named file has all reasons."""
    for name in "abcde":
        parts = "".join(f'<include file="{name}_{part}.xml"/>' for part in ("arm", "hand"))
        Path("robots", f"{name}.xml").write_text(f"<mujoco>{parts}</mujoco>")
    report = audit(["robots"], Settings())
    scenes = [item for item in report.findings if "there is no file" in item.finding.message]
    assert [item.finding.span.path for item in scenes] == [f"robots/{name}.xml" for name in "abcde"]
    assert {item.finding.help for item in scenes} == {"1 more reason: audit the file by its name"}
    (group,) = [g for g in for_people(report.findings) if "there is no file" in g.first.finding.message]
    assert [span.path for span in group.copies] == [f"robots/{name}.xml" for name in "bcde"]
    assert "(the same kind in robots/b.xml, robots/c.xml and 2 more)" in group.headline()
    named = audit(["robots/a.xml"], Settings())
    assert len(found(named)) == 2


def test_a_folder_that_is_not_there_is_one_entry() -> None:
    """A submodule that was not fetched: two scenes with three includes of it each, in folders of one's own, too."""
    Path("robots/arms").mkdir()
    for name in "ab":
        parts = "".join(f'\n<include file="../sim/{part}/{name}.xml"/>' for part in ("arm", "hand", "scene"))
        Path("robots/arms", f"{name}.xml").write_text(f"<mujoco>{parts}</mujoco>")
    report = audit(["robots"], Settings(as_named=True))
    scenes = [item for item in report.findings if item.finding.span.path.startswith("robots/arms/")]
    assert len(scenes) == 6
    (group,) = for_people(scenes)
    assert group.headline() == (
        "the file cannot be read: the include cannot be followed: there is no folder '../sim' (ROBOT006)"
        " (the same in robots/arms/b.xml)"
    )
    assert (group.also_on(3), group.first.finding.help) == ("also on lines 3, 4", "tried robots/sim")


def test_a_world_with_robots_in_it_is_no_robot_file() -> None:
    """Another program's: it is passed over in a folder, and refused by name."""
    world = "<?xml version='1.0'?>\n<!-- a <robot> -->\n<world><robot><filename>leg.xml</filename></robot></world>"
    Path("robots/world.xml").write_text(world)
    assert [item[1] for item in found(audit(["robots"], Settings()))] == ["robots/leg.xml"]
    assert len(found(audit(["robots/world.xml"], Settings()))) == 1


@pytest.mark.parametrize("named", [["robots", "robots/leg.xml"], ["robots/leg.xml", "robots"]])
def test_a_file_that_is_named_beside_its_folder(named: list[str]) -> None:
    """Whoever names it asks for it."""
    report = audit(named, Settings())
    assert found(report) == [("AUD008", "robots/leg.xml", 3, Severity.ERROR)]


def test_a_spec_in_a_folder() -> None:
    """It is the user's own; every reason is told."""
    Path("robots/leg.yaml").write_text("actspec: 1\nrobot: {nam: leg}\nactuators: 3\n")
    report = audit(["robots"], Settings())
    own = [item for item in found(report) if item[1] == "robots/leg.yaml"]
    assert {severity for *_, severity in own} == {Severity.ERROR}
    assert {line for _, _, line, _ in own} == {2, 3}


@pytest.mark.parametrize("coding", ["utf-16", "utf-32"])
def test_a_model_in_another_coding(coding: str) -> None:
    """It cannot be read, and is counted; a page in it is none of ours."""
    Path("robots/arm.urdf").write_text('<robot name="arm"><link name="a"/></robot>', encoding=coding)
    Path("robots/page.xml").write_text("<html/>", encoding=coding)
    assert [item[1] for item in found(audit(["robots"], Settings()))] == ["robots/arm.urdf", "robots/leg.xml"]


def test_a_warning_about_a_file_is_counted() -> None:
    """MuJoCo refuses the class that is not there; the rules have notes alone."""
    Path("robots/leg.xml").write_text(
        '<mujoco model="leg"><compiler angle="radian"/><worldbody><body><joint name="knee" class="gone"/>'
        '<geom size="0.1"/></body></worldbody><actuator><motor joint="knee"/></actuator></mujoco>'
    )
    report = audit(["robots"], Settings())
    assert report.findings and {item.severity for item in report.findings} == {Severity.INFO}
    text = render(report, "concise", ReportOptions(least=Severity.WARNING))
    assert text.splitlines()[-1] == "no errors in 2 files; 1 warning about files"


CFG = "from isaaclab.assets import ArticulationCfg\nLEG_CFG = ArticulationCfg(actuators={)\n"
DEPLOY = "joint_names: [knee, hip]\nkp: [25, 25\nkd: [1, 1]\n"
OTHERS = {
    "python2.py": "print 'the robot of legged gym'\n",
    "train.py": "import isaaclab\nprint(1)\n",
    "commands.py": "# train\npython legged_gym/scripts/train.py --task=leg\n~/legged_gym/logs$ tensorboard\n",
    "chart.yaml": "{{ if .Values.kp }}\nname: [a\n",
    "comment.yaml": "# kp: 25\nname: [a\n",
    "scene.yaml": "stiff: [1, 2\n",
    "gains.yaml": "kp_file: gains.csv\n",
    "yarp.urdf": '<?xml version="1.0"?><!DOCTYPE robot PUBLIC "-//YARP//DTD" "x.dtd"><robot><a></robot>',
}
"""Broken, or nothing of a robot's: none is both."""


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("leg_cfg.py", CFG, 2),
        ("leg_config.py", CFG.replace("isaaclab.assets", "omni.isaac.lab.assets"), 2),
        (
            "old.py",
            "from legged_gym.envs.base import LeggedRobotCfg\nclass Leg(LeggedRobotCfg:\n    pass\n",
            2,
        ),
        ("leg.yml", DEPLOY, 3),
        ("gains.yaml", "robot: {stiffness: [1,\n", 2),
        ("leg_b.urdf", "version https://git-lfs.github.com/spec/v1\n", 1),
    ],
)
def test_what_the_words_of_a_broken_file_tell(name: str, text: str, line: int) -> None:
    """It is one of a robot's, and not whatever somebody has there: a note in a folder, an error with --as-named."""
    for other, its in OTHERS.items():
        Path("robots", other).write_text(its)
    Path("robots/leg.xml").write_text("<mujoco/>")
    Path("robots", name).write_text(text)
    for as_named, severity in ((False, Severity.INFO), (True, Severity.ERROR)):
        report = audit(["robots"], Settings(as_named=as_named))
        assert found(report) == [("AUD008", f"robots/{name}", line, severity)]
        text = render(report, "concise", ReportOptions(least=Severity.ERROR))
        assert text.splitlines()[-1].endswith("in 3 files, 1 of which could not be read")


def test_a_broken_configuration_alone_in_its_folder() -> None:
    """The folder has something to audit, and the remark in its first lines is read."""
    Path("cfgs").mkdir()
    Path("cfgs/leg_cfg.py").write_text(CFG)
    assert [item[1] for item in found(audit(["cfgs"], Settings()))] == ["cfgs/leg_cfg.py"]
    Path("cfgs/leg_cfg.py").write_text("# actspec: ignore-file[AUD008] half a merge\n" + CFG)
    report = audit(["cfgs"], Settings())
    assert (found(report), [item.reason for item in report.suppressed]) == ([], ["half a merge"])


def test_one_slip_in_several_joints() -> None:
    """Is told once with their names; another text is another finding. Each keeps its place for a baseline."""
    ends = '<parent link="a"/><child link="{0}_l"/><limit effort="{1}" velocity="1"/>'
    joint = f'<joint name="{{0}}" type="revolute">{ends}</joint>'
    joints = (("hip", "3O0"), ("knee", "3O0"), ("ankle", "1,7"))
    links = "".join(f'<link name="{name}_l"/>' for name, _ in joints)
    text = "\n".join(joint.format(name, effort) for name, effort in joints)
    Path("arm.urdf").write_text(f'<robot name="arm"><link name="a"/>{links}\n{text}\n</robot>')
    report = audit(["arm.urdf"], Settings())
    found = [(one.finding.joint, one.finding.span.line) for one in report.findings]
    assert found == [("hip", 2), ("knee", 3), ("", 4)]
    said = render(report, "concise", ReportOptions())
    assert said.count("AUD008") == 2
    assert "hip, knee: the file cannot be read: <limit effort> must be a number, got '3O0' (ROBOT120)" in said
    assert "the file cannot be read: ankle: <limit effort> must be a number, got '1,7' (ROBOT120)" in said


def test_a_submodule_that_is_not_checked_out() -> None:
    """Nothing is wrong with the file: a warning where it was named, else a note; it counts as not read."""
    Path(".gitmodules").write_text('[submodule "m"]\n\tpath = robots/menagerie\n')
    Path("robots/menagerie").mkdir()
    Path("robots/leg.xml").write_text('<mujoco>\n  <include file="menagerie/panda/panda.xml"/>\n</mujoco>\n')
    for path, as_named, severity in (
        ("robots", False, Severity.INFO),
        ("robots", True, Severity.WARNING),
        ("robots/leg.xml", False, Severity.WARNING),
    ):
        report = audit([path], Settings(as_named=as_named))
        assert found(report) == [("AUD008", "robots/leg.xml", 2, severity)]
        assert not report.fails(Severity.ERROR) and report.fails(severity)
        (item,) = (one.finding for one in report.findings if one.finding.code == "AUD008")
        assert item.message == (
            "the file cannot be read: the include cannot be followed: 'robots/menagerie' is a git submodule that is "
            "not checked out (ROBOT010)"
        )
        assert item.help == "git submodule update --init robots/menagerie"
    text = render(report, "concise", ReportOptions(least=Severity.WARNING))
    assert text.endswith("in 1 file, which could not be read\n")
    Path("robots/menagerie/README.md").touch()
    assert found(audit(["robots/leg.xml"], Settings())) == [("AUD008", "robots/leg.xml", 2, Severity.ERROR)]


def test_a_menagerie_that_is_not_cloned() -> None:
    """As a submodule that is not checked out; an absolute path, and a file that a clone lacks, stay errors."""
    Path("robots/leg.xml").write_text(
        '<mujoco>\n  <include file="../mujoco_menagerie/a1/a1.xml"/>\n</mujoco>\n'
    )
    report = audit(["robots"], Settings(as_named=True))
    assert found(report) == [("AUD008", "robots/leg.xml", 2, Severity.WARNING)]
    assert found(audit(["robots"], Settings())) == [("AUD008", "robots/leg.xml", 2, Severity.INFO)]
    (item,) = (one.finding for one in report.findings if one.finding.code == "AUD008")
    assert item.message == (
        "the file cannot be read: the include cannot be followed: MuJoCo Menagerie is not cloned at "
        "'mujoco_menagerie' (ROBOT010)"
    )
    assert item.help == "git clone https://github.com/google-deepmind/mujoco_menagerie mujoco_menagerie"
    Path("mujoco_menagerie/a1").mkdir(parents=True)
    Path("mujoco_menagerie/a1/scene.xml").touch()
    assert found(audit(["robots/leg.xml"], Settings())) == [("AUD008", "robots/leg.xml", 2, Severity.ERROR)]
    Path("robots/leg.xml").write_text('<mujoco>\n  <include file="/a/mujoco_menagerie/a1.xml"/>\n</mujoco>\n')
    assert found(audit(["robots/leg.xml"], Settings())) == [("AUD008", "robots/leg.xml", 2, Severity.ERROR)]


@pytest.mark.parametrize(
    ("path", "code", "message"),
    [
        (
            "menagerie/panda.xml",
            "AUD016",
            "there is no such file or folder: 'menagerie' is a git submodule that is not checked out",
        ),
        (
            "menagerie/",
            "AUD014",
            "nothing to audit in this folder: 'menagerie' is a git submodule that is not checked out",
        ),
    ],
)
def test_one_that_is_named_itself(path: str, code: str, message: str) -> None:
    """A name that stands for nothing, as any other; it comes with the command that gets it."""
    Path("menagerie").mkdir()
    (item,) = audit([path], Settings()).diagnostics()
    assert (item.code, item.help) != (code, "git submodule update --init menagerie")
    Path(".gitmodules").write_text('[submodule "m"]\n\tpath = menagerie\n')
    report = audit([path], Settings())
    (item,) = report.diagnostics()
    assert (item.code, item.message, item.help) == (code, message, "git submodule update --init menagerie")
    assert report.misnamed


def test_a_spec_whose_model_is_in_one() -> None:
    """It stays an error: the spec is its writer's own, and whoever compiles it needs the model."""
    Path(".gitmodules").write_text('[submodule "m"]\n\tpath = menagerie\n')
    Path("leg.yaml").write_text(
        "actspec: 1\nrobot: {name: leg, model: menagerie/leg.xml}\n"
        'actuators:\n  legs: {joints: [".*"], level: ideal_pd, kp: 25, kd: 0.5}\n'
    )
    (item,) = audit(["leg.yaml"], Settings()).findings
    assert (item.finding.code, item.severity, item.finding.help) == (
        "AUD008",
        Severity.ERROR,
        "git submodule update --init menagerie",
    )


@pytest.mark.parametrize(
    ("name", "old", "new", "severity"),
    [
        # Measured with MuJoCo 4.0: it reads the first three.
        ("arm.xml", "'arm'", "'l&r'", Severity.INFO),
        ("arm.xml", "'arm'", "'l<r'", Severity.INFO),
        ("arm.xml", "'arm'", "'\xe9'", Severity.INFO),
        ("arm.xml", "'arm'", "'arm", Severity.WARNING),
        ("arm.xml", "/>", "></a>", Severity.WARNING),
        ("arm.urdf", "'arm'", "'l&r'", Severity.WARNING),
    ],
)
def test_what_mujoco_reads_all_the_same(name: str, old: str, new: str, severity: Severity) -> None:
    """Of an MJCF that a program loads it is a note: nobody there is hindered. Whoever names it has an error."""
    text = {
        "arm.xml": "<mujoco model='arm'>\n<option/>\n<worldbody/></mujoco>",
        "arm.urdf": "<robot name='arm'>\n<link name='a'/></robot>",
    }[name]
    Path("robots/leg.xml").unlink()
    Path("robots", name).write_bytes(text.replace(old, new, 1).encode("latin-1"))
    Path("robots/run.py").write_text(f"import mujoco\nmodel = load('{name}')\n")
    assert [item[3] for item in found(audit(["robots"], Settings()))] == [severity]
    assert [item[3] for item in found(audit([f"robots/{name}"], Settings()))] == [Severity.ERROR]
