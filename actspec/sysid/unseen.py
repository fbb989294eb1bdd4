"""How far the position is off where the fit did not look: pieces of its own logs, or logs that it is validated on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from actspec.diagnostics import Collector, Span, listed
from actspec.sysid.descent import Fit, Search, descend
from actspec.sysid.identified import JointFit
from actspec.sysid.work import JointInWork, piecewise
from actspec.units import format_number

WORSE = 3.0
"""Position error on a log of its own over that of the fit, from which on the figures do not carry over. Chosen: as for
the misfit, so that a little more friction on another day is none."""


def held_out(joint: JointInWork) -> float | None:
    """Position error on every fifth piece, with figures from the others [rad or m]."""
    import numpy as np

    fit, scale = joint.fit, joint.scale
    assert fit is not None and scale is not None
    pieces = piecewise(joint)
    if sum(len(p.starts) for p in pieces) < 5:
        return None
    seen, unseen, states, others = [], [], [], []
    for part, (q, qd) in zip(pieces, fit.states, strict=True):
        out = np.arange(len(part.starts)) % 5 == 2
        seen.append(replace(part, starts=part.starts[~out]))
        unseen.append(replace(part, starts=part.starts[out]))
        states.append((q[~out], qd[~out]))
        others.append((q[out], qd[out]))
    low = joint.low
    reading = fit.values["delay"] if joint.torque else None
    seen = [part for part in seen if len(part.starts)]
    search = Search(seen, joint.bounds, fit.free, scale, low, reading)
    refit = descend(search, fit.values, replace(fit, states=tuple(s for s in states if len(s[0]))))
    kept = [(part, state) for part, state in zip(unseen, others, strict=True) if len(part.starts)]
    if not kept:
        return None
    blind = Search([part for part, _ in kept], joint.bounds, (), scale, low, reading)
    tested = descend(blind, refit.values, replace(refit, states=tuple(state for _, state in kept)))
    return tested.noise["position"]


def tested(joint: JointInWork) -> Fit:
    """A joint's figures on the logs of `joint`, which no fit has seen: only where each piece begins is found."""
    fit, scale = joint.fit, joint.scale
    assert fit is not None and scale is not None
    reading = fit.values["delay"] if joint.torque else None
    return descend(Search(piecewise(joint), joint.bounds, (), scale, joint.low, reading), fit.values)


def judge_validation(
    found: Mapping[str, JointFit], logs: Mapping[str, tuple[str, ...]], out: Collector
) -> None:
    """What is to be said of validation.

    Args:
        found: Joints that were fitted.
        logs: Joint to the logs that it was validated on; a joint that is in none of them is left out.
        out: Takes it.
    """
    missing = [name for name in found if name not in logs]
    if missing:
        message = (
            f"no log of --validate has {listed(missing)}: nothing is known of how far these figures carry"
        )
        out.info("SYS028", message)
    for name, paths in logs.items():
        joint = found[name]
        if joint.held_out_rmse is None or joint.held_out_rmse <= WORSE * joint.position_rmse:
            continue
        unit = next(p.unit for p in joint.parameters if p.field == "encoder_bias")
        message = (
            f"the position is off by {format_number(joint.held_out_rmse, 3)} {unit} in {listed(paths, 3)}, and by "
            f"{format_number(joint.position_rmse, 3)} {unit} in the logs of the fit: the figures do not carry over"
        )
        help = (
            "is it the same robot, pose of the base, gains and temperature? Fit logs of both kinds of motion"
        )
        out.warning("SYS029", message, where=name, span=Span(paths[0]), help=help)
