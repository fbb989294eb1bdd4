"""Names of any kind, through the commands: what is shown steers nothing, and what is written is found again."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest

from actspec.cli.main import main
from actspec.files import name_in_file, path_of_name
from tests.in_process import in_process

ROOT = Path(__file__).resolve().parents[2]
SCENE = ROOT / "tests" / "fuzz" / "scene"
EXAMPLE = ROOT / "docs" / "example"

HOSTILE = "x\n::error::pwned\n\x1b[31m\r\u202e\u200b|`<b>]]>--&\"'%25,;=*[a](http:e)"
"""A line that GitHub would run, colours, letters from right to left, and the marks of every format."""

pytestmark = pytest.mark.skipif(os.sep != "/", reason="no such names here")


@pytest.fixture(params=[HOSTILE, os.fsdecode(b"-r\xff\x85 a\\b:3:4")])
def folder(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A folder of that name with robot files of such names and a spec, seen from the folder above."""
    monkeypatch.chdir(tmp_path)
    place = tmp_path / str(request.param)
    try:
        place.mkdir()
    except OSError:
        pytest.skip("this file system takes UTF-8 alone")
    for name in ("biped.urdf", "biped_cfg.py", "biped_deploy.yaml"):
        shutil.copy(EXAMPLE / name, place / name)
    shutil.copy(EXAMPLE / "biped.urdf", place / f"{request.param}.urdf")
    for name in ("plain.yaml", "motors.yaml", "results.yaml", "log.csv", "log.yaml"):
        shutil.copy(SCENE / name, place / name)
    with in_process():
        yield f"./{request.param}"


@pytest.mark.slow
def test_nothing_printed_steers(folder: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Every command in every form: printable lines, none that the name began, and what parses parses."""
    urdf, cfg, spec = (f"{folder}/{name}" for name in ("biped.urdf", "biped_cfg.py", "plain.yaml"))
    lines = [
        *(
            ["audit", folder, "--output-format", form]
            for form in ("full", "json", "sarif", "github", "junit")
        ),
        *(["audit", urdf, cfg, "--ledger"], ["diff", urdf, cfg], ["validate", spec], ["show", spec]),
        *(["compile", spec, "-o", f"{folder}/out"], ["compile", spec, "-o", f"{folder}/out", "--check"]),
        *(["import", urdf, cfg, "-o", f"{folder}/new.yaml"], ["validate", f"{folder}/new.yaml"]),
        *(["diagnose", spec, f"{folder}/log.csv"], ["compare", spec, "--output-format", "markdown"]),
        *(
            ["report", urdf, cfg, "-o", f"{folder}/r.{form}", "--output-format", form]
            for form in ("html", "markdown", "json")
        ),
        *(["validate", f"{folder}/none"], ["audit", f"{folder}/none"], ["lock", f"{folder}/none"]),
    ]
    for line in lines:
        assert main(line) in (0, 1) or line[1].endswith("none"), line
        out, err = capsys.readouterr()
        for text in (out, err):
            assert all(part.isprintable() for part in re.split("[\n\t]", text)), line
            assert not re.search(r"^\s*::error::pwned", text, re.MULTILINE), line
        if line[0] == "report":
            continue
        if line[-1] in ("json", "sarif"):
            json.loads(out)
        elif line[-1] == "junit":
            ElementTree.fromstring(out)
    json.loads(Path(folder, "r.json").read_text("utf-8"))
    page, markdown = (Path(folder, name).read_text("utf-8") for name in ("r.html", "r.markdown"))
    assert "<b>" not in page and "\n::error::pwned" not in page + markdown
    # Two of them, as the name has one.
    assert ("to be filled, a spec, which the commands take: `` actspec import $'" in markdown) == (
        "`" in folder
    )


def test_what_is_written_is_found_again(folder: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A lock and a baseline name the files, and are plain text of printable characters."""
    main(["lock", folder + "/biped.urdf", folder + "/biped_cfg.py"])
    assert main(["lock", "--check"]) == 0
    assert main(["audit", folder, "--write-baseline", "base.json"]) == 0
    capsys.readouterr()
    assert main(["audit", folder, "--baseline", "base.json"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("no findings in ") and "AUD007" not in err
    for written in ("actspec.lock", "base.json"):
        text = Path(written).read_text("utf-8")
        assert text.replace("\n", "").isprintable()


def test_a_name_in_a_file_is_that_of_one_file() -> None:
    """A byte that is not UTF-8, and a file that is called as the byte is written."""
    names = ["a\udcff", "a\\xff", "a\\x5cxff", "a\\\udcff", "a\\b", "a\\x41", "a\\xfg", "\xff"]
    written = [name_in_file(name) for name in names]
    assert written[:2] == ["a\\xff", "a\\x5cxff"] and written[4:] == names[4:]
    assert len(set(written)) == len(names) and all(map(str.isprintable, written))
    assert [path_of_name(name) for name in written] == names
