"""Samples of logs: which rows have a whole history, what their inputs are, and what is held out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from actspec import api
from actspec.diagnostics import Collector
from actspec.ir import ActuatorSet
from actspec.learn.windows import Dataset, dataset, has_arrived, split, with_rows
from actspec.logs import Log, LogError, load_log
from tests.learn.pendulums import folder, log

pytest.importorskip("scipy")


@pytest.fixture(scope="module")
def actuators(tmp_path_factory: pytest.TempPathFactory) -> ActuatorSet:
    """The spec, resolved."""
    spec = api.load(str(folder(tmp_path_factory.mktemp("spec")) / "spec.yaml"))
    return api.resolve(spec, api.load_robot(spec))


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> list[Log]:
    """Two recordings of 600 rows."""
    path = tmp_path_factory.mktemp("logs")
    return [load_log(log(path / f"{seed}.npz", seed, 600).path) for seed in (1, 2)]


def samples(actuators: ActuatorSet, logs: list[Log], **more: object) -> Dataset:
    """A dataset that nothing was found in."""
    out = Collector()
    found = dataset(actuators, logs, out, **more)  # type: ignore[arg-type]
    assert not out.failed
    return found


def test_rows_and_inputs(actuators: ActuatorSet, logs: list[Log]) -> None:
    """Three taps of 10 ms in rows of 5 ms: row 4 is the first, with rows 4, 2, 0 and their commands."""
    data = samples(actuators, logs[:1], taps=(0, 1, 2), period=0.01)
    track = data.tracks[0]
    assert (track.joint, track.stride, track.rows[0], len(track.rows)) == ("hip", 2, 4, 596)
    hip = logs[0].joints["hip"]
    assert hip.command is not None and hip.position is not None and hip.velocity is not None
    expected = [hip.command[k] - hip.position[k] for k in (4, 2, 0)]
    expected += [hip.velocity[4], hip.velocity[2], hip.velocity[0]]
    assert track.inputs(track.rows[:1])[0] == pytest.approx(expected)
    assert data.kind == "drive" and data.group == "legs"
    # Where a sample's own command has not arrived: row 5 is the first, with the commands of rows 4, 2, 0.
    before = with_rows(replace(track, arrived=False), track.torque)
    expected = [hip.command[k - 1] - hip.position[k] for k in (5, 3, 1)]
    assert before.inputs(before.rows[:1])[0][:3] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("delay", "step", "physics", "arrived"),
    [
        (7.0, 5.0, 5.0, True),
        (0.0, 5.0, 5.0, True),
        (10.0, 5.0, 5.0, True),
        (0.0, 10.0, 5.0, False),
        (2.5, 10.0, 5.0, True),
        (7.0, 20.0, 5.0, False),
        (8.0, 20.0, 5.0, True),
        (None, 5.0, 5.0, True),
        (None, 20.0, 5.0, False),
        (1.0, 2.0, 4.0, True),
    ],
)
def test_whether_a_command_has_arrived(
    delay: float | None, step: float, physics: float, arrived: bool
) -> None:
    """7 ms in rows and steps of 5: one row acts after 5 - 2.5 ms, two after 10 - 2.5, which is nearer [ms].

    In rows of 20 ms none acts after -2.5 ms, one after 17.5: the middle is 7.5, of 10 ms 2.5. In the middle, as of 0
    in rows of 5, the row more is taken. Of no known delay 4 ms are taken, or half a row.
    """
    known = None if delay is None else 1e-3 * delay
    assert has_arrived(known, 1e-3 * step, 1e-3 * physics) is arrived


def test_no_sample_goes_over_a_gap(actuators: ActuatorSet, logs: list[Log]) -> None:
    """After 1 s without rows the history begins anew: with three taps the rows 0, 1 and 300, 301 have none."""
    late = replace(logs[0], time=logs[0].time + np.where(np.arange(600) >= 300, 1.0, 0.0))
    rows = samples(actuators, [late], taps=(0, 1, 2)).tracks[0].rows
    assert sorted(set(range(600)) - set(rows.tolist())) == [0, 1, 300, 301]


def test_a_period_between_rows_is_interpolated(actuators: ActuatorSet, logs: list[Log]) -> None:
    """Rows of 4 ms, brought to 5 ms: row 2 is at 10 ms, between rows 2 and 3; the drive had the command of 8 ms."""
    fast = replace(logs[0], time=0.8 * logs[0].time)
    hip = fast.joints["hip"]
    joints = {
        **fast.joints,
        "hip": replace(hip, velocity=hip.velocity / 0.8),
        "arm": replace(fast.joints["arm"], velocity=fast.joints["arm"].velocity / 0.8),
    }
    track = samples(actuators, [replace(fast, joints=joints)], taps=(0,), period=0.005).tracks[0]
    assert track.time[2] == pytest.approx(0.01)
    assert track.in_force[2] == hip.command[2]
    assert track.position[2] == pytest.approx(0.5 * (hip.position[2] + hip.position[3]))


def test_split(actuators: ActuatorSet, logs: list[Log]) -> None:
    """Of two recordings the last is held out; of one its last fifth, a history apart."""
    two = split(samples(actuators, logs, taps=(0, 1, 2)))
    assert (two.whole, two.logs) == (True, (logs[1].path,))
    assert [len(rows) for rows in two.train] == [598, 0, 598, 0]
    one = split(samples(actuators, logs[:1], taps=(0, 1, 2)))
    # Row 480 is the first of the last 120; rows 478 and 479 are in its history.
    assert (one.whole, one.train[0][-1], one.validate[0][0]) == (False, 477, 480)


def test_a_recording_with_the_only_data_of_a_joint_is_not_held_out(
    actuators: ActuatorSet, logs: list[Log]
) -> None:
    """A log a joint: each gives its last fifth."""
    parts = [
        replace(one, joints={name: one.joints[name]}) for one, name in zip(logs, ("hip", "arm"), strict=True)
    ]
    assert not split(samples(actuators, parts)).whole


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda j: replace(j, torque=-j.torque), "SYS014"),
        (lambda j: replace(j, torque=None), "LRN006"),
        (lambda j: replace(j, torque=np.nan * j.torque), "LRN006"),
        (lambda j: replace(j, command=0.0 * j.command), "SYS011"),
    ],
)
def test_columns_that_are_refused(change: object, code: str, actuators: ActuatorSet, logs: list[Log]) -> None:
    """A torque of the wrong sign, none, a constant command: the joint and the file are named."""
    joints = {**logs[0].joints, "arm": change(logs[0].joints["arm"])}  # type: ignore[operator]
    with pytest.raises(LogError) as caught:
        dataset(actuators, [replace(logs[0], joints=joints)], Collector())
    (item,) = (i for i in caught.value.diagnostics if i.severity.value == "error")
    assert (item.code, item.where) == (code, "arm")
    assert item.span is not None and item.span.path == logs[0].path


@pytest.mark.parametrize(
    ("second", "shown"),
    [
        pytest.param(3.0, "5 and 15 ms", id="a third of the rate"),
        pytest.param(4.0 / 3.0, "5 and 6.667 ms", id="three quarters"),
        pytest.param(0.5, "2.5 and 5 ms", id="twice"),
    ],
)
def test_two_rates_one_after_the_other(
    second: float, shown: str, actuators: ActuatorSet, logs: list[Log]
) -> None:
    """Row 400 of 600 is the first after another time: the log and its line are named, whichever stretch is longer."""
    steps = np.where(np.arange(599) >= 399, 0.005 * second, 0.005)
    log = replace(logs[0], time=np.concatenate([[0.0], np.cumsum(steps)]), first_row=2)
    with pytest.raises(LogError) as caught:
        dataset(actuators, [log], Collector(), taps=(0,))
    (item,) = (i for i in caught.value.diagnostics if i.severity.value == "error")
    assert (item.code, item.message) == ("LRN008", f"the rows come at two rates, {shown} apart")
    # A step is told from those of four rows around it.
    assert item.span is not None and item.span.path == log.path and abs(item.span.line - 402) <= 2


@pytest.mark.slow
def test_one_rate(actuators: ActuatorSet, logs: list[Log]) -> None:
    """A tenth of the rows missing here and there, a clock that jitters, rows of 2.5 ms with stamps in milliseconds, and
    a rate that is another one while the drives are off."""
    random = np.random.default_rng(3)
    kept = np.flatnonzero(random.random(600) > 0.1)
    joints = {
        name: replace(joint, **{key: values[kept] for key, values in joint.signals.items()})
        for name, joint in logs[0].joints.items()
    }
    on = np.where(np.arange(600) < 400, 1.0, 0.0)
    off = {name: replace(joint, enabled=on) for name, joint in logs[0].joints.items()}
    steps = 0.005 * np.where(np.arange(600) > 400, 0.2, 1.0)
    fast = {name: replace(joint, velocity=2.0 * joint.velocity) for name, joint in logs[0].joints.items()}
    for case in (
        replace(logs[0], time=logs[0].time[kept], joints=joints),
        replace(logs[0], time=logs[0].time + random.uniform(0.0, 0.0015, 600)),
        replace(logs[0], time=np.round(0.5 * logs[0].time + 1e-9, 3), joints=fast),
        replace(logs[0], time=np.cumsum(steps), joints=off),
    ):
        out = Collector()
        data = dataset(actuators, [case], out, taps=(0,), period=0.005)
        assert "LRN008" not in {item.code for item in out} and len(data.tracks[0].rows) > 100


def test_rows_without_a_torque_are_counted(actuators: ActuatorSet, logs: list[Log]) -> None:
    """60 readings that are none, of rows 100 to 159: counted at the first, in line 102, and not learned."""
    hip = logs[0].joints["hip"]
    assert hip.torque is not None
    lost = np.where((np.arange(600) >= 100) & (np.arange(600) < 160), np.nan, hip.torque)
    log = replace(logs[0], joints={**logs[0].joints, "hip": replace(hip, torque=lost)}, first_row=2)
    out = Collector()
    data = dataset(actuators, [log], out, taps=(0,))
    (item,) = (item for item in out if item.code == "SYS013")
    assert (item.where, item.message) == ("hip", "60 rows have no torque: they are left out of it")
    assert item.span is not None and (item.span.path, item.span.line) == (log.path, 102)
    assert set(data.tracks[0].rows.tolist()) == set(range(600)) - set(range(100, 160))


def test_the_log_is_named_whose_rate_does_not_fit(actuators: ActuatorSet, logs: list[Log]) -> None:
    """Rows of 2 ms, physics steps of 5 ms: the log. A tap period of 12.5 ms: the spec, where the step stands."""
    for given, more, path, message in (
        (
            replace(logs[0], time=0.4 * logs[0].time),
            {},
            logs[0].path,
            "a row comes every 2 ms, no whole number",
        ),
        (
            logs[0],
            {"period": 0.0125},
            "spec.yaml",
            "the tap period is 12.5 ms, no whole number of physics steps of 5 ms",
        ),
    ):
        with pytest.raises(LogError) as caught:
            dataset(actuators, [given], Collector(), **more)  # type: ignore[arg-type]
        (item,) = (i for i in caught.value.diagnostics if i.severity.value == "error")
        assert item.code == "LRN009" and item.message.startswith(message)
        assert item.span is not None and item.span.path.endswith(path)


def test_logs_that_are_refused(actuators: ActuatorSet, logs: list[Log]) -> None:
    """One joint for two, one joint's columns twice, two rates, a rate that does not fit, too few rows, other joints."""
    first = logs[0]
    hip = first.joints["hip"]
    few = slice(0, 60)
    short = replace(
        first,
        time=first.time[few],
        joints={n: replace(j, **{k: v[few] for k, v in j.signals.items()}) for n, j in first.joints.items()},
    )
    cases: list[tuple[list[Log], dict[str, object], str]] = [
        ([replace(first, joints={"hip": hip})], {}, "LRN004"),
        ([replace(first, joints={"hip": hip, "arm": replace(hip, name="arm")})], {}, "LRN004"),
        ([first, replace(logs[1], time=2 * logs[1].time)], {}, "LRN008"),
        ([replace(first, time=np.cumsum(np.where(np.arange(600) % 2, 0.004, 0.01)))], {}, "LRN008"),
        ([replace(first, time=0.4 * first.time)], {}, "LRN009"),
        ([first], {"period": 0.0125}, "LRN009"),
        ([first], {"period": 0.001}, "LRN008"),
        ([short], {"taps": tuple(range(70))}, "LRN005"),
        ([replace(first, joints={**first.joints, "knee": hip})], {}, "SYS021"),
        ([first], {"group": "arms"}, "LRN002"),
    ]
    for given, more, code in cases:
        with pytest.raises(LogError) as caught:
            dataset(actuators, given, Collector(), **more)  # type: ignore[arg-type]
        codes = {item.code for item in caught.value.diagnostics if item.severity.value == "error"}
        assert codes == {code}, (code, [str(item) for item in caught.value.diagnostics])
