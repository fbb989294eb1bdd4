"""A remark is unused only if no selection of the files has a use for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.build import case_of
from actspec.audit.engine import audit
from actspec.audit.finding import Finding
from actspec.audit.read import read_files
from actspec.audit.rules import all_rules
from actspec.audit.settings import Settings
from actspec.readings.artifact import FileKind
from actspec.readings.including import without_fragments
from actspec.readings.versions import Versions
from tests.audit.rules.test_cases import CASES, load, text_of

RULES = {code: rule for rule in all_rules() for code in (*rule.aliases, rule.code)}

MODEL = """<mujoco model="leg">
  <worldbody>
    <body>
      <!-- actspec: ignore[DMP101] measured -->
      <joint name="knee" damping="4" armature="0.01"/>
      <geom size="0.1" mass="1"/>
    </body>
  </worldbody>
  <actuator>
    <position joint="knee" kp="40" kv="2" forcerange="-20 20"/>
  </actuator>
</mujoco>
"""
"""kv beside joint damping: DMP101 speaks of the file by itself."""

INTENT = """actspec: 1
robot: {name: leg, model: leg.xml}
actuators:
  legs:
    joints: ["knee"]
    level: ideal_pd
    kp: 40 N*m/rad
    kd: 2 N*m*s/rad
    effort_limit: 20 N*m
    armature: 0.01 kg*m^2
    friction: {coulomb: 0 N*m, viscous: 4 N*m*s/rad}
targets: {mujoco: {version: "3.12"}}
"""
"""Declares the damping: beside it DMP101 is silent."""

URDF = """<robot name="leg">
  <link name="base"/>
  <link name="shank"/>
  <joint name="knee" type="revolute">
    <parent link="base"/><child link="shank"/>
    <limit lower="-1" upper="1" effort="EFFORT" velocity="20"/>
  </joint>
</robot>
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder `leg` below the working folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "leg").mkdir()
    return tmp_path / "leg"


def _unused(*paths: str) -> list[tuple[str, str]]:
    """ACT002 of a run: file and message."""
    report = audit(paths, Settings())
    return [(i.span.path, i.message) for i in report.problems if i.span is not None and i.code == "ACT002"]


def test_a_remark_that_the_file_alone_needs(folder: Path) -> None:
    """The spec silences DMP101; the hook, which sees the MJCF only, would fail without the remark."""
    (folder / "leg.xml").write_text(MODEL, encoding="utf-8")
    alone = audit(["leg/leg.xml"], Settings())
    assert [item.reported.finding.code for item in alone.suppressed] == ["DMP101"]
    (folder / "leg.yaml").write_text(INTENT, encoding="utf-8")
    together = audit(["leg"], Settings())
    assert not together.suppressed
    assert "DMP101" not in {item.finding.code for item in together.findings}
    assert "ACT002" not in {item.code for item in together.problems}


def test_a_remark_that_nobody_needs(folder: Path) -> None:
    """With the damping gone, the hook and the run over the folder both say so."""
    (folder / "leg.xml").write_text(MODEL.replace('damping="4" ', ""), encoding="utf-8")
    told = [("leg/leg.xml", "this ignore of DMP101 sets nothing aside")]
    assert _unused("leg/leg.xml") == told
    (folder / "leg.yaml").write_text(INTENT.replace("viscous: 4", "viscous: 0"), encoding="utf-8")
    assert _unused("leg/leg.xml", "leg/leg.yaml") == told
    assert _unused("leg") == told


@pytest.mark.parametrize(
    "effort, named, told",
    [
        ("30", ("leg",), False),
        ("30", ("leg/leg.xml", "leg/leg.urdf"), False),
        ("20", ("leg",), True),
        ("20", ("leg/leg.xml", "leg/leg.urdf"), False),
        ("20", ("leg/leg.xml",), False),
    ],
    ids=["used", "used by two", "folder", "two files", "one file"],
)
def test_a_remark_on_a_rule_that_compares(
    folder: Path, effort: str, named: tuple[str, ...], told: bool
) -> None:
    """Only a folder shows that no other file of the robot has another limit."""
    text = MODEL.replace("<!-- actspec: ignore[DMP101] measured -->", "").replace(
        "    <position", "    <!-- actspec: ignore[SRC101] the driver clips -->\n    <position"
    )
    (folder / "leg.xml").write_text(text, encoding="utf-8")
    (folder / "leg.urdf").write_text(URDF.replace("EFFORT", effort), encoding="utf-8")
    found = _unused(*named)
    assert found == ([("leg/leg.xml", "this ignore of SRC101 sets nothing aside")] if told else [])


@pytest.mark.parametrize(
    "group, told", [("", False), (", effort_limit=20.0", True)], ids=["used alone", "unused"]
)
def test_a_remark_in_a_configuration(folder: Path, group: str, told: bool) -> None:
    """The model's limit silences CFG104 in the folder; the hook sees the configuration only and needs the remark."""
    lines = (
        "from mjlab.actuator import IdealPdActuatorCfg",
        "from mjlab.entity import EntityArticulationInfoCfg",
        "# actspec: ignore[LIM105] the model limits it",
        f'LEGS = IdealPdActuatorCfg(target_names_expr=("knee",), stiffness=20.0, damping=2.0{group})',
        "LEG_ARTICULATION = EntityArticulationInfoCfg(actuators=(LEGS,))",
    )
    (folder / "leg_constants.py").write_text("\n".join(lines), encoding="utf-8")
    alone = [item.reported.finding.code for item in audit(["leg/leg_constants.py"], Settings()).suppressed]
    assert alone == ([] if told else ["CFG104"])
    model = MODEL.replace('damping="4" ', 'actuatorfrcrange="-20 20" ').replace("DMP101", "VER102")
    (folder / "leg.xml").write_text(model, encoding="utf-8")
    found = _unused("leg")
    assert found == ([("leg/leg_constants.py", "this ignore of LIM105 sets nothing aside")] if told else [])


def _places(found: list[Finding]) -> set[tuple[str, int]]:
    return {(item.span.path, item.span.line) for item in found}


def _cases() -> list[object]:
    """Cases of more than one file, of rules that say that no other file gives them a finding."""
    return [
        pytest.param(path.stem, name, id=f"{path.stem}-{name}")
        for path in sorted(CASES.glob("*.yaml"))
        if not RULES[path.stem].paired
        for name, case in load(path).items()
        if name != "shared" and len(case["files"]) > 1
    ]


@pytest.mark.parametrize("code, name", _cases())
def test_rules_that_are_not_paired(
    code: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever such a rule finds in a model among other files it finds in the model by itself."""
    monkeypatch.chdir(tmp_path)
    data = load(CASES / f"{code}.yaml")
    case = data[name]
    for file, content in case["files"].items():
        Path(file).parent.mkdir(parents=True, exist_ok=True)
        Path(file).write_text(text_of(content, data.get("shared", {})), encoding="utf-8")
    named = case.get("audit") or [file for file in case["files"] if not file.endswith(".json")]
    readings = without_fragments(read_files(named, jobs=1))
    versions, options = Versions(**case.get("versions", {})), {RULES[code].code: case.get("options", {})}

    def places(*chosen: object) -> set[tuple[str, int]]:
        some = tuple(reading for reading in readings if reading in chosen)
        found = RULES[code]().check(case_of(some, versions, options))
        return _places([item for item in found if isinstance(item, Finding)])

    together = places(*readings)
    for reading in readings:
        if reading.kind in (FileKind.MJCF, FileKind.URDF):
            own = {file.path for file in reading.files}
            assert {place for place in together if place[0] in own} <= places(reading)
