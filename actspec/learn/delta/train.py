"""A delta action trained on a policy's logs: corrections of commands after which the model goes where the robot went.

The gradient of the next row's error goes through the change of the model's control period by each command, taken by
differences and anew when the corrections have moved. Position and velocity of each joint count over their own error
without correction.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.laws.network import Dense
from actspec.learn.delta.network import TURN, DeltaLayers
from actspec.learn.delta.samples import Samples
from actspec.learn.delta.validate import Judged, judged
from actspec.learn.files import torch_activation
from actspec.learn.windows import HELD_OUT
from actspec.logs import LogError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Rows = NDArray[np.intp]

RATE = 3e-3
"""Largest learning rate. Chosen."""
STEPS = 3000
"""Steps of a training whose epochs are not stated. Chosen: ten times as many gained 0.01."""
LEAST_EPOCHS = 10
BATCH = (64, 1024)
"""Smallest and largest batch: a twentieth of the rows between them."""
ROUNDS = 3
"""How often the errors are simulated anew. Chosen."""
SLOPES = 2
"""In how many of these the slopes are too. Chosen: they change little with the correction."""
STEP = 0.25
"""Difference of a command for its slope, as a share of the largest correction. Chosen: dry friction and the ends of
torque are felt on average, not at one place."""
MOST_ROWS = 20_000
"""Most rows to train on, evenly taken: slopes are simulated for each. Chosen."""
LEAST_ROWS = 200
"""Fewest that are left where time is short."""
CLIP = 1.0
"""Largest norm of the gradient."""
EASE = 1e-3
"""What a correction at its limit costs, against an error as large as without correction. Chosen: where nothing is
gained the command stays."""
HIDDEN, ACTIVATION = {"joint": (64, 64), "robot": (128, 128)}, "elu"
"""Sizes of hidden layers. Chosen: 32 and 128 did as well."""


@dataclass(frozen=True, slots=True)
class TrainOptions:
    """How a delta action is trained.

    Attributes:
        max_delta: Largest correction [rad or m].
        per: `joint` or `robot`.
        seed: Of weights and batches.
        epochs: Passes over the rows; None: by their number.
        max_time: In all [s]; None: as long as it takes.
    """

    max_delta: float
    per: str = "joint"
    seed: int = 0
    epochs: int | None = None
    max_time: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Trained:
    """A delta action.

    Attributes:
        layers: The network.
        judged: Errors on held-out rows.
        epochs: Done.
        best: Epoch of the weights that are kept.
        seconds: Taken.
        rows: How many it was trained on.
    """

    layers: DeltaLayers
    judged: Judged
    epochs: int
    best: int
    seconds: float
    rows: int


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """Rows apart.

    Attributes:
        seen: To train on.
        unseen: Held out.
        logs: Paths of what is held out.
        whole: Whether those are whole recordings.
    """

    seen: Rows
    unseen: Rows
    logs: tuple[str, ...]
    whole: bool


def split(samples: Samples) -> Parts:
    """Hold out the last recordings, with a fifth of the rows; of a single one its last fifth."""
    import numpy as np

    count = len(samples)
    out: list[tuple[str, slice]] = []
    for path, part in reversed(samples.logs[1:]):
        if sum(p.stop - p.start for _, p in out) >= HELD_OUT * count:
            break
        out.append((path, part))
    if out:
        first = out[-1][1].start
        return Parts(
            np.arange(first), np.arange(first, count), tuple(path for path, _ in reversed(out)), True
        )
    first = count - round(HELD_OUT * count)
    # The row between shares a reading with both.
    return Parts(np.arange(first - 1), np.arange(first, count), (samples.logs[0][0],), False)


def train(
    samples: Samples,
    parts: Parts,
    options: TrainOptions,
    progress: Callable[[int, int], None] | None = None,
) -> Trained:
    """Train a delta action; the weights that did best on held-out rows are kept.

    Args:
        samples: Of the logs.
        parts: Its rows, apart.
        options: How.
        progress: Called with epochs done, of how many.

    Raises:
        LogError: the time does not suffice for one epoch.
    """
    import numpy as np
    import torch

    begun = clock.perf_counter()
    seen, unseen = parts.seen, parts.unseen
    bare = samples.errors()
    most = MOST_ROWS
    if options.max_time is not None:
        # Half of the time is for the simulation: slopes cost one of a row for each joint.
        of_a_row = (clock.perf_counter() - begun) / len(samples)
        cost = of_a_row * (SLOPES * len(samples.joints) + ROUNDS + 1)
        most = int(min(max(0.5 * options.max_time / cost, LEAST_ROWS), most))
    if len(seen) > most:
        seen = seen[np.linspace(0, len(seen) - 1, most).astype(int)]
    sound = np.flatnonzero(np.isfinite(bare).all(axis=1))
    seen, unseen = np.intersect1d(seen, sound), np.intersect1d(unseen, sound)
    size = np.sqrt(np.mean(bare[seen] ** 2, axis=0))
    size = np.where(size > 0, size, 1.0)
    columns = _features(samples, seen, options.per)
    epochs, batch = options.epochs, min(max(len(seen) // 20, BATCH[0]), BATCH[1], len(seen))
    steps = max(len(seen) // batch, 1)
    if epochs is None:
        epochs = max(LEAST_EPOCHS, math.ceil(STEPS / steps))
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(options.seed)
            network = _network(columns, len(samples.joints), options)
            inputs = torch.tensor(columns.whitened(samples), dtype=torch.float32)
            course = _Course(epochs * steps, options.max_time, begun)
            optimizer = torch.optim.Adam(network.parameters(), lr=RATE)
            best, kept, at, epoch = math.inf, _state(network), 0, 0
            remains = bare[unseen]
            slopes: Any = None
            rounds = min(ROUNDS, epochs)
            for number in range(rounds):
                with torch.no_grad():
                    delta = network(inputs[:, seen]).numpy().astype(float)
                errors = samples.errors(delta, seen)
                if slopes is None or number < SLOPES:
                    slopes = samples.slopes(delta, errors, STEP * options.max_delta, seen)
                    slopes = np.nan_to_num(slopes / size[:, None].astype(np.float32))
                tensors = tuple(
                    torch.tensor(np.asarray(a, dtype=np.float32))
                    for a in (delta, np.nan_to_num(errors / size), slopes)
                )
                end = epochs * (number + 1) // rounds
                while epoch < end and not course.over:
                    _epoch(network, optimizer, inputs, seen, tensors, batch, steps, options.max_delta, course)
                    epoch += 1
                    if progress is not None:
                        progress(epoch, epochs)
                with torch.no_grad():
                    delta = network(inputs[:, unseen]).numpy().astype(float)
                left = samples.errors(delta, unseen)
                loss = float(np.mean(np.nan_to_num(left / size, nan=10.0) ** 2))
                if loss < best:
                    best, kept, at, remains = loss, _state(network), epoch, left
                if course.over:
                    break
            if not epoch:
                message = (
                    f"the time is over before the first epoch: simulating {len(seen)} rows took all of it"
                )
                raise LogError.of("LRN050", message, where="--max-time", help="give more")
            network.load_state_dict(kept)
    finally:
        torch.set_num_threads(threads)
    layers = _folded(network, columns, samples, options)
    whole = np.isfinite(remains).all(axis=1)
    told = judged(bare[unseen][whole], remains[whole])
    return Trained(layers, told, epoch, at, clock.perf_counter() - begun, len(seen))


@dataclass(slots=True)
class _Course:
    """How far a training is, by steps or by its time."""

    steps: int
    max_time: float | None
    begun: float
    done: int = 0

    @property
    def share(self) -> float:
        found = self.done / self.steps
        if self.max_time is not None:
            found = max(found, (clock.perf_counter() - self.begun) / self.max_time)
        return found

    @property
    def over(self) -> bool:
        return self.share >= 1.0


def _epoch(
    network: Any,
    optimizer: Any,
    inputs: Any,
    seen: Rows,
    tensors: tuple[Any, Any, Any],
    batch: int,
    steps: int,
    limit: float,
    course: _Course,
) -> None:
    """One pass over the rows."""
    import torch

    before, errors, slopes = tensors
    order = torch.randperm(len(before))
    places = torch.as_tensor(seen)
    for k in range(steps):
        share = course.share
        if share >= 1.0:
            return
        # Warmed up over a fiftieth, then along half a cosine to nothing.
        rate = RATE * min(1.0, 0.02 + share * 50.0) * 0.5 * (1.0 + math.cos(math.pi * share))
        optimizer.param_groups[0]["lr"] = rate
        rows = order[k * batch : (k + 1) * batch]
        delta = network(inputs[:, places[rows]])
        left = errors[rows] + torch.einsum("nij,nj->ni", slopes[rows], delta - before[rows])
        loss = (left * left).mean() + EASE * ((delta / limit) ** 2).mean()
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), CLIP)
        optimizer.step()
        course.done += 1


@dataclass(frozen=True, slots=True, eq=False)
class _Features:
    """What the parts of a network see of the columns, of like size and independent of each other.

    Attributes:
        picked: See `DeltaLayers`.
        basis: Picked columns to features, shape (n_part, n_pick, n_pick).
        middle: Of the picked columns, shape (n_part, n_pick).
    """

    picked: NDArray[np.intp]
    basis: Array
    middle: Array

    def whitened(self, samples: Samples) -> NDArray[np.float32]:
        """Features of all samples, shape (n_part, n, n_pick)."""
        import numpy as np

        x = _extended(samples)[:, self.picked].transpose(1, 0, 2) - self.middle[:, None]
        found: NDArray[np.float32] = (x @ self.basis).astype(np.float32)
        return found


def _extended(samples: Samples) -> Array:
    """The columns, and behind them the way down in the base's axes where a quaternion is among them."""
    import numpy as np

    x = samples.inputs
    if TURN[0] not in samples.columns:
        return x
    w, a, b, c = (x[:, samples.columns.index(name)] for name in TURN)
    down = np.stack([2 * (w * b - a * c), -2 * (b * c + w * a), 2 * (a * a + b * b) - 1.0], axis=1)
    return np.concatenate([x, down], axis=1)


def _features(samples: Samples, seen: Rows, per: str) -> _Features:
    """Of each joint: command - position, velocity, command - last command and position; of the base its sensors."""
    import numpy as np

    x = _extended(samples)[seen]
    n = len(samples.joints)
    joints = [[j, n + j, 2 * n + j, len(samples.columns) - n + j] for j in range(n)]
    # What a step of the command is depends on all four; columns of position, velocity, last command, command.
    change = np.array([[-1.0, 0, 0, 1], [0, 1, 0, 0], [0, 0, -1, 0], [1, 0, 1, 0]])
    base = [k for k, name in enumerate(samples.columns) if name.startswith("base.angular_velocity.")]
    base += list(range(len(samples.columns), x.shape[1]))
    parts = [[*own, *base] for own in joints]
    blocks = 1
    if per == "robot":
        parts, blocks = [[k for own in joints for k in own] + base], n
    picked = np.array(parts, dtype=np.intp)
    size = picked.shape[1]
    basis = np.zeros((len(picked), size, size))
    middle = x[:, picked].mean(axis=0)
    for part in range(len(picked)):
        turn = np.eye(size)
        for block in range(blocks):
            at = slice(4 * block, 4 * block + 4)
            turn[at, at] = change
        seen_as = (x[:, picked[part]] - middle[part]) @ turn
        spread = seen_as.std(axis=0)
        basis[part] = turn / np.where(spread > 1e-9, spread, 1.0)
    return _Features(picked, basis, middle)


def _network(columns: _Features, joints: int, options: TrainOptions) -> Any:
    """Of features, shape (n_part, n, n_pick), to corrections, shape (n, n_joint)."""
    import torch

    parts, size = columns.picked.shape
    hidden = HIDDEN[options.per]

    class Network(torch.nn.Module):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__()
            self.first = torch.nn.Linear(size, hidden[0])
            # One joint is told from another by it.
            self.own = torch.nn.Parameter(torch.zeros(parts, 1, hidden[0]))
            rest: list[Any] = []
            for before, after in zip(hidden, (*hidden[1:], joints // parts), strict=True):
                rest += [torch_activation(ACTIVATION), torch.nn.Linear(before, after)]
            self.rest = torch.nn.Sequential(*rest)

        def forward(self, x: torch.Tensor) -> torch.Tensor:
            out = self.rest(self.first(x) + self.own)
            return options.max_delta * torch.tanh(out.transpose(0, 1).reshape(x.shape[1], -1))

    return Network()


def _state(network: Any) -> dict[str, Any]:
    return {name: value.detach().clone() for name, value in network.state_dict().items()}


def _folded(network: Any, columns: _Features, samples: Samples, options: TrainOptions) -> DeltaLayers:
    """The network of raw columns: features go into its first layer."""
    import numpy as np

    def array(value: Any) -> Array:
        return np.asarray(value.detach().numpy(), dtype=float)

    weight = columns.basis @ array(network.first.weight).T
    bias = (
        array(network.first.bias) + array(network.own)[:, 0] - np.einsum("pi,pih->ph", columns.middle, weight)
    )
    affine = [part for part in network.rest if hasattr(part, "weight")]
    dense = tuple(
        Dense(array(part.weight), array(part.bias), ACTIVATION if part is not affine[-1] else "identity")
        for part in affine
    )
    if len(samples.columns) in columns.picked:
        # The file's way down lacks the -1 of its last part.
        for part, row in enumerate(columns.picked):
            bias[part] -= weight[part][row == len(samples.columns) + 2].sum(axis=0)
    return DeltaLayers(samples.columns, columns.picked, weight, bias, ACTIVATION, dense, options.max_delta)
