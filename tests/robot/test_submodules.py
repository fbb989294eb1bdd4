"""Files of git submodules that are not checked out, told by `.gitmodules` alone; a menagerie without a clone."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from actspec.diagnostics import RobotError
from actspec.robot.load import find_model
from actspec.robot.submodules import not_checked_out
from actspec.robot.xml import open_document

MODULES = '[submodule "menagerie"]\n\tpath = env/menagerie\n\turl = https://example.org/menagerie.git\n'


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Path(tmp_path, "repo/env").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "repo")
    Path(".gitmodules").write_text(MODULES)


def told(path: str, beside: str = "env/scene.xml") -> str | None:
    """The command that helps."""
    found = not_checked_out(beside, path)
    return None if found is None else found.help


def test_what_is_in_one() -> None:
    assert told("env/menagerie/panda/panda.xml") == "git submodule update --init env/menagerie"
    assert told("env/menagerie_2/panda.xml") is None
    assert told("panda.xml") is None
    Path("env/menagerie").mkdir()
    assert told("env/menagerie/panda.xml") is not None, "git leaves an empty folder"
    Path("env/menagerie/README.md").touch()
    assert told("env/menagerie/panda.xml") is None, "it is checked out, and has no such file"


def test_the_command_works_from_where_one_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir("..")
    assert (
        told("repo/env/menagerie/a.xml", "repo/env/scene.xml")
        == "git -C repo submodule update --init env/menagerie"
    )
    monkeypatch.chdir("repo/env")
    assert told("menagerie/a.xml", "scene.xml") == "git -C .. submodule update --init env/menagerie"
    root = str(Path("..").resolve())
    command = f"git -C {root} submodule update --init env/menagerie"
    assert told(f"{root}/env/menagerie/a.xml", f"{root}/env/scene.xml") == command


def test_names_are_quoted_for_the_shell() -> None:
    Path(".gitmodules").write_text('[submodule "a"]\r\n  path = "a b;rm"\r\n')
    assert told("a b;rm/leg.xml", "scene.xml") == "git submodule update --init 'a b;rm'"


@pytest.mark.parametrize("path", ["..", "../other", "/", ""])
def test_a_path_that_leads_elsewhere_is_none(path: str) -> None:
    Path(".gitmodules").write_text(f'[submodule "a"]\n\tpath = {path}\n')
    assert told("../other/leg.xml", "scene.xml") is None


def test_no_farther_than_the_repository() -> None:
    """One of another repository around it says nothing; nor does what is no file."""
    Path("env/.git").mkdir()
    assert told("env/menagerie/panda.xml") is None
    Path("env/.git").rmdir()
    Path(".gitmodules").unlink()
    os.mkfifo(".gitmodules")
    assert told("env/menagerie/panda.xml") is None


CLONE = "git clone https://github.com/google-deepmind/mujoco_menagerie"


def test_menagerie_that_is_not_cloned() -> None:
    """Git ignores it in many repositories, and no `.gitmodules` tells; without files it is as one that is not there."""
    Path(".gitmodules").unlink()
    assert told("third party/mujoco_menagerie/a1/a1.xml") == f"{CLONE} 'third party/mujoco_menagerie'"
    assert told("mujoco_menagerie/a1/a1.xml", "mujoco_menagerie/a1/a1.xml") == f"{CLONE} mujoco_menagerie"
    here = os.path.abspath("")
    assert told(f"{here}/mujoco_menagerie/a1.xml", f"{here}/a.xml") == f"{CLONE} {here}/mujoco_menagerie"
    for other in ("my_mujoco_menagerie/a1.xml", "mujoco_menagerie_2/a1.xml", "mujoco_menagerie"):
        assert told(other) is None
    assert told("/home/ada/mujoco_menagerie/a1.xml") is None, "of one machine"
    Path("env/mujoco_menagerie").mkdir()
    assert told("env/mujoco_menagerie/a1.xml") is not None
    Path("env/mujoco_menagerie/README.md").touch()
    assert told("env/mujoco_menagerie/a1.xml") is None, "it is there, and has no such file"
    assert told("mujoco_menagerie/a1.xml") is None, "it is in another folder"


def test_a_submodule_is_told_as_one_whatever_it_is_called() -> None:
    Path(".gitmodules").write_text('[submodule "m"]\n\tpath = env/mujoco_menagerie\n')
    assert told("env/mujoco_menagerie/a1.xml") == "git submodule update --init env/mujoco_menagerie"


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ('<mujoco><include file="menagerie/panda/panda.xml"/></mujoco>', "the include"),
        ('<mujoco><asset><model name="p" file="menagerie/p.xml"/></asset></mujoco>', "the attached model"),
    ],
)
def test_of_an_include_and_an_attached_model(text: str, what: str) -> None:
    from actspec.robot.attached import opened_by

    Path("env/scene.xml").write_text(text)
    with pytest.raises(RobotError) as caught:
        list(opened_by(open_document("env/scene.xml")))
    (item,) = caught.value.diagnostics
    assert (item.code, item.help) == ("ROBOT010", "git submodule update --init env/menagerie")
    assert item.message == (
        f"{what} cannot be followed: 'env/menagerie' is a git submodule that is not checked out"
    )


def test_of_the_model_of_a_spec() -> None:
    with pytest.raises(RobotError) as caught:
        find_model("menagerie/a1/a1.xml", "env")
    (item,) = caught.value.diagnostics
    assert (item.code, item.help) == ("ROBOT010", "git submodule update --init env/menagerie")
    assert item.message == (
        "there is no model 'menagerie/a1/a1.xml': 'env/menagerie' is a git submodule that is not checked out"
    )
    with pytest.raises(RobotError) as caught:
        find_model("other/a1.xml", "env")
    assert caught.value.diagnostics[0].code == "ROBOT101"
