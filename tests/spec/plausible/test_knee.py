"""A knee of a torque-speed curve in another unit than its end."""

from __future__ import annotations

import pytest

from actspec.diagnostics import ActspecError
from tests.fitting import fit, spec_of

REST = "rest: {joints: [hip, calf, slide], level: ideal_pd, kp: 1, kd: 1}"


@pytest.mark.parametrize(
    ("knee", "free", "message", "help"),
    [
        # 195 rpm are 20.4 rad/s, 100 rpm 10.5 rad/s, 200 rpm 20.9 rad/s.
        ("100 rad/s", "195 rpm", "195 rpm, 20.4 rad/s", "is it in rpm? 100 rpm is 10.5 rad/s"),
        ("200 rad/s", "195 rpm", "195 rpm, 20.4 rad/s", "the full torque ends"),
        ("200 rpm", "195 rpm", "195 rpm", "the full torque ends"),
        ("30 rad/s", "20 rad/s", "20 rad/s", "the full torque ends"),
    ],
)
def test_a_knee_beyond_the_end(knee: str, free: str, message: str, help: str) -> None:
    curve = f"{{drive_torque: 60, brake_torque: 60, knee_speed: {knee}, no_load_speed: {free}}}"
    with pytest.raises(ActspecError) as raised:
        fit(spec_of(REST, motors=f"{{m: {{side: joint, curve: {curve}}}}}"))
    (found,) = raised.value.diagnostics
    assert found.code == "SPEC134"
    assert found.message == f"knee_speed {knee} is not below no_load_speed {message}"
    assert (found.help or "").startswith(help)
