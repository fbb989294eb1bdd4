"""How good a network is: torques against those that were logged, beside laws of the spec, and motion in MuJoCo."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Diagnostic, Severity, Span, many
from actspec.ir import JointActuator, Level
from actspec.laws.network import NetworkLaw
from actspec.learn.closed_loop import BASELINES, HORIZON, ROLLED, RollImpossible, baseline_laws, closed_loop
from actspec.learn.windows import Dataset, Track
from actspec.libraries import extra_line
from actspec.readings.onnx_network import read_onnx
from actspec.spec.network import NetworkManifest
from actspec.sysid.figures import Bounds
from actspec.sysid.stand import Stand
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

GOOD = (0.015, 0.95)
"""Largest share of the effort limit and least R² of a good network. Source: 0.5 N*m at 33.5 N*m."""
FAIR = (0.03, 0.85)
"""Likewise of a fair one. Source: 1 N*m at 33.5 N*m."""
WORSE = 2.0
"""Chosen: a network that is so many times as far from the logs' motion or torque as the spec's own law is of no use."""


@dataclass(frozen=True, slots=True)
class Errors:
    """Of torques.

    Attributes:
        rmse: [N*m or N].
        mse: [N^2*m^2 or N^2].
        relative_error: RMSE over the root mean square of the torque [-]; None without torque.
        worst: Largest [N*m or N].
        r2: Share of the variance that is explained [-]; None where the torque is constant.
        rows: How many.
    """

    rmse: float
    mse: float
    relative_error: float | None
    worst: float
    r2: float | None
    rows: int


@dataclass(frozen=True, slots=True)
class JointErrors:
    """Of a joint.

    Attributes:
        joint: Its name.
        errors: Of its torque.
        limit: Effort limit [N*m or N]; None: unknown.
        grade: `good`, `fair` or `poor`.
        baselines: Errors of the spec's laws.
    """

    joint: str
    errors: Errors
    limit: float | None
    grade: str
    baselines: Mapping[str, Errors]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Of a network on logs.

    Attributes:
        overall: Errors of all rows.
        grade: The worst of the joints'.
        joints: In the spec's order.
        baselines: Errors of the spec's laws; without those that it does not state.
        closed_loop: `network` and the baselines to the RMSE of the position [rad or m]; None: not run.
        growth: Likewise, to the RMSE after each physics step of the rollouts, shape (n_step,).
        why_not: Why no closed loop was run.
        outside: Share of rows outside of the manifest's range: `error`, `velocity`, `any`; None: it has no range.
    """

    overall: Errors
    grade: str
    joints: tuple[JointErrors, ...]
    baselines: Mapping[str, Errors]
    closed_loop: Mapping[str, float | None] | None
    growth: Mapping[str, Array]
    why_not: str | None
    outside: Mapping[str, float] | None


def errors_of(found: Array, torque: Array) -> Errors:
    """Of torques against those that were logged, shapes (n,)."""
    import numpy as np

    left = found - torque
    mse = float(np.mean(left**2))
    rms, var = float(np.sqrt(np.mean(torque**2))), float(np.var(torque))
    return Errors(
        math.sqrt(mse),
        mse,
        math.sqrt(mse) / rms if rms > 0 else None,
        float(np.abs(left).max()),
        1.0 - mse / var if var > 0 else None,
        len(torque),
    )


def graded(errors: Errors, limit: float | None, laws: Mapping[str, Errors]) -> str:
    """`good`, `fair` or `poor`.

    Args:
        errors: Of the network.
        limit: Effort limit [N*m or N]; None: it is graded by R² alone.
        laws: Errors of the spec's laws on the same rows: a network that is further off than one of them is not good,
            and one that is `WORSE` times as far is poor.
    """
    share = 0.0 if limit is None else errors.rmse / limit
    r2 = -math.inf if errors.r2 is None else errors.r2
    behind = _behind(errors, laws)
    for name, (most, least), times in (("good", GOOD, 1.0), ("fair", FAIR, WORSE)):
        if share < most and r2 > least and behind <= times:
            return name
    return "poor"


def _behind(errors: Errors, laws: Mapping[str, Errors]) -> float:
    """How many times as far off a network is as the nearest law; 0 without a law."""
    least = min((law.rmse for law in laws.values()), default=math.inf)
    return errors.rmse / least if least > 0.0 else math.inf if errors.rmse > 0.0 else 0.0


def behind_the_law(
    joints: Iterable[tuple[str, Errors, Mapping[str, Errors]]], unit: str
) -> Iterator[Diagnostic]:
    """Joints whose torque the spec's own law tells better than the network, at once.

    Args:
        joints: Name of each, errors of its network, and of the spec's laws on the same rows.
        unit: Of their torque.
    """
    found = {name: (errors, laws) for name, errors, laws in joints if _behind(errors, laws) > 1.0}
    if not found:
        return
    worst = max(found, key=lambda name: _behind(*found[name]))
    errors, laws = found[worst]
    best = min(laws, key=lambda name: laws[name].rmse)
    times, among = _behind(errors, laws), f", at most of {many(len(found), 'joint')}" * (len(found) > 1)
    message = (
        f"the network's torque is {format_number(times, 3)} times as far from the logs as that of {best}, the spec's "
        f"own law{among}: {format_number(errors.rmse, 3)} and {format_number(laws[best].rmse, 3)} {unit}"
    )
    severity = Severity.WARNING if times > WORSE else Severity.INFO
    help = "keep the law, or train longer and on longer logs"
    yield Diagnostic("LRN035", severity, message, worst, help=help)


def limit_of(actuator: JointActuator) -> float | None:
    """What its torque is graded by [N*m or N]; None where it has no limit."""
    limit = Bounds.of(actuator).limit
    return None if math.isinf(limit) else limit


def worst(grades: Iterable[str]) -> str:
    """The worst of some grades."""
    found = set(grades)
    return next(grade for grade in ("poor", "fair", "good") if grade in found)


def predicted(law: NetworkLaw, tracks: Sequence[Track], bounds: Bounds) -> list[Array]:
    """The network's torque, clamped, at the rows of a joint's tracks [N*m or N], one array a track."""
    if law.layers.recurrent:
        from actspec.learn.recurrent import along

        found = along(law, tracks, [track.rows for track in tracks])
    else:
        found, n = [], len(law.taps)
        for track in tracks:
            x = track.inputs(track.rows)
            found.append(law.torque(x[:, :n], x[:, n:])[0])
    return [
        bounds.clip(torque, track.velocity[track.rows]) for torque, track in zip(found, tracks, strict=True)
    ]


def evaluate(
    data: Dataset,
    law: NetworkLaw,
    manifest: NetworkManifest,
    stand: Stand,
    step: float,
    *,
    policy: Dataset | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Evaluation:
    """Judge a network on logs.

    Args:
        data: The logs, with torques, at the network's taps.
        law: The network.
        manifest: Its manifest.
        stand: For the closed loop: the model, and where its other joints are.
        step: Physics step [s].
        policy: Logs whose share outside of the manifest's range is told; None: those of `data`.
        progress: Called with steps done, of how many.
    """
    import numpy as np

    joints, everything = [], []
    for actuator in data.actuators:
        tracks = [t for t in data.tracks if t.joint == actuator.joint and len(t.rows)]
        if not tracks:
            continue
        bounds = Bounds.of(actuator)
        torque = np.concatenate([t.torque[t.rows] for t in tracks])
        found = {"network": np.concatenate(predicted(law, tracks, bounds))}
        found |= _by_laws(actuator, [(t, t.rows) for t in tracks])
        limit = limit_of(actuator)
        errors = {name: errors_of(part, torque) for name, part in found.items()}
        network = errors.pop("network")
        joints.append(JointErrors(actuator.joint, network, limit, graded(network, limit, errors), errors))
        everything.append((torque, found))
    torque = np.concatenate([part for part, _ in everything])
    names = [name for name in BASELINES if all(name in found for _, found in everything)]
    overall, *rest = (
        errors_of(np.concatenate([found[name] for _, found in everything]), torque)
        for name in ("network", *names)
    )
    closed, why = None, None
    growth: Mapping[str, Array] = {}
    try:
        growth = closed_loop(data, law, manifest, stand, step, progress)
        closed = {
            name: float(np.sqrt(np.mean(growth[name] ** 2))) if name in growth else None for name in ROLLED
        }
    except RollImpossible as err:
        why = str(err)
    return Evaluation(
        overall,
        worst(joint.grade for joint in joints),
        tuple(joints),
        dict(zip(names, rest, strict=True)),
        closed,
        growth,
        why,
        outside(policy or data, manifest),
    )


def law_errors(data: Dataset, rows: Sequence[NDArray[np.intp]]) -> dict[str, dict[str, Errors]]:
    """Joint to errors of the spec's laws at chosen rows of each track; what lies within a torque's slack is none."""
    import numpy as np

    found = {}
    for actuator in data.actuators:
        pairs = zip(data.tracks, rows, strict=True)
        mine = [(track, some) for track, some in pairs if track.joint == actuator.joint and len(some)]
        if not mine:
            continue
        torque = np.concatenate([track.torque[some] for track, some in mine])
        slack = np.concatenate(
            [np.zeros(len(some)) if track.slack is None else track.slack[some] for track, some in mine]
        )
        found[actuator.joint] = {
            name: errors_of(part, np.clip(part, torque - slack, torque + slack))
            for name, part in _by_laws(actuator, mine).items()
        }
    return found


def _by_laws(actuator: JointActuator, tracks: Sequence[tuple[Track, NDArray[np.intp]]]) -> dict[str, Array]:
    """Torque of the spec's laws at rows of a joint's tracks [N*m or N], shape (n,)."""
    import numpy as np

    bias = actuator.encoder_bias.value or 0.0
    return {
        name: np.concatenate(
            [law.torque(t.in_force[some], t.position[some] - bias, t.velocity[some]) for t, some in tracks]
        )
        for name, law in baseline_laws(actuator).items()
    }


def worse_in_motion(found: Evaluation) -> Iterator[Diagnostic]:
    """A network with which the model moves less like the logs than with the spec's own laws, whatever its torques."""
    if found.closed_loop is None:
        return
    own = found.closed_loop["network"]
    laws = {name: value for name in BASELINES if (value := found.closed_loop[name]) is not None}
    best = min(laws, key=laws.__getitem__, default="")
    if own is not None and best and own > WORSE * laws[best]:
        message = (
            f"in motion the network is {own / laws[best]:.3g} times as far from the logs as {best}: {own:.3g} and "
            f"{laws[best]:.3g} rad over {HORIZON:g} s"
        )
        help = "use the spec's law, or log faster: rows tell a delay to a row"
        yield Diagnostic("LRN033", Severity.WARNING, message, help=help)


def outside(data: Dataset, manifest: NetworkManifest) -> dict[str, float] | None:
    """Share of rows whose inputs the training data did not reach; None: the manifest does not tell."""
    import numpy as np

    if manifest.range is None:
        return None
    parts = {}
    for name in ("error", "velocity"):
        ends = getattr(manifest.range, name)
        values = np.concatenate([getattr(track, name)[track.rows] for track in data.tracks])
        parts[name] = (values < ends.low) | (values > ends.high)
    shares = {name: float(np.mean(part)) for name, part in parts.items()}
    return {**shares, "any": float(np.mean(parts["error"] | parts["velocity"]))}


def network_of(
    path: str, actuators: Sequence[JointActuator], step: float
) -> tuple[NetworkLaw, NetworkManifest]:
    """The network that a manifest names, read as data; its taps are those of the manifest.

    Args:
        path: Of the manifest.
        actuators: Of the spec.
        step: Physics step, of which the time between two taps must be a whole number [s].

    Raises:
        LogError: the manifest or its ONNX file cannot be read, or they do not fit.
    """
    from actspec.ir import Network
    from actspec.logs import LogError
    from actspec.readings.onnx_network import NetworkFileError, OnnxMissing
    from actspec.targets.kit.network import read_network

    out = Collector()
    named = replace(actuators[0], level=Level.ACTUATOR_NET, network=Network(None, path), span=None)
    found = read_network(named, "onnx", out, out.at("--network", Span(path)))
    if found is not None:
        found.stride(step)
    out.raise_if_failed(LogError)
    assert found is not None
    try:
        return found.manifest.law(read_onnx(found.data)), found.manifest
    except OnnxMissing as err:
        message = "a network is read by onnx, which is not installed"
        raise LogError.of("LRN012", message, Span(path), help=extra_line("learn")) from err
    except NetworkFileError as err:
        raise LogError.of("LRN013", f"'{found.name}' cannot be read: {err}", Span(path)) from err
