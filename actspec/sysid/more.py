"""Figures that a fit takes in unasked: Stribeck friction and a low-pass of the command, where the logs call for them.

Left out where it is, Stribeck friction makes Coulomb friction 8 to 15 % too large, and a low-pass goes into delay and
kd. Taken in where it is not, a figure explains something else. So they are tried only where the position is off by more
than its readings' noise, and stay only where the error falls clearly on pieces that the fit has not seen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from actspec.diagnostics import Collector, listed
from actspec.sysid.identified import FIELDS
from actspec.sysid.recording import reading_noise
from actspec.sysid.unseen import held_out
from actspec.sysid.work import FitOptions, JointInWork, ended
from actspec.units import format_number

LEFT = 1.1
"""Position error over the noise of the readings from which on figures are tried. Measured: 0.97 to 1.01 where nothing
is left out; at 1.12 a low-pass of 80 Hz made kp 2 % and viscous friction 24 % wrong."""
CLEAR = 0.9
"""Error on unseen pieces, over that without the figures, at which they stay. Chosen: a figure that fits noise alone
changes it by thousandths, of either sign."""
SEEN = 3.0
"""Least size of such a figure, in its standard deviations."""
PAIRS: tuple[tuple[str, ...], ...] = (("static", "stribeck_velocity"), ("lag",))
"""What is tried, together."""


def enlarged(
    joint: JointInWork,
    options: FitOptions,
    descend: Callable[[JointInWork, FitOptions, Collector], None],
    out: Collector,
) -> JointInWork:
    """The joint, with more figures where that pays.

    Args:
        joint: After its fit.
        options: What the user asks; a field that is held is not tried.
        descend: Fits a joint.
        out: Takes what was added.
    """
    assert joint.fit is not None
    if not joint.fit.arrived or joint.fit.noise["position"] <= LEFT * reading_noise(joint.recordings):
        return joint
    before = held_out(joint, ended(joint))
    if before is None:
        return joint
    for _ in PAIRS:
        best: tuple[float, JointInWork, tuple[str, ...]] | None = None
        for names in PAIRS:
            assert joint.fit is not None
            if any(name in joint.fit.free or FIELDS[name][0] in options.hold for name in names):
                continue
            trial = replace(joint, added=joint.added | set(names))
            descend(trial, options, Collector())
            error = held_out(trial, ended(trial))
            if error is not None and error < CLEAR * (best[0] if best else before) and _shows(trial, names):
                best = (error, trial, names)
        if best is None:
            break
        after, joint, names = best
        unit = "m" if any(r.log.joints[r.joint].linear for r in joint.recordings) else "rad"
        message = (
            f"{listed(FIELDS[name][0] for name in names)} fitted too: the position error on pieces that the fit has "
            f"not seen falls from {format_number(before, 3)} to {format_number(after, 3)} {unit}"
        )
        out.info("SYS026", message, where=joint.actuator.joint, help="`--hold` leaves a field out")
        before = after
        if joint.fit is not None and joint.fit.noise["position"] <= LEFT * reading_noise(joint.recordings):
            break
    return joint


def _shows(joint: JointInWork, names: tuple[str, ...]) -> bool:
    """Whether what was added is there at all: more break-away than Coulomb friction, a lag above 0."""
    fit = joint.fit
    assert fit is not None
    if not all(name in fit.free for name in names):
        return False
    over = fit.values["coulomb"] if names[0] == "static" else 0.0
    return fit.values[names[0]] - over > SEEN * fit.std(names[0])
