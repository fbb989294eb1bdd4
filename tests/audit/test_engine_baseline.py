"""The baseline: which findings are the same one tomorrow, and which have gone."""

from __future__ import annotations

import ast
import json
from dataclasses import replace
from pathlib import Path

import pytest

from actspec.audit import rules
from actspec.audit.baseline import baseline_text, read_baseline, write_baseline
from actspec.audit.drives import driven
from actspec.audit.engine import audit, judge
from actspec.audit.finding import Finding
from actspec.audit.outcome import Means, Report
from actspec.audit.read import pending_files
from actspec.audit.settings import Settings
from actspec.cli.main import main
from actspec.diagnostics import SEVERITIES, AuditError, Severity
from tests.audit.making import case_of, finding, rule_of
from tests.audit.robots import CFG, LEG, SPEC
from tests.schemas import fits


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, with a file to audit."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.xml").write_text("<a/>")
    return tmp_path


def judged(*found: Finding, baseline: str | None = None, select: tuple[str, ...] = ("ALL",)) -> Report:
    """A report of findings in a.xml."""
    rule = rule_of(found[0].code if found else "LIM901", "first-rule", *found)
    settings = Settings(select=select, baseline=baseline)
    return judge(case_of({"a.xml": b"<a/>"}), settings, (rule, rule_of("DMP901", "other-rule")))


def test_known_findings_are_hidden_wherever_they_stand(folder: Path) -> None:
    """A finding that moves or is worded otherwise stays hidden; another joint and a second one do not."""
    known = judged(finding("LIM901", line=3, joint="knee"))
    write_baseline(known.findings, "base.json")
    report = judged(
        finding("LIM901", line=30, joint="knee", message="wrong, in other words"),
        finding("LIM901", line=31, joint="knee"),
        finding("LIM901", line=30, joint="hip"),
        baseline="base.json",
    )
    assert [(i.finding.span.line, i.finding.joint) for i in report.findings] == [(30, "hip"), (31, "knee")]
    assert [(item.means, item.reported.finding.span.line) for item in report.suppressed] == [
        (Means.BASELINE, 30)
    ]
    assert report.complete


@pytest.mark.parametrize(
    ("now", "reported"),
    [(Severity.INFO, False), (Severity.WARNING, False), (Severity.ERROR, True)],
)
def test_what_is_worse_than_it_was_is_reported(now: Severity, reported: bool, folder: Path) -> None:
    """A warning was accepted; its entry is used up by the error, and is no stale one."""
    write_baseline(judged(finding("LIM901", joint="knee")).findings, "base.json")
    report = judged(finding("LIM901", joint="knee", severity=now), baseline="base.json")
    assert bool(report.findings) is reported
    assert not [item for item in report.diagnostics() if item.code == "AUD007"]


@pytest.mark.parametrize(
    ("figure", "unit", "hidden"),
    [
        pytest.param(24.0, "N*m", True, id="the same"),
        pytest.param(24.2, "N*m", True, id="0.8 % more: another release of MuJoCo"),
        pytest.param(24.3, "N*m", False, id="1.25 % more: another number in the file"),
        pytest.param(24.0, "rad/s", False, id="another field of the joint"),
        pytest.param(None, None, False, id="something else"),
    ],
)
def test_a_figure_that_has_changed_is_not_known(
    figure: float | None, unit: str | None, hidden: bool, folder: Path
) -> None:
    """What was accepted is 24 N*m at the knee."""
    write_baseline(judged(finding("LIM901", joint="knee", value=24.0, unit="N*m")).findings, "base.json")
    report = judged(finding("LIM901", joint="knee", value=figure, unit=unit), baseline="base.json")
    assert (not report.findings) is hidden


@pytest.mark.parametrize(
    ("expected", "hidden"),
    [
        pytest.param(12.0, True, id="the same"),
        pytest.param(12.1, True, id="0.8 % more: another release of MuJoCo"),
        pytest.param(1.2, False, id="the other file's figure has changed: 20 times in place of twice"),
        pytest.param(None, False, id="wrong in another way"),
    ],
)
def test_a_figure_that_is_held_to_another_one(expected: float | None, hidden: bool, folder: Path) -> None:
    """24 beside 12 that is known says nothing of 24 beside 1.2."""
    at = {"joint": "knee", "value": 24.0, "unit": "N*m"}
    write_baseline(judged(finding("LIM901", **at, expected=12.0)).findings, "base.json")
    fits("baseline", json.loads(Path("base.json").read_text()))
    report = judged(finding("LIM901", **at, expected=expected), baseline="base.json")
    assert (len(report.findings), len(report.suppressed)) == ((0, 1) if hidden else (1, 0))


def test_a_baseline_covers_all_that_it_was_written_of(folder: Path) -> None:
    """Two findings of a joint whose figures differ by less than 1 %, in both orders: each has its own entry."""
    at = {"joint": "knee", "unit": "N*m", "expected": 35.55}
    for lines in ((3, 9), (9, 3)):
        found = [
            finding("LIM901", **at, line=lines[0], value=23.7, severity=Severity.WARNING),
            finding("LIM901", **at, line=lines[1], value=23.5, severity=Severity.INFO),
        ]
        write_baseline(judged(*found).findings, "base.json", force=True)
        report = judged(*found, baseline="base.json")
        assert (len(report.findings), len(report.suppressed)) == (0, 2)
        assert not report.problems


@pytest.mark.parametrize(
    ("known", "now", "shown"),
    [
        pytest.param(
            [(23.7, "warning"), (23.5, "info")],
            [(23.76, "warning"), (23.56, "info")],
            [],
            id="another release of MuJoCo: a quarter of a percent more",
        ),
        pytest.param(
            [(23.7, "warning"), (23.5, "info")], [(23.6, "warning")], [], id="the one that is not milder"
        ),
        pytest.param(
            [(23.7, "info"), (23.5, "warning")], [(23.7, "warning")], [23.7], id="worse than itself"
        ),
        pytest.param([(23.7, "info")], [(23.7, "warning"), (23.7, "info")], [23.7], id="one is new"),
    ],
)
def test_of_several_entries_the_nearest_is_it(
    known: list[tuple[float, str]], now: list[tuple[float, str]], shown: list[float], folder: Path
) -> None:
    """Figures within 1 % are one, of entries that cover a finding each is used once."""

    def made(figures: list[tuple[float, str]]) -> list[Finding]:
        at = {"joint": "knee", "unit": "N*m", "expected": 35.55}
        return [
            finding("LIM901", **at, line=line, value=value, severity=Severity(name))
            for line, (value, name) in enumerate(figures, 1)
        ]

    write_baseline(judged(*made(known)).findings, "base.json")
    report = judged(*made(now), baseline="base.json")
    assert [item.finding.value for item in report.findings] == shown


def test_a_new_one_is_not_hidden_behind_a_mended_one(folder: Path) -> None:
    """Without a figure, what the finding is about tells it; of one more than is known, the new one is shown."""
    write_baseline(judged(finding("ORD901", about="left_ankel stiffness")).findings, "base.json")
    fits("baseline", json.loads(Path("base.json").read_text()))
    known = finding("ORD901", line=9, about="left_ankel stiffness", message="wrong, in other words")
    new = finding("ORD901", about="left_kne damping")
    assert not judged(known, baseline="base.json").findings
    for found in ([new], [new, known]):
        assert [item.finding for item in judged(*found, baseline="base.json").findings] == [new]
    entry = {"code": "ORD901", "file": "a.xml", "joint": "", "count": 1}
    Path("old.json").write_text(json.dumps({"format": "actspec-baseline/1", "findings": [entry]}))
    assert not judged(new, baseline="old.json").findings


_LEG = """from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets.articulation import ArticulationCfg
LEG_CFG = ArticulationCfg(
    actuators={
        "legs": IdealPDActuatorCfg(
            joint_names_expr=["left_hip", "left_knee"],
            effort_limit={"left_hip": 24.0, "left_knee": 24.0},
            stiffness={"left_hip": 40.0, "left_knee": 40.0%s},
            damping={"left_hip": 1.0, "left_knee%s": 1.0},
            armature=0.01,
        ),
    },
)
"""


def test_another_key_is_another_finding(folder: Path) -> None:
    """A key of `stiffness` is mended, and one of `damping` misspelt: both raise a ValueError, and both are ORD104."""
    Path("leg_cfg.py").write_text(_LEG % (', "left_ankel": 40.0', ""))
    write_baseline(audit(["leg_cfg.py"], Settings()).findings, "base.json")
    assert not audit(["leg_cfg.py"], Settings(baseline="base.json")).findings
    Path("leg_cfg.py").write_text(_LEG % ("", "s"))
    report = audit(["leg_cfg.py"], Settings(baseline="base.json"))
    assert [(item.finding.code, item.severity.value) for item in report.findings] == [("ORD104", "error")]
    assert [item.code for item in report.diagnostics()] == ["AUD007"]


def test_what_has_no_figure_says_what_it_is_about() -> None:
    """Else a baseline counts the findings of a file, and cannot tell a new one from a known one."""
    silent = []
    for path in sorted(Path(rules.__file__).parent.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Finding":
                words = {word.arg for word in node.keywords}
                # Code, message, place, joint, value; `joints` has a finding of which a file has one.
                if len(node.args) < 4 and not words & {"joint", "value", "about", "joints"}:
                    silent.append(f"{path.name}:{node.lineno}")
    assert not silent


def test_a_baseline_of_an_earlier_release(folder: Path) -> None:
    """It has a hash of the message and no figure: rule, file and joint count, and the number of findings."""
    entry = {"code": "LIM901", "file": "a.xml", "joint": "knee", "hash": "0123456789abcdef", "count": 1}
    Path("base.json").write_text(json.dumps({"format": "actspec-baseline/1", "findings": [entry]}))
    found = [finding("LIM901", line=line, joint="knee", value=float(line), unit="N*m") for line in (1, 2)]
    assert [i.finding.span.line for i in judged(*found, baseline="base.json").findings] == [2]


def test_the_file_is_relative_to_the_baseline(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It serves from any working folder."""
    (folder / "ci").mkdir()
    write_baseline(judged(finding("LIM901")).findings, "ci/base.json")
    assert json.loads((folder / "ci" / "base.json").read_text())["findings"][0]["file"] == "../a.xml"
    monkeypatch.chdir(folder / "ci")
    rule = rule_of("LIM901", "first-rule", finding("LIM901", "../a.xml"))
    report = judge(case_of({"../a.xml": b"<a/>"}), Settings(baseline="base.json"), (rule,))
    assert not report.findings


def test_stale_entries_are_told(folder: Path) -> None:
    """An entry that is no longer found is told, unless its rule or its file was not looked at."""
    write_baseline(
        judged(finding("LIM901", joint="knee"), finding("LIM901", joint="hip")).findings, "base.json"
    )
    (problem,) = judged(baseline="base.json").problems
    assert str(problem) == (
        "base.json: AUD007 [warning]: LIM901 is in the baseline and is no longer found in a.xml (hip, knee)\n"
        "  help: write the baseline again with --write-baseline base.json"
    )
    assert not judged(baseline="base.json", select=("DMP",)).problems
    other = judge(
        case_of({"b.xml": b"<a/>"}), Settings(baseline="base.json"), (rule_of("LIM901", "first-rule"),)
    )
    assert not other.problems


def test_entries_of_a_deleted_file_are_told(folder: Path) -> None:
    """They hide what a new file of that name would have; once a file, whatever rules run."""
    found = [finding("LIM901", joint="knee"), finding("LIM901", joint="hip"), finding("LIM901", "b\\x80.xml")]
    (folder / "ci").mkdir()
    write_baseline(judged(*found).findings, "ci/base.json")
    Path("b\\x80.xml").write_text("<a/>")
    rules = (rule_of("LIM901", "first-rule"),)
    case, settings = case_of({"c.xml": b"<a/>"}), Settings(baseline="ci/base.json", select=("DMP",))
    assert not judge(case, settings, rules).problems
    Path("a.xml").unlink()
    (problem,) = judge(case, settings, rules).problems
    assert problem.code == "AUD021"
    assert problem.message == "the baseline has findings of ../a.xml, which is not there: LIM901"
    report = judge(case, settings, rules)
    assert [report.fails(severity) for severity in (*SEVERITIES, None)] == [True, True, False, False]
    assert not judge(case, replace(settings, ignore=("AUD021",)), rules).fails(Severity.INFO)


def test_text_is_stable_and_valid(folder: Path) -> None:
    """Entries are sorted, equal ones counted, and the text has the form of its schema."""
    found = [finding("LIM901", line=line, joint=joint) for joint in ("knee", "hip") for line in (1, 2)]
    text = baseline_text(judged(*found).findings, "base.json")
    assert text == baseline_text(judged(*reversed(found)).findings, "base.json")
    data = json.loads(text)
    fits("baseline", data)
    assert [(entry["joint"], entry["count"]) for entry in data["findings"]] == [("hip", 2), ("knee", 2)]
    fits("baseline", json.loads(baseline_text((), "base.json")))


@pytest.mark.parametrize(
    "text, message",
    [
        (None, "the baseline cannot be read: no such file or directory"),
        ("{", "this is not JSON in UTF-8: "),
        ("[" * 100_000, "this is not JSON in UTF-8: it is nested too deeply"),
        ("[]", "this is no baseline of actspec"),
        ('{"format": "actspec-baseline/2"}', "the baseline is of another version of actspec"),
        ('{"format": "actspec-baseline/1"}', "an entry of the baseline is not as actspec writes it"),
        (
            '{"format": "actspec-baseline/1", "findings": [{"code": "A", "file": 1}]}',
            "an entry of the baseline is not as actspec writes it",
        ),
        (
            '{"format": "actspec-baseline/1", "findings": '
            '[{"code": "A", "file": "b", "joint": "", "hash": "0", "count": 0}]}',
            "an entry of the baseline is not as actspec writes it",
        ),
        (
            '{"format": "actspec-baseline/1", "findings": '
            '[{"code": "A", "file": "b", "joint": "", "value": "24", "count": 1}]}',
            "an entry of the baseline is not as actspec writes it",
        ),
        (
            '{"format": "actspec-baseline/1", "findings": [], "driven": [{"file": "b", "joints": [1]}]}',
            "the driven joints of a file are not as actspec writes them",
        ),
    ],
    ids=["missing", "cut", "deep", "list", "newer", "no findings", "types", "count", "figure", "driven"],
)
def test_bad_baselines(text: str | None, message: str, folder: Path) -> None:
    """What is no baseline is refused with the way to write one."""
    if text is not None:
        (folder / "base.json").write_text(text)
    with pytest.raises(AuditError) as caught:
        read_baseline("base.json", {})
    (item,) = caught.value.diagnostics
    assert item.code == "AUD005"
    assert item.message.startswith(message)


def test_a_baseline_that_cannot_be_written(folder: Path) -> None:
    """A folder that is not there is told."""
    with pytest.raises(AuditError) as caught:
        write_baseline((), "no/base.json")
    assert caught.value.diagnostics[0].message == "the baseline cannot be written: no such file or directory"


def test_what_is_said_of_a_file_is_known_too(folder: Path) -> None:
    """A model that MuJoCo refuses is said once; another file of that kind is still said."""
    refused = (
        '<mujoco><compiler angle="radian"/><worldbody><body><joint name="knee"/></body></worldbody></mujoco>'
    )
    Path("robots").mkdir()
    (folder / "robots/a.xml").write_text(refused)
    report = audit(["robots"], Settings())
    assert [item.code for item in report.diagnostics()] == ["AUD013"]
    write_baseline(report.findings, "base.json", report.diagnostics())
    fits("baseline", json.loads((folder / "base.json").read_text()))
    (folder / "robots/b.xml").write_text(refused)
    again = audit(["robots"], Settings(baseline="base.json"))
    assert [(item.code, item.span and item.span.path) for item in again.diagnostics()] == [
        ("AUD013", "robots/b.xml")
    ]


def _leg(*actuators: str, joints: str = "hip knee toe") -> str:
    bodies = "".join(
        f'<body pos="0 0 -0.2"><joint name="{name}"/><geom size="0.05"/>' for name in joints.split()
    )
    return (
        f'<mujoco model="leg">\n<worldbody>{bodies}{"</body>" * len(joints.split())}</worldbody>\n'
        '<tendon><fixed name="t"><joint joint="toe" coef="1"/></fixed></tendon>\n'
        f"<actuator>{''.join(actuators)}</actuator></mujoco>\n"
    )


MOTORS = {
    name: f'<motor name="{name}" joint="{name}" ctrlrange="-24 24"/>' for name in ("hip", "knee", "toe")
}


@pytest.mark.parametrize(
    ("now", "names"),
    [
        ([*MOTORS], None),
        (["hip", "toe"], "knee"),
        (["hip"], "knee, toe"),
        # Another kind of actuator, and one over a tendon, drive it too.
        (["hip", "<position joint='knee' kp='3' ctrlrange='-1 1'/>", "<motor tendon='t'/>"], None),
    ],
)
def test_a_joint_that_has_lost_its_actuator(now: list[str], names: str | None, folder: Path) -> None:
    """It is told at the joint, in place of what is no longer found there, and the exit code counts it."""
    Path("leg.xml").write_text(_leg(*MOTORS.values()))
    known = audit(["leg.xml"], Settings())
    write_baseline(known.findings, "base.json", driven=driven(known.case, ""))
    data = json.loads(Path("base.json").read_text())
    fits("baseline", data)
    assert data["driven"] == [{"file": "leg.xml", "joints": ["hip", "knee", "toe"]}]
    assert any(item.finding.joint == "knee" for item in known.findings)
    Path("leg.xml").write_text(_leg(*(MOTORS.get(name, name) for name in now)))
    report = audit(["leg.xml"], Settings(baseline="base.json"))
    assert [str(one) for one in report.problems if one.code != "AUD007"] == (
        []
        if names is None
        else [
            f"leg.xml:2:{Path('leg.xml').read_text().splitlines()[1].index(f'<joint name={chr(34)}knee') + 1}: AUD023 "
            f"[warning]: no actuator drives {names} any more, as one did when the baseline was written: the "
            f"joint{'s swing' if ',' in names else ' swings'} freely\n"
            f"  help: put the actuator{'s' * (',' in names)} back; if it is meant, write the baseline again with "
            "--write-baseline base.json"
        ]
    )
    assert not any(name in one.message for one in report.problems[1:] for name in (names or "-").split(", "))
    assert report.fails(Severity.WARNING) is (names is not None) and not report.fails(Severity.ERROR)
    quiet = audit(["leg.xml"], Settings(baseline="base.json", ignore=("AUD023",)))
    assert not quiet.fails(Severity.WARNING)


def test_a_joint_that_is_not_there_any_more(folder: Path) -> None:
    """Its findings have gone with it, which is said in place of letting them pass for mended."""
    Path("leg.xml").write_text(_leg(*MOTORS.values()))
    known = audit(["leg.xml"], Settings())
    write_baseline(known.findings, "base.json", driven=driven(known.case, ""))
    # Renamed, it is driven by its new name.
    renamed = _leg(*MOTORS.values()).replace('"knee"', '"shank"')
    Path("leg.xml").write_text(renamed)
    report = audit(["leg.xml"], Settings(baseline="base.json"))
    told = [one.message for one in report.problems]
    assert told and all(
        message.endswith(
            " is in the baseline and is no longer found in leg.xml (knee): knee is no joint of it any more"
        )
        for message in told
    )
    for now, names in (
        (_leg(MOTORS["hip"], MOTORS["toe"], joints="hip toe"), "knee is no joint of it any more, and"),
        (
            _leg(MOTORS["hip"], MOTORS["toe"]).replace('"knee"', '"shank"'),
            "knee is no joint of it any more, and",
        ),
        (renamed.replace('"toe"', '"foot"').replace(MOTORS["hip"], ""), "hip any more, as"),
    ):
        Path("leg.xml").write_text(now)
        report = audit(["leg.xml"], Settings(baseline="base.json"))
        (lost,) = (one for one in report.problems if one.code == "AUD023")
        assert names in lost.message and report.fails(Severity.WARNING)
        assert not any("(knee)" in one.message for one in report.problems if "is no joint" in lost.message)
    Path("leg.xml").write_text(_leg(MOTORS["hip"], joints="hip").replace("toe", "hip"))
    (lost,) = (
        one for one in audit(["leg.xml"], Settings(baseline="base.json")).problems if one.code == "AUD023"
    )
    assert str(lost) == (
        "leg.xml: AUD023 [warning]: knee, toe are no joints of it any more, and an actuator drove each when the "
        "baseline was written\n  help: put the joints back; if it is meant, write the baseline again with "
        "--write-baseline base.json"
    )


def test_a_model_without_any_actuator(folder: Path) -> None:
    """All of them at once, at the file; not where mjlab loads it, which brings its own: Isaac Lab loads a USD."""
    Path("leg.xml").write_text(_leg(*MOTORS.values()))
    known = audit(["leg.xml"], Settings())
    write_baseline((), "base.json", driven=driven(known.case, ""))
    Path("leg.xml").write_text(_leg())
    (told,) = audit(["leg.xml"], Settings(baseline="base.json")).problems
    assert str(told).startswith("leg.xml: AUD023 [warning]: no actuator drives any of its joints any more")
    isaaclab = (
        "from isaaclab.actuators import IdealPDActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        'LEG_CFG = ArticulationCfg(actuators={"all": IdealPDActuatorCfg(joint_names_expr=["hip", "knee", "toe"], '
        "stiffness=20.0, damping=1.0, effort_limit=24.0)})\n"
    )
    Path("leg_cfg.py").write_text(isaaclab)
    assert audit(["leg.xml", "leg_cfg.py"], Settings(baseline="base.json")).problems == (told,)
    mjlab = (
        "import mujoco\nfrom mjlab.actuator import BuiltinPositionActuatorCfg\n"
        "from mjlab.entity import EntityArticulationInfoCfg, EntityCfg\n"
        'LEG = BuiltinPositionActuatorCfg(target_names_expr=(".*",), stiffness=20.0, damping=1.0, effort_limit=24.0)\n'
        'def get_spec(): return mujoco.MjSpec.from_file("@")\n'
        "LEG_CFG = EntityCfg(spec_fn=get_spec, articulation=EntityArticulationInfoCfg(actuators=(LEG,)))\n"
    )
    for model, lost in (("leg.xml", False), ("other.xml", True)):
        Path("leg_cfg.py").write_text(mjlab.replace("@", model))
        assert bool(audit(["leg.xml", "leg_cfg.py"], Settings(baseline="base.json")).problems) is lost
    # Which one it loads is not told: one that lies beside it.
    mjlab = mjlab.replace('"@"', "mujoco.anything()")
    Path("leg_cfg.py").write_text(mjlab)
    Path("sub").mkdir()
    Path("sub/leg_cfg.py").write_text(mjlab)
    assert not audit(["leg.xml", "leg_cfg.py"], Settings(baseline="base.json")).problems
    assert audit(["leg.xml", "sub/leg_cfg.py"], Settings(baseline="base.json")).problems == (told,)
    Path("leg_cfg.py").write_text(isaaclab)
    # Joints that are called otherwise now, and a file that was not audited, say nothing.
    renamed = (
        _leg(*MOTORS.values()).replace('joint="toe"', 'joint="foot"').replace('name="toe"', 'name="foot"')
    )
    Path("leg.xml").write_text(renamed)
    assert not audit(["leg.xml"], Settings(baseline="base.json")).problems
    Path("leg.xml").unlink()
    assert not audit(["a.xml"], Settings(baseline="base.json")).problems


DEPLOY = "joint_names: [hip, knee]\nkp: [50, 100]\nkd: [3, 3]\n"


@pytest.mark.parametrize(
    ("file", "text", "state", "codes"),
    [
        ("deploy.yaml", "", "in which nothing is left to audit", "SRC103"),
        ("deploy.yaml", None, "which is not there", "SRC103"),
        ("leg_cfg.py", "# moved\n", "in which nothing is left to audit", "FRC102, SRC103"),
        (
            "leg_cfg.py",
            CFG.partition("    actuators=")[0] + ")\n",
            "in which nothing is left to audit",
            "FRC102, SRC103",
        ),
        ("leg.xml", "", "in which nothing is left to audit", "DMP101"),
        ("leg.xml", "<mujoco/>", "in which nothing is left to audit", "DMP101"),
    ],
)
def test_a_file_that_has_lost_its_robot(
    file: str, text: str | None, state: str, codes: str, folder: Path
) -> None:
    """It takes its findings with it, as a deleted one does, and is told and counted as that is."""
    robots = {"leg.xml": LEG, "leg_cfg.py": CFG.replace("100.0", "200.0"), "deploy.yaml": DEPLOY}
    Path("robots").mkdir()
    for name, content in robots.items():
        Path("robots", name).write_text(content)
    known = audit(["robots"], Settings(as_named=True))
    write_baseline(known.findings, "base.json", driven=driven(known.case, ""))
    settings = Settings(baseline="base.json", as_named=True)
    assert not audit(["robots"], settings).problems
    own = Path("robots", file)
    own.unlink() if text is None else own.write_text(text)
    told = [one for one in audit(["robots"], settings).problems if one.code == "AUD021"]
    assert [one.message for one in told] == [f"the baseline has findings of robots/{file}, {state}: {codes}"]
    back = "" if text is None else "put back what it had; if it is meant, "
    assert told[0].help == f"{back}write the baseline again with --write-baseline base.json"
    assert audit(["robots"], settings).fails(Severity.WARNING)
    # Of the drives of a model alone, too; a run over something else knows nothing of them.
    write_baseline((), "base.json", driven=driven(known.case, ""))
    told = [one for one in audit(["robots"], settings).problems if one.code != "AUD007"]
    assert [one.message for one in told] == (
        [f"the baseline has the drives of robots/leg.xml, {state}"] if file == "leg.xml" else []
    )
    assert not audit(["a.xml"], settings).problems


def test_a_file_that_has_lost_its_robot_is_left_out(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of a baseline that is written again, with its drives."""
    Path("robots").mkdir()
    Path("robots/leg.xml").write_text(LEG)
    Path("robots/other.xml").write_text(LEG.replace('"leg"', '"other"'))
    assert main(["audit", "robots", "--write-baseline", "base.json"]) == 0
    Path("robots/leg.xml").write_text("")
    assert main(["audit", "robots", "--write-baseline", "base.json"]) == 0
    assert "base.json: left out: 2 findings of 1 file, no longer there\n" in capsys.readouterr().err
    data = json.loads(Path("base.json").read_text())
    assert {one["file"] for one in (*data["findings"], *data["driven"])} == {"robots/other.xml"}


def test_a_part_that_stands_alone_is_not_lost(folder: Path) -> None:
    """What another file includes or imports, and a file of which it was said that it has nothing to audit."""
    Path("robots/parts").mkdir(parents=True)
    Path("robots/leg.xml").write_text(LEG)
    Path("robots/leg.yaml").write_text(
        "include: [parts/motors.yaml]\n"
        + SPEC.replace("    effort_limit: 30 N*m\n    armature: 0.01 kg*m^2\n", "    motor: m\n")
    )
    Path("robots/parts/motors.yaml").write_text(
        "motors:\n  m: {peak_torque: 80 N*m, side: joint, rotor_inertia: 1e-4 kg*m^2, gear_ratio: 10}\n"
    )
    Path("robots/parts/gains.py").write_text("LIMIT = -30.0\n")
    text = "from .parts.gains import LIMIT\n" + CFG.replace("effort_limit=30.0", "effort_limit=LIMIT")
    Path("robots/leg_cfg.py").write_text(text)
    Path("robots/notes.yaml").write_text("rate: 50\n")
    known = audit(["robots", "robots/notes.yaml"], Settings(as_named=True))
    files = {f"robots/{name}" for name in ("leg.xml", "notes.yaml", "parts/motors.yaml", "parts/gains.py")}
    assert files <= {one.finding.span.path for one in known.findings}
    write_baseline(known.findings, "base.json", driven=driven(known.case, ""))
    for select in (("ALL",), ("DMP",)):
        settings = Settings(baseline="base.json", as_named=True, select=select)
        assert not audit(["robots"], settings).problems
        assert not audit(["robots/parts"], settings).problems


def test_a_baseline_names_no_model(folder: Path) -> None:
    """A program loads one of two legs; the baseline has the other's file name, and runs nothing: what is found stays.

    Where a model that no program names counts as named, its limit would be blamed in place of the loaded one's.
    """
    (folder / "a.xml").unlink()
    for name, limit in (("leg.xml", 20), ("spare/leg.xml", 90)):
        (folder / name).parent.mkdir(exist_ok=True)
        text = _leg('<motor joint="hip"/>', joints="hip").replace(
            "<motor ", f'<motor forcerange="-{limit} {limit}" '
        )
        (folder / name).write_text(text)
    (folder / "run.py").write_text('load("leg.xml")\n')

    def read() -> dict[str, bool]:
        with pending_files(["."]) as pending:
            return {one.path: one.unnamed for one in pending.finish()}

    before = read()
    (folder / "base.json").write_text(
        '{\n  "format": "actspec-baseline/1", "findings": [{"file": "spare/leg.xml"}]}'
    )
    assert read() == before
    # A file of somebody's own that lists it does count.
    (folder / "base.json").write_text('{"models": ["spare/leg.xml"]}')
    assert read() != before
