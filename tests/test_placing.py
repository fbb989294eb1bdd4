"""Files are put in place all or none, and what a kill leaves is finished by the next run."""

from __future__ import annotations

import json
import os
import signal
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from actspec import placing
from actspec.placing import finish, place, replace_file

ROOT = Path(__file__).resolve().parents[1]


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*"))


def killed(call: Callable[[], None], function: str, after: int) -> int:
    """Make a call in a fork that is killed when it calls a function of `os` once more than `after` times."""
    child = os.fork()
    if child == 0:
        calls = 0
        real = getattr(os, function)

        def counted(*arguments: object) -> object:
            nonlocal calls
            if calls == after:
                os.kill(os.getpid(), signal.SIGKILL)
            calls += 1
            return real(*arguments)

        setattr(os, function, counted)
        call()
        os._exit(0)
    return os.WTERMSIG(os.waitpid(child, 0)[1])


def test_all_are_put_in_place(tmp_path: Path) -> None:
    """New folders and files are made, old files keep their mode, links stay links, and nothing else is left."""
    old, there, link = tmp_path / "old", tmp_path / "there", tmp_path / "link"
    old.write_text("1")
    old.chmod(0o640)
    there.write_text("1")
    link.symlink_to("there")
    place([(str(tmp_path / "a" / "b" / "new"), b"2"), (str(old), b"2"), (str(link), b"2")])
    assert names(tmp_path) == ["a", "b", "link", "new", "old", "there"]
    assert [path.read_text() for path in (old, there, tmp_path / "a/b/new")] == ["2", "2", "2"]
    assert stat.S_IMODE(old.stat().st_mode) == 0o640
    assert link.is_symlink()
    mask = os.umask(0o022)
    os.umask(mask)
    assert stat.S_IMODE((tmp_path / "a/b/new").stat().st_mode) == 0o666 & ~mask


def _read_only(folder: Path) -> str:
    (folder / "bad").write_text("1")
    (folder / "bad").chmod(0o444)
    return "read-only"


def _folder(folder: Path) -> str:
    (folder / "bad").mkdir()
    return "a folder"


def _below_a_file(folder: Path) -> str:
    (folder / "bad").symlink_to("file/bad")
    (folder / "file").write_text("1")
    return "File exists|Not a directory"


@pytest.mark.parametrize("spoil", [_read_only, _folder, _below_a_file])
def test_none_is_where_one_cannot_be(spoil: Callable[[Path], str], tmp_path: Path) -> None:
    """The others are as they were, and no folder is left that was made for them."""
    (tmp_path / "old").write_text("1")
    words = spoil(tmp_path)
    before = names(tmp_path)
    bad = str(tmp_path / "bad")
    with pytest.raises(OSError, match=words) as caught:
        place([(str(tmp_path / "old"), b"2"), (str(tmp_path / "a/b/new"), b"2"), (bad, b"2")])
    assert caught.value.filename == bad
    assert names(tmp_path) == before
    assert (tmp_path / "old").read_text() == "1"


def test_moves_are_taken_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the third of three files cannot be moved, an old one is back and a new one gone."""
    (tmp_path / "old").write_text("1")
    real, moved = os.replace, []

    def replace(source: str, target: str) -> None:
        if target.endswith("third"):
            raise PermissionError(13, "Permission denied")
        moved.append(os.path.basename(target))
        real(source, target)

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(PermissionError) as caught:
        place([(str(tmp_path / name), b"2") for name in ("old", "new", "third")])
    assert moved == ["old", "new", "old"]
    assert caught.value.filename == str(tmp_path / "third")
    assert names(tmp_path) == ["old"]
    assert (tmp_path / "old").read_text() == "1"


def test_a_limit_of_size(tmp_path: Path) -> None:
    """A real limit, met by the second file: nothing has changed."""
    (tmp_path / "a").write_text("1")
    code = (
        "import resource\nfrom actspec.placing import place\nresource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "try:\n    place([('a', b'2'), ('b', b'2' * 2000)])\nexcept OSError as e:\n    print(e.filename, e.strerror)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
    )
    assert done.stdout.decode() == "b File too large\n", done.stderr
    assert names(tmp_path) == ["a"]
    assert (tmp_path / "a").read_text() == "1"


FILES = ("old", "new", "sub/other")


def written(folder: Path) -> Callable[[], None]:
    (folder / "old").write_text("1")
    return lambda: place([(str(folder / name), b"2") for name in FILES])


@pytest.mark.parametrize("after", range(3))
def test_a_kill_before_the_moves(after: int, tmp_path: Path) -> None:
    """While files are written beside their places: the next run takes them away."""
    assert killed(written(tmp_path), "fsync", after) == signal.SIGKILL
    assert len(names(tmp_path)) > 2
    finish([str(tmp_path / name) for name in FILES])
    assert names(tmp_path) == ["old", "sub"]
    assert (tmp_path / "old").read_text() == "1"


@pytest.mark.parametrize("after", range(3))
def test_a_kill_between_the_moves(after: int, tmp_path: Path) -> None:
    """The next run finishes them."""
    assert killed(written(tmp_path), "replace", after) == signal.SIGKILL
    texts = [(tmp_path / name).read_text() for name in FILES if (tmp_path / name).exists()]
    assert texts == (["2"] * after + ["1"])[: max(after, 1)]
    finish([str(tmp_path / name) for name in FILES])
    assert names(tmp_path) == ["new", "old", "other", "sub"]
    assert [(tmp_path / name).read_text() for name in FILES] == ["2", "2", "2"]


@pytest.mark.parametrize("there", ["1", None])
def test_a_kill_before_the_only_move(there: str | None, tmp_path: Path) -> None:
    """A file alone is taken back: the next run is not told that it is there, nor is an older one put over it."""
    path = tmp_path / "alone"
    if there is not None:
        path.write_text(there)
    assert killed(lambda: replace_file(str(path), b"2"), "replace", 0) == signal.SIGKILL
    finish([str(path)])
    assert names(tmp_path) == ["alone"] * (there is not None)
    assert there is None or path.read_text() == there


def test_what_was_edited_since_stays(tmp_path: Path) -> None:
    """A file that somebody has changed after the kill is not replaced."""
    assert killed(written(tmp_path), "replace", 0) == signal.SIGKILL
    (tmp_path / "old").write_text("edited")
    finish([str(tmp_path / name) for name in FILES])
    assert names(tmp_path) == ["new", "old", "other", "sub"]
    assert (tmp_path / "old").read_text() == "edited"


def test_a_run_that_goes_on_is_left_alone(tmp_path: Path) -> None:
    """What lies beside a locked journal is somebody's."""
    run = "0123456789abcdef"
    left = tmp_path / f".{run}.0.actspec-new"
    with placing._journal(str(tmp_path), run) as write:
        left.write_text("2")
        write([placing._Move(str(tmp_path / "a"), str(left), None, None)])
        finish([str(tmp_path / "a")])
        assert names(tmp_path) == [left.name, f".{run}.actspec-journal"]
    finish([str(tmp_path / "a")])
    assert names(tmp_path) == []


@pytest.mark.parametrize("text", ["", "{", "[]", '{"moves": [{"name": 1}]}', '{"moves": 3}', "[" * 100_000])
def test_a_journal_of_others(text: str, tmp_path: Path) -> None:
    """One that says nothing moves nothing; one that names other folders neither."""
    run = "0123456789abcdef"
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / f".{run}.0.actspec-new").write_text("2")
    named = json.dumps(
        {
            "moves": [
                {"name": name, "new": f".{run}.0.actspec-new", "was": None}
                for name in ("../a", "..", "/a", "")
            ]
        }
    )
    for said in (text, named):
        (tmp_path / "in" / f".{run}.actspec-journal").write_text(said)
        finish([str(tmp_path / "in" / "a")])
        assert names(tmp_path) == ["in"]


def test_streams(tmp_path: Path) -> None:
    """Pipes are appended to; a file below /dev/shm is one like others."""
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    place([(str(tmp_path / "pipe"), b"2"), (str(tmp_path / "a"), b"2")])
    assert os.read(reader, 10) == b"2"
    os.close(reader)
    if os.path.isdir("/dev/shm"):
        path = f"/dev/shm/actspec-{os.getpid()}"
        try:
            for data in (b"1", b"2"):
                replace_file(path, data)
            with open(path, "rb") as stream:
                assert stream.read() == b"2"
        finally:
            os.unlink(path)


def test_one_path_twice(tmp_path: Path) -> None:
    """Two files of one path, here through a link, are refused, and so are names that differ by case alone."""
    (tmp_path / "link").symlink_to("a")
    with pytest.raises(OSError, match="written twice in one run"):
        place([(str(tmp_path / "a"), b"1"), (str(tmp_path / "A"), b"2")])
    with pytest.raises(OSError, match="written twice in one run"):
        place([(str(tmp_path / "a"), b"1"), (str(tmp_path / "link"), b"2")])
    assert names(tmp_path) == ["link"]


def test_a_fix_that_was_killed_is_cleared_away(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By the next one, which has nothing to fix any more."""
    from actspec.cli.main import main

    config = tmp_path / "deploy.yaml"
    config.write_text("joint_names: [a]\nkp: [1]\nkd: [1]\n")
    (tmp_path / ".0123456789abcdef.0.actspec-old").write_text("before")
    (tmp_path / ".0123456789abcdef.actspec-journal").write_text('{"moves": []}')
    assert main(["audit", str(config), "--fix", "--diff"]) == 0
    assert len(names(tmp_path)) == 3
    assert main(["audit", str(config), "--fix"]) == 0
    assert names(tmp_path) == ["deploy.yaml"]
    capsys.readouterr()
