"""One fault that several rules see: what is explained is a note that names the rule, and nothing is left out."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import permutations
from pathlib import Path
from typing import Any

import pytest

from actspec.audit.causes import by_cause
from actspec.audit.engine import audit
from actspec.audit.finding import Confidence, Finding
from actspec.audit.outcome import Reported
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity, Span
from actspec.report import ReportOptions, render
from tests.audit.making import finding

ERROR, WARNING, INFO = Severity.ERROR, Severity.WARNING, Severity.INFO


def _of(
    code: str, joint: str = "knee", path: str = "a.xml", line: int = 1, held: str = "", **fields: Any
) -> Finding:
    fields = {"fields": ("effort_limit",), **fields}
    related = (Span(held, 1, 1),) if held else ()
    return finding(code, path, line, joint=joint, **{"related": related, **fields})


def _after(
    *found: Finding | tuple[Finding, Severity],
    unsure: str = "",
    fixed: str = "",
    whose: Callable[[Span], frozenset[int]] = lambda place: frozenset(),
) -> list[tuple[str, str, str]]:
    pairs = [item if isinstance(item, tuple) else (item, WARNING) for item in found]
    reported = [Reported(one, "made", severity, Confidence.HIGH) for one, severity in pairs]
    settled = by_cause(
        reported,
        counts=lambda item: item.finding.code != unsure,
        fixed=lambda code: code == fixed,
        whose=whose,
    )
    return [
        (item.finding.code, item.severity.value, item.cause.code if item.cause else "") for item in settled
    ]


GEAR, DIFFER, KNOWN = _of("GEA101", held="b.urdf"), _of("SRC101", held="b.urdf"), _of("KNW101")


def test_the_nearest_to_the_cause_tells_the_fault() -> None:
    """A gear that is left out explains that files differ and what is published, and is as bad as the worst of them."""
    assert _after(KNOWN, (DIFFER, ERROR), GEAR) == [
        ("KNW101", "info", "GEA101"),
        ("SRC101", "info", "GEA101"),
        ("GEA101", "error", ""),
    ]
    speed = _of("SRC102", held="c.py", fields=("no_load_speed",))
    assert _after(GEAR, speed)[1] == ("SRC102", "info", "GEA101")
    assert _after(KNOWN, DIFFER) == [("KNW101", "info", "SRC101"), ("SRC101", "warning", "")]
    # Beside two files that are right the speed of one of them is on the same line.
    three = replace(DIFFER, related=(*DIFFER.related, Span("d.py", 3, 1)))
    speed = replace(DIFFER, code="SRC102", fields=("velocity_limit",))
    assert _after(speed, three)[0] == ("SRC102", "info", "SRC101")
    assert _after(replace(speed, related=three.related), DIFFER)[0] == ("SRC102", "info", "SRC101")


def test_another_robot_of_the_file_explains_nothing() -> None:
    """A cfg file has the Go1's knee in line 1 and the Go2's, without its gear, in line 9; both call it alike."""
    gear, known = _of("GEA101", line=9, held="go2.urdf"), _of("KNW101")
    rest = [_of("KNW101", joint=joint, line=line) for joint, line in (("calf", 9), ("knee", 9), ("hip", 1))]
    robots = {1: frozenset({0}), 9: frozenset({1})}

    def whose(place: Span) -> frozenset[int]:
        return robots[place.line or 0] if place.path == "a.xml" else frozenset()

    assert _after(known, gear, whose=whose)[0] == ("KNW101", "warning", "")
    assert _after(known, gear)[0] == ("KNW101", "info", "GEA101")
    # Of an actuator that both robots have, what is said is of both.
    robots[1] = frozenset({0, 1})
    assert _after(known, gear, whose=whose)[0] == ("KNW101", "info", "GEA101")
    # Most of what says the same of the Go2 is explained, and says nothing of the Go1.
    robots[1] = frozenset({0})
    calf = _of("GEA101", joint="calf", line=9, held="go2.urdf")
    assert [cause for *_, cause in _after(*rest, gear, calf, whose=whose)] == ["GEA101", "GEA101", "", "", ""]


@pytest.mark.parametrize(
    ("code", "wrong", "told", "published", "explained"),
    [
        pytest.param("GEA101", 23.5, 45.43, 45.43, True, id="with the gear it is what is published"),
        pytest.param("GEA101", 23.5, 35.55, 45.43, False, id="45.43 / 35.55 = 1.28: still too little"),
        pytest.param("SRC101", 23.5, 35.55, 45.43, False, id="the other file has neither"),
        pytest.param("SRC101", 23.5, 40.0, 45.43, True, id="45.43 / 40 = 1.14: within KNW101's 1.2"),
        pytest.param(
            "SRC101", 300.0, 5.0, 13.4, True, id="less than the most that is published: another variant's"
        ),
        pytest.param("SRC101", 300.0, 20.0, 13.4, False, id="20 / 13.4 = 1.49: still too much"),
    ],
)
def test_what_is_published_is_not_hidden_by_another_figure(
    code: str, wrong: float, told: float, published: float, explained: bool
) -> None:
    """A calf with the hip's 23.5 N*m, of which 45.43 are published; a wrist with 300, of which 5 or 13.4 are."""
    at = {"unit": "N*m", "value": wrong}
    found = _after(_of(code, held="b.urdf", expected=told, **at), _of("KNW101", expected=published, **at))
    assert found[1] == (("KNW101", "info", code) if explained else ("KNW101", "warning", ""))


def test_a_gear_explains_what_it_multiplies() -> None:
    """A servo behind a gear that divides its targets is too stiff for the step, and its limit bounds nothing."""
    geared = _of("GEA105", fields=("effort_limit", "kp", "kd"))
    ringing = _of("STB101", fields=("kd",))
    assert _after((ringing, ERROR), _of("LIM101"), geared) == [
        ("STB101", "info", "GEA105"),
        ("LIM101", "info", "GEA105"),
        ("GEA105", "error", ""),
    ]
    assert _after(geared, replace(ringing, joint="hip"))[1][2] == ""


def test_a_gear_that_was_not_squared_explains_the_file_where_it_was() -> None:
    gear = _of("GEA102", fields=("armature",), value=0.01425, expected=0.021375)
    other = _of("SRC104", fields=("armature",), held="b.urdf", value=0.01425, expected=0.0214)
    assert _after(gear, other) == [("GEA102", "warning", ""), ("SRC104", "info", "GEA102")]
    # What the other file has is another figure, or that file's gear is the one that is told.
    apart = [replace(other, expected=0.05), replace(other, span=Span("a.xml", 2, 1))]
    for one in apart:
        assert [cause for *_, cause in _after(gear, one)] == ["", ""]


def test_a_limit_that_is_stated_twice_explains_that_another_file_has_the_first() -> None:
    twice = _of("LIM106", value=140.0, expected=14.0)
    other = _of("SRC101", held="b.urdf", value=140.0, expected=14.0)
    assert _after(twice, (other, ERROR)) == [("LIM106", "error", ""), ("SRC101", "info", "LIM106")]
    for one in (replace(other, expected=30.0), _of("KNW101", value=140.0, expected=14.0)):
        assert [cause for *_, cause in _after(twice, one)] == ["", ""]


@pytest.mark.parametrize(("code", "field"), [("LIM106", "effort_limit"), ("ORD104", "default_position")])
def test_what_the_simulator_refuses_is_told_whatever_else_is_wrong(code: str, field: str) -> None:
    one = _of("UNT103" if code == "ORD104" else "SYM101", fields=(field,))
    assert _after(one, (_of(code, fields=(field,)), ERROR))[1] == (code, "error", "")


def test_a_wrong_sign_of_a_gain_explains_that_the_sides_differ(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """MuJoCo makes another kv than 3 of it, which the other side has."""
    monkeypatch.chdir(tmp_path)
    body = '<body pos="{1} 0 0"><joint name="{0}_hip"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>'
    servo = '<general joint="{0}_hip" biastype="affine" gainprm="120" biasprm="0 -120 {1}"/>'
    Path("a.xml").write_text(
        f'<mujoco model="a"><worldbody>{body.format("L", 1)}{body.format("R", -1)}</worldbody>'
        f"<actuator>{servo.format('L', 3)}{servo.format('R', -3)}</actuator></mujoco>"
    )
    found = audit(["a.xml"], Settings(select=("SGN102", "SYM101"))).findings
    told = {(item.finding.code, item.cause.code if item.cause else "") for item in found}
    assert told == {("SGN102", ""), ("SYM101", "SGN102")}


def test_damping_that_is_counted_twice_is_told_once() -> None:
    """In a model's joint: beside the kd of a configuration, beside the model's own drive, and the joint is slow."""
    damping = {"fields": ("joint_damping",)}
    slow = _of("DMP103", **damping)
    twice = _of("DMP101", path="hands.xml", held="cfg.py", **damping)
    beside = _of("DMP105", held="cfg.py", **damping)
    assert [cause for *_, cause in _after(slow, twice, beside)] == ["DMP105", "DMP105", ""]
    assert _after(slow, replace(twice, span=slow.span))[0] == ("DMP103", "info", "DMP101")
    assert _after(beside, replace(twice, fields=("actuator_damping",)))[1][2] == ""


def test_a_servo_that_lost_its_gains_explains_the_damping_that_is_too_much_for_it() -> None:
    """Its gain is gone; what the damping leaves of the limit is another fault."""
    lost = _of("VER106", path="drives.xml", line=9, fields=("kp", "kd"))
    lags = _of("DMP101", held="drives.xml", fields=("joint_damping",))
    assert _after(lost, lags) == [("VER106", "warning", ""), ("DMP101", "info", "VER106")]
    assert _after(lost, replace(lags, joint="hip"))[1] == ("DMP101", "warning", "")
    slow = _of("DMP103", held="drives.xml", fields=("joint_damping",))
    assert _after(lost, slow)[1] == ("DMP103", "warning", "")


@pytest.mark.parametrize(
    "one, other",
    [
        (GEAR, _of("SRC101", "hip", held="b.urdf")),
        (GEAR, _of("KNW101", path="b.urdf")),
        (GEAR, _of("SRC101", path="c.xml", held="b.urdf")),
        (DIFFER, _of("SRC105", fields=("frictionloss",))),
        (DIFFER, _of("SRC102", held="c.urdf", fields=("velocity_limit",))),
        (_of("SYM101"), _of("SRC102", held="b.urdf", fields=("velocity_limit",))),
        (_of("LIM101", fields=("velocity_limit",)), DIFFER),
        (_of("SYM101", line=7, related=(Span("a.xml", 8, 1),)), _of("LIM101", "hip")),
    ],
    ids=[
        "joint",
        "right file",
        "file beside it",
        "figure",
        "third file",
        "sides",
        "torque of a speed",
        "other sides",
    ],
)
def test_another_fault_stands_for_itself(one: Finding, other: Finding) -> None:
    assert all(cause == "" for _, _, cause in _after(one, other))


@pytest.mark.parametrize(
    ("code", "value", "expected"),
    [("UNT106", 0.863, 45.43), ("UNT105", 4.63, 45.43), ("LIM101", 1e9, None)],
    ids=["an angle as torque", "another unit", "a placeholder"],
)
def test_a_wrong_model_does_not_make_the_configuration_right(
    code: str, value: float, expected: float | None
) -> None:
    """A Go1's hips with 45.43 N*m in a configuration, of which 23.7 are published, beside a model with less or more.

    Once the model is put right, what is published of the configuration's limit is there as before.
    """
    at = {"unit": "N*m", "value": value, "expected": expected}
    model = _of(code, path="go1.xml", held="cfg.py", **at)
    differ = _of("SRC101", path="cfg.py", held="go1.xml", unit="N*m", value=45.43, expected=value)
    known = _of("KNW101", path="cfg.py", unit="N*m", value=45.43, expected=23.7)
    assert [cause for *_, cause in _after(model, differ, known)] == ["", code, ""]


def test_friction_that_no_motor_overcomes_explains_the_other_file() -> None:
    """A URDF with 1000 N of friction, and an MJCF with 0.2; not two files of which neither has the 1000."""
    stuck = _of("FRC101", path="b.urdf", held="c.xml", fields=("frictionloss",))
    less = _of("SRC105", held="b.urdf", fields=("frictionloss",))
    assert _after(less, stuck) == [("SRC105", "info", "FRC101"), ("FRC101", "warning", "")]
    assert _after(_of("SRC105", held="c.xml", fields=("frictionloss",)), stuck)[0][2] == ""


def test_what_is_not_reported_explains_nothing() -> None:
    """A note, or what the settings leave out; and a severity that they state is kept."""
    assert _after((GEAR, INFO), KNOWN)[1] == ("KNW101", "warning", "")
    assert _after(GEAR, KNOWN, unsure="GEA101")[1] == ("KNW101", "warning", "")
    assert _after(GEAR, KNOWN, fixed="KNW101") == [("GEA101", "warning", ""), ("KNW101", "warning", "")]
    assert _after(GEAR, (KNOWN, ERROR), fixed="GEA101")[0] == ("GEA101", "warning", "")


def test_torque_and_speed_of_two_files_are_one_line_of_a_datasheet() -> None:
    speed = _of("SRC102", held="b.urdf", fields=("velocity_limit",))
    assert _after(DIFFER, speed)[1] == ("SRC102", "info", "SRC101")
    assert _after(DIFFER, replace(speed, joint="hip"))[1] == ("SRC102", "warning", "")


def test_a_gear_of_one_file_is_no_cause_of_what_another_has_alone() -> None:
    """The configuration's 23.5 leaves out a reduction of the URDF's 45.43; the MJCF's 454.3 differs from both."""
    gear = _of("GEA101", path="cfg.py", held="go2.urdf")
    known, beside = _of("KNW101", path="go2.xml"), _of("SRC101", path="go2.xml", held="cfg.py")
    urdf = _of("SRC101", path="go2.xml", held="go2.urdf")
    assert _after(gear, urdf, known) == [
        ("GEA101", "warning", ""),
        ("SRC101", "warning", ""),
        ("KNW101", "info", "SRC101"),
    ]
    assert _after(gear, beside, known)[1:] == [("SRC101", "info", "GEA101"), ("KNW101", "warning", "")]


def test_a_gear_explains_no_figure_from_which_it_leads_away() -> None:
    """23.5 N*m for 45.43: beside 35.55, or 454.3, the 45.43 is nearer; beside 3.555 it is not."""
    at = {"unit": "N*m", "path": "cfg.py"}
    gear = _of("GEA101", held="b.urdf", value=23.5, expected=45.43, **at)
    for third, cause in ((35.55, "GEA101"), (454.3, "GEA101"), (3.555, "")):
        other = _of("SRC101", path="go2.urdf", held="cfg.py", unit="N*m", value=third, expected=23.5)
        turned = _of("SRC101", held="go2.urdf", value=23.5, expected=third, **at)
        assert [_after(gear, one)[1][2] for one in (other, turned)] == [cause, cause]


def test_which_of_two_sides_is_wrong_nobody_knows() -> None:
    """`b.urdf` has one figure: it speaks against the left side, or the right. Against both, it is another fault."""
    sides = _of("SYM101", "right", line=2, related=(Span("a.xml", 1, 1),))
    left, right = (
        _of("SRC101", joint, line=at, held="b.urdf") for at, joint in enumerate(("left", "right"), 1)
    )
    assert _after(sides, left)[1] == ("SRC101", "info", "SYM101")
    assert _after(sides, right)[1] == ("SRC101", "info", "SYM101")
    assert [cause for *_, cause in _after(sides, left, right)] == ["", "", ""]
    # A third file contradicts the left side: that the right one, which is told as the odd one, differs is the sides'.
    third = replace(left, related=(Span("c.urdf", 1, 1),))
    assert [cause for *_, cause in _after(sides, third, right)] == ["", "", "SYM101"]
    # A mapping of a configuration has both sides at one place: there the joint tells.
    place = Span("a.xml", 1, 1)
    mapping, other = replace(sides, span=place, related=(place,)), replace(right, span=place)
    assert _after(mapping, left)[1] == ("SRC101", "warning", "")
    assert _after(mapping, (other, ERROR)) == [("SYM101", "error", ""), ("SRC101", "info", "SYM101")]


def test_what_other_joints_lack_is_no_cause_of_a_slip() -> None:
    """The left calf has 3.555 N*m for 35.55; the right one has the gear of another revision, as the rear ones have."""
    gear = _of("GEA101", "right", line=2, held="b.urdf")
    sides = _of("SYM101", "left", line=1, related=(Span("a.xml", 2, 1),))
    left, right = (_of("SRC101", joint, line=at, held="b.urdf") for at, joint in ((1, "left"), (2, "right")))
    slip = [(left, ERROR), sides, _of("KNW101", "left", line=1)]
    told = [("SRC101", "info", "SYM101"), ("SYM101", "error", ""), ("KNW101", "info", "SYM101")]
    assert _after(*slip, gear) == [*told, ("GEA101", "warning", "")]
    # That the right one departs from the other file is the gear's, and leaves the left one's to the sides.
    assert _after(*slip, gear, right) == [*told, ("GEA101", "warning", ""), ("SRC101", "info", "GEA101")]
    assert _after(gear, replace(sides, joint="right", span=gear.span, related=(left.span,)))[1][2] == ""


def test_why_sides_differ_says_nothing_of_the_right_one() -> None:
    """The right side's figure is in another unit; what the left one differs in from another file is another fault."""
    unit = _of("UNT103", "right", line=2, held="b.urdf")
    sides = _of("SYM101", "left", line=1, related=(Span("a.xml", 2, 1),))
    left = _of("SRC101", "left", line=1, held="b.urdf")
    assert _after(unit, sides, left) == [
        ("UNT103", "warning", ""),
        ("SYM101", "info", "UNT103"),
        ("SRC101", "warning", ""),
    ]


@pytest.mark.parametrize(
    ("code", "field"), [("SRC103", "kd"), ("SRC104", "armature"), ("SRC106", "action_scale")]
)
def test_a_figure_of_one_side_is_told_once(code: str, field: str) -> None:
    """A deploy file has 20 at one entry, and 2 at the other side as the configuration has at both: one fault.

    Of 20 and 10 neither is the configuration's, and of another figure the sides say nothing.
    """
    deploy = {"path": "deploy.yaml", "held": "cfg.py", "fields": (field,)}
    sides = replace(_of("SYM101", "left", line=7, **deploy), related=(Span("deploy.yaml", 8, 1),))
    left, right = (_of(code, joint, line=line, **deploy) for joint, line in (("left", 7), ("right", 8)))
    assert _after(left, sides) == [(code, "info", "SYM101"), ("SYM101", "warning", "")]
    assert [cause for *_, cause in _after(left, sides, right)] == ["", "", ""]
    assert _after(replace(left, fields=("kp",)), sides)[0][2] == ""


def test_a_file_of_another_variant_departs_from_the_spec_once() -> None:
    """What the variant explains is a note: the departing figure, a gear that only one of them has. Nothing else is."""
    variant = _of("SPC107", path="g1.urdf", held="g1.yaml", fields=("effort_limit", "velocity_limit"))
    limit = _of("SPC101", path="g1.urdf", held="g1.yaml")
    speed = replace(limit, fields=("velocity_limit",))
    sheet = _of("LIM108", path="g1.urdf", held="motors.yaml")
    gear = _of("GEA101", path="motors.yaml", held="g1.urdf")
    assert [cause for *_, cause in _after(variant, limit, speed, sheet, gear)] == ["", *["SPC107"] * 4]
    gains, ankle = replace(limit, fields=("kp",)), replace(limit, joint="ankle")
    assert [cause for *_, cause in _after(variant, gains, ankle)] == ["", "", ""]
    # Without the variant SPC101 explains nothing, and nothing explains it.
    assert [cause for *_, cause in _after(gear, limit, sheet)] == ["", "", ""]


def test_two_files_that_are_the_sides_differ_once() -> None:
    """Of joints of one name in `left.xml` and `right.xml` two rules say the same; a third file's figure is another
    fault, where both differ from it.
    """
    sides = _of("SYM101", path="right.xml", held="left.xml")
    assert _after(sides, (_of("SRC101", path="right.xml", held="left.xml"), ERROR)) == [
        ("SYM101", "error", ""),
        ("SRC101", "info", "SYM101"),
    ]
    beside = [_of("SRC101", path=path, held="other.urdf") for path in ("right.xml", "left.xml")]
    assert _after(sides, *beside) == [("SYM101", "warning", ""), *[("SRC101", "warning", "")] * 2]


def test_a_side_in_another_file_explains_nothing_of_this_one() -> None:
    """At the right hand's file it leaves what the left hand's files differ in; at the left's it tells it."""
    differ = _of("SRC101", "left", "left-ros.urdf", held="left.urdf")
    at_right = _of("SYM101", "right", "right.urdf", held="left-ros.urdf")
    assert _after(at_right, differ)[1] == ("SRC101", "warning", "")
    at_left = _of("SYM101", "left", "left-ros.urdf", held="right.urdf")
    assert _after(at_left, differ)[1] == ("SRC101", "info", "SYM101")


def test_the_rest_of_a_sentence_goes_with_most_of_it() -> None:
    """The fingers of a hand without limits, two of which the other hand explains."""
    zeros = [_of("LIM101", f"finger{at}", line=at, message="the effort is 0") for at in range(3)]
    sides = [_of("SYM101", f"finger{at}", line=at, held="left.urdf") for at in range(2)]
    assert [cause for *_, cause in _after(*zeros, *sides)] == ["SYM101"] * 3 + ["", ""]
    assert [cause for *_, cause in _after(*zeros, sides[0])] == ["SYM101", "", "", ""]


def test_degrees_tell_what_two_files_differ_in() -> None:
    """A deploy file has 23 for the configuration's 0.4 rad: degrees, no other pose. A kd per degree is no other gain,
    and what diverges by it is explained too.
    """
    pose = {"path": "deploy.yaml", "held": "cfg.py", "fields": ("default_position",)}
    degrees, off, out = (_of(code, **pose) for code in ("UNT103", "SRC106", "LIM111"))
    assert _after(off, out, degrees) == [
        ("SRC106", "info", "UNT103"),
        ("LIM111", "info", "UNT103"),
        ("UNT103", "warning", ""),
    ]
    gain = {"fields": ("kd",), "held": "cfg.py"}
    of_gain, other, rings = (_of(code, **gain) for code in ("UNT103", "SRC103", "STB101"))
    assert _after(of_gain, other, (rings, ERROR)) == [
        ("UNT103", "error", ""),
        ("SRC103", "info", "UNT103"),
        ("STB101", "info", "UNT103"),
    ]
    # Another joint, another figure, and what is wrong with the pose that is in radians.
    assert _after(degrees, replace(off, joint="hip"))[1][2] == ""
    assert _after(degrees, replace(off, fields=("action_scale",)))[1][2] == ""
    assert _after(degrees, _of("LIM111", path="cfg.py", fields=("default_position",)))[1][2] == ""


def test_a_pose_in_degrees_is_told_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`[23, -46]` for 0.4 and -0.8 rad: 57.5 times both, within 0.5 % of 57.3."""
    monkeypatch.chdir(tmp_path)
    Path("hopper_cfg.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        "from isaaclab.assets import ArticulationCfg\n"
        "HOPPER_CFG = ArticulationCfg(\n"
        '    init_state=ArticulationCfg.InitialStateCfg(joint_pos={"hip": 0.4, "knee": -0.8}),\n'
        '    actuators={"all": ImplicitActuatorCfg(joint_names_expr=["hip", "knee"], stiffness=60.0, damping=2.0)},\n'
        ")\n"
    )
    Path("hopper_deploy.yaml").write_text(
        "joint_names: [hip, knee]\nkps: [60, 60]\nkds: [2, 2]\ndefault_angles: [23, -46]\n"
    )
    found = audit(["."], Settings(as_named=True, select=("UNT103", "SRC106"))).at_or_above(WARNING)
    assert [(item.finding.code, item.finding.joint) for item in found] == [
        ("UNT103", "hip"),
        ("UNT103", "knee"),
    ]


BIPED = """<robot name="biped"><link name="base"/><link name="a"/><link name="b"/>
<joint name="left_knee" type="revolute"><parent link="base"/><child link="a"/><limit effort="20" velocity="9"/></joint>
<joint name="right_knee" type="revolute"><parent link="base"/><child link="b"/><limit effort="0" velocity="9"/></joint>
</robot>"""


def test_the_lesser_rule_alone_speaks_for_itself(tmp_path: Path) -> None:
    """SYM101 tells of a side without a limit; LIM101 is a note that names it, and tells it where it is asked alone."""
    path = tmp_path / "biped.urdf"
    path.write_text(BIPED)
    report = audit([str(path)], Settings(select=("SYM101", "LIM101")))
    assert [(item.finding.code, item.severity) for item in report.findings] == [
        ("LIM101", INFO),
        ("SYM101", ERROR),
    ]
    records = json.loads(render(report, "json", ReportOptions(least=INFO)))["findings"]
    assert [record["explained_by"] for record in records] == ["SYM101", None]
    assert "(explained by SYM101 at " in render(report, "concise", ReportOptions(least=INFO))
    alone = audit([str(path)], Settings(select=("LIM101",)))
    assert [(item.severity, item.cause) for item in alone.findings] == [(WARNING, None)]


GO2_CFG = """from isaaclab.actuators import DCMotorCfg
from isaaclab.assets import ArticulationCfg
GO2_CFG = ArticulationCfg(
    init_state=ArticulationCfg.InitialStateCfg(
        joint_pos={"F[L,R]_hip_joint": 0.1, ".*_thigh_joint": 0.8, ".*_calf_joint": -1.5}
    ),
    actuators={
        "hips": DCMotorCfg(joint_names_expr=[".*_hip_joint", ".*_thigh_joint"], effort_limit=23.7,
            saturation_effort=23.7, velocity_limit=30.1, stiffness=25.0, damping=0.5, armature=0.01),
        "knees": DCMotorCfg(joint_names_expr=[".*_calf_joint"], effort_limit=45.43,
            saturation_effort=@STALL@, velocity_limit=@SPEED@, stiffness=@KP@, damping=@KD@, armature=@ARMATURE@),
    }
)
"""
FIGURES = {"STALL": "45.43", "SPEED": "15.7", "KP": "25.0", "KD": "0.5", "ARMATURE": "0.01"}
LEGS = [f"{side}_{part}_joint" for side in ("FL", "FR", "RL", "RR") for part in ("hip", "thigh", "calf")]
GO2_URDF = (
    '<robot name="go2"><link name="base"/>'
    + "".join(
        f'<link name="{leg}_link"/><joint name="{leg}" type="revolute"><parent link="base"/><child link="{leg}_link"/>'
        f'<limit lower="-3" upper="3" effort="{effort}" velocity="{speed}"/></joint>'
        for leg in LEGS
        for effort, speed in [(45.43, 15.7) if "calf" in leg else (23.7, 30.1)]
    )
    + "</robot>"
)
GO2_XML = (
    '<mujoco model="go2"><worldbody>'
    + "".join(f'<body><joint name="{leg}" armature="0.01"/><geom size="0.1"/></body>' for leg in LEGS)
    + "</worldbody><actuator>"
    + "".join(
        f'<motor joint="{leg}" ctrlrange="-{effort} {effort}"/>'
        for leg in LEGS
        for effort in [45.43 if "calf" in leg else 23.7]
    )
    + "</actuator></mujoco>"
)


def _two_revisions() -> dict[str, str]:
    """Writes the maker's URDF, one of another gear, and a configuration with the hip's limits on every joint."""
    uniform = GO2_CFG.replace("effort_limit=45.43", "effort_limit=23.7")
    for name, figure in {**FIGURES, "STALL": "23.7", "SPEED": "30.1"}.items():
        uniform = uniform.replace(f"@{name}@", figure)
    chain = re.sub(r'link="base"(/><child link="(..)_thigh)', r'link="\2_hip_joint_link"\1', GO2_URDF)
    chain = re.sub(r'link="base"(/><child link="(..)_calf)', r'link="\2_thigh_joint_link"\1', chain)
    revision = chain.replace('effort="45.43" velocity="15.7"', 'effort="35.55" velocity="20.07"')
    texts = {"go2_description.urdf": chain, "cfg.py": uniform, "go2.urdf": revision}
    for name, text in texts.items():
        Path(name).write_text(text)
    return texts


@pytest.mark.parametrize("order", list(permutations(("cfg.py", "go2.urdf", "go2_description.urdf"))))
def test_a_gear_is_told_by_the_file_with_the_published_figure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, order: tuple[str, ...]
) -> None:
    """In whatever order the files are named: 45.43 N*m of a Go2's calf, and the other file beside it."""
    monkeypatch.chdir(tmp_path)
    _two_revisions()
    found = [item.finding for item in audit(order, Settings(select=("GEA101",))).findings]
    assert {(one.span.path, one.expected) for one in found} == {("cfg.py", 45.43), ("go2.urdf", 45.43)}
    assert len(found) == 8
    beside = "; go2.urdf gives it 35.55 N*m at 20.07 rad/s: one of the two is of another robot or revision"
    assert [one.message.endswith(beside) for one in found] == [one.span.path == "cfg.py" for one in found]


@pytest.mark.parametrize(
    "beside",
    [
        ("go2_description.urdf",),
        ("cfg.py",),
        ("go2_description.urdf", "cfg.py"),
        ("cfg.py", "go2_description.urdf"),
    ],
)
def test_a_slip_in_one_leg_is_told_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, beside: tuple[str, ...]
) -> None:
    """A digit is missing in one calf of a URDF whose calves have another gear than the maker's, 35.55 N*m at 20.07.

    The other three calves tell of the gear, as before; the configuration has the hip's 23.7 N*m on every joint.
    """
    monkeypatch.chdir(tmp_path)
    revision = _two_revisions()["go2.urdf"]

    def told() -> set[tuple[str, str, str, str, float | None]]:
        found = audit(["go2.urdf", *beside], Settings()).at_or_above(WARNING)
        ones = ((item.finding, item.severity.value) for item in found)
        return {(one.code, severity, one.span.path, one.joint, one.expected) for one, severity in ones}

    whole = told()
    Path("go2.urdf").write_text(revision.replace('effort="35.55"', 'effort="3.555"', 1))
    slipped = told()
    assert slipped - whole == {("SYM101", "error", "go2.urdf", "FL_calf_joint", None)}
    assert {code for code, *_ in slipped} >= {"GEA101"}
    assert {joint for _, _, _, joint, _ in whole - slipped} == {"FL_calf_joint"}


@pytest.mark.parametrize(
    ("changed", "beside", "told", "notes"),
    [
        ({}, "", set(), set()),
        # 15.7 rad/s is 150 rpm and 900 deg/s.
        ({"SPEED": "150.0"}, "urdf", {"UNT104"}, {"KNW103"}),
        ({"SPEED": "900.0"}, "urdf", {"UNT103"}, {"KNW103"}),
        ({"SPEED": "900.0"}, "", {"KNW103"}, set()),
        # 20 N*m at standstill is below the limit of 45.43, and nobody's.
        ({"STALL": "20.0"}, "", {"LIM107"}, set()),
        ({"STALL": "23.7"}, "", {"KNW101"}, {"LIM107"}),
        # 45.43 N*m over 10 kg*m^2 are 4.5 rad/s^2.
        ({"ARMATURE": "10.0"}, "", {"KNW103"}, {"GEA102", "UNT105"}),
        ({"ARMATURE": "10.0"}, "xml", {"KNW103"}, {"SRC104", "UNT105"}),
        ({"ARMATURE": "-0.01"}, "", {"SGN101"}, {"GEA102"}),
        ({"ARMATURE": "-0.01"}, "xml", {"SGN101"}, {"SRC104"}),
        ({"KP": "0.5", "KD": "25.0"}, "", {"UNT107"}, set()),
    ],
)
def test_one_figure_is_told_by_the_rule_that_says_most(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    changed: dict[str, str],
    beside: str,
    told: set[str],
    notes: set[str],
) -> None:
    """The others of these rules name it, as notes."""
    monkeypatch.chdir(tmp_path)
    text = GO2_CFG
    for name, figure in {**FIGURES, **changed}.items():
        text = text.replace(f"@{name}@", figure)
    files = {"cfg.py": text} | (
        {f"robot.{beside}": GO2_URDF if beside == "urdf" else GO2_XML} if beside else {}
    )
    for name, content in files.items():
        Path(name).write_text(content)
    report = audit(list(files), Settings())
    assert {item.finding.code for item in report.at_or_above(WARNING)} == told
    explained = {item.finding.code for item in report.findings if item.cause is not None}
    assert explained == notes
    assert {item.cause.code for item in report.findings if item.cause is not None} <= told


def test_a_pose_in_degrees_is_told_of_each_joint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """5.7 degrees are 0.1 rad (5.73) as 45.8 are 0.8 (45.84): no other rule has the two hips, nor the other file."""
    monkeypatch.chdir(tmp_path)
    text = GO2_CFG
    for name, figure in FIGURES.items():
        text = text.replace(f"@{name}@", figure)
    Path("cfg.py").write_text(text)
    degrees = {"hip": 5.7, "thigh": 45.8, "calf": -85.9}
    pose = [
        degrees[part] if leg[0] == "F" or part != "hip" else 0.0
        for leg in LEGS
        for part in [leg.split("_")[1]]
    ]
    Path("deploy.yaml").write_text(
        f"joint_names: [{', '.join(LEGS)}]\nkp: {[25] * 12}\nkd: {[0.5] * 12}\ndefault_joint_pos: {pose}\n"
    )
    found = audit(["cfg.py", "deploy.yaml"], Settings()).at_or_above(WARNING)
    assert {(item.finding.code, item.finding.span.path) for item in found} == {("UNT103", "deploy.yaml")}
    assert {item.finding.joint for item in found} == {
        leg for leg in LEGS if leg[0] == "F" or "hip" not in leg
    }


def test_one_joint_that_is_nearly_57_times_another_file_is_no_pose_in_degrees(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """5.7 for 0.1 is 57 times, half a per cent from 57.3: of a file whose other joints agree that is SRC106's."""
    monkeypatch.chdir(tmp_path)
    text = GO2_CFG
    for name, figure in FIGURES.items():
        text = text.replace(f"@{name}@", figure)
    Path("cfg.py").write_text(text)
    radians = {"hip": 0.0, "thigh": 0.8, "calf": -1.5}
    pose = [5.7 if leg == "FL_hip_joint" else radians[leg.split("_")[1]] for leg in LEGS]
    pose[LEGS.index("FR_hip_joint")] = 0.1
    Path("deploy.yaml").write_text(
        f"joint_names: [{', '.join(LEGS)}]\nkp: {[25] * 12}\nkd: {[0.5] * 12}\ndefault_joint_pos: {pose}\n"
    )
    found = audit(["cfg.py", "deploy.yaml"], Settings()).at_or_above(WARNING)
    assert {(item.finding.code, item.finding.joint) for item in found} == {("SRC106", "FL_hip_joint")}
