"""`actspec sysid fit` on logs that are none: exit code 2, file, row and joint named, nothing written, no code run."""

from __future__ import annotations

import io
import os
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from actspec.cli.main import main
from actspec.logs import load_log
from tests.sysid.test_fit import MODEL, SPEC

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow

HEADER = "time [s],hip.command [rad],hip.position [rad],hip.velocity [rad/s],hip.torque [N*m]"
ROWS, PERIOD = 400, 0.005
Lines = list[str]


def numbers() -> np.ndarray:
    """A joint that follows 0.3 sin(2 pi 1.5 t), a light pendulum: what each column holds, shape (ROWS, 5)."""
    t = PERIOD * np.arange(ROWS)
    w = 2 * np.pi * 1.5
    random = np.random.default_rng(2)
    # Behind by 10 ms; tau = 40 (a - q) - 0.6 q', as the spec.
    command, position, velocity = (
        0.3 * np.sin(w * t),
        0.3 * np.sin(w * (t - 0.01)),
        0.3 * w * np.cos(w * (t - 0.01)),
    )
    torque = 40 * (command - position) - 0.6 * velocity
    noise = random.standard_normal((4, ROWS)) * np.array([[0.0], [5e-4], [0.05], [0.02]])
    return np.stack([t, *(np.stack([command, position, velocity, torque]) + noise)], axis=1)


def text(values: np.ndarray | None = None, header: str = HEADER) -> Lines:
    """Lines of a CSV file."""
    rows = numbers() if values is None else values
    return [header, *(",".join(f"{cell:.9g}" for cell in row) for row in rows)]


def changed(column: int, change: Callable[[np.ndarray], np.ndarray]) -> Lines:
    """The log with another column."""
    values = numbers()
    values[:, column] = change(values[:, column])
    return text(values)


def cell(row: int, column: int, content: str) -> Lines:
    """The log with another cell; both from 0, rows below the header."""
    lines = text()
    cells = lines[row + 1].split(",")
    cells[column] = content
    lines[row + 1] = ",".join(cells)
    return lines


def each(change: Callable[[str], str], lines: Lines | None = None) -> Lines:
    """Every line below the header changed."""
    lines = lines or text()
    return [lines[0], *(change(line) for line in lines[1:])]


def archive(**more: np.ndarray) -> bytes:
    """The log as NPZ, with more arrays."""
    out = io.BytesIO()
    columns = dict(zip(HEADER.split(","), numbers().T, strict=True))
    np.savez(out, **{**columns, **more})
    return out.getvalue()


def member(header: bytes, body: bytes = b"", name: str = "time [s].npy", repeat: int = 1) -> bytes:
    """An NPZ of one array with such a header."""
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed, packed.open(name, "w") as stream:
        stream.write(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
        for _ in range(repeat):
            stream.write(body)
    return out.getvalue()


class Bomb:
    """Leaves a file where it is unpickled."""

    def __reduce__(self) -> tuple[object, ...]:
        return (open, ("ran", "w"))


SIDE = "format: actspec-log/1\n"
BAD: dict[str, tuple[Lines | bytes | Callable[[], bytes], str, str, str]] = {
    # What the file holds, or what makes it, its ending, and what is reported: where, and in which words.
    "constant command": (
        # One place of seven digits: a reading, of which four tell enough.
        changed(1, lambda a: 0 * a + 0.1834621),
        ".csv",
        "",
        "SYS011 hip: the command is 0.1835 rad in every row",
    ),
    "clipped torque": (
        changed(4, lambda a: a.clip(-0.3, 0.3)),
        ".csv",
        ":",
        "hip: the torque is clipped at 0.3 N*m in",
    ),
    "sign of position": (changed(2, np.negative), ".csv", "", "hip: the position goes against the command"),
    "sign of velocity": (changed(3, np.negative), ".csv", "", "hip: the velocity has the opposite sign"),
    "both in degrees": (
        text(numbers() * np.array([1.0, 57.29578, 57.29578, 1.0, 1.0])),
        ".csv",
        "",
        "hip: the position's derivative is 57.3 times the velocity: the position is in degrees",
    ),
    "torque in mN*m": (changed(4, lambda a: a * 1e3), ".csv", ":", "is it in mN*m?"),
    "a gap every eight rows": (
        [HEADER, *(line for i, line in enumerate(text()[1:]) if i % 20 < 8)],
        ".csv",
        "",
        "19 gaps, up to",
    ),
    "a sixth of a second": (text()[:34], ".csv", "", "SYS011 hip: no stretch of the log is long enough"),
    "position in degrees": (changed(2, np.degrees), ".csv", "", "hip: the position moves 5"),
    "command in degrees": (changed(1, np.degrees), ".csv", "", "it is in degrees"),
    "velocity in rpm": (changed(3, lambda a: a * 9.549297), ".csv", "", "it is in rpm"),
    "no position at all": (changed(2, lambda a: a * np.nan), ".csv", "", "not a number in 400 of 400 rows"),
    "ten rows": (text()[:11], ".csv", "", "LOG012: the log has 10 rows, at least 20 are needed"),
    "time backwards": (text(numbers()[::-1]), ".csv", ":3", "the time does not grow: 1.99 follows 1.995"),
    "time twice": ([*text()[:50], *text()[49:]], ".csv", ":51", "the time does not grow: 0.24 follows 0.24"),
    "time in ms": (changed(0, lambda a: a * 1e3), ".csv", ":1", "a row comes every 5 s"),
    "time in minutes": (changed(0, lambda a: a / 1e3), ".csv", ":1", "a row comes every 5 us"),
    "no unit": (
        text(header=HEADER.replace(" [rad],hip.v", ",hip.v")),
        ".csv",
        ":1:3",
        "LOG013 hip.position: the column has no unit",
    ),
    "unit of another kind": (
        text(header=HEADER.replace("[rad],hip.v", "[N*m],hip.v")),
        ".csv",
        ":1:3",
        "1 N*m is a torque, not a position",
    ),
    "counts below 0 read as 65535": (
        changed(4, lambda a: np.round(a * 1e3) % 65536),
        ".csv",
        ":1:5",
        "LOG014 hip.torque: jumps between 0 and 65535: a signed number of 16 bits, read as an unsigned one",
    ),
    "unknown unit": (
        text(header=HEADER.replace("[rad],hip.v", "[ell],hip.v")),
        ".csv",
        ":1:3",
        "unknown unit `ell`",
    ),
    "text": (cell(40, 2, "err"), ".csv", ":42:3", "LOG004: column 3 holds 'err', not a number"),
    "text in a column": (
        each(lambda line: line.replace(",", ",err", 1)),
        ".csv",
        ":2:2",
        "and so do 399 more",
    ),
    "a digit separator": (cell(40, 2, "1_000"), ".csv", ":42:3", "'1_000', not a number"),
    "a short row": ([*text()[:40], "1,2", *text()[41:]], ".csv", ":41", "the row has 2 cells, the header 5"),
    "a comma more": (
        each(lambda line: line + ","),
        ".csv",
        ":2",
        "the row has 6 cells, the header 5, and so do 399 more",
    ),
    "units in a row": (
        [text()[0], "s,rad,rad,rad/s,N*m", *text()[1:]],
        ".csv",
        ":2",
        "the row holds text, not numbers",
    ),
    "a comment within": ([*text()[:50], "# pause", *text()[50:]], ".csv", ":51", "a comment between rows"),
    "a blank line": ([*text()[:50], "", *text()[50:]], ".csv", ":51", "the line is blank"),
    "spaces": (
        each(lambda line: line.replace(",", " "), [HEADER.replace(",", " "), *text()[1:]]),
        ".csv",
        ":1",
        "the header has one column",
    ),
    "empty": (b"", ".csv", ":1", "the log is empty"),
    "blank header": (["", *text()], ".csv", ":1", "the log is empty"),
    "header alone": ([HEADER], ".csv", ":2", "the log has no rows"),
    "no header": (text()[1:], ".csv", ":1", "the first row holds numbers, not names"),
    "quotation mark": (
        ['"' + HEADER, *text()[1:]],
        ".csv",
        ":1",
        "a quotation mark in the header is not closed",
    ),
    "long header": (
        [HEADER + "," + "a" * 200_000, *each(lambda line: line + ",0")[1:]],
        ".csv",
        ":1",
        "LOG002: the header has 200084 characters",
    ),
    "many columns": ([",".join(["a"] * 5000), *text()[1:]], ".csv", ":1", "5000 columns, at most 2000"),
    "long cell": (cell(3, 2, "x" * 200_000), ".csv", ":5", "the row cannot be read"),
    "unknown joint": (
        text(header=HEADER.replace("hip.", "hipp.")),
        ".csv",
        ":1",
        "SYS021 hipp: the spec has no such joint",
    ),
    "metres": (
        # The same digits, as a slide's: rad/s and N*m would be read with them.
        text(header="time [s],hip.command [m],hip.position [m],hip.velocity [m/s],hip.torque [N]"),
        ".csv",
        ":1",
        "SYS021 hip: its columns are in m, but the joint is a hinge",
    ),
    "column twice": (
        [HEADER + ",hip.position [rad]", *each(lambda line: line + ",0")[1:]],
        ".csv",
        ":1:6",
        "two columns are hip.position",
    ),
    "no command": (
        text(header=HEADER.replace("hip.command", "other")),
        ".csv",
        "",
        "SYS010 hip: no column hip.command",
    ),
    "terminal codes": (
        [HEADER + ",\x1b[31mred.position [rad]", *each(lambda line: line + ",0")[1:]],
        ".csv",
        ":1",
        r"\x1b[31mred",
    ),
    "enabled 2": (
        [HEADER + ",hip.enabled", *each(lambda line: line + ",2")[1:]],
        ".csv",
        ":1",
        "LOG014 hip.enabled: must be 0 or 1",
    ),
    "never enabled": (
        [HEADER + ",hip.enabled", *each(lambda line: line + ",0")[1:]],
        ".csv",
        "",
        "SYS011 hip: no stretch",
    ),
    "UTF-16": ("\n".join(text()).encode("utf-16"), ".csv", "", "LOG003: the log is UTF-16 text"),
    "Latin-1": ("\n".join([HEADER, *text()[1:4], "\xb0"]).encode("latin1"), ".csv", ":5", "not UTF-8 text"),
    "zeros": (bytes(4096), ".csv", ":1", "the log is not text"),
    "pickle": (pickle.dumps(Bomb()), ".csv", "", "the log is a pickle, which is not read"),
    "old pickle": (pickle.dumps(Bomb(), protocol=0), ".csv", ":1", "LOG003"),
    "gzip": (b"\x1f\x8b\x08", ".csv", "", "the log is compressed"),
    "workbook": (archive(), ".csv", "", "the log is a zip archive, not text"),
    "pickle as NPZ": (pickle.dumps(Bomb()), ".npz", "", "the log is a pickle, which is not read"),
    "objects": (
        archive(x=np.array([Bomb()], dtype=object)),
        ".npz",
        "",
        "LOG005: array 'x' holds Python objects",
    ),
    "texts": (archive(x=np.array(["a"])), ".npz", "", "array 'x' must hold numbers"),
    "two dimensions": (archive(q=np.zeros((3, 3))), ".npz", "", "got float64 of shape (3, 3)"),
    "lengths": (archive(q=np.zeros(3)), ".npz", "", "LOG004: the arrays have different lengths"),
    "cut off": (archive()[:2000], ".npz", "", "LOG003: the log is no NPZ file"),
    # 400 MB in 400 kB: refused by the archive's own figures.
    "zip bomb": (
        lambda: member(
            b"{'descr': '<f8', 'fortran_order': False, 'shape': (50000000,), }", bytes(8_000_000), repeat=50
        ),
        ".npz",
        "",
        "over 40000000 cells",
    ),
    "a header that lies": (
        member(b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }"),
        ".npz",
        "",
        "is cut off",
    ),
    "code in a header": (member(b"__import__('pathlib').Path('ran').touch()"), ".npz", "", "is no array"),
    "a path": (member(b"{}", name="../../evil.npy"), ".npz", "", "'../../evil' is no array"),
    "no Parquet": (b"PAR1 PAR1", ".parquet", "", "arquet"),
    "workbook by name": (b"PK", ".xlsx", "", "is no log"),
    "numpy file": (b"\x93NUMPY", ".npy", "", "such a file may run code or has no columns"),
    "no ending": (text(), "", "", "is no log"),
}
SIDECARS = {
    "another version": ("format: actspec-log/2\n", ":1:9", "must be actspec-log/1"),
    "a list": ("- a\n", ":1:1", "must be a mapping"),
    "a tag": ("format: !!python/object:os.system actspec-log/1\n", ":1:9", "is not allowed"),
    "gains of nobody": (SIDE + "gains: {hipp: {kp: 40, kd: 0.6}}\n", "", "did you mean 'hip'?"),
    "a pattern": (SIDE + "gains: {'(hip': {kp: 40, kd: 0.6}}\n", "", "LOG015 gains"),
    "a unit of nobody": (SIDE + "units: {postion: rad}\n", "", "did you mean 'position'?"),
    "a column that is not there": (SIDE + "columns: {q_hip: hip.position}\n", "", "no column 'q_hip'"),
    "no quaternion": (SIDE + "base: {orientation: [0, 0, 0, 0]}\n", ":2:21", "a quaternion has length 1, this one 0"),
    "no day": (SIDE + "date: yesterday\n", ":2:7", "must be a day as 2026-11-22, got 'yesterday'"),
    "another robot": (SIDE + "robot: spot\n", None, "the log is of the robot 'spot', the spec of 'bench'"),
}  # fmt: skip


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with robot and spec."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bench.xml").write_text(MODEL.replace("AXIS", "0 1 0"))
    (tmp_path / "spec.yaml").write_text(SPEC)
    return tmp_path


def refused(path: str, capsys: pytest.CaptureFixture[str]) -> str:
    """What the command reports of a log that it refuses."""
    before = sorted(os.listdir())
    assert main(["sysid", "fit", "spec.yaml", path, "-o", "r.yaml"]) == 2
    assert sorted(os.listdir()) == before
    err = capsys.readouterr().err
    assert "Traceback" not in err and "Warning:" not in err
    # A fault is reported once, not once a row.
    assert len(err.splitlines()) < 12, err
    return err


@pytest.mark.parametrize("name", BAD)
def test_a_log_is_refused(name: str, bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each by its place and its cause."""
    content, suffix, place, words = BAD[name]
    if callable(content):
        content = content()
    data = content if isinstance(content, bytes) else ("\n".join(content) + "\n").encode()
    (bench / f"a{suffix}").write_bytes(data)
    err = refused(f"a{suffix}", capsys)
    assert words in err
    assert err.startswith(f"a{suffix}{place}"), err


@pytest.mark.parametrize("name", SIDECARS)
def test_a_sidecar_is_refused(name: str, bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its own file is named."""
    content, place, words = SIDECARS[name]
    (bench / "a.csv").write_text("\n".join(text()) + "\n")
    (bench / "a.yaml").write_text(content)
    err = refused("a.csv", capsys)
    assert words in err
    assert err.startswith("a.csv" if place is None else f"a.yaml{place}"), err


def test_what_is_no_file(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Folders, pipes, devices and three gigabytes are refused before they are read."""
    os.mkdir("folder.csv")
    os.mkfifo("pipe.csv")
    os.symlink("/dev/zero", "zero.csv")
    os.symlink("loop.csv", "loop.csv")
    for suffix in ("csv", "npz"):
        with open(f"large.{suffix}", "wb") as stream:
            stream.truncate(3 * 2**30)
    for path, words in (
        ("folder.csv", "a folder"), ("pipe.csv", "not a regular file"), ("zero.csv", "not a regular file"),
        ("loop.csv", "symbolic links"), ("none.csv", "no such file"), ("spec.yaml", "is no log"),
        ("large.csv", "LOG002: the log has 3221225472 bytes"), ("large.npz", "LOG002"),
    ):  # fmt: skip
        assert words in refused(path, capsys), path


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads every file")
def test_a_file_without_permission(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The system's reason is reported."""
    (bench / "a.csv").write_text("\n".join(text()))
    os.chmod("a.csv", 0)
    assert "permission denied" in refused("a.csv", capsys)


@pytest.mark.parametrize(
    "content",
    [
        pytest.param(
            "\n".join(each(lambda line: line.replace(",", ";"), [HEADER.replace(",", ";"), *text()[1:]])),
            id="semicolons",
        ),
        pytest.param(
            "\n".join(
                [HEADER.replace(",", ";"), *(line.replace(",", ";").replace(".", ",") for line in text()[1:])]
            ),
            id="decimal commas",
        ),
        pytest.param("\n".join(line.replace(",", "\t") for line in text()), id="tabs"),
        pytest.param("\ufeff" + "\n".join(text()), id="BOM"),
        pytest.param("\r\n".join(text()), id="CRLF"),
        pytest.param("\r".join(text()), id="CR"),
        pytest.param("\n".join(["# a bench", "# today", *text()]), id="comments"),
        pytest.param("\n".join(["# today", "# " + HEADER, *text()[1:]]), id="numpy.savetxt"),
        pytest.param("\n".join(",".join(f'"{c}"' for c in line.split(",")) for line in text()), id="quoted"),
        pytest.param("\n".join(line + "," for line in text()), id="a comma at the end"),
        pytest.param("\n".join(text()) + "\n\n\n", id="blank lines at the end"),
    ],
)
def test_ways_to_write_the_same(content: str, tmp_path: Path) -> None:
    """As spreadsheets and programs write it: the same numbers."""
    (tmp_path / "a.csv").write_bytes(content.encode())
    found = load_log(str(tmp_path / "a.csv"))
    assert found.joints["hip"].torque == pytest.approx(numbers()[:, 4], abs=1e-7)
    lines = content.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    fourth = next(i for i, line in enumerate(lines, 1) if line.strip('"').startswith(("0.015", "0,015")))
    assert found.span(3).line == fourth


def test_three_digits_behind_every_comma(tmp_path: Path) -> None:
    """1,234 may be a thousand or one: refused."""
    lines = ["time [s];hip.position [rad]", *(f"{i},000;1,234" for i in range(30))]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    with pytest.raises(Exception, match="1,234"):
        load_log(str(tmp_path / "a.csv"))


def test_gains_of_other_joints_do_no_harm(tmp_path: Path) -> None:
    """A sidecar that lists the whole robot, beside a log of one joint."""
    (tmp_path / "a.csv").write_text("\n".join(text()))
    (tmp_path / "a.yaml").write_text(SIDE + "gains: {hip: {kp: 1, kd: 2}, 'kn.*': {kp: 3, kd: 4}}\n")
    gains = load_log(str(tmp_path / "a.csv")).sidecar.gains_of("hip")
    assert gains is not None and gains.kp.value == 1.0
