"""What a reader cannot take of a named file is a finding: a list one short leaves every joint's gain unjudged."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.outcome import Means
from actspec.audit.rules import all_rules
from actspec.audit.settings import Settings, load_settings
from actspec.cli.main import main
from actspec.diagnostics import AuditError
from actspec.readings.artifact import NOT_TAKEN

DEPLOY = "joint_names: [hip, knee, hop]\nkp: [40, 30]\nkd: [1, .inf, 1]\n"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("robots").mkdir()
    Path("robots/deploy.yaml").write_text(DEPLOY)


def run(*arguments: str) -> int:
    """The exit code."""
    return main(["audit", *arguments])


@pytest.mark.parametrize(
    "arguments, code",
    [
        (["robots/deploy.yaml"], 0),
        (["robots/deploy.yaml", "--fail-on", "warning"], 1),
        (["robots", "--as-named", "--fail-on", "warning"], 1),
        (["robots", "--as-named", "--fail-on", "warning", "--select", "LIM101"], 1),
        (["robots", "--as-named", "--fail-on", "warning", "--ignore", "AUD022"], 0),
        (["robots", "--as-named", "--fail-on", "warning", "--ignore", "DEPLOY001"], 1),
        (["robots", "--as-named", "--fail-on", "warning", "--ignore", "DEPLOY001,no-number"], 0),
        (["robots", "--as-named", "--fail-on", "warning", "--ignore", "DEPLOY"], 0),
        (["robots", "--fail-on", "info"], 0),
    ],
)
def test_it_counts_where_it_was_named(arguments: list[str], code: int) -> None:
    """As a warning, set aside by its own code or the remark's; in a folder of somebody else it counts for nothing."""
    assert run(*arguments) == code


def test_it_is_told_once() -> None:
    """As a finding or as a remark about the file, never as both; a folder's remark is the same as ever."""
    named = audit(["robots"], Settings(as_named=True))
    assert [(item.finding.code, str(item.finding.span)) for item in named.findings] == [
        ("AUD022", "robots/deploy.yaml:2:5"),
        ("AUD022", "robots/deploy.yaml:3:9"),
    ]
    assert named.diagnostics() == ()
    met = audit(["robots"], Settings())
    assert met.findings == ()
    assert [(item.code, item.severity.value) for item in met.diagnostics()] == [
        ("DEPLOY001", "warning"),
        ("DEPLOY003", "warning"),
    ]


def test_what_stands_twice_is_none_in_a_folder() -> None:
    """It may be somebody else's: only which lists are not judged is said there, as before."""
    Path("robots/deploy.yaml").write_text(
        "joint_names: [hip, knee, hip]\nkp: [4, 3, 2]\nkp: [4, 3, 1]\nkd: [1, 1, 1]\n"
    )
    met = audit(["robots"], Settings())
    assert (met.findings, [item.code for item in met.diagnostics()]) == ((), ["DEPLOY002"])
    (lists,) = met.diagnostics()
    assert lists.message.startswith("it is a list whose joint names have one twice: ")
    named = audit(["robots/deploy.yaml"], Settings())
    assert [str(item.finding.span) for item in named.findings] == [
        "robots/deploy.yaml:1:26",
        "robots/deploy.yaml:3:1",
    ]


def test_per_file_ignores_by_the_remarks_code() -> None:
    """A setting of earlier releases holds on; how much it sets aside is counted."""
    report = audit(
        ["robots"], Settings(as_named=True, per_file_ignores=(("robots/deploy.yaml", ("DEPLOY003",)),))
    )
    assert [item.finding.names[0] for item in report.findings] == ["DEPLOY001"]
    assert [item.means for item in report.suppressed] == [Means.SETTING]


def test_baseline_knows_which_remark() -> None:
    """A list that is short hides no value that is none, nor another list."""
    Path("robots/deploy.yaml").write_text(DEPLOY.replace(".inf", "1"))
    fails = ("--fail-on", "warning")
    assert run("robots/deploy.yaml", "--write-baseline", "known.json") == 0
    assert run("robots/deploy.yaml", "--baseline", "known.json", *fails) == 0
    Path("robots/deploy.yaml").write_text(DEPLOY.replace("[40, 30]", "[40, 30, 20]"))
    assert run("robots/deploy.yaml", "--baseline", "known.json", *fails) == 1
    Path("robots/deploy.yaml").write_text("joint_names: [hip, knee, hop]\nkp: [4, 3, 2]\nkd: [1, 1]\n")
    assert run("robots/deploy.yaml", "--baseline", "known.json", *fails) == 1


def test_every_format_has_it(capsys: pytest.CaptureFixture[str]) -> None:
    """As a failure in JUnit, a result in SARIF, an annotation, a line."""
    said = {}
    for name in ("concise", "full", "json", "sarif", "github", "junit", "markdown", "html"):
        run("robots", "--as-named", "--fail-on", "warning", "--output-format", name)
        said[name] = capsys.readouterr().out
        assert "it has 2 values for 3 joint names" in said[name]
    assert 'failures="2"' in said["junit"]
    assert [item["ruleId"] for item in json.loads(said["sarif"])["runs"][0]["results"]] == ["AUD022"] * 2


def test_an_ignore_in_the_file() -> None:
    """By the rule's code, with a reason."""
    ignored = DEPLOY.replace("30]", "30]  # actspec: ignore[AUD022] the robot's own program fills it")
    Path("robots/deploy.yaml").write_text(ignored)
    report = audit(["robots"], Settings(as_named=True))
    assert [item.finding.names[0] for item in report.findings] == ["DEPLOY003"]
    assert [item.means for item in report.suppressed] == [Means.INLINE]


@pytest.mark.parametrize("code", sorted(NOT_TAKEN))
def test_a_remark_has_no_severity_to_set(code: str) -> None:
    """That of the rule can be set, and the refusal leads there."""
    Path("actspec.toml").write_text(f'[audit.severity]\n{code} = "error"\n')
    with pytest.raises(AuditError) as caught:
        load_settings(all_rules())
    (told,) = caught.value.diagnostics
    assert (told.code, told.help) == ("AUD004", "of a file that you name it is AUD022")
    Path("actspec.toml").write_text('[audit.severity]\nAUD022 = "error"\n')
    assert run("robots/deploy.yaml") == 1


def test_what_is_ignored_is_counted(capsys: pytest.CaptureFixture[str]) -> None:
    """As what the baseline and the files themselves set aside is; a rule that is ignored explains no other."""
    Path("actspec.toml").write_text('[audit]\nignore = ["AUD022"]\n')
    assert run("robots", "--as-named", "--fail-on", "warning") == 0
    assert "no findings in 1 file; 2 by ignore\n" in capsys.readouterr().out
    report = audit(["robots"], Settings(as_named=True, ignore=("AUD022",)))
    assert [(item.means, item.reported.finding.code) for item in report.suppressed] == [
        (Means.IGNORE, "AUD022")
    ] * 2
    # What is not selected is not set aside.
    report = audit(["robots"], Settings(as_named=True, select=("SRC",), ignore=("AUD022", "LIM")))
    assert len(report.suppressed) == 2


def test_a_baseline_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    """The run fails, and shows what the baseline is to hold and how it is made."""
    Path("actspec.toml").write_text('[audit]\nas-named = true\nbaseline = "my known.json"\n')
    for more in ([], ["--exit-zero"]):
        assert run("robots", *more) == 2
        said = capsys.readouterr()
        assert "AUD022" in said.out and "AUD005: the baseline cannot be read: no such file" in said.err
        assert "`actspec audit FILE --write-baseline 'my known.json'` writes it" in said.err
    Path("my known.json").write_text("{")
    assert main(["audit", "robots"]) == 2
    assert "AUD022" not in capsys.readouterr().out
    Path("my known.json").unlink()
    assert run("robots", "--write-baseline", "my known.json") == 0
    assert run("robots", "--fail-on", "warning") == 0
