"""Mass matrices over poses, against hand calculation, MuJoCo's own matrix and Sobol poses."""

from __future__ import annotations

import math
import os
import warnings
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from actspec.robot import inertia
from actspec.robot.inertia import InertiaUnknown, latin_hypercube, pose_inertia
from actspec.robot.mjspec import compile_spec, open_spec
from actspec.robot.view import InertiaRange, ModelFormat, PoseInertia
from actspec.robot.xml import open_document

CORPUS = Path(os.environ.get("ACTSPEC_CORPUS", Path(__file__).parents[3] / "shared" / "corpus"))
GO2 = CORPUS / "unitree_mujoco" / "unitree_robots" / "go2" / "go2.xml"

POINT = 'mass="{m}" pos="{x} 0 0" diaginertia="{i} {i} {i}"'


def compiled(text: str) -> Any:
    """A model from its text."""
    return mujoco.MjModel.from_xml_string(text)


def arm(first: str = "", second: str = "", rest: str = "") -> str:
    """Two links about z: m1 = 2 kg at 0.5 m, I1 = 0.1; joint 2 at 1 m; m2 = 3 kg at 0.4 m, I2 = 0.2."""
    return f"""<mujoco><compiler angle="radian"/><worldbody><body>
      <joint name="a" axis="0 0 1" {first}/><inertial {POINT.format(m=2, x=0.5, i=0.1)}/>
      <body pos="1 0 0"><joint name="b" axis="0 0 1" {second}/><inertial {POINT.format(m=3, x=0.4, i=0.2)}/>
      </body></body></worldbody>{rest}</mujoco>"""


def two_link(q2: float) -> np.ndarray[Any, Any]:
    """Textbook matrix of `arm`: M22 = I2 + m2 c2^2 = 0.2 + 3*0.16 = 0.68; see the terms."""
    m22 = 0.2 + 3 * 0.4**2
    m12 = m22 + 3 * 1.0 * 0.4 * math.cos(q2)
    # I1 + m1 c1^2 + I2 + m2 (l1^2 + c2^2 + 2 l1 c2 cos q2)
    m11 = 0.1 + 2 * 0.5**2 + 0.2 + 3 * (1.0 + 0.4**2 + 2 * 0.4 * math.cos(q2))
    return np.array([[m11, m12], [m12, m22]])


def test_one_link() -> None:
    """One link: I + m c^2 at every pose, and the armature is kept apart."""
    text = f"""<mujoco><worldbody><body><joint name="j" axis="0 0 1" armature="0.07"/>
      <inertial {POINT.format(m=2, x=0.5, i=0.1)}/></body></worldbody></mujoco>"""
    found = pose_inertia(compiled(text))
    # 0.1 + 2 * 0.25 = 0.6
    assert found.matrices.shape == (257, 1, 1)
    np.testing.assert_allclose(found.matrices, 0.6, rtol=1e-12)
    np.testing.assert_allclose(found.armature, [0.07])
    held = found.held({0: 0.4})[0]
    # 0.6 + 0.4; the file's 0.07 is replaced, not added to.
    np.testing.assert_allclose((held.reference, held.low, held.high), 1.0)
    free = found.free({0: 0.4})[0]
    np.testing.assert_allclose((free.reference, free.low, free.high), 1.0)


WHEEL = """<mujoco><worldbody><body><joint name="j" axis="0 0 1" armature="0.07"/>
<inertial mass="2" pos="0 0 0" diaginertia="0.1 0.1 0.1"/></body></worldbody>
<actuator><motor joint="j" gear="2" armature="0.01"/></actuator></mujoco>"""


def test_wheel() -> None:
    """A wheel on its own axis, whose diagonal MuJoCo does not compute anew, has no armature in it."""
    model = compiled(WHEEL)
    found = pose_inertia(model)
    np.testing.assert_allclose(found.matrices, 0.1, rtol=1e-12)
    # 0.07 + 4 * 0.01
    np.testing.assert_allclose(found.armature, [0.11])
    assert model.dof_M0[0] == pytest.approx(0.21)


def test_two_links_at_the_reference() -> None:
    """At q2 = 0 the matrix is the textbook's; free inertia is 1/(M^-1)_jj with armature."""
    found = pose_inertia(compiled(arm()))
    # M11 = 0.1+0.5+0.2+3*(1.16+0.8) = 6.68, M12 = 0.68+1.2 = 1.88, M22 = 0.68
    np.testing.assert_allclose(found.matrices[0], [[6.68, 1.88], [1.88, 0.68]], rtol=1e-12)
    # M11 - M12^2/(M22 + 0.1) = 6.68 - 3.5344/0.78 = 2.14872; the other keeps the file's armature, 0
    free = found.free({1: 0.1})[1]
    # 0.78 - 3.5344/6.68 = 0.250898
    assert free.reference == pytest.approx(0.78 - 1.88**2 / 6.68, rel=1e-9)
    both = found.free({0: 0.0, 1: 0.1})
    assert both[0].reference == pytest.approx(2.148718, rel=1e-6)


def test_range_over_poses() -> None:
    """M11 runs from q2 = pi (1.88) to q2 = 0 (6.68); a joint without a range is turned all round."""
    found = pose_inertia(compiled(arm())).held({0: 0.0, 1: 0.0})
    # 0.1+0.5+0.2+3*(1.16-0.8) = 1.88
    assert found[0].low == pytest.approx(1.88, abs=0.005)
    assert found[0].high == pytest.approx(6.68, abs=0.005)
    assert found[1].low == pytest.approx(0.68)


def test_limits_bound_the_poses() -> None:
    """With q2 in [1, 1.5] rad no pose but the reference is outside of it."""
    found = pose_inertia(compiled(arm(second='range="1 1.5" limited="true"')))
    m11 = found.matrices[1:, 0, 0]
    # cos 1.5 and cos 1 bound the term.
    assert m11.min() > two_link(1.5)[0, 0] - 1e-12
    assert m11.max() < two_link(1.0)[0, 0] + 1e-12
    # 256 cells of 0.5/256 rad: the outermost are within one cell of the ends.
    assert m11.min() == pytest.approx(two_link(1.5)[0, 0], abs=2.4 * 0.5 / 256)


def test_the_reference_is_a_pose_that_the_joint_can_take() -> None:
    """A knee that never stretches: qpos0 is outside of its range, and the nearest end counts."""
    knee = 'range="0.524 2.531" limited="true"'
    found = pose_inertia(compiled(arm(second=knee)))
    np.testing.assert_allclose(found.matrices[0], two_link(0.524), rtol=1e-12)
    assert found.matrices[:, 0, 0].max() <= two_link(0.524)[0, 0] * (1 + 1e-12)
    key = '<keyframe><key qpos="0 0"/></keyframe>'
    np.testing.assert_allclose(pose_inertia(compiled(arm(second=knee, rest=key))).matrices[0], two_link(0.0))


def test_first_keyframe_is_the_reference() -> None:
    """The reference pose is the first keyframe, not qpos0 and not the second."""
    keys = '<keyframe><key qpos="0.3 0.9"/><key qpos="0 0.1"/></keyframe>'
    found = pose_inertia(compiled(arm(rest=keys)))
    np.testing.assert_allclose(found.matrices[0], two_link(0.9), rtol=1e-12)


def test_armature_is_left_out() -> None:
    """Joint and actuator armature (gear^2) are in `armature`, not in the matrices; the model is as it was."""
    motor = '<motor joint="b" gear="{}" armature="{}"/>'
    rest = f"<actuator>{motor.format(3, 0.05)}{motor.format(-2, 0.01)}</actuator>"
    model = compiled(arm('armature="0.1"', 'armature="0.2"', rest))
    found = pose_inertia(model)
    np.testing.assert_allclose(found.matrices[0], two_link(0.0), rtol=1e-12)
    # b: 0.2 + 9*0.05 + 4*0.01 = 0.69
    np.testing.assert_allclose(found.armature, [0.1, 0.69])
    np.testing.assert_allclose(model.dof_armature, [0.1, 0.2])
    np.testing.assert_allclose(model.actuator_armature, [0.05, 0.01])
    # The engine's own matrix, column by column, is the sum.
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    columns = np.zeros((2, 2))
    for column, unit in zip(columns, np.eye(2), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    np.testing.assert_allclose(found.matrices[0] + np.diag(found.armature), columns, rtol=1e-12)


def test_slide_ball_and_free_stay() -> None:
    """A slide without a range, a ball and a free joint stay at the reference; a hinge on them moves."""
    text = """<mujoco><worldbody><body><freejoint name="f"/><geom size="0.1"/>
      <body pos="1 0 0"><joint name="s" type="slide" axis="1 0 0"/><geom size="0.1"/>
      <body pos="0 1 0"><joint name="b" type="ball"/><geom size="0.1"/>
      <body pos="0 0 1"><joint name="h" axis="1 0 0"/><geom size="0.1" pos="0 0.4 0"/>
      </body></body></body></body></worldbody></mujoco>"""
    model = compiled(text)
    columns, low, high = inertia._sampled(model)
    # qpos: 7 free, 1 slide, 4 ball, then the hinge at 12.
    assert (list(columns), list(low), list(high)) == ([12], [-math.pi], [math.pi])
    assert pose_inertia(model).matrices.shape == (257, 11, 11)


def test_nothing_to_sample() -> None:
    """A model that cannot move has one pose and an empty matrix."""
    model = compiled("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    assert pose_inertia(model).matrices.shape == (1, 0, 0)


def test_an_inertia_beyond_the_inverse_is_infinite() -> None:
    """1/(M^-1)_jj where (M^-1)_jj is 0 as a double; numpy says nothing (warnings are errors here)."""
    found = PoseInertia(np.full((1, 1, 1), 1.5e308), np.zeros(1))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert found.free({0: 1e308})[0] == found.held({0: 1e308})[0] == InertiaRange(*[math.inf] * 3)


def test_singular_matrix_gives_zero() -> None:
    """Two joints on one axis without armature resist nothing: free inertia 0, no exception."""
    matrices = np.ones((2, 2, 2))

    free = PoseInertia(matrices, np.zeros(2)).free({0: 0.0})
    assert free[0].high == pytest.approx(0.0, abs=1e-9)


ACTUATORS = (
    '<tendon><fixed name="t" armature="0.3"><joint joint="a" coef="1"/><joint joint="b" coef="-1"/></fixed></tendon>'
    '<actuator><motor joint="a" gear="3" armature="0.02"/><motor joint="b" armature="0.05"/></actuator>'
)


@pytest.mark.parametrize(
    "text",
    [
        arm('armature="0.5"', 'range="-1 2" limited="true"'),
        arm('armature="0.5"', "", '<keyframe><key qpos="0.3 1.1"/></keyframe>'),
        arm('armature="0.5"', 'armature="0.1"', ACTUATORS),
        """<mujoco><worldbody><body><freejoint/><inertial mass="2" pos="0.1 0 0" diaginertia="1 2 2"/>
        <body pos="0 0 1"><joint name="s" type="slide" axis="1 0 0" range="-1 1"/>
        <inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><body pos="0 1 0"><joint type="ball"/>
        <inertial mass="1" pos="0 0 0.5" diaginertia="1 1 1"/><body pos="1 0 0"><joint name="h" armature="0.1"/>
        <inertial mass="1" pos="0 0 0.5" diaginertia="1 1 1"/></body></body></body></body></worldbody></mujoco>""",
        WHEEL,
        '<mujoco><worldbody><body><freejoint/><geom size="1"/></body></worldbody></mujoco>',
        "<mujoco/>",
    ],
    ids=[
        "limits",
        "keyframe",
        "tendon-and-actuator-armature",
        "slide-ball-free",
        "wheel",
        "no-hinge",
        "nothing",
    ],
)
def test_the_model_is_left_as_it_was(text: str) -> None:
    """Its armature is off during the call only."""
    model = compiled(text)
    before = (model.dof_armature.copy(), model.actuator_armature.copy(), model.dof_M0.copy())
    pose_inertia(model, 16)
    after = (model.dof_armature, model.actuator_armature, model.dof_M0)
    assert all(np.array_equal(one, other) for one, other in zip(before, after, strict=True))


def test_the_files_own_armature_has_its_actuators() -> None:
    """Joint 2 of the arm with 0.05 of its actuator's armature: 0.68 + 0.05; a tendon couples, so 0.3 more."""
    found = pose_inertia(compiled(arm(rest=ACTUATORS)))
    held = found.held({1: float(found.armature[1])})
    assert held[1].reference == pytest.approx(0.68 + 0.05 + 0.3, rel=1e-12)


def test_memory_bounds_the_poses(monkeypatch: pytest.MonkeyPatch) -> None:
    """Poses are fewer where the matrices would not fit, and none is an error."""
    model = compiled(arm())
    # 2*2*8 = 32 bytes a pose.
    monkeypatch.setattr(inertia, "MOST_BYTES", 32 * 10)
    assert len(pose_inertia(model).matrices) == 10
    monkeypatch.setattr(inertia, "MOST_BYTES", 31)
    with pytest.raises(InertiaUnknown, match="2 degrees of freedom are too many"):
        pose_inertia(model)


def test_latin_hypercube_is_latin() -> None:
    """Each coordinate has each cell once, and columns are not the same permutation."""
    points = latin_hypercube(16, 5, inertia.SEED)
    cells = np.sort(points, axis=0)
    np.testing.assert_allclose(cells, np.tile((np.arange(16)[:, None] + 0.5) / 16, (1, 5)))
    assert len({tuple(column) for column in points.T}) == 5


def test_splitmix64_is_the_published_one() -> None:
    """The first numbers for seed 0 are splitmix64's, so that poses are the same everywhere."""
    # 16294208416658607535, 7960286522194355700, 487617019471545679 for seed 0: ranks 2, 1, 0.
    np.testing.assert_allclose(latin_hypercube(3, 1, 0)[:, 0], [2.5 / 3, 1.5 / 3, 0.5 / 3])


@pytest.mark.skipif(not GO2.is_file(), reason="no corpus of real robot files")
@pytest.mark.parametrize("which", ["held", "free"])
def test_extremes_agree_with_sobol(which: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Go2: the extremes over our 256 poses are those of 4096 Sobol poses, within 10 % at every joint."""
    qmc = pytest.importorskip("scipy.stats.qmc")
    files = open_document(str(GO2)).files
    model = compile_spec(open_spec(files, format=ModelFormat.MJCF), files)
    ours = pose_inertia(model)

    def sobol(count: int, dimensions: int, seed: int) -> Any:
        return qmc.Sobol(dimensions, scramble=True, seed=7).random(count)

    monkeypatch.setattr(inertia, "latin_hypercube", sobol)
    theirs = pose_inertia(model, 4096)
    armature = {dof: float(ours.armature[dof]) for dof in range(6, model.nv)}
    mine, other = getattr(ours, which)(armature), getattr(theirs, which)(armature)
    # Chosen: 10 %; measured at most 5.2 %, where 256 Sobol poses have 6.0 %.
    for dof in armature:
        assert mine[dof].low == pytest.approx(other[dof].low, rel=0.1)
        assert mine[dof].high == pytest.approx(other[dof].high, rel=0.1)
        assert mine[dof].reference == pytest.approx(other[dof].reference, rel=1e-12)
