"""Which joint belongs to which group."""

from __future__ import annotations

import pytest

from actspec.diagnostics import ResolveError, Severity
from tests.fitting import NONE, fit, joint, refused, spec_of

PD = "level: ideal_pd, kp: 25, kd: 0.5"
TREE = """<mujoco model="tree"><worldbody><body><joint name="a" axis="0 1 0"/><geom size="0.1" mass="1"/><body>
<joint name="b" axis="0 1 0"/><geom size="0.1" mass="1"/><body><joint name="c" axis="0 1 0"/>
<geom size="0.1" mass="1"/></body></body></body></worldbody>
<tendon><fixed name="t"><joint joint="c" coef="1"/></fixed></tendon><actuator>%s</actuator></mujoco>"""


def robot(groups: str, more: str = "") -> str:
    """A spec for TREE."""
    return spec_of(groups, robot=f"name: r, model: robot.xml{more}")


def test_full_match() -> None:
    """A pattern matches whole names: `hip` is not `hip_left`."""
    text = spec_of(
        f"a: {{joints: [hip], {PD}}}, b: {{joints: [hip_left], {PD}}}",
        robot="name: r, model: none, joints: [hip_left, hip]",
    )
    found = fit(text)
    assert [(j.joint, j.group, j.pattern) for j in found.joints] == [
        ("hip_left", "b", "hip_left"),
        ("hip", "a", "hip"),
    ]


def test_one_group_may_match_a_joint_twice() -> None:
    """Two patterns of one group on one joint are no conflict; the first is kept as its pattern."""
    text = spec_of(f'a: {{joints: ["h.*", ".*p", calf, slide], {PD}}}')
    assert joint(text, "hip").pattern == "h.*"


def test_two_groups_for_one_joint() -> None:
    """A joint in two groups is an error that names both patterns and the other's place."""
    assert refused(spec_of(f'a: {{joints: ["h.*"], {PD}}}, b: {{joints: [".*"], {PD}}}')) == [
        "BIND002 actuators.b.joints[0]: the joint 'hip' is in two groups: 'b' by '.*' and 'a' by 'h.*' "
        "(s.yaml:4:26)"
    ]


def test_several_joints_in_two_groups_are_one_error() -> None:
    """One pattern takes them all, and the joint that is in no group is its doing too."""
    text = spec_of(f'a: {{joints: [hip, calf], {PD}}}, b: {{joints: ["hip|calf"], {PD}}}')
    assert refused(text) == [
        "BIND002 actuators.b.joints[0]: the joints hip, calf are in two groups: 'b' by 'hip|calf' and 'a' by "
        "'hip', 'calf' (s.yaml:4:26)"
    ]
    assert refused(text.replace("[hip, calf]", '["hip|c.*"]')) == [
        "BIND002 actuators.b.joints[0]: the joints hip, calf are in two groups: 'b' by 'hip|calf' and 'a' by "
        "'hip|c.*' (s.yaml:4:26)"
    ]


def test_a_joint_of_two_groups_of_two_kinds_is_one_error() -> None:
    """Nothing tells which group is meant, and so nothing is said of what the slide lacks among hinges."""
    hinges = PD.replace("25", "25 N*m/rad")
    slides = PD.replace("25", "25 N/m")
    text = spec_of(f"a: {{joints: [hip, calf, slide], {hinges}}}, b: {{joints: [slide], {slides}}}")
    (told,) = refused(text)
    assert told.startswith(
        "BIND002 actuators.b.joints[0]: the joint 'slide' is in two groups: 'b' by 'slide' and 'a'"
    )
    # In one group alone it is told.
    (told,) = refused(spec_of(f"a: {{joints: [hip, calf, slide], {hinges}}}"))
    assert told.startswith("RES001 actuators.a.kp: slide: ")


def test_a_greedy_pattern_is_one_error() -> None:
    """It is told, wherever it stands, with the joint that is unmanaged; the units of its slide follow from it."""
    greedy, narrow = (
        f'b: {{joints: [".*"], {PD} N*m*s/rad}}'.replace("25", "25 N*m/rad"),
        f"a: {{joints: [hip], {PD}}}",
    )
    told = "BIND002 actuators.b.joints[0]: the joint 'hip' is in two groups: 'b' by '.*' and 'a' by 'hip' "
    told += "(s.yaml:4:{})"
    assert refused(spec_of(f"{narrow}, {greedy}")) == [told.format(26)]
    # It stands behind the greedy group and `, `.
    assert refused(spec_of(f"{greedy}, {narrow}")) == [told.format(26 + len(greedy) + 2)]
    text = spec_of(f"{narrow}, {greedy}", robot=NONE + ", unmanaged: [slide]")
    column = text.splitlines()[1].rindex("slide") + 1
    assert refused(text) == [told.format(26) + f"; slide unmanaged (s.yaml:2:{column}) and in it too"]
    with pytest.raises(ResolveError) as refusal:
        fit(text)
    (item,) = refusal.value.diagnostics
    assert (
        item.help
        == "narrow it to calf, in no other group; to change one field of some joints use `overrides`"
    )


def test_the_help_names_no_joint_of_a_third_group() -> None:
    """Both patterns have the calf beside the hip: neither has it alone."""
    text = spec_of(
        f'a: {{joints: [hip], {PD}}}, b: {{joints: ["hip|calf"], {PD}}}, c: {{joints: ["h.*|c.*"], {PD}}}'
    )
    with pytest.raises(ResolveError) as refusal:
        fit(text)
    twice = [item for item in refusal.value.diagnostics if item.code == "BIND002"]
    assert len(twice) > 1
    assert {item.help for item in twice} == {
        "make the patterns disjoint; to change one field of some joints use `overrides`"
    }


def test_unmanaged_joints_of_a_group_are_one_error() -> None:
    """However many the pattern has."""
    text = spec_of(f"a: {{joints: [hip, calf, slide], {PD}}}", robot=NONE + ', unmanaged: ["h.*|c.*"]')
    assert refused(text) == [
        "BIND003 robot.unmanaged[0]: the joints hip, calf are unmanaged by 'h.*|c.*' and in the group 'a'"
    ]


def test_an_override_of_a_joint_in_no_group() -> None:
    """Of one in another group nothing is said of that."""
    text = "a: {joints: [hip], %s, overrides: {calf: {kp: 1}}}, b: {joints: [%s], %s}"
    for joints, help in (
        ("slide", "it matches calf, outside the group; that is in no group: missing from `joints` here?"),
        ("calf, slide", "it matches calf, outside the group"),
    ):
        with pytest.raises(ResolveError) as refusal:
            fit(spec_of(text % (PD, joints, PD)))
        (item,) = refusal.value.diagnostics
        assert (item.code, item.help) == ("BIND001", help)


def test_joints_left_out() -> None:
    """A robot without a file has no passive joints: each is in a group or unmanaged."""
    assert refused(spec_of(f"a: {{joints: [hip], {PD}}}")) == [
        "BIND005 actuators: 2 joints of 'leg' in no group: calf, slide"
    ]
    found = fit(spec_of(f"a: {{joints: [hip], {PD}}}", robot=NONE + ', unmanaged: ["c.*", slide]'))
    assert found.unmanaged == ("calf", "slide")


def test_the_group_of_the_nearest_joint_is_named() -> None:
    """`l_ankle` is in `feet`; of two joints that are near to those of two groups none is named."""
    listed = "name: leg, model: none, joints: [l_ankle, r_ankle, l_knee, r_knee]"
    for joints, hint in (("l_knee, r_knee", " (`feet` has l_ankle)"), ("l_knee", "")):
        with pytest.raises(ResolveError) as refusal:
            fit(
                spec_of(
                    f"feet: {{joints: [l_ankle], {PD}}}, knees: {{joints: [{joints}], {PD}}}", robot=listed
                )
            )
        (item,) = refusal.value.diagnostics
        assert item.code == "BIND005"
        assert item.help == f"add them to a group{hint}, or to robot.unmanaged to leave them as they are"


def test_a_joint_without_actuator_may_be_left_out() -> None:
    """A joint that the file does not drive is left as it is, and that is said once."""
    found = fit(robot(f"g: {{joints: [b], {PD}}}"), TREE % '<motor joint="b"/><motor tendon="t"/>')
    assert found.unmanaged == ("a", "c")
    notes = [d for d in found.diagnostics if d.code == "BIND007"]
    assert [(d.severity, d.message) for d in notes] == [
        (
            Severity.INFO,
            "2 joints of 'tree' in no group and without an actuator in the model: left as they are: a, c",
        )
    ]


def test_a_driven_joint_may_not_be_left_out() -> None:
    """Of two joints in no group, the one with an actuator is the error."""
    said = refused(robot(f"g: {{joints: [b], {PD}}}"), TREE % '<motor joint="b"/><motor joint="a"/>')
    assert [line.split(":")[0] for line in said] == ["BIND005 actuators", "BIND007 actuators"]
    assert said[0].endswith("in no group: a")
    assert said[1].endswith("left as they are: c")


def test_a_file_without_actuators_cannot_tell() -> None:
    """Where the file drives nothing, every joint must be spoken of."""
    said = refused(robot(f"g: {{joints: [b], {PD}}}"), TREE % "")
    assert [line.split(":")[0] for line in said] == ["BIND005 actuators"]
    assert said[0].endswith("in no group: a, c")


def test_override_outside_its_group() -> None:
    """An override matches joints of its own group only, and the help would name the others."""
    text = spec_of(
        f"a: {{joints: [hip], {PD}, overrides: {{calf: {{kp: 1}}}}}}, b: {{joints: [calf, slide], {PD}}}"
    )
    assert refused(text) == [
        "BIND001 actuators.a.overrides.calf: the pattern 'calf' matches no joint of the group 'a'"
    ]


def test_default_pose() -> None:
    """Patterns give positions; joints that match none are at 0, and say that nobody chose it."""
    text = spec_of(
        f'a: {{joints: [".*"], {PD}}}', robot=NONE + ', default_pose: {"h.*": 30 deg, slide: 5 cm}'
    )
    found = fit(text)
    assert [j.default_position.value for j in found.joints] == [0.5235987755982988, 0.0, 0.05]
    assert [j.default_position.origin.value for j in found.joints] == ["authored", "default", "authored"]


def test_order_is_the_robots() -> None:
    """The IR has the robot's joint order, whatever the spec's."""
    text = spec_of(f"z: {{joints: [slide], {PD}}}, a: {{joints: [calf, hip], {PD}}}")
    assert [j.joint for j in fit(text).joints] == ["hip", "calf", "slide"]


ANOTHER = "name: r, model: none, joints: [LF_HAA, LF_HFE, LF_KFE, RF_HAA, RF_HFE, RF_KFE]"


@pytest.mark.parametrize(
    ("groups", "pose", "expected"),
    [
        # All in one list: the list as it is to be.
        (
            "a: {joints: [lf_haa, rf_haa, lf_hfe, RF_HFE], PD}, b: {joints: [LF_KFE, RF_KFE], PD}",
            "",
            (
                "BIND001 actuators.a.joints[0]: the patterns 'lf_haa', 'rf_haa', 'lf_hfe' match no joint of 'r'",
                "write [LF_HAA, RF_HAA, LF_HFE, RF_HFE]",
            ),
        ),
        (
            'a: {joints: [".*_haa", "[lr]f_hfe"], PD}, b: {joints: [".*_KFE"], PD}',
            "",
            (
                "BIND001 actuators.a.joints[0]: the pattern '.*_haa' matches no joint of 'r'",
                "did you mean '.*_HAA'? (matches LF_HAA, RF_HAA)",
            ),
        ),
        # In several: once, with the lines.
        (
            'a: {joints: [".*_haa", ".*_HFE"], PD, overrides: {"rf_.*": {kp: 2}}}, b: {joints: [".*_KFE"], PD}',
            ', default_pose: {".*_haa": 0.1 rad}',
            (
                "BIND001 actuators.a.joints[0]: the patterns '.*_haa', 'rf_.*' match no joint of 'r'",
                "write '.*_HAA', 'RF_.*' (lines 2, 4)",
            ),
        ),
        # One pattern, in two places.
        (
            'a: {joints: [".*_haa", ".*_HFE", ".*_KFE"], PD}',
            ', default_pose: {".*_haa": 0.1 rad}',
            (
                "BIND001 actuators.a.joints[0]: the pattern '.*_haa' matches no joint of 'r'",
                "write '.*_HAA' (lines 2, 4)",
            ),
        ),
    ],
)
def test_names_in_other_letters_are_told_once(groups: str, pose: str, expected: tuple[str, str]) -> None:
    """However many they are: the cause with what to write; one alone has its own answer."""
    with pytest.raises(ResolveError) as refusal:
        fit(spec_of(groups.replace("PD", PD), robot=ANOTHER + pose))
    found = [item for item in refusal.value.diagnostics if item.code == "BIND001"]
    both = ", whose names have other capital letters: LF_HAA, LF_HFE, LF_KFE, RF_HAA and 2 more"
    assert [(f"{item.code} {item.where}: {item.message}".replace(both, ""), item.help) for item in found][
        :1
    ] == [expected]
    assert (both in found[0].message) == expected[1].startswith("write")


JOINTS = "name: r, model: none, joints: [l_yaw_joint, l_hip_joint, l_knee_joint, l_foot_joint, l_toe_joint]"


@pytest.mark.parametrize(
    ("patterns", "expected"),
    [
        (
            "[l_yaw, l_hip, l_knee, l_foot_joint, l_toe_joint]",
            "the patterns 'l_yaw', 'l_hip', 'l_knee' match no joint of 'r', whose names for them end in '_joint'. "
            "write [l_yaw_joint, l_hip_joint, l_knee_joint, l_foot_joint, l_toe_joint]",
        ),
        (
            '[yaw_joint, "(hip|knee)_joint", l_foot_joint, l_toe_joint]',
            "the pattern 'yaw_joint' matches no joint of 'r'. did you mean '.*yaw_joint'? (matches l_yaw_joint)",
        ),
        (
            "[yaw_joint, hip_joint, knee_joint, l_foot_joint, l_toe_joint]",
            "the patterns 'yaw_joint', 'hip_joint', 'knee_joint' match no joint of 'r', whose names for them begin "
            "with 'l_'. write [l_yaw_joint, l_hip_joint, l_knee_joint, l_foot_joint, l_toe_joint]",
        ),
        # Globs have their own answer.
        (
            '["l_yaw*", "l_hip*", l_knee_joint, l_foot_joint, l_toe_joint]',
            "the pattern 'l_yaw*' matches no joint of 'r'. did you mean 'l_yaw.*'? (matches l_yaw_joint)",
        ),
        # None of these is a joint's with an end of its own.
        (
            "[l_wrist, l_elbow, l_neck, l_foot_joint, l_toe_joint]",
            "3 of the spec's 5 patterns match no joint of 'r': the model is another robot's, or its joints have other "
            "names. it has the joints l_yaw_joint, l_hip_joint, l_knee_joint, l_foot_joint and 1 more; the patterns "
            "without a match: 'l_wrist', 'l_elbow', 'l_neck'",
        ),
        (
            "[l_yaw_joint l_hip_joint l_knee_joint, l_foot_joint, l_toe_joint]",
            "the pattern 'l_yaw_joint l_hip_joint l_knee_joint' matches no joint of 'r'. a space in a text ends no "
            'pattern: write `["l_yaw_joint", "l_hip_joint", "l_knee_joint"]`',
        ),
    ],
)
def test_short_names_are_told_once(patterns: str, expected: str) -> None:
    """Names without the beginning or end that all have, and names with spaces between them: not another robot."""
    with pytest.raises(ResolveError) as refusal:
        fit(spec_of(f"a: {{joints: {patterns}, {PD}}}", robot=JOINTS))
    item = refusal.value.diagnostics[0]
    names = ": l_yaw_joint, l_hip_joint, l_knee_joint, l_foot_joint and 1 more"
    assert f"{item.message.removesuffix(names)}. {item.help}" == expected


def test_keys_of_another_naming_are_told_once() -> None:
    """Twelve keys of a pose have one cause; two may be slips, and one that is nearly a joint's has its own answer."""
    names = [f"{leg}_{joint}_joint" for leg in ("FL", "FR", "RL", "RR") for joint in ("hip", "thigh", "calf")]
    for few, count in ((names, 1), (names[:2], 2), ([*names[:3], "LF_HAB"], 4)):
        pose = ", ".join(f"{name}: 0.1 rad" for name in few)
        with pytest.raises(ResolveError) as refusal:
            fit(spec_of(f'a: {{joints: [".*"], {PD}}}', robot=ANOTHER + f", default_pose: {{{pose}}}"))
        assert len(refusal.value.diagnostics) == count, few
        if count == 1:
            (item,) = refusal.value.diagnostics
            assert (item.code, item.where, item.message) == (
                "BIND001",
                "robot.default_pose",
                "none of the 12 patterns matches a joint of 'r': its joints have other names",
            )
            assert item.help == (
                "it has the joints LF_HAA, LF_HFE, LF_KFE, RF_HAA and 2 more; the patterns without a match: "
                "'FL_hip_joint', 'FL_thigh_joint', 'FL_calf_joint', 'FR_hip_joint' and 8 more"
            )


@pytest.mark.parametrize(
    ("joints", "expected"),
    [
        # None of four.
        (
            '".*_hip", ".*_thigh", ".*_calf"',
            [
                "BIND001 robot.joints: no pattern of the spec matches a joint of 'r': the model is another "
                "robot's, or its joints have other names"
            ],
        ),
        # Three of five are more than a third.
        (
            '".*_HAA", ".*_HFE", ".*_hip", ".*_thigh", ".*_calf"',
            [
                "BIND001 robot.joints: 3 of the spec's 5 patterns match no joint of 'r': the model is another "
                "robot's, or its joints have other names"
            ],
        ),
        # Two of two may be slips.
        (
            '".*_hip", ".*_thigh"',
            [
                f"BIND001 actuators.a.joints[{i}]: the pattern '.*_{name}' matches no joint of 'r'"
                for i, name in enumerate(("hip", "thigh"))
            ],
        ),
        # One letter each: each has an answer of its own.
        (
            '".*_HAB", ".*_HFF", ".*_KFF"',
            [
                f"BIND001 actuators.a.joints[{i}]: the pattern '.*_{name}' matches no joint of 'r'"
                for i, name in enumerate(("HAB", "HFF", "KFF"))
            ],
        ),
    ],
)
def test_the_model_of_another_robot_is_told_once(joints: str, expected: list[str]) -> None:
    """Where a third of the patterns, and three at least, match nothing, the model is another one."""
    assert refused(spec_of(f"a: {{joints: [{joints}], {PD}}}", robot=ANOTHER)) == expected


def test_another_model_is_told_with_its_joints() -> None:
    """The help names joints of the one and patterns of the other."""
    with pytest.raises(ResolveError) as refusal:
        fit(spec_of(f"a: {{joints: [hip, thigh, calf, toe, heel], {PD}}}", robot=ANOTHER))
    (item,) = refusal.value.diagnostics
    assert item.help == (
        "it has the joints LF_HAA, LF_HFE, LF_KFE, RF_HAA and 2 more; the patterns without a match: "
        "'hip', 'thigh', 'calf', 'toe' and 1 more"
    )


def test_a_model_without_joints_is_told_once() -> None:
    """However many patterns there are."""
    empty = '<mujoco model="box"><worldbody><body><geom size="0.1" mass="1"/></body></worldbody></mujoco>'
    assert refused(robot(f"g: {{joints: [a, b], {PD}}}", ", default_pose: {a: 1 rad}"), empty) == [
        "BIND001 robot.model: 'box' has no hinge or slide joint with a name, and the spec has patterns of joints"
    ]
