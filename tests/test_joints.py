"""Words of joints' names."""

from __future__ import annotations

import pytest

from actspec.audit.rules.misnamed import is_misspelt
from actspec.joints import begin_alike, other_word
from actspec.readings.joint_names import renaming


@pytest.mark.parametrize(
    ("one", "other", "word"),
    [
        ("left_knee", "left_calf", ("knee", "calf")),
        ("LeftKnee", "LeftCalf", ("Knee", "Calf")),
        ("knee1_joint", "calf1_joint", ("knee", "calf")),
        ("HipPitchL", "HipPitchR", ("L", "R")),
        ("arm_j1", "arm_j2", ("1", "2")),
        ("r_arm_j1", "r_arm/j1", ("_", "/")),
        ("arm_a_to_arm_b", "leg_a_to_leg_b", ("arm", "leg")),
        ("left_knee", "right_calf", None),
        ("left_knee", "left_knee_joint", None),
        ("left_knee", "left_knee", None),
    ],
)
def test_the_word_in_which_two_names_differ(one: str, other: str, word: tuple[str, str] | None) -> None:
    assert other_word(one, other) == word
    assert other_word(other, one) == (word and word[::-1])


@pytest.mark.parametrize(
    ("one", "other", "misspelt"),
    [
        ("left_calf_joint", "left_calff_joint", True),
        ("LeftShoulder", "LeftSholder", True),
        ("FL_hip", "FR_hip", False),
        ("HipPitchL", "HipPitchR", False),
        ("LeftKneeX", "LeftKneeY", False),
        ("joint_1", "joint_2", False),
    ],
)
def test_a_letter_for_a_side_or_an_axis_is_no_slip(one: str, other: str, misspelt: bool) -> None:
    assert is_misspelt(one, other) is misspelt


@pytest.mark.parametrize(
    ("one", "other", "alike"),
    [
        ("left_knee", "LEFT_KNEE_JOINT", True),
        ("left_knee", "left-knee-motor", True),
        ("left_knee_joint", "left_knee_motor", False),
        ("", "left_knee", False),
    ],
)
def test_names_that_begin_alike(one: str, other: str, alike: bool) -> None:
    assert begin_alike(one, other) is alike
    assert begin_alike(other, one) is alike


@pytest.mark.parametrize(
    ("mine", "its", "found"),
    [
        ("l_hip r_hip l_knee r_knee", "l_hip r_hip l_calf r_calf", {"l_knee": "l_calf", "r_knee": "r_calf"}),
        ("LHip RHip LKnee RKnee", "LHip RHip LCalf RCalf", {"LKnee": "LCalf", "RKnee": "RCalf"}),
        ("l_arm_j1 a_b r_arm_j1 a_c", "l_arm/j1 a_b r_arm/j1 a_c",
         {"l_arm_j1": "l_arm/j1", "r_arm_j1": "r_arm/j1"}),
        ("a_to_a b l_hip r_hip", "c_to_c b l_hip r_hip", {"a_to_a": "c_to_c"}),
        ("l_hip l_knee r_knee", "l_hip l_calf r_calf", {}),
        ("l_hip r_hip l_knee r_knee", "l_hip r_hip l_calf r_ankle", {}),
    ],
)  # fmt: skip
def test_one_word_for_another_in_names(mine: str, its: str, found: dict[str, str]) -> None:
    one, other = frozenset(mine.split()), frozenset(its.split())
    assert renaming(one, other) == found
    assert renaming(other, one) == {called: name for name, called in found.items()}
