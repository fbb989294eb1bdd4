"""Where the loss of a torque-speed line is: what counts is up to no-load speed."""

from __future__ import annotations

import pytest

from actspec.ir import Command
from actspec.laws import TorqueLaw
from actspec.targets.kit.sizes import boxed, line_error, lined, two_quadrants

CURVED = TorqueLaw(Command.POSITION, 50.0, 1.0, 120.0, None, None, (120.0, 120.0, 5.0, 20.0), 0.0, None, 0.0)
LINE = TorqueLaw(Command.POSITION, 50.0, 1.0, 30.0, 45.0, 20.0, None, 0.0, None, 0.0)


def test_a_curve_and_its_drive_side() -> None:
    """120 (1 - (w - 5)/15) driving, which the line 160 (1 - w/20) is; braking at 20 rad/s 0, and the line 120."""
    found = line_error(CURVED, lined(CURVED).torque, "rad/s")
    assert (found.error, found.at) == (pytest.approx(120.0), "braking at 20 rad/s, none driving")
    # Above it the line still gives -120 where the curve has nothing.
    assert found.beyond == pytest.approx(120.0)


def test_a_box_for_a_line() -> None:
    """At 20 rad/s the line has 0 where the box gives 30; at 40 the line forces max(-30, 45 (1 - 2)) = -30: 60."""
    found = line_error(LINE, boxed(LINE).torque, "rad/s")
    assert (found.error, found.at, found.beyond) == (
        pytest.approx(30.0),
        "driving at 20 rad/s, none braking",
        pytest.approx(60.0),
    )


def test_only_above_no_load_speed() -> None:
    """Two quadrants are the same as four up to no-load speed; above it they do not force 30 N*m."""
    found = line_error(LINE, two_quadrants(LINE), "rad/s")
    assert (found.error, found.at, found.beyond) == (0.0, "", pytest.approx(30.0))
