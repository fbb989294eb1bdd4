"""Linkages: limits, speeds and armature of joints that several motors move, against hand and MuJoCo."""

from __future__ import annotations

import pytest

from actspec.ir import ActuatorSet, Approximation, JointActuator
from tests.fitting import fit, spec_of

MOTORS = (
    "{a: {side: joint, peak_torque: 30 N*m, stall_torque: 40 N*m, no_load_speed: 12 rad/s, "
    "reflected_inertia: 0.02 kg*m^2}, b: {side: joint, peak_torque: 20 N*m, stall_torque: 50 N*m, "
    "no_load_speed: 20 rad/s, reflected_inertia: 0.01 kg*m^2}, "
    "jack: {side: joint, peak_torque: 500 N, no_load_speed: 0.4 m/s, reflected_inertia: 3 kg}}"
)
ROBOT = "name: leg, model: none, joints: [pitch, roll]"
# J^-1 = 1/(-1.1) [[-0.5, -0.6], [-1, 1]] = [[0.4545.., 0.5454..], [0.9090.., -0.9090..]]
JACOBIAN = "[[1, 0.6], [1, -0.5]]"


def linkage(
    geometry: str, *, motors: str = "[a, b]", group: str = "level: ideal_pd", robot: str = ROBOT
) -> ActuatorSet:
    """Two joints behind a linkage `ankle`."""
    return fit(
        spec_of(
            f"ankle: {{joints: [pitch, roll], {group}, kp: 1, kd: 1}}",
            robot=robot,
            motors=MOTORS,
            more=f"linkages: {{ankle: {{joints: [pitch, roll], motors: {motors}, {geometry}}}}}",
        )
    )


def values(found: ActuatorSet, field: str) -> list[float | None]:
    """A field of each joint."""
    return [getattr(joint, field).value for joint in found.joints]


def losses(found: ActuatorSet, field: str) -> list[Approximation]:
    """Approximations of one name."""
    return [loss for loss in found.approximations if loss.field == field]


def test_alone() -> None:
    """t_m = J^-T t: for pitch alone (0.4545, 0.5454) of it, for roll alone (0.9090, -0.9090).

    Pitch: least of 30/0.4545 = 66 and 20/0.5454 = 36.667. Roll: least of 30/0.9090 = 33 and 20/0.9090 = 22.
    """
    found = linkage(f"jacobian: {JACOBIAN}")
    assert values(found, "peak_torque") == pytest.approx([20 * 1.1 / 0.6, 22.0])
    assert values(found, "effort_limit") == pytest.approx([20 * 1.1 / 0.6, 22.0])
    pitch = found.joints[0]
    assert pitch.motor == "a, b by the linkage ankle"
    assert pitch.peak_torque.formula == "20 N*m (b) / 0.545455, linkage ankle"


def test_together() -> None:
    """Both at `alone`: a needs 36.667 x 0.4545 + 22 x 0.9090 = 36.667 of 30, b 20 + 20 = 40 of 20: half of both."""
    found = linkage(f"jacobian: {JACOBIAN}, limits: together")
    assert values(found, "peak_torque") == pytest.approx([20 * 1.1 / 0.6 / 2, 11.0])
    assert found.joints[1].peak_torque.formula == (
        "20 N*m (b) / 0.909091 x 0.5 (share that all joints can have at once), linkage ankle"
    )
    limits = losses(found, "linkage_limits")
    # What a joint alone could have and does not get.
    assert [loss.max_torque_error for loss in limits] == pytest.approx([20 * 1.1 / 0.6 / 2, 11.0])


def test_the_torque_speed_line() -> None:
    """Stall as the limits: pitch least of 40/0.4545 = 88 and 50/0.5454 = 91.667, roll 44.

    Speeds by J itself: pitch at 12/1 (a, not b's 20), roll at least of 12/0.6 = 20 and 20/0.5 = 40.
    """
    found = linkage(f"jacobian: {JACOBIAN}", group="level: dc_motor")
    assert [
        joint.stall_torque.value for joint in found.joints if joint.stall_torque is not None
    ] == pytest.approx([88.0, 44.0])
    speeds = [joint.no_load_speed for joint in found.joints if joint.no_load_speed is not None]
    assert [speed.value for speed in speeds] == pytest.approx([12.0, 20.0])
    assert speeds[1].formula == "12 rad/s (a) / 0.6, linkage ankle"


def test_armature() -> None:
    """J^T diag(0.02, 0.01) J: 0.03, 0.02 x 0.36 + 0.01 x 0.25 = 0.0097, between them 0.012 - 0.005 = 0.007."""
    found = linkage(f"jacobian: {JACOBIAN}")
    assert values(found, "armature") == pytest.approx([0.03, 0.0097])
    assert (
        found.joints[1].armature.formula == "0.02 kg*m^2 (a) x 0.36 + 0.01 kg*m^2 (b) x 0.25, linkage ankle"
    )
    pitch, roll = losses(found, "linkage_inertia")
    assert pitch.asked == "0.007 kg*m^2 with roll"
    # The other joint's limit on its armature: 0.007 x 22 / 0.0097, 0.007 x 36.667 / 0.03.
    assert pitch.max_torque_error == pytest.approx(0.007 * 22 / 0.0097)
    assert roll.max_torque_error == pytest.approx(0.007 * 22 / 0.6 / 0.03)


def test_equal_motors_and_mirrored_rods_couple_no_inertia() -> None:
    """[[1, r], [1, -r]] with the same motor twice: I - I = 0 between the joints; twice the torque alone."""
    found = linkage("jacobian: [[1, 0.6], [1, -0.6]]", motors="[a, a]")
    assert losses(found, "linkage_inertia") == []
    assert values(found, "peak_torque") == pytest.approx([60.0, 36.0])
    # Both at once ask for twice the motors' torque: half of each limit is missing.
    assert [loss.max_torque_error for loss in losses(found, "linkage_limits")] == pytest.approx([30.0, 18.0])
    assert "need 2 times their peak torque" in losses(found, "linkage_limits")[0].why


def test_stated_limits_within_the_motors_lose_nothing() -> None:
    """30 and 18 N*m are just what [[1, 0.6], [1, -0.6]] has at once; a little more is not."""
    same = "jacobian: [[1, 0.6], [1, -0.6]]"
    group = "level: ideal_pd, overrides: {pitch: {effort_limit: 30}, roll: {effort_limit: %s}}"
    assert losses(linkage(same, motors="[a, a]", group=group % 18), "linkage_limits") == []
    assert len(losses(linkage(same, motors="[a, a]", group=group % 18.1), "linkage_limits")) == 2


def test_a_diagonal_shares_nothing() -> None:
    """Each motor drives its own joint: limits are exact, at once and alone."""
    found = linkage("jacobian: [[2, 0], [0, 4]], at: any")
    assert values(found, "peak_torque") == pytest.approx([60.0, 80.0])
    assert values(found, "armature") == pytest.approx([0.08, 0.16])
    assert found.approximations == ()


def test_unknown_motors() -> None:
    """An unknown torque is no limit, and what it would be shared with is told without a size."""
    found = linkage(f"jacobian: {JACOBIAN}", group="level: ideal_pd, effort_limit: unknown")
    assert values(found, "effort_limit") == [None, None]
    assert [loss.max_torque_error for loss in losses(found, "linkage_limits")] == [None, None]


TABLE = (
    "table: [{at: [0, 0], jacobian: [[1, 0.6], [1, -0.6]]}, "
    "{at: [0.5 rad, 0], jacobian: [[0.8, 0.6], [0.8, -0.6]]}, "
    "{at: [-1 rad, 0], jacobian: [[0.5, 0.4], [0.5, -0.4]]}]"
)


@pytest.mark.parametrize(
    ("pose", "pitch", "text"),
    [
        pytest.param("", 60.0, "at [0, 0] rad", id="zero"),
        pytest.param("pitch: 0.5 rad", 48.0, "at [0.5, 0] rad", id="in the table"),
        pytest.param(
            "pitch: 0.3 rad",
            48.0,
            "at [0.5, 0] rad, of 3 poses the nearest to [0.3, 0] rad",
            id="nearest",
        ),
        pytest.param(
            "pitch: -0.6 rad, roll: 0.1 rad",
            30.0,
            "at [-1, 0] rad, of 3 poses the nearest to [-0.6, 0.1] rad",
            id="both joints",
        ),
    ],
)
def test_table(pose: str, pitch: float, text: str) -> None:
    """The Jacobian at the default pose: 2 x 30 x 1, 0.8 or 0.5 N*m."""
    found = linkage(TABLE, motors="[a, a]", robot=f"{ROBOT}, default_pose: {{{pose}}}")
    assert found.joints[0].effort_limit.value == pytest.approx(pitch)
    assert (found.joints[0].armature.formula or "").endswith(f", linkage ankle {text}")


def test_table_reports_its_range() -> None:
    """Pitch 30 to 60 N*m, 2 x 0.02 x 0.25 to 1; the size is the farthest from what is used, 60 - 30."""
    loss = losses(linkage(TABLE, motors="[a, a]"), "linkage_pose")[0]
    assert loss.asked == "limit 30 to 60 N*m, armature 0.01 to 0.04 kg*m^2 over 3 poses"
    assert loss.emitted == "limit 60 N*m, armature 0.04 kg*m^2"
    assert loss.max_torque_error == pytest.approx(30.0)


@pytest.mark.parametrize(
    ("at", "count"),
    [
        pytest.param("", 2, id="nobody says"),
        pytest.param(", at: [0.1 rad, 0]", 2, id="at a pose"),
        pytest.param(", at: any", 0, id="at any"),
    ],
)
def test_one_pose(at: str, count: int) -> None:
    """One Jacobian is that of one pose, unless it is said to hold at any."""
    found = losses(linkage(f"jacobian: {JACOBIAN}{at}"), "linkage_pose")
    assert [loss.max_torque_error for loss in found] == [None] * count


def test_plain_factor() -> None:
    """(30 + 20) x 0.5, the slower motor's 12 rad/s / 0.5, (0.02 + 0.01) x 0.25; and nobody computed it."""
    found = linkage("factor: 0.5")
    assert values(found, "effort_limit") == pytest.approx([25.0, 25.0])
    assert values(found, "armature") == pytest.approx([0.0075, 0.0075])
    assert found.joints[0].peak_torque.formula == "(30 N*m (a) + 20 N*m (b)) x 0.5, linkage ankle"
    (pitch, roll) = found.approximations
    assert (pitch.key, roll.joint) == ("spec.linkage_factor", "roll")


def test_plain_factor_of_a_line() -> None:
    """Torques add up to 90 N*m, the speed is the slower motor's."""
    found = linkage("factor: 0.5", group="level: dc_motor").joints[0]
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert (found.stall_torque.value, found.no_load_speed.value) == (45.0, 24.0)


def test_linear_motors() -> None:
    """Rods at 50 and 30 mm/rad: pitch 2 x 500 x 0.05 = 50 N*m, roll 30; 2 x 3 kg x 0.05^2 = 0.015 kg*m^2."""
    found = linkage(
        "jacobian: [[50 mm/rad, 30 mm/rad], [50 mm/rad, -30 mm/rad]], at: any", motors="[jack, jack]"
    )
    assert values(found, "effort_limit") == pytest.approx([50.0, 30.0])
    assert [joint.effort_limit.unit for joint in found.joints] == ["N*m", "N*m"]
    assert values(found, "armature") == pytest.approx([0.015, 0.0054])
    assert found.joints[0].armature.unit == "kg*m^2"


def test_one_joint_with_a_table() -> None:
    """A knee whose jack has 40 mm at 0 and 50 mm at 1 rad: 500 x 0.05 at the default pose of 0.8 rad."""
    found = fit(
        spec_of(
            "knee: {joints: [knee], level: ideal_pd, kp: 1, kd: 1}",
            robot="name: leg, model: none, joints: [knee], default_pose: {knee: 0.8 rad}",
            motors=MOTORS,
            more="linkages: {k: {joints: [knee], motors: [jack], table: [{at: [0], jacobian: [[40 mm/rad]]}, "
            "{at: [1 rad], jacobian: [[50 mm/rad]]}]}}",
        )
    )
    (knee,) = found.joints
    assert knee.effort_limit.value == pytest.approx(25.0)
    (loss,) = found.approximations
    assert (loss.field, loss.max_torque_error) == ("linkage_pose", pytest.approx(5.0))


def _dofs(joints: tuple[JointActuator, ...], field: str) -> list[float]:
    return [float(getattr(joint, field).value) for joint in joints]


def test_mujoco_has_the_same_linkage() -> None:
    """Two motors on tendons with the rows of J as coefficients, in the engine: inertia, torque and speed.

    Of a body without mass to speak of, the mass matrix is J^T diag(I) J and the joint torques J^T m.
    """
    import mujoco
    import numpy as np

    joints = "".join(
        f'<joint name="{name}" axis="{axis}"/>' for name, axis in (("pitch", "0 1 0"), ("roll", "1 0 0"))
    )
    rows = ((1.0, 0.6), (1.0, -0.5))
    tendons = "".join(
        f'<fixed name="t{k}"><joint joint="pitch" coef="{p}"/><joint joint="roll" coef="{r}"/></fixed>'
        for k, (p, r) in enumerate(rows)
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option gravity="0 0 0"/><worldbody><body>{joints}'
        '<inertial pos="0 0 0" mass="1e-9" diaginertia="1e-12 1e-12 1e-12"/></body></worldbody>'
        f"<tendon>{tendons}</tendon><actuator>"
        '<motor tendon="t0" armature="0.02"/><motor tendon="t1" armature="0.01"/></actuator></mujoco>'
    )
    data = mujoco.MjData(model)
    found = linkage(f"jacobian: {JACOBIAN}", group="level: dc_motor")
    limits = _dofs(found.joints, "peak_torque")
    inverse = np.linalg.inv(np.array(rows).T)
    for index, limit in enumerate(limits):
        # The motors that give one joint its limit and the other nothing: none beyond its own peak, one at it.
        wanted = np.zeros(2)
        wanted[index] = limit
        data.ctrl[:] = inverse @ wanted
        mujoco.mj_forward(model, data)
        assert data.qfrc_actuator == pytest.approx(wanted)
        assert max(abs(data.ctrl) / [30.0, 20.0]) == pytest.approx(1.0)
    mass = np.zeros((2, 2))
    for index in range(2):
        mujoco.mj_mulM(model, data, mass[index], np.eye(2)[index])
    assert np.diag(mass) == pytest.approx(_dofs(found.joints, "armature"), rel=1e-6)
    assert mass[0, 1] == pytest.approx(0.007, rel=1e-6)
    for index, speed in enumerate(_dofs(found.joints, "no_load_speed")):
        data.qvel[:] = 0.0
        data.qvel[index] = speed
        mujoco.mj_forward(model, data)
        assert max(abs(data.actuator_velocity) / [12.0, 20.0]) == pytest.approx(1.0)


def test_a_share_needs_every_motor() -> None:
    """With one motor unknown nobody knows what all joints can have at once, also where they share nothing."""
    motors = "{known: {side: joint, peak_torque: 30 N*m}, other: {side: joint, peak_torque: unknown}}"
    for mode, expected in (("alone", [60.0, None]), ("together", [None, None])):
        text = spec_of(
            "ankle: {joints: [pitch, roll], level: ideal_pd, kp: 1, kd: 1}",
            robot=ROBOT,
            motors=motors,
            more="linkages: {ankle: {joints: [pitch, roll], motors: [known, other], jacobian: [[2, 0], [0, 4]], "
            f"at: any, limits: {mode}}}}}",
        )
        assert values(fit(text), "peak_torque") == expected
