"""Draws of effective values: what each operation and factor does, sharing, seeds, distributions, checks."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import actspec
from actspec.diagnostics import Collector, ResolveError
from actspec.ir import ActuatorSet
from actspec.sampling import check_ranges, sample
from tests.fitting import fit, spec_of

ROBOTS = Path(__file__).resolve().parents[1] / "robots"

N = 20_000
"""Draws of the statistical tests. The mean of a uniform is off by its width/sqrt(12 N): 0.2 % of the width."""


def legs(randomize: str, more: str = "", joints: str = "[hip, calf]") -> ActuatorSet:
    """Two hinges with kp 20, kd 0.5, limit 30, armature 0.01, coulomb 0.2, viscous 0.04."""
    numbers = "kp: 20, kd: 0.5, effort_limit: 30, armature: 0.01, friction: {coulomb: 0.2, viscous: 0.04}"
    group = f"legs: {{joints: {joints}, level: ideal_pd, {numbers}, randomize: {{{randomize}}} {more}}}"
    return fit(spec_of(group, robot="name: leg, model: none, joints: [hip, calf]"))


def drawn(randomize: str, more: str = "", n: int = N, seed: int = 3) -> dict[str, NDArray[Any]]:
    """Draws of `legs`."""
    return sample(legs(randomize, more), n, seed=seed)


def test_nothing_is_drawn() -> None:
    """Without ranges every environment is the nominal robot; static friction is the kinetic one."""
    found = drawn("", n=3)
    assert {key: array.shape for key, array in found.items()} == dict.fromkeys(found, (3, 2))
    assert {key: float(array[2, 1]) for key, array in found.items()} == {
        "kp": 20.0, "kd": 0.5, "effort_limit": 30.0, "armature": 0.01, "friction.coulomb": 0.2,
        "friction.static": 0.2, "friction.viscous": 0.04, "encoder_bias": 0.0, "delay": 0.0, "strength": 1.0,
    }  # fmt: skip


@pytest.mark.parametrize(
    "field, text, low, high",
    [
        pytest.param("kp", "{scale: [0.5, 2]}", 10.0, 40.0, id="scale"),
        pytest.param("armature", "{add: [-0.002, 0.006]}", 0.008, 0.016, id="add"),
        pytest.param("friction.coulomb", "{abs: [0.1, 0.5]}", 0.1, 0.5, id="abs"),
        pytest.param("encoder_bias", "{add: [-0.5 deg, 0.5 deg]}", -0.0087266463, 0.0087266463, id="bias"),
        pytest.param("delay", "{abs: [0 ms, 10 ms]}", 0.0, 0.010, id="delay"),
    ],
)
def test_operations(field: str, text: str, low: float, high: float) -> None:
    """A uniform range fills [low, high] evenly, and nothing else moves."""
    found = drawn(f"{field}: {text}")
    array = found.pop(field)
    width = high - low
    assert low <= array.min() < low + 0.001 * width
    assert high - 0.001 * width < array.max() <= high
    # Five standard errors of the mean and of the variance, width²/12 and width⁴/180, over 2 N draws.
    assert abs(array.mean() - (low + high) / 2) < 5 * width / math.sqrt(12 * 2 * N)
    assert abs(array.var() - width**2 / 12) < 5 * width**2 / math.sqrt(180 * 2 * N)
    nominal = drawn("", n=1)
    moved = {key for key, other in found.items() if not np.all(other == nominal[key])}
    assert moved == ({"friction.static"} if field == "friction.coulomb" else set())


def test_log_uniform() -> None:
    """log_uniform has its median at the geometric mean: kp 20 × [0.25, 4] at 20, not at 42.5."""
    array = drawn("kp: {scale: [0.25, 4], distribution: log_uniform}")["kp"]
    # The logarithm is uniform over ln 16 = 2.77; its mean is known to 2.77/sqrt(12 2N) = 0.004.
    assert abs(np.log(array / 20).mean()) < 5 * 0.004
    assert 5.0 <= array.min() < 5.01 and 79.9 < array.max() <= 80.0


def test_gaussian_is_mean_and_deviation() -> None:
    """The pair of a gaussian is (mean, std): 20 × (1, 0.1) has a deviation of 2."""
    array = drawn("kp: {scale: [1, 0.1], distribution: gaussian}")["kp"]
    assert abs(array.mean() - 20) < 5 * 2 / math.sqrt(2 * N)
    assert abs(array.std() - 2) < 5 * 2 / math.sqrt(4 * N)


def test_gaussian_is_cut_at_zero() -> None:
    """Values below 0 become 0: a gain that turns its sign is no robot."""
    array = drawn("kd: {scale: [0.5, 0.5], distribution: gaussian}")["kd"]
    # P(z < -1) = 15.87 %; its standard error over 2 N draws is 0.18 %.
    assert array.min() == 0.0
    assert abs((array == 0.0).mean() - 0.1587) < 0.01


def test_gains_are_one_factor() -> None:
    """`gains` keeps kp/kd at 40, and leaves the limit."""
    found = drawn("gains: {scale: [0.5, 1.5]}")
    np.testing.assert_allclose(found["kp"] / found["kd"], 40.0, rtol=1e-12)
    assert found["kp"].std() > 5.0
    assert np.all(found["effort_limit"] == 30.0)


def test_order_of_combination() -> None:
    """kp = own range × gains × strength, the limit follows strength alone, and the factors stand beside."""
    found = drawn("kp: {abs: [40, 40]}, gains: {scale: [3, 3]}, strength: {scale: [0.5, 0.5]}", n=1)
    # 40 · 3 · 0.5 = 60; 0.5 · 3 · 0.5 = 0.75; 30 · 0.5 = 15.
    assert [found[key][0, 0] for key in ("kp", "kd", "effort_limit", "strength")] == [60.0, 0.75, 15.0, 0.5]


def test_strength_moves_gains_and_limit_together() -> None:
    """kp, kd and limit are the nominal times the same number in every environment."""
    found = drawn("strength: {scale: [0.9, 1.1]}", n=100)
    for field, nominal in (("kp", 20.0), ("kd", 0.5), ("effort_limit", 30.0)):
        np.testing.assert_allclose(found[field], nominal * found["strength"], rtol=1e-15)


@pytest.mark.parametrize(
    "per, in_group, over_groups",
    [
        pytest.param("joint", False, False),
        pytest.param("group", True, False),
        pytest.param("env", True, True),
    ],
)
def test_sharing(per: str, in_group: bool, over_groups: bool) -> None:
    """`per` says which joints have one number; environments never share."""
    numbers = "level: ideal_pd, kp: 20, kd: 1, effort_limit: 9"
    text = spec_of(
        f"a: {{joints: [hip, calf], {numbers}, randomize: {{kp: {{scale: [0.5, 1.5], per: {per}}}}}}},"
        f"b: {{joints: [toe], {numbers}, randomize: {{kp: {{scale: [0.5, 1.5], per: {per}}}}}}}",
        robot="name: leg, model: none, joints: [hip, calf, toe]",
    )
    hip, calf, toe = sample(fit(text), 50, seed=1)["kp"].T
    assert np.array_equal(hip, calf) is in_group
    assert np.array_equal(hip, toe) is over_groups
    assert len(set(hip)) == 50


def test_env_shares_the_quantile() -> None:
    """With ranges of their own, groups of one environment take the same quantile."""
    numbers = "level: ideal_pd, kp: 20, kd: 1, effort_limit: 9"
    text = spec_of(
        f"a: {{joints: [hip], {numbers}, randomize: {{kp: {{scale: [0.5, 1.5], per: env}}}}}},"
        f"b: {{joints: [calf], {numbers}, randomize: {{kp: {{abs: [0, 100], per: env}}}}}}",
        robot="name: leg, model: none, joints: [hip, calf]",
    )
    hip, calf = sample(fit(text), 50, seed=1)["kp"].T
    np.testing.assert_allclose((hip - 10) / 20, calf / 100, rtol=1e-12)


def test_seed_and_independence() -> None:
    """A seed repeats; another differs; another field or joint beside it changes nothing; joints differ."""
    one = drawn("kp: {scale: [0.5, 1.5]}", n=8)["kp"]
    assert np.array_equal(one, drawn("kp: {scale: [0.5, 1.5]}", n=8)["kp"])
    assert not np.any(one == drawn("kp: {scale: [0.5, 1.5]}", n=8, seed=4)["kp"])
    more = drawn("kp: {scale: [0.5, 1.5]}, kd: {scale: [0.5, 1.5]}", n=8)
    assert np.array_equal(one, more["kp"])
    assert abs(np.corrcoef((one / 20).ravel(), (more["kd"] / 0.5).ravel())[0, 1]) < 0.999
    assert not np.any(one[:, 0] == one[:, 1])


def test_pinned_numbers() -> None:
    """The numbers of a seed are part of the contract: they do not change with the platform or a release."""
    found = drawn("kp: {scale: [0, 1]}", n=2, seed=0)["kp"] / 20
    np.testing.assert_allclose(found, PINNED, rtol=1e-12)


PINNED = [[0.8408567087346718, 0.6311956263383562], [0.24057190202986778, 0.27846731297130267]]


def test_kinetic_friction_stays_below_static() -> None:
    """Kinetic friction is cut at the static one, which is not drawn: P(c > 0.3) of U(0.1, 0.5) is one half."""
    numbers = "kp: 20, kd: 0.5, effort_limit: 30, friction: {coulomb: 0.2, static: 0.3}"
    text = f"legs: {{joints: [hip], level: ideal_pd, {numbers}, randomize: {{friction.coulomb: {{abs: [0.1, 0.5]}}}}}}"
    found = sample(fit(spec_of(text, robot="name: leg, model: none, joints: [hip]")), N, seed=1)
    assert np.all(found["friction.static"] == 0.3)
    # Standard error sqrt(0.25/N) = 0.35 %.
    assert abs((found["friction.coulomb"] == 0.3).mean() - 0.5) < 0.02
    assert found["friction.coulomb"].max() == 0.3


def test_range_of_the_delay_itself() -> None:
    """A delay with a range of its own is drawn, one number a group; `randomize` comes before it."""
    delay = ", delay: {nominal: 5 ms, range: [2 ms, 6 ms]}"
    found = drawn("", delay)["delay"]
    assert np.array_equal(found[:, 0], found[:, 1])
    assert abs(found.mean() - 0.004) < 5 * 0.004 / math.sqrt(12 * N)
    assert np.all(drawn("delay: {abs: [9 ms, 9 ms]}", delay, n=4)["delay"] == 0.009)


def test_torch_has_the_same_numbers() -> None:
    """With torch the result is tensors of its default type, with numpy's numbers."""
    torch = pytest.importorskip("torch")
    there = sample(legs("kp: {scale: [0.5, 1.5]}"), 8, seed=3, xp=torch)
    assert there["kp"].dtype is torch.get_default_dtype()
    np.testing.assert_allclose(there["kp"].numpy(), drawn("kp: {scale: [0.5, 1.5]}", n=8)["kp"], rtol=1e-6)


def test_from_a_path() -> None:
    """`actspec.sample` takes a spec's path: the A1's strength is one factor a robot within ∓10 %."""
    found = actspec.sample(ROBOTS / "a1.yaml", 500, seed=0)
    assert found["kp"].shape == (500, 12)
    assert np.all(np.ptp(found["strength"], axis=1) == 0.0)
    assert 0.9 <= found["strength"].min() < 0.91 and 1.09 < found["strength"].max() <= 1.1


@pytest.mark.parametrize(
    "n, seed, message",
    [
        pytest.param(0, 0, "n must be a whole number >= 1, got 0", id="n"),
        pytest.param(1, -1, "seed must be a whole number >= 0, got -1", id="seed"),
        pytest.param(True, 0, "n must be a whole number >= 1, got True", id="bool"),
    ],
)
def test_bad_arguments(n: int, seed: int, message: str) -> None:
    """n and seed are named with what they got."""
    with pytest.raises(ValueError) as caught:
        sample(legs(""), n, seed=seed)
    assert str(caught.value) == message


FAULTS = {
    "nominal unknown": (
        "armature: {scale: [0.9, 1.1]}", ", armature: unknown",
        "RND001 armature: hip, calf: armature is unknown, and the range is a factor on it",
    ),
    "offset on a nominal unknown": (
        "armature: {add: [-0.1, 0.1]}", ", armature: unknown",
        "RND001 armature: hip, calf: armature is unknown, and the range is an offset on it",
    ),
    "gain that is not there": (
        "kp: {abs: [1, 2]}", ", command: velocity",
        "RND002 kp: hip, calf: a drive of level ideal_pd and command velocity has no kp",
    ),
    "nothing has no Stribeck velocity": (
        "friction.stribeck_velocity: {abs: [0.1 rad/s, 0.2 rad/s]}", "",
        "RND002 friction.stribeck_velocity: hip, calf: the joint has no Stribeck velocity to draw",
    ),
    "factor on nothing": (
        "friction.coulomb: {scale: [0.5, 2]}", ", friction: {coulomb: 0}",
        "RND003 friction.coulomb: hip, calf: friction.coulomb is 0 N*m, and 0 times a factor stays 0",
    ),
    "factor on no delay": (
        "delay: {scale: [0.5, 2]}", "", "RND003 delay: hip, calf: delay is 0 s, and 0 times a factor stays 0",
    ),
    "below zero": (
        "friction.coulomb: {add: [-0.3, 0.3]}", "",
        # 0.2 − 0.3
        "RND004 friction.coulomb: hip, calf: friction.coulomb is drawn below 0: -0.1 N*m",
    ),
    "gaussian below zero": (
        "kp: {scale: [1, 0.5], distribution: gaussian}", "",
        # 20 · (1 − 3 · 0.5)
        "RND005 kp: hip, calf: kp is drawn below 0 within 3 std: -10 N*m/rad",
    ),
    "nominal outside, abs": (
        "kp: {abs: [21, 30]}", "",
        "RND006 kp: hip, calf: the nominal 20 N*m/rad is outside of the range of kp, 21 to 30: "
        "the nominal robot is never drawn",
    ),
    "nominal outside, scale": (
        "strength: {scale: [0.7, 0.9]}", "",
        "RND006 strength: hip, calf: 1 is outside of the range of strength, 0.7 to 0.9: "
        "the nominal robot is never drawn",
    ),
    "nominal outside, add": (
        "encoder_bias: {add: [0.01 rad, 0.02 rad]}", "",
        "RND006 encoder_bias: hip, calf: 0 is outside of the range of encoder_bias, 0.01 to 0.02: "
        "the nominal robot is never drawn",
    ),
    "kinetic above static": (
        "friction.coulomb: {scale: [0.5, 2]}", ", friction: {coulomb: 0.2, static: 0.3}",
        "RND007 friction.coulomb: hip, calf: coulomb friction up to 0.4 N*m meets static friction from 0.3 N*m: "
        "it is cut to the static one",
    ),
}  # fmt: skip


@pytest.mark.parametrize("randomize, more, expected", FAULTS.values(), ids=FAULTS)
def test_checks(randomize: str, more: str, expected: str) -> None:
    """Each range that cannot be drawn, or is a slip, is one message that names the joints."""
    numbers = {
        "kp": "kp: 20", "kd": "kd: 0.5", "effort_limit": "effort_limit: 30", "armature": "armature: 0.01",
        "friction": "friction: {coulomb: 0.2, viscous: 0.04}",
    }  # fmt: skip
    left = [text for key, text in numbers.items() if f"{key}:" not in more.replace("friction.", "")]
    if "velocity" in more:
        left.remove("kp: 20")
    group = (
        f"legs: {{joints: [hip, calf], level: ideal_pd, {', '.join(left)}{more}, randomize: {{{randomize}}}}}"
    )
    actuators = fit(spec_of(group, robot="name: leg, model: none, joints: [hip, calf]"))
    collector = Collector()
    check_ranges(actuators, collector)
    said = [f"{d.code} {d.where.removeprefix('actuators.legs.randomize.')}: {d.message}" for d in collector]
    assert said == [expected]
    assert collector.failed is (expected[:6] in ("RND001", "RND002", "RND003", "RND004"))
    if collector.failed:
        with pytest.raises(ResolveError):
            sample(actuators, 1, seed=0)


def test_sound_ranges_say_nothing() -> None:
    """A range around its nominal is not commented, not even where it ends there."""
    collector = Collector()
    check_ranges(legs("kp: {scale: [1, 1.2]}, kd: {abs: [0.4, 0.5]}, armature: {add: [-0.01, 0]}"), collector)
    assert list(collector) == []
