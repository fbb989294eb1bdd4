"""Codes and names of rules that have gone select the rule that took their place, wherever a rule is named."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.outcome import Report
from actspec.audit.rules import all_rules
from actspec.audit.settings import Settings, load_settings
from actspec.cli.main import main
from actspec.diagnostics import Severity

FORMER = {
    "SPC102": "SPC101", "SPC103": "SPC101", "SPC104": "SPC101", "SGN105": "SGN101", "SGN103": "SGN102",
    "SGN104": "SGN102", "LIM102": "LIM101", "LIM103": "LIM101", "LIM105": "CFG104", "LIM110": "CFG104",
    "DMP001": "DMP101", "FRC001": "FRC101", "FRC002": "FRC106", "STB001": "STB102",
}  # fmt: skip
URDF = """<robot name="leg">
  <link name="base"/>
  <link name="shank"/>
  <joint name="knee" type="revolute">
    <parent link="base"/>
    <child link="shank"/>
    <limit lower="-2" upper="0" effort="1e9" velocity="21"/>{remark}
  </joint>
</robot>
"""
PLACEHOLDER = (
    "the effort limit of 1000000000 N*m is a placeholder: no motor reaches it, and it limits nothing"
)


@pytest.fixture(autouse=True)
def leg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A URDF with the finding that was LIM102's, in the working folder."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "leg.urdf"
    path.write_text(URDF.format(remark=""), encoding="utf-8")
    return path


def found(settings: Settings) -> list[tuple[str, str]]:
    """Code and severity of the findings about limits."""
    report: Report = audit(["leg.urdf"], settings)
    return [
        (item.finding.code, item.severity.value) for item in report.findings if item.finding.code[:3] == "LIM"
    ]


def settings(text: str) -> Settings:
    """Settings from a file of this text."""
    Path("actspec.toml").write_text(text, encoding="utf-8")
    return load_settings(all_rules())


def test_every_alias_has_its_rule() -> None:
    """Each code that has gone leads to one rule, and no code or name leads to two."""
    rules = all_rules()
    assert {old: rule.code for rule in rules for old in rule.aliases if old != rule.code} == FORMER
    names = [name for rule in rules for name in {rule.code, *rule.names()}]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("name", ["LIM102", "limit-is-a-placeholder", "LIM101", "LIM"])
def test_selectors(name: str) -> None:
    """Old code and name select, ignore and set the severity; the finding has the new code."""
    assert found(Settings(select=(name,))) == [("LIM101", "warning")]
    assert found(Settings(ignore=(name,))) == []
    assert found(settings(f'[audit]\nignore = ["{name}"]\n')) == []
    assert found(Settings(severity={name: Severity.ERROR})) == [("LIM101", "error")]
    assert found(settings(f'[audit.severity]\n{name} = "error"\n')) == [("LIM101", "error")]
    assert found(Settings(per_file_ignores=(("*.urdf", (name,)),))) == []
    assert found(settings(f'[audit.per-file-ignores]\n"*.urdf" = ["{name}"]\n')) == []


@pytest.mark.parametrize("name", ["LIM102", "limit-is-a-placeholder", "LIM101"])
def test_options(name: str) -> None:
    """Options stand under any of the rule's names."""
    assert found(settings(f"[audit.rules.{name}]\nleast = 1e10\n")) == []


@pytest.mark.parametrize("name", ["LIM102", "limit-is-a-placeholder", "LIM101", "no-effective-limit"])
def test_remarks(leg: Path, name: str) -> None:
    """A remark with an old code sets the finding aside, and is not reported."""
    leg.write_text(
        URDF.format(remark=f" <!-- actspec: ignore[{name}] the driver clips -->"), encoding="utf-8"
    )
    report = audit(["leg.urdf"], Settings(select=("LIM", "ACT")))
    assert not report.findings and not report.problems
    assert [item.reason for item in report.suppressed] == ["the driver clips"]


def test_baseline() -> None:
    """An entry with an old code covers the finding that has the new one now, and goes stale as the new one's."""
    known = settings('[audit]\nbaseline = "known.json"\n')
    assert main(["audit", "leg.urdf", "--select", "LIM", "--write-baseline", "known.json"]) == 0
    data = json.loads(Path("known.json").read_text(encoding="utf-8"))
    assert [entry["code"] for entry in data["findings"]] == ["LIM101"]
    data["findings"][0]["code"] = "LIM102"
    Path("known.json").write_text(json.dumps(data), encoding="utf-8")
    assert found(known) == []
    Path("leg.urdf").write_text(URDF.format(remark="").replace("1e9", "33.5"), encoding="utf-8")
    (problem,) = audit(["leg.urdf"], known).problems
    assert problem.code == "AUD007" and problem.message.startswith("LIM101 is in the baseline")


def test_page(capsys: pytest.CaptureFixture[str]) -> None:
    """`actspec rule OLD` shows the page of the rule that took its place, which says so."""
    assert main(["rule", "LIM102"]) == 0
    page = capsys.readouterr().out
    assert page.startswith("# LIM101 no-effective-limit\n")
    assert "Formerly also LIM101 no-limit-of-any-kind, LIM102 limit-is-a-placeholder" in page
    assert main(["rule", "LIM102", "--output-format", "json"]) == 0
    (record,) = json.loads(capsys.readouterr().out)["rules"]
    assert record["aliases"]["LIM103"] == "limit-of-zero"


def test_remarks_about_remarks_are_selected_by_their_old_names(leg: Path) -> None:
    """ACT001 to ACT003 are no rules any more; their codes and names are still accepted."""
    leg.write_text(URDF.format(remark=" <!-- actspec: ignore[LIM101] -->"), encoding="utf-8")
    for name, shown in (("ACT", True), ("ACT001", True), ("ignore-without-reason", True), ("ACT002", False)):
        report = audit(["leg.urdf"], settings(f'[audit]\nselect = ["{name}"]\n'))
        assert [item.code for item in report.problems] == ["ACT001"] * shown
        report = audit(["leg.urdf"], settings(f'[audit]\nignore = ["{name}"]\n'))
        assert [item.code for item in report.problems] == ["ACT001"] * (not shown)
    glob = '[audit.per-file-ignores]\n"*.urdf" = ["ACT001"]\n'
    assert not audit(["leg.urdf"], settings(glob)).problems
