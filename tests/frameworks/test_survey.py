"""docs/survey.md is what the audit finds in published files, and every error and warning in it has its reason."""

from __future__ import annotations

import dataclasses

import pytest

from actspec.diagnostics import Severity
from benchmarks import survey
from tests.frameworks.prepare import ISAACLAB


def _found(**changes: object) -> survey.Found:
    one = survey.Found("a/leg.urdf", 3, "LIM103", "limit-of-zero", Severity.ERROR, "effort is 0", ("knee",))
    return dataclasses.replace(one, **changes)  # type: ignore[arg-type]


def _verdict(**changes: object) -> survey.Verdict:
    return dataclasses.replace(survey.Verdict("LIM103", ("a/*.urdf",), "effort", "It is."), **changes)  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.usefixtures("frameworks")
def test_the_page_is_what_the_audit_finds() -> None:
    """Run over the corpus and both wheels, the script writes the committed page and misses no reason."""
    found, missing = survey.collections()
    if missing:
        pytest.skip(f"not here: {'; '.join(missing)}")
    text, wrong = survey.survey(found)
    assert wrong == []
    assert text == survey.SURVEY.read_text(encoding="utf-8")


def test_the_page_names_no_path_of_a_machine() -> None:
    """Files are named below their collections."""
    text = survey.SURVEY.read_text(encoding="utf-8")
    assert not [
        word for word in ("/home", "/root", "/work", "/tmp", "site-packages", "shared/") if word in text
    ]


@pytest.mark.parametrize(
    "found, verdict, judged",
    [
        ({}, {}, True),
        ({}, {"files": ("b/*", "*/leg.urdf")}, True),
        ({"code": "LIM101"}, {}, False),
        ({"file": "b/leg.urdf"}, {}, False),
        ({"message": "velocity is 0"}, {}, False),
        ({"message": "velocity is 0"}, {"text": ""}, True),
    ],
    ids=["same", "second glob", "rule", "file", "text", "any text"],
)
def test_what_a_verdict_judges(found: dict[str, object], verdict: dict[str, object], judged: bool) -> None:
    """Rule, file and part of the message must fit."""
    assert _verdict(**verdict).judges(_found(**found)) is judged


def test_a_finding_without_a_reason_and_a_reason_without_a_finding_are_told() -> None:
    """Remarks need none; the first verdict that fits judges, one behind it that judges nothing is idle."""
    error = _found()
    warning = _found(severity=Severity.WARNING, file="b/leg.urdf")
    remark = _found(severity=Severity.INFO, file="c/leg.urdf")
    right, idle = _verdict(), _verdict(text="", why="Never reached.")
    reasons, wrong = survey._judged([error, warning, remark], [right, idle])
    assert reasons == {id(error): right}
    assert wrong == [
        "no reason: b/leg.urdf:3: LIM103 [warning] effort is 0",
        "no finding: LIM103 in a/*.urdf",
    ]


def test_missing_collections_are_said(
    monkeypatch: pytest.MonkeyPatch, tmp_path: object, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where nothing is at hand, nothing is written, and it is no failure."""
    before = survey.SURVEY.read_bytes()
    monkeypatch.setenv("ACTSPEC_CORPUS", str(tmp_path))
    monkeypatch.setenv("ACTSPEC_ENGINES", str(tmp_path))
    monkeypatch.setattr("sys.argv", ["survey.py"])
    assert survey.main() == 0
    said = capsys.readouterr().out.splitlines()
    assert [line.partition(" (")[0] for line in said] == [
        "skipped: the corpus",
        f"skipped: the wheel isaaclab {ISAACLAB[-1]}",
        "skipped: the wheel mjlab",
    ]
    assert survey.SURVEY.read_bytes() == before
