"""The Isaac Lab, mjlab and randomisation targets: every number of a spec is in the text, or a loss names it."""

from __future__ import annotations

import ast
import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.property.targets_oracle import (
    DIALECTS,
    Drive,
    Oracle,
    by_joint,
    cfgs,
    compiled,
    dc,
    drives,
    isaaclab_losses,
    off,
    one_line,
    path_losses,
    robots,
    sizes_of,
    stuck,
)


def agree(joint: str, got: dict[str, float | None], want: dict[str, float | None], d: Drive) -> None:
    """The same fields at the same sizes."""
    assert set(got) == set(want), (joint, d)
    for field, size in want.items():
        found = got[field]
        assert (found is None) == (size is None), (joint, field, found, size, d)
        if found is not None and size is not None:
            assert math.isclose(found, size, rel_tol=1e-9, abs_tol=1e-9 * d.limit), (
                joint,
                field,
                found,
                size,
                d,
            )


def held(numbers: dict[str, Any], want: dict[str, float | None], where: object) -> None:
    """Exactly these numbers are written; None: the field is not there."""
    got = {field: numbers.get(field) for field in want}
    assert got == {field: None if v is None else pytest.approx(v, rel=1e-9) for field, v in want.items()}, (
        where
    )


@pytest.mark.slow
@given(
    groups=robots(), dialect=st.sampled_from(DIALECTS), cls=st.sampled_from(["auto", "implicit", "custom"])
)
@settings(deadline=None, max_examples=70)
def test_isaaclab_says_or_names_every_number(
    groups: list[Drive], dialect: tuple[str, str | None, str | None, str], cls: str
) -> None:
    """Each field of each joint is in the module in the version's own names, or lost at the size that it has."""
    version, sim, backend, friction = dialect
    cls = "auto" if version == "3.0" and cls == "custom" else cls
    emission = compiled(groups, kind="isaaclab", version=version, isaac_sim=sim, backend=backend, class_=cls)
    text = emission.files[0].data.decode()
    compile(text, "module", "exec")
    names = [name for drive in groups for name in drive.joints]
    numbers = by_joint(cfgs(text, "joint_names_expr"), "joint_names_expr", names)
    lost = sizes_of(emission.approximations)
    new = version == "3.0"
    model = "actuator_effort_limit" if new else "effort_limit"
    solver, fastest = (
        ("joint_effort_limit", "joint_velocity_limit") if new else ("effort_limit_sim", "velocity_limit_sim")
    )
    for drive in groups:
        o = Oracle(drive)
        limit = one_line(drive)[2] if cls == "auto" and drive.curve else drive.limit
        summed = friction in ("coefficient", "dead") and drive.command != "velocity"
        dry = {"effort": (drive.static if drive.static is not None else drive.coulomb, drive.coulomb),
               "one": (drive.coulomb, None)}.get(friction, (None, None))  # fmt: skip
        for joint in drive.joints:
            held(
                numbers[joint],
                {
                    "stiffness": drive.kp if drive.command == "position" else 0.0,
                    "damping": (drive.kd if drive.command != "effort" else 0.0)
                    + ((drive.viscous or 0.0) if summed else 0.0),
                    model: None if cls == "implicit" else limit,
                    solver: limit if new or cls == "implicit" else None,
                    fastest: drive.velocity_limit,
                    "armature": drive.armature,
                    "friction": dry[0],
                    "dynamic_friction": dry[1],
                    "viscous_friction": None if friction in ("coefficient", "dead") else drive.viscous,
                },
                (joint, drive),
            )
            found = lost.get(joint, {})
            if backend == "newton" and drive.velocity_limit is not None:
                assert found.pop("velocity_limit", 0.0) is None
            agree(joint, found, isaaclab_losses(drive, o, version, friction, cls), drive)


@pytest.mark.slow
@given(groups=robots(), version=st.sampled_from(["1.0", "1.2", "1.3", "1.6"]))
@settings(deadline=None, max_examples=40)
def test_mjlab_says_or_names_every_number(groups: list[Drive], version: str) -> None:
    """Each field of each joint is in the module, or lost at the size that it has."""
    emission = compiled(groups, kind="mjlab", version=version)
    text = emission.files[0].data.decode()
    compile(text, "module", "exec")
    names = [name for drive in groups for name in drive.joints]
    numbers = by_joint(cfgs(text, "target_names_expr"), "target_names_expr", names)
    lost = sizes_of(emission.approximations)
    for drive in groups:
        o = Oracle(drive)
        want = path_losses(drive, o, whole=False)
        if drive.curve:
            want["torque_speed_curve"] = o.against(dc(o.tau, o.w, *one_line(drive)))
        if stuck(drive):
            want["friction.static"] = (drive.static or 0.0) - (drive.coulomb or 0.0)
            if drive.stribeck is not None:
                want["friction.stribeck_velocity"] = want["friction.static"]
        if drive.velocity_limit is not None:
            want["velocity_limit"] = None
        old = version < "1.3"
        if old and drive.viscous is not None:
            want["friction.viscous"] = None
        _, low, high, _ = drive.delay or (None, 0, 0, "")
        if max(off(low), off(high)) > 1e-9:
            want["delay" if low == high else "delay.range"] = o.half
        dc_motor = drive.level == "dc_motor"
        for joint in drive.joints:
            # A class that takes both gains has the other at 0.
            zero = 0.0 if numbers[joint]["class"] in ("DcMotorActuatorCfg", "IdealPdActuatorCfg") else None
            held(
                numbers[joint],
                {
                    "stiffness": drive.kp if drive.command == "position" else zero,
                    "damping": drive.kd if drive.command != "effort" else zero,
                    "effort_limit": one_line(drive)[2] if drive.curve else drive.limit,
                    "saturation_effort": one_line(drive)[0] if dc_motor else None,
                    "velocity_limit": one_line(drive)[1] if dc_motor else None,
                    "armature": drive.armature,
                    "frictionloss": drive.coulomb,
                    "viscous_damping": None if old else drive.viscous,
                },
                (joint, drive),
            )
            agree(joint, lost.get(joint, {}), want, drive)


FIELDS = {"kp": "stiffness_distribution_params", "kd": "damping_distribution_params",
          "armature": "armature_distribution_params"}  # fmt: skip


@st.composite
def ranges(draw: st.DrawFn) -> dict[str, dict[str, Any]]:
    """Some fields' ranges, as factors: pair, distribution and time."""
    found = {}
    for field in draw(st.sets(st.sampled_from([*FIELDS, "gains"]), min_size=1)):
        kind = draw(st.sampled_from(["uniform", "log_uniform", "gaussian"]))
        pair = (
            [1.0, 0.1] if kind == "gaussian" else draw(st.sampled_from([[0.5, 1.5], [0.25, 1.0], [1.0, 3.0]]))
        )
        found[field] = {
            "scale": pair,
            "distribution": kind,
            "when": draw(st.sampled_from(["reset", "startup"])),
        }
    return found


def values(field: str, drive: Drive, factors: dict[str, dict[str, Any]]) -> tuple[str, float, float] | None:
    """Distribution and ends, or mean and deviation, of a field that is drawn by one range; None: by none, or two."""
    parts = [factors[f] for f in (field, "gains") if f in factors and (f == field or field in ("kp", "kd"))]
    nominal = {"kp": drive.kp, "kd": drive.kd, "armature": drive.armature}[field]
    if len(parts) != 1 or nominal is None:
        return None
    (low, high) = parts[0]["scale"]
    return parts[0]["distribution"], low * nominal, high * nominal


@pytest.mark.slow
@given(drive=drives(("a", "b")), factors=ranges(), dialect=st.sampled_from(DIALECTS))
@settings(deadline=None, max_examples=50)
def test_isaaclab_events_draw_the_spec_s_ranges(
    drive: Drive, factors: dict[str, dict[str, Any]], dialect: tuple[str, str | None, str | None, str]
) -> None:
    """A term on the config's number gives the field its range, also where `damping` holds more than kd."""
    drive = replace(drive, command="position", armature=0.02, delay=None)
    version, sim, backend, friction = dialect
    emission = compiled([drive], kind="randomization", version=version, isaac_sim=sim, backend=backend,
                        for_=("isaaclab",), randomize=factors)  # fmt: skip
    lost = {loss.field for loss in emission.approximations}
    terms = []
    for node in ast.walk(ast.parse(emission.files[0].data)):
        if isinstance(node, ast.Dict):
            given = {
                k.value: v for k, v in zip(node.keys, node.values, strict=True) if isinstance(k, ast.Constant)
            }
            given.pop("asset_cfg", None)
            terms.append({key: ast.literal_eval(value) for key, value in given.items()})
    beside = (drive.viscous or 0.0) if friction in ("coefficient", "dead") else 0.0
    for field, key in FIELDS.items():
        want = values(field, drive, factors)
        found = [term for term in terms if key in term]
        assert len(found) == (field in factors or ("gains" in factors and field != "armature"))
        if want is None:
            continue
        (term,) = found
        kind = term["distribution"]
        low, high = term[key]
        if term["operation"] == "scale":
            # Refused by the terms' constructors.
            assert low >= 0.0
            assert high >= low
            nominal = {"kp": drive.kp, "kd": drive.kd + beside, "armature": 0.02}[field]
            low, high = low * nominal, high * nominal
        if field == "kd":
            low, high = low - beside, high - (0.0 if kind == "gaussian" else beside)
        assert (low, high) == pytest.approx(want[1:], rel=1e-6, abs=1e-9)
        shifted = field == "kd" and beside > 0.0 and kind == "log_uniform"
        assert kind == want[0]
        assert (f"isaaclab.{field}" in lost or "isaaclab.gains" in lost) or not shifted
