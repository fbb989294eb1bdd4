"""The table of symptoms: its page, its rules and its commands are there."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from actspec.audit.rules import all_rules
from actspec.cli.main import main, parser
from actspec.study.findings import CHECKS, COMPARED
from actspec.study.symptoms import SYMPTOMS, page, symptoms_for

PAGE = Path(__file__).resolve().parents[2] / "docs" / "troubleshooting.md"
RULES = {rule.code for rule in all_rules()}
FINDINGS = {check.code for check in (*CHECKS, *COMPARED)}
SYSID = set(
    re.findall(r"^\| (SYS\d+) ", (PAGE.parent / "sysid.md").read_text(encoding="utf-8"), re.MULTILINE)
)


def test_the_page_is_the_table(request: pytest.FixtureRequest) -> None:
    """docs/troubleshooting.md is what the table makes; `--regen` writes it anew."""
    if request.config.getoption("--regen"):
        PAGE.write_text(page(), encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == page()


def test_every_code_and_command_is_there() -> None:
    """Rules that exist, commands that the parser takes."""
    assert len(SYMPTOMS) >= 14
    for symptom in SYMPTOMS:
        for cause in symptom.causes:
            assert cause.codes or cause.command, cause.what
            assert set(cause.codes) <= RULES | FINDINGS | SYSID, cause.codes
            if cause.command:
                assert parser().parse_args(shlex.split(cause.command)[1:]).command


def test_words_find_symptoms(capsys: Any) -> None:
    """By the words people use, in any case; several words must all be there; none is an error."""
    assert [s.name for s in symptoms_for("shake")] == ["Joints shake or buzz"]
    assert {s.name for s in symptoms_for("Network strong")} == {
        "An actuator network is far too strong or too weak"
    }
    assert main(["rule", "--symptom", "sluggish"]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"damping is counted twice.*DMP101", shown)
    assert main(["rule", "--symptom", "flies away"]) == 2
    assert "no symptom" in capsys.readouterr().err
