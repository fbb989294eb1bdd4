"""`actspec.runtime.networks` and `attach`: the torque of a network, by its formula, in arrays and in plain MuJoCo."""

from __future__ import annotations

import copy
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec import runtime
from actspec.learn.bundle import RuntimeFault
from tests.learn.netted import SPEC, build, torques

mujoco = pytest.importorskip("mujoco")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The compiled robot."""
    return build(tmp_path_factory.mktemp("netted"))


def course(steps: int = 40, envs: int = 5) -> tuple[Any, Any, Any]:
    """Commands, positions and speeds, some of them fast; shapes (steps, envs, 2)."""
    random = np.random.default_rng(4)
    return tuple(size * random.normal(size=(steps, envs, 2)) for size in (0.3, 0.2, 6.0))  # type: ignore[return-value]


@pytest.mark.parametrize("history", ["first_sample", "zero"])
def test_arrays(history: str, tmp_path: Path) -> None:
    """Torque of each step, clamped; one environment is reset on its way."""
    nets = runtime.networks(build(tmp_path, history=history), envs=5)
    assert nets.joints == ("hip", "knee")
    command, q, qd = course()
    found = []
    for k in range(len(command)):
        if k == 17:
            nets.reset([3])
        found.append(nets.torque(command[k], q[k], qd[k]))
    error = command - q
    backfill = history == "first_sample"
    for env in (0, 3):
        begin = 17 if env == 3 else 0
        expected = torques(error[begin:, env], qd[begin:, env], backfill=backfill)
        assert np.array(found)[begin:, env] == pytest.approx(expected, abs=1e-6)
    assert np.abs(found).max() == pytest.approx(6.0)


def test_torch_in_torch_out(folder: Path) -> None:
    """Of torch's arrays the same, in their type."""
    import torch

    command, q, qd = course(10)
    nets, theirs = runtime.networks(folder, envs=5), runtime.networks(folder, envs=5)
    for k in range(10):
        expected = nets.torque(command[k], q[k], qd[k])
        arrays = [torch.tensor(part[k], dtype=torch.float32) for part in (command, q, qd)]
        got = theirs.torque(*arrays)
        assert got.dtype == torch.float32
        assert got.numpy() == pytest.approx(expected, abs=1e-4)


def loaded(folder: Path) -> Any:
    model = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, i) for i in range(model.nu)]
    # The first two columns of the tests are the legs.
    assert sorted(names) == ["arm_motor", "hip", "knee"]
    return model


def controls(model: Any) -> list[int]:
    return [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, n) for n in ("hip", "knee")]


def steps(model: Any, data: Any, targets: Any, *, forward: bool = False) -> tuple[Any, Any, Any]:
    """Errors, speeds and forces of the legs in each step; with `mj_forward` at other commands before each step."""
    legs = controls(model)
    errors, speeds, forces = [], [], []
    for target in targets:
        if forward:
            data.ctrl[legs] = 7.0
            mujoco.mj_forward(model, data)
        data.ctrl[legs] = target
        errors.append(target - data.qpos[:2])
        speeds.append(data.qvel[:2].copy())
        mujoco.mj_step(model, data)
        forces.append(data.qfrc_actuator[:2].copy())
    return np.array(errors), np.array(speeds), np.array(forces)


@pytest.mark.parametrize("forward", [False, True])
def test_in_mujoco(folder: Path, forward: bool) -> None:
    """The force of each step is the network's at the state before it, and `ctrl` stays the command."""
    model = loaded(folder)
    targets = 0.8 * np.sin(np.arange(200)[:, None] * [0.11, 0.07])
    with runtime.attach(model, folder) as attached:
        assert attached.joints == ("hip", "knee")
        data = mujoco.MjData(model)
        errors, speeds, forces = steps(model, data, targets, forward=forward)
        assert forces == pytest.approx(torques(errors, speeds), abs=1e-5)
        assert data.ctrl[controls(model)] == pytest.approx(targets[-1])
        # A reset forgets: the same course again, from the same state.
        mujoco.mj_resetData(model, data)
        again = steps(model, data, targets, forward=forward)[2]
        assert again == pytest.approx(forces, abs=1e-12)


def test_two_data_in_turn(folder: Path) -> None:
    """Each MjData has a history of its own."""
    model = loaded(folder)
    legs = controls(model)
    with runtime.attach(model, folder):
        one, two = mujoco.MjData(model), mujoco.MjData(model)
        found: dict[int, list[Any]] = {0: [], 1: []}
        for k in range(60):
            for i, (data, way) in enumerate(((one, 1.0), (two, -1.0))):
                data.ctrl[legs] = way * 0.5 * np.sin(0.2 * k)
                mujoco.mj_step(model, data)
                found[i].append(data.qpos[:2].copy())
        alone = mujoco.MjData(model)
        for k in range(60):
            alone.ctrl[legs] = 0.5 * np.sin(0.2 * k)
            mujoco.mj_step(model, alone)
            assert alone.qpos[:2] == pytest.approx(found[0][k], abs=1e-12)


def test_threads_of_rollout(folder: Path) -> None:
    """Many rollouts in threads give what one alone gives."""
    from mujoco import rollout

    model = loaded(folder)
    with runtime.attach(model, folder):
        data = mujoco.MjData(model)
        size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        state = np.zeros(size)
        mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        random = np.random.default_rng(5)
        control = 0.4 * random.normal(size=(16, 50, model.nu))
        initial = np.tile(state, (16, 1))
        many, _ = rollout.rollout(model, [mujoco.MjData(model) for _ in range(4)], initial, control)
        for i in range(16):
            one, _ = rollout.rollout(model, mujoco.MjData(model), initial[i], control[i])
            assert many[i] == pytest.approx(one[0], abs=1e-12)


def test_python_threads(folder: Path) -> None:
    """Simulations in Python's threads do not touch each other."""
    model = loaded(folder)
    legs = controls(model)

    def course(seed: int) -> Any:
        data, random = mujoco.MjData(model), np.random.default_rng(seed)
        for _ in range(200):
            data.ctrl[legs] = 0.3 * random.normal(size=2)
            mujoco.mj_step(model, data)
        return data.qpos.copy()

    with runtime.attach(model, folder):
        alone = [course(seed) for seed in range(6)]
        with ThreadPoolExecutor(3) as pool:
            together = list(pool.map(course, range(6)))
    assert np.array(together) == pytest.approx(np.array(alone), abs=1e-12)


def test_detach(folder: Path) -> None:
    """After `detach` the model is as it was, and nobody asks the networks any more."""
    model, other = loaded(folder), loaded(folder)
    attached = runtime.attach(model, folder)
    assert mujoco.get_mjcb_act_bias() is not None
    attached.detach()
    attached.detach()
    assert mujoco.get_mjcb_act_bias() is None
    for name in ("gainprm", "biasprm", "biastype", "gaintype", "ctrllimited"):
        name = f"actuator_{name}"
        assert np.array_equal(getattr(model, name), getattr(other, name))


def test_what_does_not_fit(folder: Path, tmp_path: Path) -> None:
    """Another step, RK4, another model, twice, no folder, another shape: refused by name."""
    model = loaded(folder)
    model.opt.timestep = 0.002
    with pytest.raises(RuntimeFault, match=r"0\.002 s"):
        runtime.attach(model, folder)
    model.opt.timestep = 0.005
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    with pytest.raises(RuntimeFault, match="RK4"):
        runtime.attach(model, folder)
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    with runtime.attach(model, folder), pytest.raises(RuntimeFault, match="already"):
        runtime.attach(model, folder)
    bare = mujoco.MjModel.from_xml_string("<mujoco><option timestep='0.005'/></mujoco>")
    with pytest.raises(RuntimeFault, match="no actuator hip"):
        runtime.attach(bare, folder)
    with pytest.raises(RuntimeFault, match=r"no networks\.json"):
        runtime.networks(tmp_path)
    nets = runtime.networks(folder, envs=2)
    with pytest.raises(RuntimeFault, match=r"shape \(3, 2\)"):
        nets.torque(np.zeros((3, 2)), np.zeros((2, 2)), np.zeros((2, 2)))


def test_what_no_longer_fits(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """RK4 or another step that is set behind `attach`, and a copy of the model: refused, not run wrongly."""
    model = loaded(folder)
    data = mujoco.MjData(model)
    with runtime.attach(model, folder):
        mujoco.mj_step(model, data)
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
        with pytest.raises(RuntimeFault, match="RK4"):
            mujoco.mj_step(model, data)
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        model.opt.timestep = 0.002
        with pytest.raises(RuntimeFault, match=r"0\.002 s"):
            mujoco.mj_step(model, data, 3)
        model.opt.timestep = 0.005
        copied = copy.copy(model)
        with pytest.raises(RuntimeFault, match="copy"), ThreadPoolExecutor(1) as pool:
            pool.submit(mujoco.mj_forward, copied, mujoco.MjData(copied)).result()
        # A thread of MuJoCo's own would end the process with less.
        assert "LRN043" in capfd.readouterr().err
        with runtime.attach(copied, folder):
            mujoco.mj_forward(copied, mujoco.MjData(copied))
        mujoco.mj_resetData(model, data)
        mujoco.mj_step(model, data)


def test_watch(folder: Path) -> None:
    """Samples beyond the manifest's range are counted: errors beyond 1 rad, speeds beyond 5 rad/s."""
    nets = runtime.networks(folder, envs=2, watch=True)
    zero = np.zeros((2, 2))
    nets.torque(np.array([[1.5, 0.5], [0.0, -2.0]]), zero, np.array([[0.0, 6.0], [0.0, 0.0]]))
    assert nets.outside == 3


def test_delay_of_the_spec_is_said(tmp_path: Path) -> None:
    """The network holds the drive's own delay: the spec's is not added, and that is counted."""
    from actspec import api

    build(tmp_path, spec=SPEC.replace("level: actuator_net,", "level: actuator_net, delay: 8 ms,"))
    made = api.compile(str(tmp_path / "spec.yaml"))
    lost = [(a.joint, a.field, a.asked) for a in made.emissions[0].approximations if a.field == "delay"]
    assert lost == [("hip", "delay", "8 ms"), ("knee", "delay", "8 ms")]


@pytest.mark.parametrize("library", ["list", "numpy", "torch"])
def test_environments_that_are_not_there(library: str, folder: Path) -> None:
    """Of four environments 4 and -1 are none, three truth values no mask and 0.5 no index; nothing is forgotten."""
    import torch

    def made(values: list[Any]) -> Any:
        return {"list": list, "numpy": np.array, "torch": torch.tensor}[library](values)

    nets, other = (runtime.networks(folder, envs=4) for _ in "ab")
    rows = [[0.1, -0.2]] * 4
    arrays = [torch.tensor(rows) if library == "torch" else np.array(rows) for _ in range(3)]
    for begun in (False, True):
        for wrong, message in (
            ([5], "envs has 5, there are 4 environments"),
            ([0, -1, 4], "envs has -1, 4, there are 4 environments"),
            ([True] * 3, r"the mask envs has the shape \(3,\), there are 4 environments"),
            ([0.5], "neither indices nor a mask"),
        ):
            with pytest.raises(ValueError, match=message) as caught:
                nets.reset(made(wrong))
            assert isinstance(caught.value, RuntimeFault) and caught.value.diagnostics[0].code == "LRN042"
        if not begun:
            # A history, from which a reset could be seen.
            for part in (nets, other):
                part.torque(*arrays)
    moved = [2.0 * arrays[0], *arrays[1:]]
    assert np.array_equal(np.asarray(nets.torque(*moved)), np.asarray(other.torque(*moved)))
    # Of those that are there: an index, a mask, and none.
    nets.reset(made([1]))
    other.reset(made([False, True, False, False]))
    assert np.array_equal(np.asarray(nets.torque(*moved)), np.asarray(other.torque(*moved)))
    nets.reset(
        {"list": [], "numpy": np.array([], int), "torch": torch.tensor([], dtype=torch.int64)}[library]
    )
    assert np.array_equal(np.asarray(nets.torque(*moved)), np.asarray(other.torque(*moved)))
