"""Which of two sides SYM101 names: the one whose figure is not the joint's own, on two legs, four legs and two arms."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings

LEG = {
    "hip_yaw": (88, 32),
    "hip_roll": (139, 20),
    "hip_pitch": (88, 32),
    "knee": (139, 20),
    "ankle": (50, 37),
}
"""A humanoid's, effort [N*m] and speed [rad/s]: one motor at yaw and pitch, another at roll and knee."""

PLAIN = dict.fromkeys(("hip_roll_joint", "hip_pitch_joint"), (24, 20)) | {"knee_joint": (46, 20)}
"""A biped's, whose file gives every joint one speed, so that limits alone tell the knee's gear."""

GEARED = PLAIN | {"knee_joint": (46, 10.4)}
"""The same where the knee has the speed of its gear."""

ARM = {f"joint{n}": (100, 2) if n < 5 else (30, 3) for n in range(1, 8)}

DOG = {"hip_roll": (20, 20), "hip_pitch": (30, 20), "knee": (45, 20)}


@pytest.mark.parametrize(
    ("limb", "slip"),
    [
        # 24 is the hips', in the file 4 times and once at the slip: what is commoner was taken from there.
        (PLAIN, ("knee_joint", 24, 20)),
        (GEARED, ("knee_joint", 24, 10.4)),
        (GEARED, ("knee_joint", 24, 20)),
        # Nobody has 20; the other hips have 24, and are called hips.
        (PLAIN, ("hip_pitch_joint", 20, 20)),
        # A digit too few is nobody's: 5 others have 24, though none of them is called a knee but the other one.
        (PLAIN | {"knee_joint": (24, 20)}, ("knee_joint", 2.4, 20)),
        # Hips behind the roll's own speed are none: of those with its motor 3 have 139.
        (LEG, ("hip_roll", 88, 20)),
        (LEG, ("hip_yaw", 139, 32)),
        (LEG, ("knee", 88, 20)),
        (LEG, ("knee", 88, 32)),
        # Of the joints 1 to 4 of both arms 7 have 100, of 5 to 7 5 have 30.
        (ARM, ("joint4", 30, 2)),
        (ARM, ("joint5", 100, 3)),
        (ARM, ("joint4", 60, 2)),
    ],
)
@pytest.mark.parametrize("side", ["left", "right"])
def test_the_side_is_named_whose_figure_is_not_its_own(
    limb: Mapping[str, tuple[float, float]], slip: tuple[str, float, float], side: str, tmp_path: Path
) -> None:
    assert _told(("left", "right"), limb, side, slip, tmp_path) == {f"{side}_{slip[0]}"}


@pytest.mark.parametrize("side", ["FL", "RR"])
def test_of_four_legs_the_joints_of_its_kind_tell(side: str, tmp_path: Path) -> None:
    # 3 rolls have 20; that 4 pitches have 30, with the word hip too, says nothing.
    assert _told(("FL", "FR", "RL", "RR"), DOG, side, ("hip_roll", 30, 20), tmp_path) == {f"{side}_hip_roll"}


def test_a_joint_without_its_like_is_told_beside_the_first(tmp_path: Path) -> None:
    # Neither 46 nor 40 is any other joint's: the first is the pattern.
    assert _told(("left", "right"), PLAIN, "left", ("knee_joint", 40, 20), tmp_path) == {"right_knee_joint"}


def _told(
    sides: tuple[str, ...],
    limb: Mapping[str, tuple[float, float]],
    side: str,
    slip: tuple[str, float, float],
    folder: Path,
) -> set[str]:
    """The joints of which SYM101 tells, in a URDF of a robot with such limbs, one joint of which has other limits."""
    text = '<robot name="machine"><link name="base"/>\n'
    for limb_side in sides:
        above = "base"
        for part, (effort, speed) in limb.items():
            name = f"{limb_side}_{part}"
            if (limb_side, part) == (side, slip[0]):
                _, effort, speed = slip
            text += (
                f'<link name="{name}_link"/><joint name="{name}" type="revolute">'
                f'<parent link="{above}"/><child link="{name}_link"/><axis xyz="0 1 0"/>'
                f'<limit lower="-2" upper="2" effort="{effort}" velocity="{speed}"/></joint>\n'
            )
            above = f"{name}_link"
    path = folder / "machine.urdf"
    path.write_text(f"{text}</robot>", encoding="utf-8")
    report = audit([str(path)], Settings(select=("SYM101",)))
    return {found.finding.joint for found in report.findings}


PIPER = ((-2.6, 2.6, 10, 1.0), (0.0, 3.1, 10, 0.9), (-2.9, 0.0, 10, 0.6), (-1.7, 1.7, 5, 0.4))
X5 = ((-3.1, 2.6, 27, 0.3), (0.0, 3.6, 27, 1.6), (0.0, 3.1, 27, 1.1), (-1.5, 1.5, 7, 0.2))
"""Range [rad], effort [N*m] and mass [kg] of the joints of two makers' arms."""

MIRRORED = tuple((-high, -low, effort, mass) for low, high, effort, mass in PIPER)


@pytest.mark.parametrize(
    ("right", "expected"),
    [
        # Of 20 joints 16 are the base's, which is the share at which two models are one machine.
        (X5, set()),
        # The right arm is the left one, and one of its joints has a digit too many.
        ((*MIRRORED[:2], (0.0, 2.9, 100, 0.6), MIRRORED[3]), {"joint3"}),
    ],
)
def test_two_files_of_one_base_with_an_arm_of_a_side(
    right: tuple[tuple[float, float, float, float], ...], expected: set[str], tmp_path: Path
) -> None:
    """Whether the arms are one is asked of the arms."""
    files = []
    for side, arm in (("left", PIPER), ("right", right)):
        legs = [
            (f"leg{n}_{part}", (-1.0, 2.0, 24, 1.0))
            for n in range(4)
            for part in ("hip", "thigh", "calf", "toe")
        ]
        text, above = f'<robot name="dog">{_link("base", 9.0)}\n', "base"
        for name, (low, high, effort, mass) in (*legs, *((f"joint{n}", own) for n, own in enumerate(arm, 1))):
            parent = "base" if name.endswith("hip") or name == "joint1" else above
            text += (
                f'{_link(f"{name}_link", mass)}<joint name="{name}" type="revolute"><parent link="{parent}"/>'
                f'<child link="{name}_link"/><axis xyz="0 1 0"/>'
                f'<limit lower="{low}" upper="{high}" effort="{effort}" velocity="{effort / 4}"/></joint>\n'
            )
            above = f"{name}_link"
        (tmp_path / side).mkdir()
        files.append(tmp_path / side / "robot.urdf")
        files[-1].write_text(f"{text}</robot>", encoding="utf-8")
    report = audit([*map(str, files)], Settings(select=("SYM101",)))
    assert {found.finding.joint for found in report.findings} == expected


def _link(name: str, mass: float) -> str:
    inertia = f'ixx="{mass / 500}" iyy="{mass / 500}" izz="{mass / 500}" ixy="0" ixz="0" iyz="0"'
    return f'<link name="{name}"><inertial><mass value="{mass}"/><inertia {inertia}/></inertial></link>'


@pytest.mark.parametrize(
    ("usual", "slip"),
    [
        # One motor, three kp and one kd: 1.6 is no joint's own.
        ({"hip": (40, 1.3), "knee": (35, 1.3), "ankle": (30, 1.3)}, ("ankle", 30, 1.6)),
        # A kd a joint: the knee has 4, and 2 was taken from the hip.
        ({"hip": (40, 2), "knee": (35, 4), "ankle": (30, 1)}, ("knee", 35, 2)),
    ],
)
@pytest.mark.parametrize("side", ["left", "right"])
def test_the_side_of_a_gain(
    usual: Mapping[str, tuple[float, float]], slip: tuple[str, float, float], side: str, tmp_path: Path
) -> None:
    bodies = servos = ""
    for limb in ("left", "right"):
        close = ""
        for part, (kp, kv) in usual.items():
            if (limb, part) == (side, slip[0]):
                _, kp, kv = slip
            name = f"{limb}_{part}"
            bodies += (
                '<body><inertial pos="0 0 .1" mass="1" diaginertia=".01 .01 .01"/>'
                f'<joint name="{name}" axis="0 1 0"/>'
            )
            servos += f'<position name="{name}" joint="{name}" kp="{kp}" kv="{kv}" forcerange="-24 24"/>'
            close += "</body>"
        bodies += close
    path = tmp_path / "biped.xml"
    path.write_text(
        f'<mujoco model="biped"><compiler angle="radian"/><worldbody>{bodies}</worldbody>'
        f"<actuator>{servos}</actuator></mujoco>",
        encoding="utf-8",
    )
    report = audit([str(path)], Settings(select=("SYM101",)))
    assert {found.finding.joint for found in report.findings} == {f"{side}_{slip[0]}"}
