"""What a network does, from its weights alone: sign, order of inputs, gains, delay and saturation."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

from actspec.diagnostics import Collector, Span, many
from actspec.laws.network import Layers, NetworkLaw, sequence
from actspec.logs import LogError
from actspec.targets.kit.network import misfits

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from actspec.spec.network import NetworkManifest

    Array = NDArray[np.float64]

SMALL = (1e-3, 1e-2)
"""Differences of an error [rad or m] and of a velocity [rad/s or m/s] for derivatives at rest."""
REACH = 3.0
"""Largest error of the search for saturation [rad or m]. Chosen: no leg's command is further away."""
SETTLED = 400
"""Samples in which an LSTM comes to rest."""
DAMPED = 1e-3
"""Damping over stiffness below which the weights do not tell the inputs apart [s]. Chosen: drives have 0.01 to 0.1."""
DRIVEN = 0.01
"""Drive of a velocity over stiffness that is no friction made up for, nor noise [s]. Drives damp by 0.0071 to 0.25 s,
see SPEC192."""
FULL = 0.95
"""Share of the largest torque at which a network counts as saturated."""


class Contradiction(NamedTuple):
    """What a network does otherwise than its manifest says."""

    key: str
    """Of the manifest."""
    text: str
    """What it does."""
    help: str | None = None
    """What to look at."""


@dataclass(frozen=True, slots=True)
class Inspection:
    """A network's behaviour at rest.

    Attributes:
        kind: `mlp` or `lstm`.
        inputs: Number of inputs.
        order: `position_velocity` or `velocity_position`.
        error_sign: `target_minus_measured` or `measured_minus_target`.
        stiffness: d tau / d error of all samples together, in size [N*m/rad or N/m].
        damping: -d tau / d velocity of all samples together [N*m*s/rad or N*s/m].
        delay_taps: Samples after which an error acts, weighted by how much [-].
        at_rest: Torque without error and velocity [N*m or N].
        saturation: Largest torque within `REACH` [N*m or N].
        saturates_at: Error at which it gives `FULL` of that [rad or m]; None: it still grows at `REACH`.
        guessed: Whether order and sign follow from the weights; else the manifest states them.
        contradictions: What the manifest says otherwise.
    """

    kind: str
    inputs: int
    order: str
    error_sign: str
    stiffness: float
    damping: float
    delay_taps: float
    at_rest: float
    saturation: float
    saturates_at: float | None
    guessed: bool
    contradictions: tuple[Contradiction, ...]

    @property
    def doubtful(self) -> bool:
        """Whether order and sign are guessed, and the damping that results is not that of a drive."""
        return self.guessed and self.damping < DAMPED * self.stiffness


def inspect(layers: Layers, manifest: NetworkManifest | None, path: str = "") -> Inspection:
    """Describe a network.

    Args:
        layers: Of it.
        path: Of its file, for errors.
        manifest: Its conventions; None: order and sign are what its weights tell: a drive answers an error with
            more torque than a velocity of the same size, and pulls against the velocity.

    Raises:
        LogError: its inputs are no errors and velocities of samples.
    """
    if layers.outputs != 1 or layers.inputs % 2:
        message = (
            f"{many(layers.inputs, 'input')} and {many(layers.outputs, 'output')}: an actuator network has as many "
            "errors as velocities, and one torque"
        )
        raise LogError.of("LRN013", message, Span(path))
    wrong = [Contradiction("kind", text) for text in ([] if manifest is None else misfits(layers, manifest))]
    # What a manifest says of other inputs says nothing of these.
    guessed = manifest is None or layers.inputs != 2 * len(manifest.taps)
    law = _law(layers, None if guessed else manifest)
    by_error, by_velocity = _slopes(law)
    if guessed and abs(by_velocity.sum()) > abs(by_error.sum()):
        law = replace(law, velocity_first=True)
        by_error, by_velocity = _slopes(law)
    positive = by_error.sum() > 0.0
    if manifest is not None and not wrong:
        if abs(by_velocity.sum()) > abs(by_error.sum()):
            # Both signs are of the other inputs then.
            asked = f"velocities count more than errors: are the inputs {_other(manifest.inputs)}?"
            turned = [item.text for item in _signs(replace(law, velocity_first=not law.velocity_first))]
            text = " In that order ".join([asked, " and ".join(turned)] if turned else [asked])
            wrong.append(Contradiction("inputs", text))
        else:
            wrong += _signs(law)
    weight = abs(by_error)
    grid = _grid(law)
    most = float(abs(grid[1]).max())
    full = [float(e) for e, tau in zip(*grid, strict=True) if e > 0 and abs(tau) >= FULL * most]
    ends = min(full, default=REACH)
    return Inspection(
        "lstm" if layers.recurrent else "mlp",
        layers.inputs,
        "velocity_position" if law.velocity_first else "position_velocity",
        "target_minus_measured" if positive else "measured_minus_target",
        abs(float(by_error.sum())),
        -float(by_velocity.sum()),
        float((weight * _ages(law, len(weight))).sum() / weight.sum()) if weight.sum() > 0 else 0.0,
        float(grid[1][len(grid[1]) // 2]),
        most,
        ends if ends < 0.9 * REACH else None,
        guessed,
        tuple(wrong),
    )


def _signs(law: NetworkLaw) -> list[Contradiction]:
    """What is wrong with the signs of a drive, beyond what play at 0 and noise make."""
    by_error, by_velocity = (float(part.sum()) for part in _slopes(law))
    errors, torque = _grid(law)
    wrong = []
    if by_error <= 0.0 and (torque * errors).sum() <= 0.0:
        text = f"an error of target - measured gives a torque away from the target: {by_error:.4g} N*m/rad; "
        wrong.append(Contradiction("position_scale", f"{text}position_scale needs the other sign"))
    if by_velocity > DRIVEN * abs(by_error):
        text = f"a velocity is driven on, not damped: {by_velocity:.4g} N*m*s/rad"
        wrong.append(Contradiction("velocity_scale", text))
    return wrong


def _other(order: str) -> str:
    return "velocity_position" if order == "position_velocity" else "position_velocity"


def _law(layers: Layers, manifest: NetworkManifest | None) -> NetworkLaw:
    if manifest is None:
        taps = (0,) if layers.recurrent else tuple(range(layers.inputs // 2))
        return NetworkLaw(layers, taps, 1.0)
    return manifest.law(layers)


def _ages(law: NetworkLaw, count: int) -> Array:
    import numpy as np

    return np.arange(count, dtype=float) if law.layers.recurrent else np.array(law.taps, dtype=float)


def _slopes(law: NetworkLaw) -> tuple[Array, Array]:
    """Derivatives of the torque at rest by each sample's error and velocity; of an LSTM by how long ago it was."""
    import numpy as np

    found = []
    for which, size in enumerate(SMALL):
        if law.layers.recurrent:
            # A pulse: what an LSTM answers so many samples later.
            course = np.zeros((2, SETTLED, 2))
            course[which, SETTLED // 2] = (size, -size)
            answers = sequence(law, course[0], course[1], 1)[SETTLED // 2 :].T
            found.append((answers[0] - answers[1]) / (2.0 * size))
            continue
        moved = np.zeros((2, len(law.taps), 2, len(law.taps)))
        for tap in range(len(law.taps)):
            moved[:, tap, which, tap] = (size, -size)
        torque = law.torque(moved[:, :, 0], moved[:, :, 1])[0]
        found.append((torque[0] - torque[1]) / (2.0 * size))
    return found[0], found[1]


def _grid(law: NetworkLaw) -> tuple[Array, Array]:
    """Errors that stay, 0 in their middle, and the torque that each ends in with the joint at rest."""
    import numpy as np

    errors = np.linspace(-REACH, REACH, 121)
    return errors, settled(law, errors, 0.0 * errors)


def settled(law: NetworkLaw, errors: Array, velocities: Array) -> Array:
    """The torque that errors and velocities which stay end in [N*m or N], shape (n,).

    Args:
        law: The network.
        errors: target - measured [rad or m], shape (n,).
        velocities: [rad/s or m/s], likewise.
    """
    import numpy as np

    # They were there before too, whatever a history begins with.
    law = replace(law, backfill=True)
    shape = (SETTLED if law.layers.recurrent else 1, len(errors))
    found: Array = sequence(law, np.broadcast_to(errors, shape), np.broadcast_to(velocities, shape), 1)[-1]
    return found


def converted(
    layers: Layers, manifest: NetworkManifest, path: str, described: str
) -> tuple[Layers, dict[str, object]]:
    """The same network with scales 1 and errors before velocities, and the manifest's keys for it.

    Args:
        layers: Of it.
        manifest: Its conventions.
        path: Of its file, for errors.
        described: Of the manifest's.

    Raises:
        LogError: the file is not what the manifest describes.
    """
    import numpy as np

    n = len(manifest.taps)
    out = Collector()
    if wrong := misfits(layers, manifest):
        message = f"the network is not what {os.path.basename(described)} describes: {'; '.join(wrong)}"
        help = "`actspec net inspect FILE` shows what it is"
        out.error("LRN013", message, span=Span(path), help=help)
    if manifest.tap_period.value is None:
        help = "write the time between two samples"
        out.error("LRN013", "tap_period is unknown", span=Span(described), help=help)
    out.raise_if_failed(LogError)
    scales = np.repeat([manifest.position_scale, manifest.velocity_scale], n)
    order = np.arange(2 * n)
    if manifest.inputs == "velocity_position":
        scales, order = np.repeat([manifest.velocity_scale, manifest.position_scale], n), np.roll(order, n)

    def first(weight: Array) -> Array:
        found: Array = (weight * scales)[:, order]
        return found

    recurrent, dense = list(layers.recurrent), list(layers.dense)
    if recurrent:
        recurrent[0] = replace(recurrent[0], inputs=first(recurrent[0].inputs))
    else:
        dense[0] = replace(dense[0], weight=first(dense[0].weight))
    last = dense[-1]
    if last.activation == "identity":
        dense[-1] = replace(
            last, weight=last.weight * manifest.torque_scale, bias=last.bias * manifest.torque_scale
        )
    else:
        dense.append(
            replace(last, weight=np.array([[manifest.torque_scale]]), bias=np.zeros(1), activation="identity")
        )
    entries = manifest.entries()
    for key in ("sha256", "files", "format", "kind", "doubts"):
        entries.pop(key, None)
    entries |= {"inputs": "position_velocity"}
    entries |= {"position_scale": 1.0, "velocity_scale": 1.0, "torque_scale": 1.0}
    return Layers(tuple(recurrent), tuple(dense)), entries
