"""Files that are passed over: by globs below the settings, of folders as a whole, and named ones on demand."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.exclude import Exclude
from actspec.audit.settings import Settings
from actspec.cli.main import main
from actspec.readings.named import expand

FILES = ("a.xml", "third_party/b.xml", "third_party/deep/c.xml", "own/third_party/d.xml", "own/e.urdf")


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in FILES:
        path = Path("robots", name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("<mujoco/>")


def left(*globs: str, named: tuple[str, ...] = ("robots",), force: bool = False, folder: str = ".") -> str:
    """The letters of the files that stay."""
    exclude = Exclude(tuple((glob, folder) for glob in globs), force)
    return "".join(os.path.basename(file.path)[0] for file in expand(named, exclude=exclude))


@pytest.mark.parametrize(
    ("glob", "letters"),
    [
        pytest.param("third_party", "ae", id="a name, at any depth"),
        pytest.param("third_party/", "ae", id="a name with a slash"),
        pytest.param("robots/third_party", "ade", id="a path, with all below it"),
        pytest.param("./robots/third_party", "ade", id="a path from here"),
        pytest.param("robots/third_party/**", "ade", id="all below a folder"),
        pytest.param("robots/third_party/*", "ade", id="what stands in a folder, with all below it"),
        pytest.param("robots/third_party/*.xml", "acde", id="files of a folder"),
        pytest.param("robots/**/third_party", "ae", id="a folder at any depth"),
        pytest.param("third_party/**", "abcde", id="from the folder of the settings"),
        pytest.param("*.xml", "e", id="an ending"),
        pytest.param("[abc].xml", "abcde", id="no classes of characters"),
    ],
)
def test_globs(glob: str, letters: str) -> None:
    """A glob without a slash is a name; one with a slash begins at the folder of the settings."""
    found = left(glob)
    assert "".join(sorted(found)) == letters


def test_globs_begin_at_the_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever the command runs; also with the absolute path of what is audited, and as an absolute glob."""
    root = os.getcwd()
    monkeypatch.chdir("robots/own")
    assert "".join(sorted(left("robots/third_party", named=("..",), folder="../.."))) == "ade"
    named = (os.path.join(root, "robots"),)
    assert "".join(sorted(left("robots/third_party", named=named, folder="../.."))) == "ade"
    assert "".join(sorted(left(f"{root}/robots/third_party", named=("..",)))) == "ade"


@pytest.mark.parametrize(
    ("named", "letters"),
    [
        (("robots/third_party/b.xml",), "b"),
        (("robots/third_party",), "bc"),
        (("robots", "robots/third_party/b.xml"), "abe"),
    ],
    ids=["file", "folder", "beside its folder"],
)
def test_what_is_named_is_audited_unless_forced(named: tuple[str, ...], letters: str) -> None:
    """The folders above a named file count only with `force`."""
    assert "".join(sorted(left("third_party", named=named))) == letters
    forced = left("third_party", named=named, force=True)
    assert "".join(sorted(forced)) == ("ae" if "robots" in named else "")


def test_folders_above_the_settings_have_names_too(tmp_path: Path) -> None:
    """A project may lie in a folder that is called as one that it excludes."""
    (tmp_path / "build/p").mkdir(parents=True)
    (tmp_path / "build/p/x.xml").write_text("<mujoco/>")
    assert left("build", named=(str(tmp_path / "build/p/x.xml"),), force=True, folder="build/p") == "x"


@pytest.mark.skipif(sys.platform == "win32", reason="needs links")
def test_a_link_is_known_by_its_own_name() -> None:
    """Not by where it leads."""
    Path("robots/link.xml").symlink_to("third_party/b.xml")
    assert "".join(sorted(left("third_party"))) == "ael"
    assert "".join(sorted(left("link.xml"))) == "abcde"


def test_an_excluded_folder_is_not_looked_into(monkeypatch: pytest.MonkeyPatch) -> None:
    """There may be a hundred thousand files in it."""
    looked: list[str] = []
    walk = os.walk
    monkeypatch.setattr(
        os, "walk", lambda path, **more: (looked.append(entry[0]) or entry for entry in walk(path, **more))
    )
    left("third_party")
    assert looked == ["robots", "robots/own"]


def test_named_files_that_are_excluded_are_no_slip(capsys: pytest.CaptureFixture[str]) -> None:
    """A hook is handed all files of a commit."""
    named = ["robots/third_party/b.xml", "robots/own/third_party/d.xml"]
    assert main(["audit", "--force-exclude", "--exclude", "third_party", "--", *named]) == 0
    assert capsys.readouterr() == ("no findings in 0 files; 2 files left out by exclude\n", "")


@pytest.mark.parametrize(
    "folder", [".", "./", "robots/..", "robots", "./robots/", os.path.join("..", "{}", "robots")]
)
@pytest.mark.parametrize("options", [["*.xml,*.urdf"], ["**"], ["**", "--force-exclude"]])
def test_a_folder_of_which_all_is_excluded_is_a_slip(
    folder: str, options: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """However it is written: a glob that is too wide would be a green check of nothing, as of an empty folder."""
    folder = folder.format(tmp_path.name)
    assert main(["audit", folder, "--exit-zero", "--exclude", *options]) == 2
    assert capsys.readouterr().err == (
        f"{folder}: AUD014: nothing to audit in this folder: exclude leaves out all robot files, configurations, "
        "deploy files and specs of it\n  help: take a glob out of exclude, or the folder out of the command\n"
    )
    assert main(["audit", folder, "robots/a.xml", "--exclude", options[0]]) == 0


def test_settings_and_options_add_up(capsys: pytest.CaptureFixture[str]) -> None:
    """`exclude` of the file and of the command line, which the last line counts; the settings' `force-exclude` too."""
    Path("actspec.toml").write_text('[audit]\nexclude = ["third_party"]\n')
    assert main(["audit", "robots", "--exclude", "e.urdf"]) == 0
    # robots/third_party, robots/own/third_party and robots/own/e.urdf
    told = "1 file and 2 folders left out by exclude"
    own = f"{told}; --as-named judges a folder of your own"
    assert capsys.readouterr().out == f"no findings in 1 file; {own}\n"
    for output_format, text in (("markdown", f"in 1 file; {own}\n"), ("html", f"Not shown: {told}.<")):
        main(["audit", "robots", "--exclude", "e.urdf", "--output-format", output_format])
        assert text in capsys.readouterr().out
    Path("pyproject.toml").write_text(
        '[tool.actspec.audit]\nexclude = ["third_party"]\nforce-exclude = true\n'
    )
    assert main(["audit", "robots/third_party/b.xml", "--config", "pyproject.toml"]) == 0
    assert main(["audit", "robots/third_party/b.xml"]) == 0
    assert capsys.readouterr().out == (
        "no findings in 0 files; 1 file left out by exclude\nno findings in 1 file; 1 warning about files\n"
    )


def test_the_spec_is_never_excluded(capsys: pytest.CaptureFixture[str]) -> None:
    """What the files are held to is named on purpose."""
    arguments = ["audit", "robots", "--spec", "robots/a.xml", "--exclude", "*.xml", "--force-exclude"]
    assert main(arguments) == 2
    assert "this is not an actspec spec" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('exclude = "third_party"', "audit.exclude: must be a list of globs, got 'third_party'"),
        ("exclude = [1]", "audit.exclude: must be a list of globs, got [1]"),
        ("force-exclude = 1", "audit.force-exclude: must be true or false, got 1"),
    ],
)
def test_wrong_settings(text: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    """They are named, though files are read before."""
    Path("actspec.toml").write_text(f"[audit]\n{text}\n")
    assert main(["audit", "robots"]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("settings", "shown"),
    [
        (Settings(), ["ROBOT123"]),
        (Settings(select=("LIM101",)), ["ROBOT123"]),
        (Settings(ignore=("ROBOT123",)), []),
        (Settings(ignore=("ROBOT",)), []),
        (Settings(per_file_ignores=(("robots/own/**", ("ROBOT123",)),)), []),
        (Settings(per_file_ignores=(("robots/third_party/**", ("ROBOT123",)),)), ["ROBOT123"]),
    ],
    ids=["none", "selected others", "code", "family", "file", "other file"],
)
def test_what_is_said_of_files_can_be_ignored(settings: Settings, shown: list[str]) -> None:
    """A speed of -2 rad/s in a URDF is reported by the reader, whatever rules are selected."""
    Path("robots/own/e.urdf").write_text(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/>'
        '<child link="b"/><limit lower="-1" upper="1" effort="1" velocity="-2"/></joint></robot>'
    )
    report = audit(["robots/own/e.urdf"], settings)
    # Of a file that is named as a finding.
    assert [name for item in report.findings for name in item.finding.names] == shown


@pytest.mark.parametrize(
    ("glob", "named", "said"),
    [
        pytest.param("thrid_party", ".", "did you mean 'third_party'?", id="a misspelt name"),
        pytest.param(
            "robots/own/third_prty/*.xml",
            ".",
            "did you mean 'robots/own/third_party/*.xml'?",
            id="in a path",
        ),
        pytest.param("robots/own/third_prty/*.usd", ".", None, id="in a path to files that are not there"),
        pytest.param("third_party", ".", None, id="one that fits"),
        pytest.param("build", ".", None, id="not made yet, and nothing has nearly its name"),
        pytest.param(
            "third_patry", "robots", "did you mean 'third_party'?", id="of a folder of the settings"
        ),
        pytest.param(
            "robotz/own", "robots", "did you mean 'robots/own'?", id="a path of which the rest is kept"
        ),
        pytest.param("elsewhere/thrid_party", "robots", None, id="there, in another folder"),
        pytest.param("thrid_part", "robots", None, id="there, beside the folder"),
        pytest.param("thrid_party", "robots", None, id="there, somewhere in another folder"),
        pytest.param("third_parties", "robots", None, id="the plural, there"),
        pytest.param("third_part", "robots", "did you mean 'third_party'?", id="without its last letter"),
        pytest.param("e.urd", "robots", "did you mean 'e.urdf'?", id="a file without its last letter"),
        pytest.param(
            "own/third_party", ".", "did you mean '**/own/third_party'?", id="a path from the middle"
        ),
        pytest.param("own/*.urdf", "robots", "did you mean '**/own/*.urdf'?", id="files of it"),
        pytest.param("own/*.usd", "robots", None, id="files that are not there"),
        pytest.param("elsewhere/*.xml", "robots", None, id="a folder that is there"),
        pytest.param("third_party2", "robots", "did you mean 'third_party'?", id="nowhere: another number"),
        pytest.param(
            "robots\\own\\third_party",
            ".",
            "did you mean 'robots/own/third_party'?",
            id="as Windows writes it",
        ),
        pytest.param(
            "robots\\own\\third_prty",
            ".",
            "did you mean 'robots/own/third_party'?",
            id="so, and misspelt",
        ),
        pytest.param("thrid_party", "robots/a.xml", None, id="a file, as a hook names it"),
    ],
)
def test_a_misspelt_glob_is_told(
    glob: str, named: str, said: str | None, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of folders, where it can hardly mean something else; the exit code stays."""
    if named == "robots":
        Path("elsewhere/thrid_party").mkdir(parents=True)
        Path("thrid_part").mkdir()
        Path("elsewhere/third_parties").mkdir()
    Path("actspec.toml").write_text(f"[audit]\nexclude = [{json.dumps(glob)}]\n")
    main(["audit", named, "--exit-zero", "--jobs", "1"])
    found = [
        line for line in capsys.readouterr().err.splitlines() if "AUD017" in line or "did you mean" in line
    ]
    wanted = (
        [
            f"actspec.toml:2:12: AUD017 [warning]: the glob '{glob}' of exclude fits nothing here",
            f"  help: {said}",
        ]
        if said
        else []
    )
    assert found == wanted


def test_a_misspelt_glob_of_the_command_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    """As one of the settings is."""
    assert main(["audit", "robots", "--exclude", "thrid_party"]) == 0
    assert capsys.readouterr().err == (
        "AUD017 [warning]: the glob 'thrid_party' of exclude fits nothing here\n  help: did you mean 'third_party'?\n"
    )


@pytest.mark.parametrize(
    ("glob", "help"),
    [
        ("robots/own/**", None),
        ("e.urdf", None),
        ("*.xml", None),
        ("robot/own/**", "did you mean 'robots/own/**'?"),
        ("robots/thrid_party/*", "did you mean 'robots/third_party/*'?"),
        # A folder is no file.
        ("robots/own", "did you mean 'robots/own/**'?"),
        ("own/", "did you mean '**/own/**'?"),
        ("grippers/**", None),
        ("e.urd", "did you mean 'e.urdf'?"),
        ("own/*", "did you mean '**/own/*'?"),
        ("own/third_party", "did you mean '**/own/third_party/**'?"),
        ("./robots/own/**", "did you mean 'robots/own/**'?"),
    ],
)
def test_per_file_ignores_that_fit_nothing(
    glob: str, help: str | None, capsys: pytest.CaptureFixture[str]
) -> None:
    """They are told at their place as globs of `exclude` are, and a folder where files are named."""
    Path("actspec.toml").write_text(f'[audit.per-file-ignores]\n"{glob}" = ["ORD"]\n')
    assert main(["audit", "robots"]) == 0
    message = f"AUD017 [warning]: the glob {glob!r} of per-file-ignores fits nothing here"
    wanted = f"actspec.toml:2:1: {message}\n  help: {help}\n"
    assert capsys.readouterr().err == (wanted if help else "")
