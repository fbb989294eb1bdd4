"""What a wrong figure is called: numbers by hand, chosen so that the nearest other reading gives another number."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from actspec.verify.classify import WrongFigure, classify
from actspec.verify.layout import _settings
from actspec.verify.readback import FileFigures

ASKED = {
    "kp": 40.0,
    "kd": 1.5,
    "joint_damping": 0.05,
    "frictionloss": 0.3,
    "effort_limit": 22.5,
    "armature": 0.0081,
    "no_load_speed": 30.0,
    "default_position": 0.1,
    "filter_cutoff": 20.0,
    "delay_low": 0.01,
}


def of(name: str, got: float | None, /, **more: object) -> tuple[str, str]:
    """What is said of one figure of the joint `hip` that is another one."""
    expected = ASKED[name]
    values: dict[str, object] = {
        "field": name,
        "expected": expected,
        "got": got,
        "asked": ASKED,
        "found": {**ASKED, name: got},
        "everywhere": {"hip": (expected, got)},
        "factors": (9.0,),
        **more,
    }
    return classify(WrongFigure(**values))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "field, got, code",
    [
        # 0.05 + 1.5; 1.5 alone; 2 x 0.05; 1.5 + 0.05; 2 x 1.5
        ("joint_damping", 1.55, "VFY101"),
        ("joint_damping", 1.5, "VFY101"),
        ("joint_damping", 0.1, "VFY101"),
        ("kd", 1.55, "VFY101"),
        ("kd", 3.0, "VFY101"),
        ("joint_damping", 0.3, "VFY102"),
        ("frictionloss", 0.05, "VFY102"),
        # 0.3 / 22.5; mN*m; kgf*cm: 0.3 N*m = 3.0591 kgf*cm
        ("frictionloss", 0.3 / 22.5, "VFY102"),
        ("frictionloss", 300.0, "VFY102"),
        ("frictionloss", 3.0591, "VFY102"),
        ("frictionloss", 0.25, "VFY110"),
        # 22.5 / 9; 0.0081 / 9; 0.0081 / 81; 30 x 9
        ("effort_limit", 2.5, "VFY103"),
        ("armature", 0.0009, "VFY103"),
        ("armature", 0.0001, "VFY103"),
        ("no_load_speed", 270.0, "VFY103"),
        ("effort_limit", 1e9, "VFY104"),
        ("effort_limit", 0.0, "VFY104"),
        ("effort_limit", None, "VFY104"),
        ("effort_limit", math.inf, "VFY104"),
        ("effort_limit", 20.0, "VFY110"),
        # 30 rad/s in rpm and in degrees; 40 N*m/rad in N*m/deg; 0.1 rad in degrees; 20 Hz in rad/s
        ("no_load_speed", 286.479, "VFY105"),
        ("no_load_speed", 1718.87, "VFY105"),
        ("kp", 0.698132, "VFY105"),
        ("default_position", 5.72958, "VFY105"),
        ("filter_cutoff", 125.664, "VFY105"),
        ("filter_cutoff", 19.0, "VFY110"),
        ("kp", -40.0, "VFY106"),
        ("default_position", -0.1, "VFY106"),
        ("armature", 0.01, "VFY107"),
        ("armature", 0.0, "VFY107"),
        ("delay_low", 0.005, "VFY108"),
        ("kp", 41.0, "VFY110"),
        ("kp", None, "VFY110"),
    ],
    ids=str,
)
def test_code(field: str, got: float | None, code: str) -> None:
    """A mistake that people make has its own code; any other number has none."""
    assert of(field, got)[0] == code


def test_swapped_joints() -> None:
    """Two joints with each other's numbers are swapped; with every sign turned, that is what is reported."""
    hips = {"left": (0.1, -0.1), "right": (-0.1, 0.1), "knee": (-0.8, -0.8)}
    assert of("default_position", -0.1, everywhere=hips)[0] == "VFY109"
    turned = {**hips, "knee": (-0.8, 0.8)}
    assert of("default_position", -0.1, everywhere=turned)[0] == "VFY106"


def test_kp_and_kd_swapped() -> None:
    """kp with kd's number, and kd with kp's."""
    found = {**ASKED, "kp": 1.5, "kd": 40.0}
    assert of("kp", 1.5, found=found) == ("VFY110", "kp and kd are swapped")


def test_friction_by_version() -> None:
    """Where the unit depends on the version, any other number is taken for the other unit's."""
    assert of("frictionloss", 0.25, versioned=True)[0] == "VFY102"
    written = {"field": "friction_setting", "expected": None, "everywhere": {"hip": (None, 0.3)}}
    assert of("frictionloss", 0.3, **written)[0] == "VFY102"


def test_a_mapping_that_forgets_and_a_gear() -> None:
    """What a mapping leaves out is 0, and no lost limit; a gear in the file explains all numbers of the drive."""
    assert of("effort_limit", 0.0, forgotten=True)[0] == "VFY109"
    assert of("kp", 3240.0, geared=True)[0] == "VFY103"


@pytest.mark.parametrize(
    ("got", "said"),
    [
        (1.0 / 60.0, None),
        (0.0166667, "the physics step is 0.0166667 s, and should be 0.0166666666667 s"),
        (0.02, "the physics step is 0.02 s, and should be 0.0166667 s"),
    ],
)
def test_a_step_is_told_with_the_digits_that_differ(got: float, said: str | None) -> None:
    asked: Any = SimpleNamespace(
        decimation=None, physics_dt=SimpleNamespace(value=1.0 / 60.0), control_period=None
    )
    fresh, built = (FileFigures("cfg.py", settings={"physics_dt": step}) for step in (1.0 / 60.0, got))
    target: Any = SimpleNamespace(name="isaaclab")
    (row,) = _settings(target, asked, fresh, built)
    assert (row.ok, row.message) == (said is None, said or "")
