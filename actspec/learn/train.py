"""A perceptron trained on samples of logs: each joint counts the same, the best weights on held-out rows are kept."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from actspec.laws.network import Dense, Layers
from actspec.learn.files import single, torch_activation
from actspec.learn.windows import Dataset, Split, gathered, slacks

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

RATE = 3e-3
"""Largest learning rate. Chosen."""
FLOOR = 0.3
"""Size of a direction of the inputs below which it is not made larger, as a share of theirs. Chosen: of five values
the best on one pair of logs; a hundredth enlarges noise."""
STEPS = 3000
"""Steps of a training whose epochs are not stated. Chosen."""
LEAST_EPOCHS = 10
STEEPEST = 1.0
"""Largest norm of a gradient. Chosen: a recurrent network's bursts."""
BATCH = (256, 2048)
"""Smallest and largest batch: a fiftieth of the rows between them."""
ACTIVATIONS = ("elu", "relu", "tanh", "softsign", "leaky_relu", "selu", "sigmoid", "softplus")
"""Of a hidden layer; each is in ONNX, in torch and in Newton's reader."""


@dataclass(frozen=True, slots=True)
class TrainOptions:
    """How a network is trained.

    Attributes:
        kind: `mlp` or `lstm`.
        hidden: Sizes of its hidden layers; of an LSTM's they are the same.
        activation: One of `ACTIVATIONS`.
        seed: Of weights and batches.
        seeds: How many networks are trained, from seeds that follow each other; the best is kept.
        epochs: Passes over the rows; None: by their number.
        max_time: Of each network [s]; None: as long as it takes.
    """

    kind: str = "mlp"
    hidden: tuple[int, ...] = (128, 128)
    activation: str = "elu"
    seed: int = 0
    seeds: int = 1
    epochs: int | None = None
    max_time: float | None = None


@dataclass(frozen=True, slots=True)
class Run:
    """One seed.

    Attributes:
        seed: Of it.
        loss: Root of the mean square of error over the joint's own torque RMS, on held-out rows [-].
        rmse: On held-out rows of all joints [N*m or N].
        epochs: Done.
        best: Epoch of the weights that are kept.
        seconds: Taken.
    """

    seed: int
    loss: float
    rmse: float
    epochs: int
    best: int
    seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class Trained:
    """A network.

    Attributes:
        layers: Of rad and rad/s to N*m; weights as float32 holds them.
        run: That it comes from.
        runs: All, in the order of their seeds.
    """

    layers: Layers
    run: Run
    runs: tuple[Run, ...]


def train(
    data: Dataset,
    parts: Split,
    options: TrainOptions,
    progress: Callable[[int, int], None] | None = None,
) -> Trained:
    """Train a network, or several from seeds that follow each other, and keep the best on held-out rows.

    Args:
        data: With torques.
        parts: Its rows, apart.
        options: How.
        progress: Called with epochs done, of how many.
    """
    import torch

    threads = torch.get_num_threads()
    # A batch is done before a second thread has begun, and on a busy machine the two wait for each other.
    torch.set_num_threads(1)
    try:
        with torch.random.fork_rng(devices=[]):
            if options.kind == "lstm":
                from actspec.learn.recurrent import train_lstm

                return train_lstm(data, parts, options, progress)
            return _train_perceptron(data, parts, options, progress)
    finally:
        torch.set_num_threads(threads)


def _train_perceptron(
    data: Dataset, parts: Split, options: TrainOptions, progress: Callable[[int, int], None] | None
) -> Trained:
    import numpy as np

    seen, unseen = gathered(data, parts.train), gathered(data, parts.validate)
    basis = whitening(seen[0])
    own = joint_scales(seen[1], seen[2], len(data.actuators))
    size = float(np.sqrt(np.mean(seen[1] ** 2))) or 1.0
    spare = [slacks(data, part) / size for part in (parts.train, parts.validate)]
    found = [
        _run(
            (*_tensors(seen, basis, own, size), single_tensor(spare[0])),
            (*_tensors(unseen, basis, own, size), single_tensor(spare[1])),
            replace(options, seed=options.seed + k),
            part_of(progress, k, options.seeds),
        )
        for k in range(options.seeds)
    ]
    best = min(range(len(found)), key=lambda k: found[k][1].loss)
    runs = []
    for layers, run in found:
        found_torque = _folded(layers, basis, size)(unseen[0])[0][:, 0]
        errors = beyond(np, found_torque - unseen[1], spare[1] * size)
        runs.append(replace(run, rmse=float(np.sqrt(np.mean(errors**2)))))
    return Trained(_folded(found[best][0], basis, size), runs[best], tuple(runs))


def whitening(x: Array) -> Array:
    """Matrix by which inputs of a history, shape (n, n_in), become nearly independent, shape (n_in, n_in).

    Samples of a history are nearly the same, and a drive's delay shows in their differences alone.
    """
    import numpy as np

    scales = np.sqrt(np.mean(x**2, axis=0))
    scales = np.where(scales > 0, scales, 1.0)
    share, ways = np.linalg.eigh((x / scales).T @ (x / scales) / len(x))
    found: Array = ways / np.sqrt(np.maximum(share, 0.0) + FLOOR**2) / scales[:, None]
    return found


def joint_scales(torque: Array, joint: NDArray[np.intp], count: int) -> Array:
    """RMS torque of each joint [N*m or N], shape (count,); 1 where there is none."""
    import numpy as np

    found = np.array(
        [np.sqrt(np.mean(torque[joint == j] ** 2)) if (joint == j).any() else 0.0 for j in range(count)]
    )
    return np.where(found > 0, found, 1.0)


def _tensors(part: tuple[Array, Array, Any], basis: Array, own: Array, size: float) -> tuple[Any, Any, Any]:
    """Inputs, torques over their size, and weights under which each joint counts the same."""
    import numpy as np

    x, y, joint = part
    rows = np.maximum(np.bincount(joint, minlength=len(own)), 1)
    weight = (size / own[joint]) ** 2 / rows[joint]
    weight *= 1.0 / max(int((np.bincount(joint, minlength=len(own)) > 0).sum()), 1)
    return single_tensor(x @ basis), single_tensor(y / size), single_tensor(weight * len(y))


def single_tensor(array: Array) -> Any:
    """Of torch, in float32."""
    import numpy as np
    import torch

    return torch.tensor(np.asarray(array, dtype=np.float32))


def beyond(xp: Any, left: Any, slack: Any) -> Any:
    """What is left of errors where the torque is known to within a slack; arrays of numpy or torch."""
    return xp.sign(left) * xp.clip(xp.abs(left) - slack, 0.0, None)


def _run(
    seen: Any, unseen: Any, options: TrainOptions, progress: Callable[[int, int], Any]
) -> tuple[Layers, Run]:
    """One network, from standardised inputs to torques over their size."""
    import torch

    torch.manual_seed(options.seed)
    x, y, weight, slack = seen
    sizes = [x.shape[1], *options.hidden, 1]
    parts: list[Any] = []
    for k, (n_in, n_out) in enumerate(pairwise(sizes)):
        parts.append(torch.nn.Linear(n_in, n_out))
        if k < len(options.hidden):
            parts.append(
                torch_activation(options.activation, 0.01 if options.activation == "leaky_relu" else 1.0)
            )
    network = torch.nn.Sequential(*parts)

    def loss(rows: Any) -> Any:
        left = beyond(torch, network(x[rows])[:, 0] - y[rows], slack[rows])
        return (weight[rows] * left * left).mean()

    run = descend(network, len(x), _batch(len(x)), loss, lambda: _loss(network, unseen), options, progress)
    dense = []
    for k, part in enumerate(parts):
        if isinstance(part, torch.nn.Linear):
            active = k + 1 < len(parts)
            dense.append(
                Dense(
                    part.weight.detach().numpy().astype(float),
                    part.bias.detach().numpy().astype(float),
                    options.activation if active else "identity",
                    0.01 if active and options.activation == "leaky_relu" else 1.0,
                )
            )
    return Layers((), tuple(dense)), run


def descend(
    network: Any,
    count: int,
    batch: int,
    loss: Callable[[Any], Any],
    judge: Callable[[], float],
    options: TrainOptions,
    progress: Callable[[int, int], Any],
) -> Run:
    """Change a network's weights until its epochs or its time are over, and keep the best; `rmse` is left 0.

    Args:
        network: Of torch.
        count: How many samples there are.
        batch: How many are taken at once.
        loss: Of the samples with these indices.
        judge: Mean square of the error on what is held out.
        options: How.
        progress: Called with epochs done, of how many.
    """
    import torch

    begun = clock.perf_counter()
    steps = max(count // batch, 1)
    epochs = options.epochs or max(LEAST_EPOCHS, math.ceil(STEPS / steps))
    optimizer = torch.optim.Adam(network.parameters(), lr=RATE, foreach=True)
    best, kept, at, epoch = math.inf, _state(network), 0, 0
    for epoch in range(1, epochs + 1):
        order = torch.randperm(count)
        for k in range(steps):
            done = (epoch - 1 + k / steps) / epochs
            if options.max_time is not None:
                done = max(done, (clock.perf_counter() - begun) / options.max_time)
            if done >= 1.0:
                break
            # Warmed up over a fiftieth, then along half a cosine to nothing.
            rate = RATE * min(1.0, 0.02 + done * 50.0) * 0.5 * (1.0 + math.cos(math.pi * done))
            optimizer.param_groups[0]["lr"] = rate
            optimizer.zero_grad(set_to_none=True)
            loss(order[k * batch : (k + 1) * batch]).backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), STEEPEST)
            optimizer.step()
        found = judge()
        if found < best:
            best, kept, at = found, _state(network), epoch
        progress(epoch, epochs)
        if options.max_time is not None and clock.perf_counter() - begun >= options.max_time:
            break
    network.load_state_dict(kept)
    return Run(options.seed, math.sqrt(best), 0.0, epoch, at, clock.perf_counter() - begun)


def part_of(progress: Callable[[int, int], None] | None, k: int, parts: int) -> Callable[[int, int], None]:
    """Progress of the whole, from that of one of its parts."""

    def step(done: int, total: int) -> None:
        if progress is not None:
            progress(k * total + done, parts * total)

    return step


def _batch(rows: int) -> int:
    return min(max(rows // 50, BATCH[0]), BATCH[1], rows)


def _state(network: Any) -> dict[str, Any]:
    return {name: value.detach().clone() for name, value in network.state_dict().items()}


def _loss(network: Any, part: Any) -> float:
    """Mean square of each joint's error over its own torque, on all rows."""
    import torch

    x, y, weight, slack = part
    with torch.no_grad():
        left = beyond(torch, network(x)[:, 0] - y, slack)
        return float((weight * left * left).double().mean())


def _folded(layers: Layers, basis: Array, size: float) -> Layers:
    """The layers with standardisation in their first and last ones, as float32 holds them."""
    dense = list(layers.dense)
    dense[0] = replace(dense[0], weight=dense[0].weight @ basis.T)
    dense[-1] = replace(dense[-1], weight=dense[-1].weight * size, bias=dense[-1].bias * size)
    return single(Layers((), tuple(dense)))


def input_ranges(data: Dataset, rows: Sequence[Any]) -> dict[str, dict[str, float]]:
    """How far error and velocity go, as a manifest has it."""
    import numpy as np

    found = {}
    for name in ("error", "velocity"):
        values = np.concatenate([getattr(t, name)[mine] for t, mine in zip(data.tracks, rows, strict=True)])
        low, high = np.quantile(values, (0.001, 0.999))
        ends = {"low": low, "high": high, "least": values.min(), "most": values.max()}
        found[name] = {key: float(f"{value:.6g}") for key, value in ends.items()}
    return found
