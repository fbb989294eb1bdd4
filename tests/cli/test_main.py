"""What `actspec` says of itself: help of the whole and of each command, and what a start loads."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from actspec.audit.finding import Confidence
from actspec.cli import audit
from actspec.cli.main import COMMANDS, main
from actspec.diagnostics import Severity


def test_alone_prints_help(capsys: pytest.CaptureFixture[str]) -> None:
    """Without a command the help is printed, on stderr and not as a success: an empty variable in a script is none."""
    with pytest.raises(SystemExit) as stop:
        main([])
    out, err = capsys.readouterr()
    assert stop.value.code == 2
    assert out == ""
    assert err.startswith("usage: actspec")
    assert all(f"    {command} " in err for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    """It says what the command does, shows a command line that the parser takes, and names the exit codes."""
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(f"usage: actspec {command} ")
    assert any(line.startswith(f"example: actspec {command} ") for line in lines)
    exits = " ".join(lines).partition("exit codes: ")[2]
    assert exits.startswith("0 ") and "; 2 " in exits
    blank = lines.index("")
    assert len(lines[blank + 1]) > 20


def test_a_command_loads_its_own_module(tmp_path: Path) -> None:
    """What another command needs is not loaded."""
    code = (
        "import sys\nfrom actspec.cli.main import main\nmain(['schema', 'compile'])\n"
        "print([n for n in sys.modules if n.startswith('actspec.cli.')], file=sys.stderr)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    own = ["main", "options", "schema", "streams"]
    assert sorted(eval(done.stderr)) == [f"actspec.cli.{name}" for name in own]


def test_choices_are_those_of_the_audit() -> None:
    """The words of the options are those of the audit's own types."""
    assert {item.value for item in Confidence} == set(audit.CONFIDENCES)
    assert {*(item.value for item in Severity), "never"} == set(audit.FAIL_ON)


@pytest.mark.parametrize("option", ["--output=--", "-o--", "-o=--"])
def test_two_dashes_are_no_value(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    """argparse makes an empty list of it, which no option is read as."""
    with pytest.raises(SystemExit) as stop:
        main(["lock", "a.xml", option])
    assert stop.value.code == 2
    name = option[:2] if option[1] != "-" else "--output"
    assert capsys.readouterr().err.endswith(f"error: argument {name}: expected one argument\n")
