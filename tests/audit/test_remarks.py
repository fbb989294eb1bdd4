"""What is said of remarks in audited files, case by case; the cases are written as those of rules."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from actspec.audit.engine import audit
from actspec.audit.ignores import REMARKS
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity
from tests.audit.rules.test_cases import load, place, text_of

CASES = Path(__file__).parent / "remarks"


def cases() -> list[Any]:
    """Every case of every file."""
    return [
        pytest.param(code, name, id=f"{code}-{name}")
        for code in REMARKS
        for name in load(CASES / f"{code}.yaml")
        if name != "shared"
    ]


@pytest.mark.parametrize("code, name", cases())
def test_case(code: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A case gives exactly the diagnostics that it states; LIM101 and STB101 run beside, to be ignored."""
    monkeypatch.chdir(tmp_path)
    data = load(CASES / f"{code}.yaml")
    case = data[name]
    assert set(case) <= {"why", "files", "expect"}
    files = {file: text_of(content, data.get("shared", {})) for file, content in case["files"].items()}
    for file, text in files.items():
        Path(file).write_text(text, encoding="utf-8")
    report = audit(list(files), Settings(select=(code, "LIM101", "STB101")))
    assert {item.code for item in report.problems} <= {code}
    found = [
        (item.span.path, item.span.line, item.message, item.help) for item in report.problems if item.span
    ]
    wanted = [
        (*place(entry, files, ""), entry["message"], entry.get("help", found[0][3]))
        for entry in case.get("expect", [])
    ]
    assert sorted(found, key=str) == sorted(wanted, key=str)
    assert bool(wanted) == name.startswith("fail")
    assert {item.severity for item in report.problems} <= {Severity.WARNING}
    assert not report.at_or_above(Severity.ERROR)


def test_every_code_has_cases() -> None:
    """No file of cases is left over."""
    assert {path.stem for path in CASES.iterdir()} == set(REMARKS)
