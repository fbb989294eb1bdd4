"""Rules that compare files pair by pair, where a robot has many files."""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import combinations

from actspec.audit.case import Case
from actspec.audit.rules import ver105
from actspec.audit.rules.joints import by_joint, joint_pairs, partner_rows, shared_joints
from actspec.audit.rules.source_pairs import disagreements
from actspec.diagnostics import Span
from actspec.readings.artifact import Artifact, FileKind, Robot
from actspec.readings.ledger import LedgerRow


def _case(files: list[dict[str, float]], *robots: tuple[int, ...]) -> Case:
    """MJCFs with the armature of each joint."""
    artifacts = tuple(Artifact(f"{index}.xml", FileKind.MJCF, "leg") for index in range(len(files)))
    rows = tuple(
        LedgerRow(
            f"{index}.xml",
            index,
            Span(f"{index}.xml", line, 1),
            joint,
            "",
            "motor",
            armature=armature,
            stated=frozenset({"armature"}),
        )
        for index, joints in enumerate(files)
        for line, (joint, armature) in enumerate(joints.items(), 1)
    )
    return Case((), artifacts, rows, tuple(Robot("leg", members) for members in robots))


def _pairs(case: Case) -> list[tuple[int, int, str]]:
    """Pairs whose later file has ten times the armature of the earlier."""
    found = joint_pairs(
        case,
        lambda row: row.armature,
        lambda one, other: (other.armature or 0.0) == 10.0 * (one.armature or 0.0),
    )
    return [(one.artifact, other.artifact, one.joint) for one, other in found]


def test_pairs_come_in_the_files_order() -> None:
    """File by file, then by the joints of the earlier one; equal figures are told for each file."""
    files = [{"hip": 1.0, "knee": 1.0}, {"knee": 10.0, "hip": 10.0}, {"knee": 1.0}, {"hip": 10.0}]
    case = _case(files, (0, 1, 2, 3))
    # 1 has the hip after the knee, which does not count; 1 to 2 goes from 10 to 1.
    assert _pairs(case) == [(0, 1, "hip"), (0, 1, "knee"), (0, 3, "hip")]


def test_pairs_against_all_pairs() -> None:
    """As asking of every two files one by one."""
    chance = random.Random(3)
    for _ in range(200):
        names = ["hip", "knee", "ankle"]
        files = [
            {
                name: chance.choice([0.0, 1.0, 10.0, 100.0])
                for name in chance.sample(names, chance.randint(1, 3))
            }
            for _ in range(6)
        ]
        expected = [
            (one, other, joint)
            for robot in ((0, 2, 3, 5), (1, 4))
            for one, other in combinations(robot, 2)
            for joint in files[one]
            if files[other].get(joint) == 10.0 * files[one][joint]
        ]
        assert _pairs(_case(files, (0, 2, 3, 5), (1, 4))) == expected


def test_shared_joints() -> None:
    """Joints that one file has alone, and those of other robots, are left out."""
    case = _case([{"hip": 1.0, "knee": 1.0}, {"knee": 2.0}, {"hip": 3.0}], (0, 1), (2,))
    assert [[(row.artifact, row.joint) for row in rows] for rows in shared_joints(case)] == [
        [(0, "knee"), (1, "knee")]
    ]


def test_partners_are_of_the_kinds_asked_for() -> None:
    """In the files' order; none where the robot has no file of such a kind, though another robot has."""
    case = _case([{"hip": 1.0}, {"hip": 2.0}, {"hip": 3.0}, {"hip": 4.0}], (0, 1, 2), (3,))
    kinds = (FileKind.MJCF, FileKind.CFG, FileKind.URDF, FileKind.DEPLOY)
    artifacts = tuple(replace(one, kind=kind) for one, kind in zip(case.artifacts, kinds, strict=True))
    case = replace(case, artifacts=artifacts)

    def partners(*wanted: FileKind) -> list[int]:
        return [row.artifact for row in partner_rows(case, case.rows[0], *wanted)]

    assert partners() == [1, 2]
    assert partners(FileKind.URDF, FileKind.CFG) == [1, 2]
    assert partners(FileKind.URDF) == [2]
    assert partners(FileKind.DEPLOY) == []
    # Its own kind is among the robot's, and it is no partner of itself.
    assert partners(FileKind.MJCF) == []
    assert by_joint(case, *kinds) == case.joints
    assert list(by_joint(case, FileKind.CFG, FileKind.DEPLOY)) == [(1, "hip"), (3, "hip")]


def test_rows_by_artifact() -> None:
    """Rows without a joint are in none of its joints; an artifact without rows has neither."""
    case = _case([{"hip": 1.0}, {}, {"hip": 2.0}], (0, 1, 2))
    loose = replace(case.rows[1], joint="")
    case = replace(case, rows=(*case.rows, loose, case.rows[1]))
    assert [len(case.rows_of(index)) for index in range(3)] == [1, 0, 3]
    assert case.joints_by_artifact == {0: {"hip": [case.rows[0]]}, 2: {"hip": [case.rows[1]] * 2}}
    assert case.joints[2, "hip"] is case.joints_by_artifact[2]["hip"]


def test_what_rules_share_is_made_once() -> None:
    """For one case; another case, though equal, has its own."""
    case = _case([{"hip": 1.0}], (0,))
    calls: list[Case] = []

    def make(given: Case) -> int:
        calls.append(given)
        return len(calls)

    assert [case.once(make), case.once(make), replace(case).once(make)] == [1, 1, 2]
    assert calls[0] is case


def test_a_file_that_agrees_with_one_of_many_is_right() -> None:
    """1 departs from 0, 2 is as 1, 3 as 0 but for rounding, 4 as none: the first file is named."""
    case = _case([{"hip": armature} for armature in (0.01, 0.03, 0.03, 0.010001, 0.05)], (0, 1, 2, 3, 4))
    found = [
        (one.mine.value, one.theirs.value, one.variant, one.rows[0].artifact, one.copy)
        for one in disagreements(case, ["armature"], 0.01)
    ]
    assert found == [(0.03, 0.01, True, 1, False), (0.03, 0.01, True, 2, True), (0.05, 0.01, True, 4, False)]
    # 3 alone would be told if it had to be equal: 0.010001 / 0.01 - 1 is 1e-4.
    assert len([one for one in disagreements(case, ["armature"], 1e-5) if not one.copy]) == 3


def test_two_artifacts_of_one_file_are_not_compared() -> None:
    """Equal figures in the same file confirm nothing; those of another file do."""
    case = _case([{"hip": 0.01}, {"hip": 0.03}, {"hip": 0.03}], (0, 1, 2))
    case = Case((), (*case.artifacts[:2], case.artifacts[1]), case.rows, case.robots)
    found = [one.rows[0].artifact for one in disagreements(case, ["armature"], 0.01)]
    assert found == [1, 2]


def test_each_feature_of_mujoco_has_a_word() -> None:
    """A file without the words of a feature is not parsed for it, so none may lack them."""
    tables = (
        ver105._OF_JOINT,
        ver105._OF_TENDON,
        ver105._OF_ACTUATOR,
        ver105._OF_TAG,
        ver105._VALUES,
    )
    features = {feature for table in tables for feature in table.values()}
    features |= {value for value in vars(ver105).values() if isinstance(value, ver105.Feature)}
    assert features == {feature for feature, _ in ver105.WORDS}
