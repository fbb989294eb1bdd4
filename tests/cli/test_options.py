"""Every option of every command, with values that are none: bad input or a name, never a fault of actspec."""

from __future__ import annotations

import argparse
import re
import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from actspec.cli.main import main, parser
from tests.in_process import in_process

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "tests" / "fuzz" / "scene"

VALUES = (
    "nan",
    "-inf",
    "-1",
    "1e400",
    "1e200 s",
    "1e-320",
    "9" * 5000,
    "",
    "rad",
    "[",
    "hip,hip",
    "x==",
    "\udcff\n",
)

LINES = {
    "compile": "plain.yaml",
    "validate": "plain.yaml",
    "show": "plain.yaml",
    "verify": "plain.yaml --fields-only",
    "compare": "plain.yaml",
    "diagnose": "plain.yaml log.csv",
    "audit": "biped_cfg.py",
    "rule": "DMP101",
    "diff": "plain.yaml plain.yaml#soft",
    "sysid design": "plain.yaml --experiment chirp --seed 0 -o out.csv",
    "sysid simulate": "plain.yaml --command log.csv --seed 0 -o out.csv",
    "sysid fit": "plain.yaml log.csv",
    "sysid report": "results.yaml -o out.html",
    "sysid import": "results.yaml --from line --robot plain.yaml --joint hip -o out.yaml",
    "net data": "plain.yaml log.csv",
    "net train": "plain.yaml log.csv --epochs 0 -o out/net",
    "net evaluate": "plain.yaml log.csv --network none.json",
    "net inspect": "results.yaml",
    "net convert": "results.yaml -o out/net",
    "delta train": "plain.yaml log.csv --epochs 0 -o out/delta",
    "delta validate": "plain.yaml log.csv --network none.json",
    "lock": "plain.yaml",
    "import": "biped.urdf",
    "init": "new.yaml",
}
"""A command line of each command, quick and without MuJoCo; `ablate` and `report` draw, and share their options."""


def options(command: argparse.ArgumentParser, name: str = "") -> Iterator[tuple[str, str]]:
    """Command and option, of all that take a text of the user's."""
    for action in command._actions:
        if isinstance(action, argparse._SubParsersAction):
            for word, part in action.choices.items():
                yield from options(part, f"{name} {word}".strip())
        elif action.option_strings and action.nargs != 0 and not action.choices:
            yield name, action.option_strings[-1]


OPTIONS = sorted(set(options(parser())))


def test_every_command_is_tried() -> None:
    """But for those whose options are the others'."""
    assert {command for command, _ in OPTIONS} - set(LINES) == {"ablate", "report"}


def test_every_option_is_in_the_docs() -> None:
    """In its command's section of the page of commands; those of two words, as `sysid fit`, have pages of their own."""
    page = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
    sections = {part.split()[0]: part for part in page.split("\n## actspec ")[1:]}
    (commands,) = (a for a in parser()._actions if isinstance(a, argparse._SubParsersAction))
    missing = [
        f"{name} {option}"
        for name, command in commands.choices.items()
        for action in command._actions
        for option in action.option_strings
        if option.startswith("--")
        and option != "--help"
        and not re.search(rf"{option}(?![a-z-])", sections[name])
    ]
    assert missing == []


@pytest.mark.slow
@pytest.mark.parametrize("command", LINES)
def test_values_that_are_none(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """An exit code, and no words of a fault."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(SCENE, tmp_path, dirs_exist_ok=True)
    shutil.copytree(ROOT / "docs" / "example", tmp_path, dirs_exist_ok=True)
    with in_process():
        for option in (option for name, option in OPTIONS if name == command):
            for value in VALUES:
                code = 2
                with suppress(SystemExit):  # of the parser
                    code = main([*command.split(), *LINES[command].split(), f"{option}={value}"])
                out, err = capsys.readouterr()
                told = f"{command} {option}={value[:20]}: {(out + err)[-300:]}"
                assert code in (0, 1, 2), told
                assert "ENV00" not in out + err and "Traceback" not in out + err and "Warning: " not in err, (
                    told
                )


@pytest.mark.parametrize(
    ("first", "option", "more"),
    [
        ("show plain.yaml", "--variant soft", "hip"),
        ("ablate plain.yaml", "-o out", "log.csv"),
        ("report plain.yaml", "-o out.html", "log.csv"),
        ("diagnose plain.yaml", "--task run", "log.csv"),
        ("audit a.xml", "--fail-on never", "b.xml"),
        ("validate a.yaml", "--output-format json", "b.yaml"),
        ("import a.xml", "-o a.yaml", "b_cfg.py"),
        ("lock a.yaml", "-o other.lock", "b.yaml"),
        ("sysid fit a.yaml", "-o out.yaml", "log.csv"),
        ("compile a.yaml", "--package p=.", "b.yaml"),
    ],
)
def test_an_option_between_arguments(first: str, option: str, more: str) -> None:
    """It stands before, between and behind them, and means the same."""
    orders = [f"{first} {more} {option}", f"{first} {option} {more}"]
    before, between = (vars(parser().parse_args(text.split())) for text in orders)
    assert between == before


def test_what_is_too_much_is_still_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """A third argument of two, and an option that there is not."""
    for text, words in (
        ("show a.yaml --variant x hip knee", "unrecognized arguments: knee"),
        ("show a.yaml --nothing hip", "unrecognized arguments: --nothing hip"),
    ):
        with pytest.raises(SystemExit):
            parser().parse_args(text.split())
        assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "name", "said"),
    [
        ("audit a.xml --noets", "audit", "--noets; did you mean --notes?"),
        ("audit --as_named a.xml", "audit", "--as_named; did you mean --as-named?"),
        ("audit --as-name a.xml", "audit", "--as-name; did you mean --as-named?"),
        ("diff a.xml b.xml --robt=x", "diff", "--robt=x; did you mean --robot?"),
        ("sysid fit a.yaml log.csv --sed 3", "sysid fit", "--sed 3"),
        ("audit a.xml -Z", "audit", "-Z"),
    ],
)
def test_a_misspelt_option(text: str, name: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The usage is the command's own, and the option of nearly that name is told; `sed` is like no option of a fit."""
    with pytest.raises(SystemExit) as stop:
        main(text.split())
    assert stop.value.code == 2
    err = capsys.readouterr().err
    assert err.startswith(f"usage: actspec {name} [-h]")
    assert err.endswith(f"actspec {name}: error: unrecognized arguments: {said}\n")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("audit a.xml --fail-on warnings", "'never'); did you mean 'warning'?"),
        ("audit a.xml --fail-on 7", "'never')"),
        ("audt a.xml", "; did you mean 'audit'?"),
    ],
)
def test_a_misspelt_choice(text: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The nearest of the choices is told, where one is near."""
    with pytest.raises(SystemExit) as stop:
        main(text.split())
    assert stop.value.code == 2
    assert capsys.readouterr().err.endswith(f"{said}\n")
