"""Mistakes as people make them in a spec, one in each: they are reported at the line that has them."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from actspec import api
from actspec.diagnostics import ActspecError, Diagnostic
from actspec.spec.plausible import BY_CODE

ROBOTS = Path(__file__).resolve().parents[3] / "robots"

MISTAKES = {
    # name: spec, the file that has the mistake, what stands there, what is typed, code
    "peak-above-stall": (
        "a1",
        "a1",
        "peak_torque: {value: 33.5 N*m",
        "peak_torque: {value: 335 N*m",
        "SPEC180",
    ),
    "stall-and-continuous-exchanged": (
        "a1",
        "a1",
        "stall_torque: {value: 33.5 N*m, source: isaaclab_a1}     # saturation_effort there\n"
        "    no_load_speed: {value: 21 rad/s, source: isaaclab_a1}    # velocity_limit there; the URDF agrees\n"
        "    peak_torque: {value: 33.5 N*m, source: a1_urdf}\n"
        "    continuous_torque: unknown",
        "stall_torque: {value: 12 N*m, source: isaaclab_a1}\n"
        "    no_load_speed: {value: 21 rad/s, source: isaaclab_a1}\n"
        "    peak_torque: unknown\n"
        "    continuous_torque: 33.5 N*m",
        "SPEC180",
    ),
    "gear-inverse": (
        "go2",
        "motors/unitree_go",
        "gear_ratio: {value: 6,",
        "gear_ratio: {value: 0.1667,",
        "SPEC182",
    ),
    "rotor-inertia-g-cm2-as-kg-m2": (
        "go2",
        "motors/unitree_go",
        "rotor_inertia: {value: 0.000111842 kg*m^2",
        "rotor_inertia: {value: 1118.42 kg*m^2",
        "SPEC185",
    ),
    "rotor-inertia-kg-cm2-as-kg-m2": (
        "go2",
        "motors/unitree_go",
        "rotor_inertia: {value: 0.000111842 kg*m^2",
        "rotor_inertia: {value: 1.11842 kg*m^2",
        "SPEC185",
    ),
    "output-inertia-as-rotor-inertia": (
        "so101",
        "motors/feetech",
        "reflected_inertia: {value: 0.0284034 kg*m^2",
        "rotor_inertia: {value: 0.0284034 kg*m^2",
        "SPEC185",
    ),
    "armature-without-gear": (
        "go2",
        "go2",
        "    friction:                    # passive",
        "    armature: 0.000111842 kg*m^2\n    friction:                    # passive",
        "SPEC191",
    ),
    "armature-g-m2-as-kg-m2": (
        "a1",
        "a1",
        "armature: {value: 0.01 kg*m^2",
        "armature: {value: 12 kg*m^2",
        "SPEC191",
    ),
    "kp-and-kd-exchanged": (
        "a1",
        "a1",
        "kp: {value: 25 N*m/rad, source: isaaclab_a1}\n    kd: {value: 0.5 N*m*s/rad",
        "kp: {value: 0.5 N*m/rad, source: isaaclab_a1}\n    kd: {value: 25 N*m*s/rad",
        "SPEC192",
    ),
    "gains-per-degree": (
        "h1",
        "h1",
        "kp: {value: 200 N*m/rad, source: rl_gym_robot}\n    kd: {value: 4 N*m*s/rad",
        "kp: {value: 3.49 N*m/rad, source: rl_gym_robot}\n    kd: {value: 0.0698 N*m*s/rad",
        "SPEC192",
    ),
    "gains-times-57.3": ("go2", "go2", "kp: {value: 25 N*m/rad", "kp: {value: 1432 N*m/rad", "SPEC192"),
    "kd-per-degree": ("a1", "a1", "kd: {value: 0.5 N*m*s/rad", "kd: {value: 0.00873 N*m*s/rad", "SPEC192"),
    "pose-outside-the-range": (
        "a1",
        "a1",
        '".*_calf_joint": {value: -1.5 rad',
        '".*_calf_joint": {value: 1.5 rad',
        "SPEC190",
    ),
    "pose-in-degrees": (
        "h1",
        "h1",
        '".*_knee_joint": {value: 0.3 rad',
        '".*_knee_joint": {value: 17.2 rad',
        "SPEC190",
    ),
    "torque-constant-mN-m-per-A": (
        "so101",
        "motors/feetech",
        "torque_constant: {value: 1.21164 N*m/A",
        "torque_constant: {value: 1211.64 N*m/A",
        "SPEC181",
    ),
    "rpm-as-rad-per-s": (
        "a1",
        "a1",
        "no_load_speed: {value: 21 rad/s",
        "no_load_speed: {value: 201 rad/s",
        "SPEC184",
    ),
    "output-figures-as-the-rotors": ("go2", "motors/unitree_go", "side: joint", "side: motor", "SPEC184"),
    "rotor-speed-as-the-outputs": (
        "go2",
        "motors/unitree_go",
        "no_load_speed: {value: 30.1 rad/s",
        "no_load_speed: {value: 180.6 rad/s",
        "SPEC184",
    ),
    "output-figures-of-a-servo-as-the-rotors": (
        "so101",
        "motors/feetech",
        "side: joint",
        "side: motor",
        "SPEC184",
    ),
    "torque-of-the-wrong-side": (
        "h1",
        "motors/unitree_m107",
        "side: joint\n    peak_torque: {value: 200 N*m, source: h1_urdf}\n    continuous_torque: unknown\n"
        "    gear_ratio: unknown ",
        "side: motor\n    peak_torque: {value: 200 N*m, source: h1_urdf}\n    continuous_torque: unknown\n"
        "    gear_ratio: 15 ",
        "SPEC187",
    ),
    "friction-mN-m-as-N-m": ("a1", "a1", "coulomb: {value: 0.2 N*m", "coulomb: {value: 200 N*m", "FRC101"),
    "friction-above-the-motors-limit": (
        "so101",
        "so101",
        "coulomb: {value: 0.0523930 N*m",
        "coulomb: {value: 5.23930 N*m",
        "FRC101",
    ),
    "viscous-times-57.3": (
        "go2",
        "go2",
        "viscous: {value: 0.1 N*m*s/rad",
        "viscous: {value: 5.73 N*m*s/rad",
        "FRC106",
    ),
    "action-scale-25": ("a1", "a1", "action_scale: {value: 0.25", "action_scale: {value: 25", "SPEC193"),
    "effort-limit-mN-m-as-N-m": (
        "h1",
        "h1",
        "effort_limit: {value: 300 N*m",
        "effort_limit: {value: 300000 N*m",
        "SPEC187",
    ),
    "delay-s-for-ms": (
        "a1",
        "a1",
        "    action_scale:",
        "    delay: 20 s\n    action_scale:",
        "SPEC186",
    ),
    "factor-in-per-cent": (
        "a1",
        "a1",
        "scale: [{value: 0.9, source: walk_these_ways}, {value: 1.1, source",
        "scale: [{value: 0.9, source: walk_these_ways}, {value: 110, source",
        "SPEC188",
    ),
    "encoder-bias-in-degrees": (
        "a1",
        "a1",
        "walk_these_ways}, {value: 0.02 rad",
        "walk_these_ways}, {value: 2 rad",
        "SPEC188",
    ),
    "kd-times-57.3": ("a1", "a1", "kd: {value: 0.5 N*m*s/rad", "kd: {value: 28.65 N*m*s/rad", "SPEC192"),
    "kp-per-degree": ("a1", "a1", "kp: {value: 25 N*m/rad", "kp: {value: 0.436 N*m/rad", "SPEC192"),
    "kp-unit-per-degree": ("a1", "a1", "kp: {value: 25 N*m/rad", "kp: {value: 25 N*m/deg", "SPEC192"),
    "damping-ratio-in-per-cent": (
        "go1",
        "go1",
        "ratio: {value: 2, source: mjlab_go1}, inertia: reflected}",
        "ratio: {value: 200, source: mjlab_go1}, inertia: reflected}",
        "SPEC192",
    ),
    "natural-frequency": ("go1", "go1", "frequency: {value: 10 Hz", "frequency: {value: 1000 Hz", "SPEC192"),
    "armature-unit": (
        "a1",
        "a1",
        "armature: {value: 0.01 kg*m^2",
        "armature: {value: 0.000001 kg*m^2",
        "SPEC191",
    ),
    "reduction-inverse": ("go1", "go1", "reduction: {value: 1.5", "reduction: {value: 0.667", "SPEC182"),
    # The effort limit of 45.43 N*m agrees with the right one.
    "reduction-inverse-beside-a-limit": (
        "go2",
        "go2",
        "reduction: {value: 1.9169",
        "reduction: {value: 0.5217",
        "SPEC182",
    ),
    "velocity-limit-in-rpm": (
        "go1",
        "go1",
        "velocity_limit: {value: 30.1 rad/s",
        "velocity_limit: {value: 287 rad/s",
        "SPEC184",
    ),
    "effort-limit-a-tenth": (
        "a1",
        "a1",
        "effort_limit: {value: 33.5",
        "effort_limit: {value: 3.35",
        "SPEC187",
    ),
    "rotor-figures-as-the-outputs": ("spot", "spot", "side: motor ", "side: joint ", "SPEC187"),
    "gear-with-two-zeros": (
        "go1",
        "motors/unitree_go",
        "gear_ratio: {value: 6,",
        "gear_ratio: {value: 600,",
        "SPEC184",
    ),
    "stall-torque-in-mN-m": (
        "a1",
        "a1",
        "stall_torque: {value: 33.5",
        "stall_torque: {value: 33500",
        "SPEC183",
    ),
    "factors-in-per-cent": (
        "a1",
        "a1",
        "scale: [{value: 0.9, source: walk_these_ways}, {value: 1.1, source",
        "scale: [{value: 90, source: walk_these_ways}, {value: 110, source",
        "SPEC188",
    ),
    "step-s-for-ms": ("a1", "a1", "physics_dt: {value: 5 ms", "physics_dt: {value: 5 s", "SPEC186"),
    "step-us-for-ms": ("so101", "so101", "physics_dt: 5 ms", "physics_dt: 5 us", "SPEC186"),
    "filter-kHz-for-Hz": (
        "a1",
        "a1",
        "    action_scale:",
        "    command_filter: {cutoff: 30 kHz}\n    action_scale:",
        "SPEC186",
    ),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The robot library, to make mistakes in."""
    path = tmp_path_factory.mktemp("mistakes") / "robots"
    shutil.copytree(ROBOTS, path)
    return path


def doubts(path: Path) -> list[Diagnostic]:
    """What the checks of numbers report of a spec, errors or not."""
    try:
        found = api.resolve(path).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    return [item for item in found if item.code in BY_CODE]


@pytest.mark.slow
@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_reported_at_its_line(name: str, folder: Path) -> None:
    spec, mistaken, right, wrong, code = MISTAKES[name]
    file = folder / f"{mistaken}.yaml"
    text = file.read_text(encoding="utf-8")
    assert text.count(right) >= 1
    typed = text.replace(right, wrong, 1)
    try:
        file.write_text(typed, encoding="utf-8")
        found = doubts(folder / f"{spec}.yaml")
    finally:
        file.write_text(text, encoding="utf-8")
    first = typed[: text.index(right)].count("\n") + 1
    expected = set(range(first, first + wrong.count("\n") + 1))
    places = [(item.code, item.span.path, item.span.line) for item in found if item.span is not None]
    assert any((code, str(file), line) in places for line in expected), [str(item) for item in found]
    assert len(found) == 1, [str(item) for item in found]


def test_the_same_specs_without_mistakes_are_sound(folder: Path) -> None:
    """Nothing is reported of what the mistakes are made in."""
    assert len(MISTAKES) >= 20
    for spec in ("a1", "go1", "go2", "h1", "so101", "spot"):
        assert doubts(folder / f"{spec}.yaml") == []
