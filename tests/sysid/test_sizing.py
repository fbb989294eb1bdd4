"""How an experiment's amplitude comes down to what is allowed."""

from __future__ import annotations

import pytest

from actspec.sysid.sizing import SHRINK, _factor


def test_an_amplitude_that_takes_a_share_of_the_torque_comes_down_in_two_tries() -> None:
    """Gravity takes 0.8 of what is allowed and the swing 0.4 of its size: 0.5 is left, by hand."""

    def share(size: float) -> float:
        return 0.8 + 0.4 * size

    first = _factor(1.0, share(1.0), None)
    assert first == pytest.approx(1.0 / 1.2)
    assert first * _factor(first, share(first), (1.0, share(1.0))) == pytest.approx(0.5)


def test_one_try_changes_an_amplitude_by_so_much_alone() -> None:
    """A line that tells of nothing, or of too much, is not believed: the joints move each other."""
    assert _factor(0.9, 1.2, (1.0, 1.1)) == pytest.approx(1.0 / 1.2)
    assert _factor(0.9, 1.5, (1.0, 1.51)) == SHRINK[0]
    assert _factor(0.9, 1.001, (1.0, 1.2)) == SHRINK[1]
