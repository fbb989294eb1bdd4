"""Figures that a configuration and a stage of Newton state in one way: limits that are none, and lags in steps."""

from __future__ import annotations

from actspec.diagnostics import Span
from actspec.ir import Delay, Quantity, assumed, stated, tidy, unknown
from actspec.readings.dict_keys import Found
from actspec.units import format_quantity

NONE_FROM = 1e9
"""A limit, stall torque or speed from which on there is none [SI]. Source: Isaac Lab's and mjlab's own defaults."""


NO_KEY = "no key of the dict covers the joint: it gets 0"
"""Why a number is 0 that nobody wrote, in Isaac Lab 2.x and legged_gym."""


def quantity_of(found: Found, unit: str) -> Quantity:
    """What is read of a setting for a joint, as a number with its place and reason."""
    if found.value is None:
        return unknown(unit, found.why, found.span)
    if not found.stated:
        return assumed(found.value, unit, NO_KEY)
    return stated(found.value, unit, found.span)


def real_limit(found: Quantity) -> Quantity:
    """A limit; unknown where it is one of the numbers that stand for none."""
    if found.value is None or found.value < NONE_FROM:
        return found
    return unknown(found.unit, f"{format_quantity(found.value, found.unit)} is no limit", found.span)


def delay_of_steps(
    least: float, most: float, step: float | None, span: Span, sampling: str = "episode"
) -> tuple[Delay, list[str]]:
    """A lag in physics steps as a delay in seconds, and what is to be remarked.

    Args:
        least: Steps.
        most: Steps, at least as many.
        step: Length of one [s]; None: no file states it.
        span: Where the lag is written.
        sampling: When one is drawn, of a range.
    """
    steps = counted(least, most)
    if step is None:
        why = f"{steps} physics steps, whose length no file states"
        return Delay(unknown("s", why, span), 0.0, 0.0, sampling), [f"delay: {why}"]
    ends, formula = (tidy(least * step), tidy(most * step)), f"{steps} steps x {step:g} s"
    if least == most:
        return Delay(stated(ends[1], "s", span, formula=formula), *ends, "episode"), []
    return Delay(unknown("s", f"a range: {formula}", span), *ends, sampling), []


def counted(least: float, most: float) -> str:
    """A number of steps, or a range of them."""
    return f"{most:g}" if least == most else f"{least:g} to {most:g}"
