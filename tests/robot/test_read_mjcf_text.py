"""The reading without MuJoCo: against the compiled one wherever MuJoCo takes the file, by hand where it does not."""

from __future__ import annotations

import math
import os
import random
from dataclasses import fields
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

from actspec.diagnostics import RobotError
from actspec.robot.read_mjcf import read_mjcf
from actspec.robot.read_mjcf_text import read_mjcf_text
from actspec.robot.view import ActuatorView, JointView, ModelFile, RobotView
from actspec.robot.xml import open_document, parse_document
from actspec.robot.xml_tree import XmlDocument

CORPUS = Path(os.environ.get("ACTSPEC_CORPUS", Path(__file__).parents[3] / "shared" / "corpus"))
EXACT = 1e-9
"""Relative; degrees and gears are multiplied in another order."""


@pytest.fixture(autouse=True)
def _in_tmp_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def document(text: str) -> XmlDocument:
    """A parsed model that is nowhere on disk."""
    return parse_document((ModelFile("m.xml", "", text.encode()),))


def same(a: Any, b: Any) -> bool:
    """Equal, numbers to the last digits."""
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, float) and isinstance(b, float):
        return math.isclose(a, b, rel_tol=EXACT, abs_tol=1e-12)
    return bool(a == b)


def differences(compiled: RobotView, text: RobotView) -> list[str]:
    """Fields in which the two readings differ, where the text claims a value."""
    found = [
        f"{name}: {getattr(compiled, name)} {getattr(text, name)}"
        for name in (
            "name",
            "path",
            "format",
            "timestep",
            "integrator",
            "keyframes",
            "eulerdamp",
            "diagnostics",
        )
        if getattr(compiled, name) != getattr(text, name)
    ]
    if [j.name for j in compiled.joints] != [j.name for j in text.joints]:
        return [*found, "joints"]
    if len(compiled.actuators) != len(text.actuators):
        return [*found, "actuators"]
    pairs: list[tuple[JointView | ActuatorView, JointView | ActuatorView]] = [
        *zip(compiled.joints, text.joints, strict=True),
        *zip(compiled.actuators, text.actuators, strict=True),
    ]
    for one, other in pairs:
        for field in fields(one):
            if field.name != "unknown" and field.name not in other.unknown:
                a, b = getattr(one, field.name), getattr(other, field.name)
                # The text does not tell where a spatial tendon runs, nor how bodies and frames turn an axis.
                if not same(a, b) and not (field.name in ("moves", "axis", "point", "tree") and b is None):
                    found.append(f"{one.name} {field.name}: {a} {b}")
    return found


def _real() -> list[Path]:
    found = sorted(CORPUS.rglob("*.xml"))
    try:
        wheel = metadata.distribution("mjlab")
    except metadata.PackageNotFoundError:
        return found
    return found + [Path(str(wheel.locate_file(f))) for f in wheel.files or () if str(f).endswith(".xml")]


@pytest.mark.slow
@pytest.mark.skipif(not _real(), reason="no corpus")
@pytest.mark.parametrize("path", _real(), ids=lambda path: "/".join(path.parts[-2:]))
def test_real_files_read_alike(path: Path) -> None:
    """Every real MJCF that compiles reads the same from its text, and nothing in it is unknown."""
    try:
        parsed = open_document(str(path))
    except RobotError:
        pytest.skip("not XML")
    if parsed.root.tag != "mujoco":
        pytest.skip("not an MJCF")
    text = read_mjcf_text(parsed, "refused")
    assert differences(read_mjcf(parsed.files, parsed, inertia=False), text) == []
    assert not any(joint.unknown for joint in text.joints)
    assert not any(actuator.unknown for actuator in text.actuators)


ACTUATORS = (
    "<motor {}/>",
    '<motor {} gear="-3" ctrlrange="-1 2" ctrllimited="false"/>',
    '<position {} kp="7" kv="2" ctrlrange="-1 1" gear="2"/>',
    '<position {} kp="7" dampratio="1"/>',
    '<position {} kp="7" timeconst="0.1" forcerange="-3 5"/>',
    '<position {} kp="-3"/>',
    '<velocity {} kv="3"/>',
    '<intvelocity {} kp="4" kv="1" actrange="-1 1"/>',
    '<general {} dyntype="integrator" gainprm="3" actrange="-1 2" ctrlrange="-4 4"/>',
    '<general {} dyntype="filter" dynprm="0.2" actrange="-1 2" ctrlrange="-4 1"/>',
    '<general {} dyntype="filterexact" dynprm="0.2" actrange="-1 2" actlimited="false" ctrlrange="-4 1"/>',
    '<damper {} kv="2" ctrlrange="0 1"/>',
    '<cylinder {} diameter="2" bias="1 2 3"/>',
    "<muscle {}/>",
    '<general {} gainprm="5" biastype="affine" biasprm="1 -5 -2" forcelimited="false" forcerange="-1 1"/>',
    '<general {} gainprm="5" biasprm="0 -4 -2"/>',
    '<general {} gainprm="5" biastype="affine" biasprm="0 -4 2"/>',
    '<general {} dyntype="filter" dynprm="0.2"/>',
    '<general {} gaintype="affine" gainprm="0 0 -2"/>',
    '<general {} biastype="affine" biasprm="0 0 -1"/>',
    '<general {} dyntype="integrator" gainprm="3" biastype="affine" biasprm="0 -3 -1"/>',
    '<dcmotor {} nominal="24 6 30" saturation="4 0 0" input="pos" controller="10 0 1 0 0 24"/>',
    '<dcmotor {} motorconst="2 3" resistance="4"/>',
    '<dcmotor {} motorconst="2" resistance="4" input="none"/>',
    '<dcmotor {} motorconst="2" resistance="4" saturation="0 2 0" input="vel" controller="0 0 1 0 0 9" gear="3"/>',
    '<dcmotor {} nominal="24 6 30" damping="0.05"/>',
    '<dcmotor {} nominal="24 6 30" resistance="2" damping="0.05" inductance="0 .01"/>',
    '<dcmotor {} nominal="24 6 30" input="pos" controller="10 1 1 0 0 24" cogging="1 2 3"/>',
    '<pid {} kp="5" kv="2" ki="1" posrange="-1 1"/>',
    '<pid {} kp="5" input="vel" velrange="-1 1"/>',
    '<motor {} armature="0.1" damping="1 2" delay="0.01" nsample="5" group="2"/>',
    '<position {} inheritrange="0.5"/>',
)
JOINT_DEFAULTS = (
    "",
    '<joint damping="3" armature="0.2" actuatorfrcrange="-2 3"/>',
    '<joint actuatorfrcrange="-2 3" actuatorfrclimited="false" stiffness="4" frictionloss="0.1"/>',
)
OPTIONS = (
    "",
    '<option timestep="0.004" integrator="implicitfast"><flag eulerdamp="disable"/></option>',
)
KEYS = ("", '<keyframe><key name="home" qpos="0 0 1 1 0 0 0 .3 .4 1 0 0 0"/></keyframe>')
TRANSMISSIONS = ('joint="j"', 'joint="j"', 'joint="s"', 'jointinparent="j"', 'tendon="t"', 'site="p"')
MODEL = """<mujoco model="m">{option}<compiler angle="degree"/>
<default>{joints}{outer}<default class="c">{inner}</default></default>
<worldbody><body name="b" childclass="c"><freejoint name="f"/>
<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
<body name="k"><joint name="j" range="-90 45" ref="10" damping="0.5 .1"/>
<joint name="s" type="slide" class="main" axis="1 0 0" range="-1 1" springdamper="{spring}"/>
<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><site name="p"/>
<frame childclass="main"><body name="x"><joint name="q" type="ball" range="0 30"/>
<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/></body></frame></body></body></worldbody>
<tendon><fixed name="t"><joint joint="j" coef="2"/></fixed></tendon>
<actuator>{actuator}</actuator>{key}</mujoco>"""


def generated(seed: int) -> str:
    """A model with two classes and an actuator drawn from the lists above."""
    draw = random.Random(seed)

    def of_class() -> str:
        # These two make a class that no other shortcut compiles with.
        usual = [a for a in ACTUATORS if "inheritrange" not in a and "delay" not in a]
        return draw.choice(["", *usual]).format("")

    own_class = draw.choice(["", 'class="c"'])
    place = f'name="a" {draw.choice(TRANSMISSIONS)} {own_class}'
    return MODEL.format(
        option=draw.choice(OPTIONS),
        joints=draw.choice(JOINT_DEFAULTS),
        outer=of_class(),
        inner=of_class(),
        spring=draw.choice(["0 0", ".1 1"]),
        actuator=draw.choice(ACTUATORS).format(place),
        key=draw.choice(KEYS),
    )


@pytest.mark.slow
@pytest.mark.parametrize("block", range(8))
def test_mixed_classes_read_alike(block: int) -> None:
    """Gains pass from class to class as MuJoCo 3.16 and later pass them; most of 400 models compile."""
    import mujoco

    if not hasattr(mujoco.MjsActuator, "type"):
        pytest.skip("before 3.16 gains went from any shortcut to any other")
    compiled = 0
    for seed in range(50 * block, 50 * block + 50):
        parsed = document(generated(seed))
        text = read_mjcf_text(parsed, "refused")
        try:
            view = read_mjcf(parsed.files, parsed, inertia=False)
        except RobotError:
            continue
        compiled += 1
        assert differences(view, text) == [], generated(seed)
    assert compiled > 30


def body(joint: str, actuator: str = "", head: str = "") -> RobotView:
    """The text reading of a body with one joint."""
    return read_mjcf_text(
        document(
            f'<mujoco>{head}<worldbody><body name="b">{joint}<geom size="1"/></body></worldbody>'
            f"<actuator>{actuator}</actuator></mujoco>"
        ),
        "refused",
    )


def test_2_3_spells_the_joint_limit_in_full() -> None:
    """`actuatorforcerange` is the joint's limit, with its own `limited`."""
    (joint,) = body('<joint name="j" actuatorforcerange="-4 5"/>').joints
    assert joint.effort_range == (-4.0, 5.0)
    assert joint.stated == {"effort"}
    (joint,) = body('<joint name="j" actuatorforcerange="-4 5" actuatorforcelimited="false"/>').joints
    assert joint.effort_range is None


def test_dcmotor_of_3_7_has_gains_in_volts() -> None:
    """K = 0.8, R = 3.2: kp 40 V/rad is 10 N*m/rad, kd 3.2 V*s/rad is 0.8, and back-EMF adds 0.2."""
    text = '<dcmotor joint="j" nominal="24 6 30" input="position" controller="40 0 3.2 0 0 24"/>'
    (found,) = body('<joint name="j"/>', text).actuators
    assert (found.control, found.back_emf) == ("dcmotor", 0.0)
    assert (found.kp, found.kd) == pytest.approx((10.0, 1.0), rel=EXACT)
    assert found.line == pytest.approx((6.0, 30.0), rel=EXACT)
    text = '<dcmotor joint="j" gear="2" nominal="24 6 30" input="velocity" controller="3.2 0 0 0 0 24"/>'
    (found,) = body('<joint name="j"/>', text).actuators
    # gear^2 * (3.2 * 0.25 + 0.2)
    assert (found.kp, found.kd) == pytest.approx((0.0, 4.0), rel=EXACT)
    text = '<dcmotor joint="j" nominal="24 6 30" input="voltage"/>'
    (found,) = body('<joint name="j"/>', text).actuators
    assert (found.kp, found.kd, found.back_emf) == pytest.approx((0.0, 0.2, 0.2), rel=EXACT)


@pytest.mark.parametrize(
    "free",
    [
        "<freejoint/>",
        '<freejoint name="f"/>',
        '<joint name="f" type="free"/>',
        '<joint name="f" class="free"/>',
    ],
)
def test_nothing_hangs_on_a_free_joint(free: str) -> None:
    """It moves the base, with a name and without one, however it is written; a ball is one that others hang on."""
    text = document(
        f"""<mujoco><default><default class="free"><joint type="free"/></default></default>
<worldbody><body>{free}<geom size="0.1"/><body><joint name="hip"/><geom size="0.1"/><body>
<joint name="ankle" type="ball"/><geom size="0.1"/><body><joint name="toe"/><geom size="0.1"/></body></body></body>
</body></worldbody></mujoco>"""
    )
    for view in (read_mjcf(text.files, text), read_mjcf_text(text, "refused")):
        found = {joint.name: joint.parent for joint in view.joints if joint.name != "f"}
        assert found == {"hip": "", "ankle": "hip", "toe": "ankle"}


def test_what_only_a_compilation_tells_is_unknown() -> None:
    """dampratio, inheritrange, springdamper and a number that is none are named, and nothing else."""
    actuators = (
        '<position name="a" joint="j" kp="7" dampratio="1"/><position name="b" joint="j" inheritrange="1"/>'
        '<motor name="c" joint="j" gear="3,5"/><pid name="d" joint="j" input="vel" velrange="-1 1"/>'
    )
    view = body('<joint name="j" springdamper=".1 1" frictionloss="x"/>', actuators)
    assert view.joints[0].unknown == {"damping", "stiffness", "frictionloss"}
    assert {a.name: set(a.unknown) for a in view.actuators} == {
        "a": {"kd"},
        "b": {"control_range", "input_range"},
        "c": {"gear", "kp", "kd", "back_emf"},
        "d": {"control_range", "input_range"},
    }
    assert view.actuators[0].kp == 7.0
    assert (view.inertia, view.inertia_reason) == (
        None,
        "only its text was read, because MuJoCo refuses the file",
    )


def test_autolimits_and_angles() -> None:
    """Without autolimits a range is a limit only where it says so; radian ranges stay as they are."""
    joint = '<joint name="j" range="-1 2"/>'
    assert body(joint, head='<compiler angle="radian"/>').joints[0].range == (-1.0, 2.0)
    assert body(joint, head='<compiler autolimits="false"/>').joints[0].range is None
    limited = '<joint name="j" range="-90 180" limited="true"/>'
    found = body(limited, head='<compiler autolimits="false"/>').joints[0].range
    assert found == pytest.approx((-math.pi / 2, math.pi), rel=EXACT)


def test_later_sections_count() -> None:
    """Of two options and compilers the later counts; main defaults of two sections add up."""
    head = """<compiler angle="radian"/><compiler angle="degree"/><option timestep="0.01"/><option timestep="0.005"/>
<default><joint damping="1"/></default><default><joint armature="2"/></default>"""
    view = body('<joint name="j" range="0 180"/>', head=head)
    (joint,) = view.joints
    assert view.timestep == 0.005
    assert (joint.damping, joint.armature) == (1.0, 2.0)
    assert joint.range == pytest.approx((0.0, math.pi), rel=EXACT)


def test_what_is_not_in_the_text_is_said_to_be_left_out() -> None:
    """Copies by `replicate` are not made, and the reader says so."""
    view = read_mjcf_text(
        document(
            '<mujoco><worldbody><replicate count="3" euler="0 0 1"><body><joint name="j"/><geom size="1"/>'
            "</body></replicate></worldbody></mujoco>"
        ),
        "refused",
    )
    assert view.joints == ()
    assert [d.message for d in view.diagnostics] == ["what replicate makes is left out"]


@pytest.mark.parametrize("gear", ["3e300", "-2e154 1", "inf"])
def test_gear_beyond_every_robot(gear: str) -> None:
    """Found by the fuzzer: no float holds its square. Refused where it is stated, the class too."""
    joint = '<worldbody><body><joint name="knee"/><geom size="0.1" mass="1"/></body></worldbody>'
    own = f'<mujoco>{joint}\n<actuator><motor joint="knee" gear="{gear}"/></actuator></mujoco>'
    drive = '<actuator><motor joint="knee"/></actuator>'
    above = f'<mujoco><default>\n<motor gear="{gear}"/></default>{joint}{drive}</mujoco>'
    for text, place in ((own, "m.xml:2:11"), (above, "m.xml:2:1")):
        with pytest.raises(RobotError, match=f"^{place}: ROBOT127: a gear of"):
            read_mjcf_text(document(text), "not asked")
