"""Delta actions: the model between rows against MuJoCo's own steps, the training, the files and the runtime."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec import api
from actspec.diagnostics import Collector
from actspec.laws.network import Dense
from actspec.learn.delta.files import DeltaFault, read_delta, write_delta
from actspec.learn.delta.network import DeltaLayers, onnx_of
from actspec.learn.delta.samples import Samples, collect
from actspec.learn.delta.train import TrainOptions, split, train
from actspec.learn.delta.validate import Pair, graded, judged, removable, replay, validate
from actspec.logs import Log, load_log
from actspec.readings.onnx_graph import Graph
from actspec.readings.onnx_network import NetworkUnknown
from actspec.runtime import delta_action
from actspec.sysid.stand import Stand
from tests.learn.pendulums import MODEL
from tests.learn.policies import FLOATING, SPEC, folder, walk

DELAYED = SPEC.replace(
    "action_scale", "delay: 10 ms, command_filter: {cutoff: 20 Hz}, encoder_bias: 0.02 rad, action_scale"
)


def samples_of(path: Path, *logs: Log | str, base: str | None = None) -> Samples:
    """Of logs that were written."""
    spec = api.load(str(path / "spec.yaml"))
    robot = api.load_robot(spec)
    read = [load_log(log if isinstance(log, str) else log.path) for log in logs]
    return collect(Stand(robot, api.resolve(spec, robot)), read, base, Collector())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spec", "model"),
    [
        pytest.param(SPEC, None, id="held"),
        pytest.param(DELAYED, None, id="delay, filter and bias"),
        pytest.param(SPEC, FLOATING, id="free base with contacts"),
    ],
)
def test_a_row_leads_to_the_next(tmp_path: Path, spec: str, model: str | None) -> None:
    """From every row the model goes where the compiled file went in one simulation, whatever its drives remember."""
    path = folder(tmp_path, spec, *([] if model is None else [model]))
    samples = samples_of(path, walk(path, "log.npz", rows=80))
    assert len(samples) == 78 and samples.runs == ((0, 78),)
    # A solver that begins cold ends where it ended warm to its tolerance.
    limit = 1e-8 if model is None else 1e-5
    assert np.abs(samples.errors()).max() < limit
    assert np.abs(samples.errors(0.01)).max() > 1e-4
    assert len(samples.columns) == (8 if model is None else 15)
    if model is not None:
        assert samples.columns[6:13] == (
            *(f"base.orientation.{c}" for c in "wxyz"),
            *(f"base.angular_velocity.{c}" for c in "xyz"),
        )
        assert samples.inputs[:, 6:10] == pytest.approx(samples.plants[0][0].base(samples.states)[:, 3:7])
    # Columns of the states that follow, at commands that follow: those of the rows that follow.
    rows = np.arange(40)
    again = samples.columns_of(samples.states[rows + 1], rows + 1)
    assert again == pytest.approx(samples.inputs[rows + 1]) and again != pytest.approx(samples.inputs[rows])


@pytest.mark.slow
def test_a_joint_that_no_motor_drives_is_where_the_sidecar_has_it(tmp_path: Path) -> None:
    """Logged with a tail that is welded on at 90 degrees, 0.5 kg at 0.2 m from it: 0.5 (0.2^2 + 0.2^2) = 0.04 kg*m^2
    more at the hip, as the sidecar says; as the file draws it 0.5 * 0.4^2 = 0.08."""
    mass = '<inertial pos="0 0 -.2" mass=".5" diaginertia="1e-9 1e-9 1e-9"/>'
    tail = f'<body name="tail" pos="0 0 -.2"TURN>JOINT{mass}</body>'
    inside = 'mass="1" diaginertia="1e-9 1e-9 1e-9"/>'
    welded = tail.replace("TURN", f' euler="0 {math.pi / 2} 0"').replace("JOINT", "")
    turning = tail.replace("TURN", "").replace("JOINT", '<joint name="tail" axis="0 1 0"/>')
    assert MODEL.count(inside) == 1
    path = folder(tmp_path, SPEC, MODEL.replace(inside, inside + welded))
    log = walk(path, "log.csv", rows=60)
    folder(
        path,
        SPEC.replace("robot.xml}", "robot.xml, unmanaged: [tail]}"),
        MODEL.replace(inside, inside + turning),
    )
    assert np.abs(samples_of(path, log).errors()).max() > 1e-3
    (path / "log.yaml").write_text("format: actspec-log/1\npose: {tail: 90 deg}\n")
    # What a log's text rounds.
    assert np.abs(samples_of(path, log).errors()).max() < 1e-6


@pytest.mark.slow
def test_slopes(tmp_path: Path) -> None:
    """One implicit step of a pendulum: qd' = qd + h (kp (c - q) - ...) / (I + h (kd + b)), q' = q + h qd'."""
    path = folder(tmp_path, SPEC.replace("decimation: 4", "decimation: 1"))
    samples = samples_of(path, walk(path, "log.npz", rows=60))
    rows = np.arange(10)
    zero = np.zeros((10, 2))
    found = samples.slopes(zero, samples.errors(zero, rows), 0.01, rows)
    # I = m l^2 + armature: 0.04 and 0.02 with 0.02 each.
    speed = [0.005 * 20 / (inertia + 0.005 * 0.6) for inertia in (0.06, 0.04)]
    expected = np.zeros((4, 2))
    expected[2:] = np.diag(speed)
    expected[:2] = 0.005 * expected[2:]
    assert found == pytest.approx(np.broadcast_to(expected, (10, 4, 2)), abs=1e-4)


@pytest.mark.slow
def test_rows_around_a_gap(tmp_path: Path) -> None:
    """Rows 0 to 29 and 33 to 59: neither end of either stretch has both neighbours."""
    path = folder(tmp_path)
    log = walk(path, "log.csv", rows=60)
    lines = Path(log.path).read_text("utf-8").splitlines()
    (tmp_path / "gap.csv").write_text("\n".join([*lines[:31], *lines[34:]]) + "\n")
    samples = samples_of(path, str(tmp_path / "gap.csv"), log)
    assert samples.runs == ((0, 28), (28, 25), (53, 58))
    assert [part for _, part in samples.logs] == [slice(0, 53), slice(53, 111)]
    hip = log.joints["hip"]
    assert hip.command is not None and hip.position is not None
    assert samples.inputs[28, :2][0] == pytest.approx(hip.position[34], rel=1e-6)
    assert samples.inputs[28, 4] == pytest.approx(hip.command[33], rel=1e-6)
    parts = split(samples)
    assert parts.whole and parts.logs == (log.path,) and (len(parts.seen), parts.unseen[0]) == (53, 53)
    alone = split(samples_of(path, log))
    assert not alone.whole and (alone.seen[-1], alone.unseen[0]) == (44, 46)


def test_what_a_limit_can_remove(tmp_path: Path) -> None:
    """A robot whose commands are 0.05 rad too large at one joint: 0.1 rad removes all, 0.02 rad two fifths."""
    path = folder(tmp_path)
    samples = samples_of(path, walk(path, "log.npz", lambda q, qd, c: np.array([0.05, 0.0]), rows=60))
    bare = samples.errors()
    rows = np.arange(5, 55)
    assert np.abs(samples.errors(np.tile([0.05, 0.0], (58, 1)))[rows]).max() < 1e-8
    whole = judged(bare[rows], removable(samples, rows, bare[rows], 0.1)[1]).improvement
    assert whole.position > 0.999 and whole.velocity > 0.999
    part = judged(bare[rows], removable(samples, rows, bare[rows], 0.02)[1]).improvement
    assert (part.position, part.velocity) == pytest.approx((0.4, 0.4), abs=1e-3)

    def right(columns: Any) -> Any:
        return np.tile([0.05, 0.0], (len(columns), 1))

    found = validate(samples, right, 0.05)
    assert found.errors.improvement.position > 0.98 and found.grade == "good"
    # Every correction of one joint of two is at its limit.
    assert found.share_at_limit == 0.5 and [j.share_at_limit for j in found.joints] == [1.0, 0.0]
    # 58 rows hold one replay of 50; the correct commands go where the robot went.
    share, count = replay(samples, right)
    assert count == 1 and share is not None and share > 0.99


def test_the_best_correction_is_best_in_both_together(tmp_path: Path) -> None:
    """Two pendulums, one physics step: each correction changes a joint's own errors, along a straight line.

    Noise makes the errors of the arm larger and of the position and the velocity contradict each other. The least sum
    of what is left of both is found by trying corrections in steps of 1/500 of the limit.
    """
    path = folder(tmp_path, SPEC.replace("decimation: 4", "decimation: 1"))
    samples = samples_of(path, walk(path, "log.npz", lambda q, qd, c: np.array([0.05, 0.0]), rows=120))
    noise = np.random.default_rng(0).standard_normal(samples.after.shape) * [1e-5, 2e-4, 8e-3, 2e-2]
    samples = replace(samples, after=samples.after + noise)
    rows, limit = np.arange(len(samples)), 0.06
    bare = samples.errors()

    def left_of(errors: Any) -> float:
        found = judged(bare, errors).improvement
        return (1.0 - found.position) ** 2 + (1.0 - found.velocity) ** 2

    slopes = (samples.errors(0.01) - bare) / 0.01
    assert (samples.errors(-limit) - bare) == pytest.approx(-limit * slopes, abs=1e-9)
    tried = np.linspace(-limit, limit, 1001)[:, None]
    size = np.sqrt([np.mean(bare[:, :2] ** 2), np.mean(bare[:, 2:] ** 2)])
    best = bare.copy()
    for row in rows:
        for j in (0, 1):
            errors = bare[row, [j, 2 + j]] + tried * slopes[row, [j, 2 + j]]
            best[row, [j, 2 + j]] = errors[np.argmin(np.sum((errors / size) ** 2, axis=1))]
    delta, found = removable(samples, rows, bare, limit)
    assert left_of(found) == pytest.approx(left_of(best), rel=1e-4)
    assert np.abs(delta).max() <= limit and samples.errors(delta) == pytest.approx(found)


@pytest.mark.parametrize("known", [0.08, 0.02])
def test_no_correction_that_is_known_is_better_than_the_best(known: float, tmp_path: Path) -> None:
    """1.5 N*m of dry friction hold what 20 N*m/rad make of a quarter of 0.1 rad: slopes at rest tell nothing there."""
    path = folder(tmp_path, SPEC.replace("coulomb: 0 N*m", "coulomb: 1.5 N*m"))
    samples = samples_of(path, walk(path, "log.npz", lambda q, qd, c: np.array([known, 0.0]), rows=80))

    def right(columns: Any) -> Any:
        return np.tile([known, 0.0], (len(columns), 1))

    found = validate(samples, right, 0.1)
    shares = [found.errors.improvement, found.at_limit, found.at_twice]
    left = [(1.0 - share.position) ** 2 + (1.0 - share.velocity) ** 2 for share in shares]
    assert left[0] >= left[1] >= left[2] and left[0] < 0.1


@pytest.mark.parametrize(
    ("position", "velocity", "grade"),
    [(0.31, 0.9, "good"), (0.9, 0.3, "fair"), (0.11, 0.5, "fair"), (0.5, 0.1, "poor"), (-1.0, 0.9, "poor")],
)
def test_grades(position: float, velocity: float, grade: str) -> None:
    """By the smaller of the two."""
    assert graded(Pair(position, velocity)) == grade


def test_errors_of_positions_and_velocities() -> None:
    """RMS over rows and joints by hand: (3, 4) is sqrt(12.5), halved a half."""
    found = judged(np.array([[3.0, 4.0, 1.0, 1.0]]), np.array([[1.5, 2.0, 0.0, 0.0]]))
    assert found.uncorrected.position == pytest.approx(12.5**0.5)
    assert (found.improvement.position, found.improvement.velocity) == (0.5, 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("per", ["joint", "robot"])
def test_a_known_fault_is_learned(tmp_path: Path, per: str) -> None:
    """A robot whose drives lag and pull: 0.08 tanh of speed and of the command."""
    pytest.importorskip("torch")

    def fault(q: Any, qd: Any, c: Any) -> Any:
        return 0.08 * np.tanh([-0.5 * qd[0] + 0.3, 2.0 * (c[1] - q[1])])

    path = folder(tmp_path)
    samples = samples_of(
        path, walk(path, "a.npz", fault, rows=300), walk(path, "b.npz", fault, rows=100, seed=1)
    )
    options = TrainOptions(0.1, per, epochs=160)
    trained = train(samples, split(samples), options)
    assert trained.judged.improvement.position > 0.85 and trained.judged.improvement.velocity > 0.85
    columns = samples.inputs
    found = Graph(onnx_of(trained.layers))(columns)
    wanted = np.array([fault(x[:2], x[2:4], x[6:]) for x in columns])
    rms = float(np.sqrt(np.mean((found - wanted) ** 2)) / np.sqrt(np.mean(wanted**2)))
    assert rms < 0.15


@pytest.mark.slow
def test_the_same_seed_gives_the_same_file(tmp_path: Path) -> None:
    """Another one another; and a training ends by its time."""
    pytest.importorskip("torch")
    samples = samples_of(
        path := folder(tmp_path), walk(path, "a.npz", lambda q, qd, c: 0.05 * np.sin(q), rows=60)
    )
    short = TrainOptions(0.1, epochs=2)
    one, other = (onnx_of(train(samples, split(samples), short).layers) for _ in "ab")
    assert one == other != onnx_of(train(samples, split(samples), replace(short, seed=1)).layers)
    assert train(samples, split(samples), replace(short, epochs=100000, max_time=0.5)).epochs < 100000


@pytest.mark.slow
@pytest.mark.parametrize("per", ["joint", "robot"])
def test_what_is_written_is_what_was_trained(tmp_path: Path, per: str) -> None:
    """Features and the way down go into the first layer: the file leaves the errors that the training told."""
    pytest.importorskip("torch")
    path = folder(tmp_path, model=FLOATING)
    samples = samples_of(path, walk(path, "a.npz", lambda q, qd, c: 0.05 * np.sin(q), rows=120))
    parts = split(samples)
    trained = train(samples, parts, TrainOptions(0.1, per, epochs=5))
    corrections = Graph(onnx_of(trained.layers))(samples.inputs)
    assert np.abs(corrections).max() > 0.01
    found = judged(samples.errors()[parts.unseen], samples.errors(corrections)[parts.unseen])
    assert found.corrected.position == pytest.approx(trained.judged.corrected.position, rel=1e-3)


def test_the_limit_is_held_wherever_a_network_goes(tmp_path: Path) -> None:
    """A network of others that grows without end: far from what is tried when it is read it is clipped."""
    import hashlib

    from onnx import TensorProto, helper, numpy_helper

    grows = helper.make_graph(
        [
            helper.make_node("Gather", ["x", "commands"], ["c"], axis=1),
            helper.make_node("Mul", ["c", "slope"], ["y"]),
        ],
        "grows",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, ["n", 15])],
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, ["n", 2])],
        [
            numpy_helper.from_array(np.array([13, 14]), "commands"),
            numpy_helper.from_array(np.array(1e-6, dtype=np.float32), "slope"),
        ],
    )
    data = helper.make_model(grows).SerializeToString()
    (tmp_path / "other.onnx").write_bytes(data)
    entry = {"path": "other.onnx", "sha256": hashlib.sha256(data).hexdigest()}
    delta = delta_action(spoilt(written(tmp_path), lambda m: m["files"].update(onnx=entry)))
    found = delta.delta(np.zeros((1, 13)), np.array([[1e4, -1e6]]))
    assert found == pytest.approx(np.array([[0.01, -0.2]]))


COLUMNS = (
    *("hip.position", "arm.position", "hip.velocity", "arm.velocity", "hip.last_command", "arm.last_command"),
    *(f"base.orientation.{c}" for c in "wxyz"),
    *(f"base.angular_velocity.{c}" for c in "xyz"),
    *("hip.command", "arm.command"),
)


def by_hand() -> DeltaLayers:
    """hip: command - last command + 0.5 of the way down's x; arm: 2 times the same of its own, and its z."""
    picked = np.array([[13, 4, 15], [14, 5, 17]])
    first = np.array([[[1.0], [-1.0], [0.5]], [[2.0], [-2.0], [1.0]]])
    # The file's way down lacks the -1 of z.
    bias = np.array([[0.0], [-1.0]])
    return DeltaLayers(
        COLUMNS, picked, first, bias, "tanh", (Dense(np.array([[0.7]]), np.array([0.1])),), 0.2
    )


def expected(x: Any) -> Any:
    """The same with rotation matrices."""
    out = []
    for row in x:
        w, i, j, k = row[6:10]
        turn = np.array(
            [
                [1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)],
                [2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)],
                [2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)],
            ]
        )
        down = turn.T @ [0.0, 0.0, -1.0]
        inner = [row[13] - row[4] + 0.5 * down[0], 2.0 * (row[14] - row[5]) + down[2]]
        out.append(0.2 * np.tanh(0.7 * np.tanh(inner) + 0.1))
    return np.array(out)


def rows_of(count: int, seed: int = 0) -> Any:
    """Columns with quaternions among them."""
    x = np.random.default_rng(seed).normal(size=(count, 15))
    x[:, 6:10] /= np.linalg.norm(x[:, 6:10], axis=1)[:, None]
    return x


def written(path: Path, **more: Any) -> str:
    """The network by hand, as files."""
    entries = {
        "period": 0.02,
        "action_scale": {"hip": 0.5, "arm": 0.25},
        "default_position": {"hip": 0.1},
    } | more
    return write_delta(str(path / "delta"), by_hand(), entries)["manifest"]


def test_the_files_are_the_formula(tmp_path: Path) -> None:
    """ONNX by numpy and torch, TorchScript by torch: each by a formula of its own."""
    torch = pytest.importorskip("torch")
    path = written(tmp_path)
    x = rows_of(50)
    network = read_delta(path)
    assert network(x) == pytest.approx(expected(x), abs=1e-6)
    single = torch.tensor(x, dtype=torch.float32)
    assert network(single).numpy() == pytest.approx(expected(x), abs=1e-5)
    script = torch.jit.load(io.BytesIO((tmp_path / "delta.pt").read_bytes()))
    assert script(single).numpy() == pytest.approx(expected(x), abs=1e-5)
    found = json.loads(Path(path).read_text("utf-8"))
    assert found["inputs"] == list(COLUMNS) and found["outputs"] == ["hip.command", "arm.command"]
    assert found["format"] == "actspec-delta/1" and found["max_delta"] == 0.2
    assert found["files"]["onnx"]["path"] == "delta.onnx"


class Robot:
    """An environment that notes its actions."""

    def __init__(self, answer: Any = None) -> None:
        self.actions: list[Any] = []
        self.answer = answer
        self.name = "robot"

    def step(self, action: Any) -> Any:
        """Note it."""
        self.actions.append(action)
        return self.answer

    def reset(self) -> str:
        """Begin."""
        return "begun"


@pytest.mark.parametrize("library", ["numpy", "torch"])
def test_wrap(tmp_path: Path, library: str) -> None:
    """Actions are turned into commands in rad by scale and default, and corrections back; joints in another order."""
    xp: Any = pytest.importorskip(library)
    delta = delta_action(written(tmp_path))
    assert delta.joints == ("hip", "arm") and len(delta.state) == 13 and len(delta.measured) == 11
    x = rows_of(3, seed=2)
    measured = np.delete(x[:, :13], [4, 5], axis=1)

    def array(value: Any) -> Any:
        return xp.asarray(value, dtype=xp.float64)

    done = xp.asarray([False, True, False])
    env = delta.wrap(
        Robot(("seen", 0.0, done, ~done & False, {})),
        state=lambda: array(measured),
        joints=["arm", "hip"],
        default_position={"hip": 0.1, "arm": -0.3},
    )
    scale, middle = np.array([0.25, 0.5]), np.array([-0.3, 0.1])
    actions = np.random.default_rng(3).normal(size=(2, 3, 2))
    commands = (middle + scale * actions)[..., ::-1]
    # At first the last command is the command; after the first step environment 1 began anew.
    last = np.array([commands[0], commands[0]])
    last[1, 1] = commands[1, 1]
    for k in range(2):
        answer = env.step(array(actions[k]))
        full = np.concatenate([measured[:, :4], last[k], measured[:, 4:], commands[k]], axis=1)
        wanted = actions[k] + expected(full)[:, ::-1] / scale
        assert np.asarray(env.actions[-1]) == pytest.approx(wanted, abs=1e-6)
        assert answer[0] == "seen"
    assert env.name == "robot" and env.reset() == "begun"
    env.step(array(actions[1]))
    full = np.concatenate([measured[:, :4], commands[1], measured[:, 4:], commands[1]], axis=1)
    assert np.asarray(env.last_delta) == pytest.approx(expected(full)[:, ::-1], abs=1e-6)


def test_wrap_with_whole_states_of_one_environment(tmp_path: Path) -> None:
    """A state with last commands is taken as it is; arrays without a row for each environment too."""
    delta = delta_action(written(tmp_path, default_position={"hip": 0.1, "arm": 0.2}))
    x = rows_of(1)[0]
    env = delta.wrap(Robot(), state=lambda: x[:13])
    action = np.array([0.3, -0.4])
    assert env.step(action) is None
    full = np.concatenate([x[:13], [0.1 + 0.5 * 0.3, 0.2 - 0.25 * 0.4]])
    assert env.actions[0] == pytest.approx(action + expected(full[None])[0] / [0.5, 0.25], abs=1e-6)


def test_no_gradient_goes_through(tmp_path: Path) -> None:
    """The delta action is frozen, and so is what it is given."""
    torch = pytest.importorskip("torch")
    delta = delta_action(written(tmp_path))
    found = delta.delta(torch.ones(2, 13), torch.ones(2, 2, requires_grad=True))
    assert not found.requires_grad and found.dtype == torch.float32
    assert float(delta.delta(torch.ones(2, 13, dtype=torch.int64), torch.ones(2, 2)).abs().max()) <= 0.2


@pytest.mark.parametrize(
    ("make", "said"),
    [
        pytest.param(
            lambda d: d.delta(np.ones((2, 12)), np.ones((2, 2))), "takes (n, 13) and (n, 2)", id="shape"
        ),
        pytest.param(
            lambda d: d.wrap(Robot(), state=None), "default_position is unknown of arm", id="unknown"
        ),
        pytest.param(
            lambda d: d.wrap(Robot(), state=None, joints=["hip"], default_position=0.0),
            "the environment moves hip, the delta action hip, arm",
            id="joints",
        ),
        pytest.param(
            lambda d: d.wrap(Robot(), state=None, default_position=[0.0]),
            "has 1 figures, there are 2",
            id="count",
        ),
        pytest.param(
            lambda d: d.wrap(Robot(), state=None, default_position=0.0, action_scale=0.0),
            "must not be 0",
            id="zero",
        ),
    ],
)
def test_what_does_not_fit(tmp_path: Path, make: Any, said: str) -> None:
    """Named, with what is taken."""
    with pytest.raises(DeltaFault) as caught:
        make(delta_action(written(tmp_path)))
    (found,) = caught.value.diagnostics
    assert found.code == "LRN062" and said in found.message


def spoilt(path: str, change: Any) -> str:
    """A manifest with another entry."""
    found = json.loads(Path(path).read_text("utf-8"))
    change(found)
    Path(path).write_text(json.dumps(found), encoding="utf-8")
    return path


def swap_file(data: bytes) -> Any:
    """Other bytes in place of the network, with their own hash."""
    import hashlib

    def change(found: Any) -> None:
        found["files"]["onnx"] = {"path": "other.onnx", "sha256": hashlib.sha256(data).hexdigest()}

    return data, change


@pytest.mark.parametrize(
    ("data", "change", "said"),
    [
        pytest.param(
            None, lambda m: m["files"]["onnx"].update(sha256="0" * 64), "is not the file", id="hash"
        ),
        pytest.param(
            None, lambda m: m["files"]["onnx"].update(path="../delta.onnx"), "path", id="another folder"
        ),
        pytest.param(None, lambda m: m["files"].pop("onnx"), "names no ONNX file", id="no ONNX"),
        pytest.param(
            None, lambda m: m.update(max_delta=0.05), "corrections above max_delta 0.05", id="limit"
        ),
        pytest.param(None, lambda m: m.update(max_delta=-0.1), "max_delta", id="no limit"),
        pytest.param(
            None, lambda m: m["inputs"].reverse(), "the last inputs are not the outputs", id="order"
        ),
        pytest.param(
            None,
            lambda m: m["inputs"].__setitem__(0, "hip.torque"),
            "unknown columns: hip.torque",
            id="column",
        ),
        pytest.param(None, lambda m: m["inputs"].pop(0), "sizes do not fit", id="a column less"),
        pytest.param(
            None,
            lambda m: m.update(action_scale={"knee": 1.0}),
            "joints that are not corrected: knee",
            id="scales",
        ),
        pytest.param(*swap_file(b"\x80\x04N."), "programs and are not run", id="pickle"),
        pytest.param(*swap_file(b"PK\x03\x04"), "programs and are not run", id="TorchScript"),
        pytest.param(*swap_file(b""), "it is empty", id="empty"),
        pytest.param(*swap_file(onnx_of(by_hand())[:500]), "cut off", id="cut"),
    ],
)
def test_manifests_that_are_refused(tmp_path: Path, data: bytes | None, change: Any, said: str) -> None:
    """With a reason, and nothing run."""
    path = spoilt(written(tmp_path), change)
    if data is not None:
        (tmp_path / "other.onnx").write_bytes(data)
    with pytest.raises(DeltaFault) as caught:
        read_delta(path)
    assert said in " ".join(str(item) for item in caught.value.diagnostics)


def test_no_manifest(tmp_path: Path) -> None:
    """A pickle, another format, and nothing at all."""
    for name, data in (
        ("a.json", b"\x80\x04N."),
        ("b.json", b'{"format": "actspec-network/1"}'),
        ("c.json", None),
    ):
        if data is not None:
            (tmp_path / name).write_bytes(data)
        with pytest.raises(DeltaFault):
            read_delta(tmp_path / name)


def test_operations_that_are_not_known() -> None:
    """Such as those that loop or open files."""
    from onnx import TensorProto, helper

    x = helper.make_tensor_value_info("x", TensorProto.FLOAT, ["n", 2])
    y = helper.make_tensor_value_info("y", TensorProto.FLOAT, ["n", 2])
    graph = helper.make_graph([helper.make_node("Erf", ["x"], ["y"])], "g", [x], [y])
    with pytest.raises(NetworkUnknown, match="Erf"):
        Graph(helper.make_model(graph).SerializeToString())
