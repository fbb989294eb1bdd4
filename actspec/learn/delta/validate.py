"""How much of the model's error a delta action takes away, and how much any of its size could."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector
from actspec.learn.delta.samples import Samples
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Rows = NDArray[np.intp]

HORIZON = 1.0
"""Length of a replay [s]. Source: ASAP's episodes."""
GOOD, FAIR = 0.3, 0.1
"""Share of the error, of position and of velocity, that a good and a fair delta action take away. Chosen."""
WIDE = 0.2
"""Largest correction that is not a warning [rad]. Chosen: at kp 25 N*m/rad it is 5 N*m; what needs more is no flaw of
a drive, and the policy learns to live on it."""
AT_LIMIT = 0.95
"""Share of the largest correction from which on one is at its limit; tanh does not reach 1."""
MOST_ROWS = 2000
"""Most rows for which the best correction is searched, evenly taken. Chosen: 0.01 of the share that is told."""
MOST_REPLAYS = 400
"""Most replays, evenly taken. Chosen."""
SEARCHES = 2
"""How often slopes are simulated on the way to a best correction."""
SWEEPS = 40
"""Passes over the joints for the best correction on straight slopes. Chosen: it is found to 1e-3 of the limit."""


@dataclass(frozen=True, slots=True)
class Pair:
    """Of positions [rad or m, or a share] and velocities [rad/s or m/s, or a share]."""

    position: float
    velocity: float


@dataclass(frozen=True, slots=True)
class Judged:
    """Errors of the next row.

    Attributes:
        uncorrected, corrected: Root mean squares.
        improvement: 1 - corrected / uncorrected.
    """

    uncorrected: Pair
    corrected: Pair
    improvement: Pair


@dataclass(frozen=True, slots=True)
class JointJudged:
    """Of a joint.

    Attributes:
        joint: Its name.
        errors: Of it.
        share_at_limit: Share of its corrections at their limit.
    """

    joint: str
    errors: Judged
    share_at_limit: float


@dataclass(frozen=True, slots=True)
class Validation:
    """Of a delta action on logs.

    Attributes:
        errors: Of all joints.
        grade: `good`, `fair` or `poor`, by the smaller improvement.
        at_limit, at_twice: What the best correction of each row, within the limit and within twice of it, takes away;
            see `removable`.
        share_at_limit: Share of corrections at their limit.
        replay: Improvement of the position over `HORIZON`; None: no stretch is long enough.
        replays: How many.
        joints: In the order of the outputs.
        rows: How many.
        diverged: Rows that are left out.
    """

    errors: Judged
    grade: str
    at_limit: Pair
    at_twice: Pair
    share_at_limit: float
    replay: float | None
    replays: int
    joints: tuple[JointJudged, ...]
    rows: int
    diverged: int


def check_limit(limit: float, out: Collector) -> None:
    """Warn of a wide limit [rad or m]."""
    if limit > WIDE:
        message = (
            f"corrections of up to {format_number(limit, 3)} rad: more than {WIDE:g} rad hides a wrong model from the "
            "policy"
        )
        help = "`delta validate` says under `removable` what a smaller limit would take away"
        out.warning("LRN058", message, where="max_delta", help=help)


def check_gain(errors: Judged, out: Collector) -> None:
    """Warn of a delta action that takes nothing away on rows that it was not trained on."""
    if min(errors.improvement.position, errors.improvement.velocity) <= 0.0:
        message = "on held-out rows the error is larger with the correction than without"
        out.warning("LRN063", message, help="log longer, or give --max-time and --epochs more room")


def judged(bare: Array, left: Array) -> Judged:
    """Errors without and with correction, shapes (n, 2 n_joint): positions, then velocities."""
    import numpy as np

    half = bare.shape[1] // 2

    def rms(x: Array) -> Pair:
        return Pair(*(float(np.sqrt(np.mean(part**2))) for part in (x[:, :half], x[:, half:])))

    before, after = rms(bare), rms(left)
    share = Pair(
        *(
            1.0 - now / then if then > 0 else 0.0
            for now, then in ((after.position, before.position), (after.velocity, before.velocity))
        )
    )
    return Judged(before, after, share)


def graded(share: Pair) -> str:
    """`good`, `fair` or `poor`."""
    least = min(share.position, share.velocity)
    return "good" if least > GOOD else "fair" if least > FAIR else "poor"


def validate(
    samples: Samples,
    delta: Callable[[Array], Array],
    max_delta: float,
    progress: Callable[[int, int], None] | None = None,
) -> Validation:
    """Judge a delta action.

    Args:
        samples: Of logs, their columns in the network's order.
        delta: Raw columns, shape (n, n_column), to corrections, shape (n, n_joint).
        max_delta: Their limit [rad or m].
        progress: Called with parts done, of how many.
    """
    import numpy as np

    tell = progress or (lambda done, total: None)
    found = delta(samples.inputs)
    bare, left = samples.errors(), samples.errors(found)
    rows = np.flatnonzero(np.isfinite(bare).all(axis=1) & np.isfinite(left).all(axis=1))
    tell(1, 4)
    overall = judged(bare[rows], left[rows])
    count = len(samples.joints)
    limited = np.abs(found[rows]) >= AT_LIMIT * max_delta
    joints = tuple(
        JointJudged(
            name,
            judged(bare[rows][:, [j, count + j]], left[rows][:, [j, count + j]]),
            float(limited[:, j].mean()),
        )
        for j, name in enumerate(samples.joints)
    )
    few = rows[np.linspace(0, len(rows) - 1, min(len(rows), MOST_ROWS)).astype(int)]
    best, known = [], (found[few], left[few])
    for k, limit in enumerate((max_delta, 2.0 * max_delta)):
        # What the network found, and what a smaller limit allowed, is allowed here too.
        known = removable(samples, few, bare[few], limit, known)
        best.append(judged(bare[few], known[1]).improvement)
        tell(2 + k, 4)
    share, replays = replay(samples, delta)
    tell(4, 4)
    return Validation(
        overall,
        graded(overall.improvement),
        best[0],
        best[1],
        float(limited.mean()),
        share,
        replays,
        joints,
        len(rows),
        len(samples) - len(rows),
    )


def removable(
    samples: Samples, rows: Rows, bare: Array, limit: float, known: tuple[Array, Array] | None = None
) -> tuple[Array, Array]:
    """The best correction of each row alone, and the errors that are left with it.

    One correction serves position and velocity, and what noise made of them agrees on none. The best is that of least
    squares, positions over the root mean square of all joints' and velocities over theirs: the squares of what is left
    of both, as `judged` has them, have the least sum, and of one of the two another correction may leave less. It is
    found by straight slopes that are taken anew where they lead; a row keeps the best that was simulated.

    Args:
        samples: Of logs.
        rows: Which.
        bare: Their errors without correction, shape (n_row, 2 n_joint).
        limit: Of a correction [rad or m].
        known: Corrections within it, shape (n_row, n_joint), and the errors with them: what is found is no worse.
    """
    import numpy as np

    half = bare.shape[1] // 2
    size = np.repeat([np.sqrt(np.mean(part**2)) for part in (bare[:, :half], bare[:, half:])], half)
    size = np.where(size > 0, size, 1.0)

    def cost(errors: Array) -> Array:
        found: Array = np.sum((np.nan_to_num(errors, nan=1e6) / size) ** 2, axis=1)
        return found

    kept, best = np.zeros((len(rows), len(samples.joints))), bare.copy()
    if known is not None:
        better = cost(known[1]) < cost(best)
        kept[better], best[better] = known[0][better], known[1][better]
    for _ in range(SEARCHES):
        slopes = np.nan_to_num(samples.slopes(kept, best, 0.25 * limit, rows).astype(float) / size[:, None])
        fresh = _boxed(slopes, best / size, kept, limit)
        errors = samples.errors(fresh, rows)
        better = cost(errors) < cost(best)
        best[better], kept[better] = errors[better], fresh[better]
    return kept, best


def _boxed(slopes: Array, errors: Array, start: Array, limit: float) -> Array:
    """The corrections of least squares of errors + slopes (delta - start) within the limit, joint by joint in turn."""
    import numpy as np

    hessian = np.einsum("nij,nik->njk", slopes, slopes)
    slant = np.einsum("nij,ni->nj", slopes, errors)
    delta = start.copy()
    for _ in range(SWEEPS):
        for j in range(delta.shape[1]):
            own = hessian[:, j, j]
            pull = np.einsum("nk,nk->n", hessian[:, j], delta - start) + slant[:, j]
            moved = delta[:, j] - np.divide(pull, own, out=np.zeros_like(own), where=own > 1e-12)
            delta[:, j] = np.clip(moved, -limit, limit)
    return delta


def replay(samples: Samples, delta: Callable[[Array], Array]) -> tuple[float | None, int]:
    """What is taken away of the position's error when logged commands are replayed from logged states for `HORIZON`.

    Returns: 1 - RMS corrected / RMS uncorrected, and of how many replays; None: no stretch is long enough.
    """
    import numpy as np

    length = max(1, round(HORIZON / samples.plants[0][0].step))
    starts = [k for begin, n in samples.runs for k in range(begin, begin + n - length + 1, length)]
    if not starts:
        return None, 0
    chosen = np.array(starts)[np.linspace(0, len(starts) - 1, min(len(starts), MOST_REPLAYS)).astype(int)]
    count = len(samples.joints)
    squares: Mapping[bool, list[Array]] = {False: [], True: []}
    for corrected, found in squares.items():
        states = samples.states[chosen].copy()
        for k in range(length):
            rows = chosen + k
            command = samples.command[rows]
            if corrected:
                command = command + delta(samples.columns_of(np.nan_to_num(states), rows))
            states = samples.step(states, command, rows)
            q, _ = samples.plants[0][0].read(states)
            found.append((q - samples.after[rows, :count]) ** 2)
    before, after = (np.stack(squares[key]) for key in (False, True))
    # A replay that falls over in one of them is compared in neither.
    whole = np.isfinite(before).all(axis=(0, 2)) & np.isfinite(after).all(axis=(0, 2))
    if not whole.any() or not before[:, whole].any():
        return None, 0
    share = 1.0 - float(np.sqrt(after[:, whole].mean() / before[:, whole].mean()))
    return share, int(whole.sum())
