"""Our own robots, compiled for every target, and imported from what was written: the same figures come back."""

from __future__ import annotations

import math
from dataclasses import fields
from pathlib import Path

import pytest

from actspec import api
from actspec.diagnostics import ActspecError
from actspec.ir import ActuatorSet, Delay, JointActuator, Origin, Quantity
from tests.importing import dynamics, imported

ROOT = Path(__file__).resolve().parents[2]
ROBOTS = sorted(path.stem for path in (ROOT / "robots").glob("*.yaml"))

READ = {"mujoco": ".xml", "isaaclab": "_cfg.py", "mjlab": "_cfg.py", "deploy": "_deploy.yaml"}
"""Targets whose files an import reads, and how those end."""

NOBODYS = {
    "group", "pattern", "motor", "span", "motor_line", "peak_torque", "continuous_torque", "torque_constant",
    "reflected_inertia", "inertia_held", "inertia_free", "randomize", "network", "gear",
}  # fmt: skip
"""What no target's file has (figures of the motor behind the limits), what depends on names in the spec, and ranges,
which stand in files of their own."""

TOLERANCE = 1e-9
"""Relative; computed numbers are written with 12 digits."""


def figures(joint: JointActuator) -> dict[str, float | str | None]:
    """Field to number; what nobody states is None, as an import writes it."""
    found: dict[str, float | str | None] = {}
    for field in fields(joint):
        value = getattr(joint, field.name)
        if field.name in NOBODYS:
            continue
        if isinstance(value, Delay):
            found["delay_low"], found["delay_high"], found["sampling"] = value.low, value.high, value.sampling
            value = value.nominal
        if isinstance(value, Quantity):
            found[field.name] = None if value.origin in (Origin.DEFAULT, Origin.UNKNOWN) else value.value
        elif value is not None and field.name != "position_range":
            found[field.name] = str(value)
    return found


def same(one: float | str | None, other: float | str | None) -> bool:
    """Whether two figures are one, but for rounding."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=TOLERANCE, abs_tol=1e-12)
    return one == other


def written(spec: Path, folder: Path) -> tuple[ActuatorSet, dict[str, list[Path]]]:
    """What a spec resolves to, and the files of each target."""
    compilation = api.compile(spec, output=str(folder))
    files: dict[str, list[Path]] = {}
    for options, emission in zip(compilation.targets, compilation.emissions, strict=True):
        target = folder / options.name
        for file in emission.files:
            path = target / file.path
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(file.data)
            if file.path.endswith(READ.get(options.name, "\0")):
                files.setdefault(options.name, []).append(path)
    return compilation.actuators, files


@pytest.mark.slow
@pytest.mark.parametrize("robot", ROBOTS)
def test_import_of_what_was_compiled(robot: str, tmp_path: Path) -> None:
    """All files of a robot together give back its figures, groups of the same size, and the same MJCF once more."""
    try:
        first, files = written(ROOT / "robots" / f"{robot}.yaml", tmp_path / "one")
    except ActspecError as err:
        if "is not installed" in str(err):
            pytest.skip(str(err))
        raise
    assert set(files) == set(READ)
    found = imported([path for target in READ for path in files[target]], tmp_path)
    assert found.combined.disagreements == ()
    spec = tmp_path / "spec.yaml"
    spec.write_text(found.draft.text, encoding="utf-8")
    again = api.resolve(spec)
    assert [joint.joint for joint in again.joints] == [joint.joint for joint in first.joints]
    for old, new in zip(first.joints, again.joints, strict=True):
        before, after = figures(old), figures(new)
        assert {key: (before.get(key), after.get(key)) for key in {**before, **after}
                if not same(before.get(key), after.get(key))} == {}, old.joint  # fmt: skip
    assert (again.physics_dt.value, again.decimation) == (first.physics_dt.value, first.decimation)
    _, twice = written(spec, tmp_path / "two")
    (one,), (two,) = files["mujoco"], twice["mujoco"]
    now = dynamics(two)
    for name, joint in dynamics(one).joints.items():
        for field, figure in joint.figures.items():
            assert same(figure.value, now.joints[name].figures[field].value), (name, field)
