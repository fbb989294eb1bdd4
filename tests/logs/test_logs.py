"""Logs as they are read: units, sidecars, and every fault at its row."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from actspec.logs import BaseLog, JointLog, Log, LogError, Sidecar, load_log, write_log
from actspec.logs.log import signal_like

HEADER = "time [ms],hip.command [deg],hip.position [rad],hip.torque [N*m],note"


def rows(count: int = 30) -> list[str]:
    """Rows of a sound log."""
    return [f"{2 * i},90,{0.001 * i:.3f},{-0.5 * i},7" for i in range(count)]


def written(folder: Path, lines: list[str], name: str = "a.csv") -> str:
    """A log with these lines."""
    (folder / name).write_text("\n".join(lines) + "\n")
    return str(folder / name)


def test_units_become_si(tmp_path: Path) -> None:
    """Milliseconds and degrees; a column that is no signal is left out and named."""
    log = load_log(written(tmp_path, [HEADER, *rows()]))
    hip = log.joints["hip"]
    assert log.step == pytest.approx(0.002) and log.time[-1] == pytest.approx(0.058)
    assert hip.command == pytest.approx(np.full(30, np.pi / 2))
    assert (hip.position[3], hip.torque[3]) == (0.003, -1.5)  # type: ignore[index]
    assert (log.ignored, hip.linear, hip.velocity) == (("note",), False, None)


def test_sidecar_maps_columns_and_gives_units(tmp_path: Path) -> None:
    """A file of another program: its names, units by signal, and the gains of the drive."""
    path = written(tmp_path, ["t,q_des,q", *(f"{0.002 * i:.3f},{i},{2 * i}" for i in range(30))])
    (tmp_path / "a.yaml").write_text(
        "format: actspec-log/1\ncolumns: {t: time, q_des: hip.command, q: hip.position}\n"
        "units: {time: s, hip.command: deg, position: mrad}\ngains: {hip: {kp: 25, kd: 0.5}}\n"
        "accuracy: {torque: 3 %}\n"
    )
    log = load_log(path)
    assert log.joints["hip"].command[2] == pytest.approx(np.radians(2))  # type: ignore[index]
    assert log.joints["hip"].position[2] == pytest.approx(0.004)  # type: ignore[index]
    assert log.sidecar.gains["hip"].kp.value == 25.0
    assert log.sidecar.accuracy.torque is not None and log.sidecar.accuracy.torque.value == pytest.approx(
        0.03
    )


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_what_is_written_is_read(tmp_path: Path, suffix: str) -> None:
    """The same numbers, those of a slide in metres."""
    random = np.random.default_rng(0)
    values = {name: random.normal(size=25) for name in ("command", "position", "velocity", "torque")}
    time = 0.002 * np.arange(25)
    given = Log(str(tmp_path / f"a{suffix}"), "", time, {"z": JointLog("z", True, **values)}, Sidecar())
    write_log(given)
    read = load_log(given.path)
    assert read.joints["z"].linear is True
    for name, signal in read.joints["z"].signals.items():
        assert signal == pytest.approx(values[name], rel=1e-9)


def test_names_that_part_columns(tmp_path: Path) -> None:
    """Joints whose names hold commas, semicolons and quotes keep their columns; a line break is for .npz."""
    time = 0.02 * np.arange(25)
    names = ("a,b", "c;d", 'e"f', "=g+h")
    joints = {name: JointLog(name, False, position=time + number) for number, name in enumerate(names)}
    for suffix in (".csv", ".npz"):
        write_log(Log(str(tmp_path / f"a{suffix}"), "", time, joints, Sidecar()))
        read = load_log(str(tmp_path / f"a{suffix}"))
        assert [joint.position[0] for joint in read.joints.values() if joint.position is not None] == [
            0,
            1,
            2,
            3,
        ]
        assert tuple(read.joints) == names
    broken = Log(
        str(tmp_path / "b.csv"), "", time, {"a\nb": JointLog("a\nb", False, position=time)}, Sidecar()
    )
    with pytest.raises(LogError, match=r"LOG001: a line of text cannot hold .*'a\\nb\.position \[rad\]'"):
        write_log(broken)


def test_how_the_base_moved(tmp_path: Path) -> None:
    """Components with units become arrays; what was written is read again."""
    time = 0.02 * np.arange(25)
    random = np.random.default_rng(1)
    turn = random.normal(size=(25, 4))
    turn /= np.linalg.norm(turn, axis=1)[:, None]
    moved = BaseLog(random.normal(size=(25, 3)), turn, angular_velocity=random.normal(size=(25, 3)))
    hip = JointLog("hip", False, position=time)
    write_log(Log(str(tmp_path / "a.csv"), "", time, {"hip": hip}, Sidecar(), base=moved))
    read = load_log(str(tmp_path / "a.csv"))
    assert read.base is not None and read.base.linear_velocity is None and read.ignored == ()
    for name in ("position", "orientation", "angular_velocity"):
        assert getattr(read.base, name) == pytest.approx(getattr(moved, name), rel=1e-9)
    text = (tmp_path / "a.csv").read_text("utf-8")
    (tmp_path / "b.csv").write_text(text.replace("base.position.x [m]", "base.position.x [mm]"), "utf-8")
    again = load_log(str(tmp_path / "b.csv"))
    assert again.base is not None and again.base.position is not None and moved.position is not None
    assert again.base.position[3] == pytest.approx(moved.position[3] * [1e-3, 1.0, 1.0])


TURN = "base.orientation.w,base.orientation.x,base.orientation.y,base.orientation.z"
SPIN = ",".join(f"base.angular_velocity.{axis} [{'m/s' if axis == 'x' else 'rad/s'}]" for axis in "xyz")


@pytest.mark.parametrize(
    "name, row, code, said",
    [
        pytest.param(
            "base.position.x [m]", "1", "LOG011", "and no base.position.y, base.position.z", id="part"
        ),
        pytest.param(SPIN, "0,0,0", "LOG013", "must be in rad/s", id="unit"),
        pytest.param(TURN, "0.5,0,0,0.1", "LOG014", "a quaternion has length 1, this one 0.51", id="length"),
        pytest.param("base.orientaton.w", "1", "LOG011", "'base.orientaton.w' is no signal", id="misspelt"),
    ],
)
def test_a_base_that_is_none(tmp_path: Path, name: str, row: str, code: str, said: str) -> None:
    """Refused with the column."""
    lines = [f"time [s],hip.position [rad],{name}", *(f"{0.02 * i:.2f},{i},{row}" for i in range(30))]
    with pytest.raises(LogError) as caught:
        load_log(written(tmp_path, lines))
    (found,) = caught.value.diagnostics
    assert found.code == code and said in found.message


def test_missing_cells_are_no_numbers(tmp_path: Path) -> None:
    """Empty, nan and NA are unknown, not 0."""
    lines = rows()
    for index, text in ((4, ""), (5, "nan"), (6, "NA")):
        lines[index] = f"{2 * index},90,{text},1,7"
    read = load_log(written(tmp_path, [HEADER, *lines])).joints["hip"]
    assert read.position is not None and np.flatnonzero(np.isnan(read.position)).tolist() == [4, 5, 6]


@pytest.mark.parametrize(
    ("change", "place", "words"),
    [
        (lambda lines: [lines[0], *lines[1:5], "8,90,abc,1,7", *lines[6:]], ":6:3", "'abc', not a number"),
        (lambda lines: [lines[0], *lines[1:5], "8,90", *lines[6:]], ":6", "2 cells, the header 5"),
        (lambda lines: [lines[0], *lines[1:5], "2,90,0,1,7", *lines[6:]], ":6", "the time does not grow"),
        (lambda lines: [lines[0].replace("[ms]", "[s]"), *lines[1:]], ":1", "time [ms]"),
        (lambda lines: [lines[0].replace(" [rad]", ""), *lines[1:]], ":1:3", "no unit"),
        (lambda lines: [lines[0].replace("[rad]", "[N*m]"), *lines[1:]], ":1:3", "a torque, not a position"),
        (lambda lines: [lines[0].replace("[deg]", "[mm]"), *lines[1:]], ":1:2", "have a hinge's: [rad], [N*m]"),
        (lambda lines: [lines[0].replace(".torque", ".torqe"), *lines[1:]], ":1:4", "'hip.torque'"),
        (lambda lines: [lines[0].replace("time", "clock"), *lines[1:]], ":1", "no column `time`"),
        (lambda lines: lines[:11], "", "10 rows, at least 20"),
        (lambda lines: lines[:1], ":2", "no rows"),
        (lambda lines: lines[1:], ":1", "numbers, not names"),
        (lambda lines: [""], ":1", "empty"),
    ],
)  # fmt: skip
def test_faults_name_their_row(tmp_path: Path, change: object, place: str, words: str) -> None:
    """Every fault has file and row, and its cause."""
    path = written(tmp_path, change([HEADER, *rows()]))  # type: ignore[operator]
    with pytest.raises(LogError) as err:
        load_log(path)
    assert words in str(err.value)
    assert str(err.value).startswith(f"{path}{place}: LOG")


def test_nothing_is_unpickled(tmp_path: Path) -> None:
    """A pickle by any name, and an array of objects, end in an error; their code is not run."""
    flag = tmp_path / "ran"

    class Bomb:
        def __reduce__(self) -> tuple[object, ...]:
            return (open, (str(flag), "w"))

    data = pickle.dumps(Bomb())
    for name in ("a.csv", "a.npz", "a.pkl", "a.pt"):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(LogError):
            load_log(str(tmp_path / name))
    np.savez(tmp_path / "b.npz", **{"time [s]": np.array([Bomb()], dtype=object)})
    with pytest.raises(LogError, match="Python objects"):
        load_log(str(tmp_path / "b.npz"))
    assert not flag.exists()


def test_an_archive_larger_than_it_says(tmp_path: Path) -> None:
    """An NPY header of 10^12 numbers takes no memory."""
    import zipfile

    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }"
    head += b" " * (-(len(head) + 11) % 64) + b"\n"
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("time [s].npy", b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head)
    with pytest.raises(LogError, match="cut off"):
        load_log(str(tmp_path / "a.npz"))


def test_a_sidecar_is_read_as_strictly_as_a_spec(tmp_path: Path) -> None:
    """Unknown keys, and a file that does not say what it is."""
    path = written(tmp_path, [HEADER, *rows()])
    (tmp_path / "a.yaml").write_text("format: actspec-log/1\ngain: {hip: {kp: 1, kd: 1}}\n")
    with pytest.raises(LogError, match="gains"):
        load_log(path)
    (tmp_path / "a.yaml").write_text("supply: 24 V\n")
    with pytest.raises(LogError, match="actspec-log/1"):
        load_log(path)


def test_a_spec_is_no_sidecar(tmp_path: Path) -> None:
    """A spec of the log's name: one error with the cause, and what to rename."""
    path = written(tmp_path, [HEADER, *rows()])
    (tmp_path / "a.yaml").write_text("actspec: 1\nrobot: {name: a, model: a.xml}\ntargets: {}\n")
    with pytest.raises(LogError) as caught:
        load_log(path)
    (item,) = caught.value.diagnostics
    assert (item.code, str(item.span)) == ("LOG010", f"{tmp_path / 'a.yaml'}:1:1")
    assert item.message == "is a spec, and stands where the sidecar of a.csv is looked for"
    assert item.help is not None and item.help.endswith(f"e.g. {tmp_path / 'a_log.csv'} for the log")


@pytest.mark.parametrize(
    ("name", "signal"),
    [
        ("pos", "position"),
        ("vel", "velocity"),
        ("cmd", "command"),
        ("Torqe", "torque"),
        ("temperature", None),
        ("q", None),
    ],
)
def test_a_signal_by_another_name(name: str, signal: str | None) -> None:
    """The beginning of a signal's name, and one that is nearly it."""
    assert signal_like(name) == signal


def test_columns_by_other_names(tmp_path: Path) -> None:
    """A joint that lacks a signal has it by another name; another joint's is none of its own, nor what it lacks not."""
    log = load_log(
        written(tmp_path, ["time [s],hip.command [rad],hip.pos [rad],knee.vel [rad/s]", *ROWS_OF_FOUR])
    )
    assert log.misnamed("hip", ["position"]) == "is it 'hip.pos'? Name that column `hip.position`"
    assert log.misnamed("hip", ["velocity"]) is None
    path = written(
        tmp_path, ["time [s],hip.cmd [rad],hip.pos [rad],knee.vel [rad/s]", *ROWS_OF_FOUR], "b.csv"
    )
    with pytest.raises(LogError, match="no column is a signal") as caught:
        load_log(path)
    assert (caught.value.diagnostics[0].help or "").startswith(
        "'hip.cmd' may be `hip.command`: name columns "
    )


ROWS_OF_FOUR = [f"{0.01 * i:.2f},0,0,0" for i in range(30)]
