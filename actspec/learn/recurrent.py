"""An LSTM on logs: pieces of even rows to train on, and its torque along whole recordings.

A state begins at 0, as simulators begin it at a reset. Rows before a piece settle it and count for no loss.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from actspec.laws.network import Dense, Layers, LstmLayer, NetworkLaw
from actspec.learn.files import single
from actspec.learn.train import (
    Run,
    Trained,
    TrainOptions,
    beyond,
    descend,
    joint_scales,
    part_of,
    single_tensor,
)
from actspec.learn.windows import Dataset, Split, Track, gathered, slacks

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]
    Rows = NDArray[np.intp]

WARM = 20
"""Samples that settle a state. Chosen: 0.1 s at 200 Hz, longer than a drive's delay and filter."""
BODY = 60
"""Samples of a piece whose errors are followed back through time."""
BATCH = (8, 64)
"""Fewest and most pieces at once: a twentieth of them between. Chosen."""
TAPS = tuple(range(WARM + 1))
"""Samples that a row must have behind it."""


def train_lstm(
    data: Dataset,
    parts: Split,
    options: TrainOptions,
    progress: Callable[[int, int], None] | None = None,
) -> Trained:
    """Train an LSTM; see `train.train`. The dataset has the samples `TAPS`."""
    import numpy as np

    _, torque, joint = gathered(data, parts.train)
    own = joint_scales(torque, joint, len(data.actuators))
    size = float(np.sqrt(np.mean(torque**2))) or 1.0
    scales = _scales(data.tracks, parts.train)
    seen, unseen = (_pieces(data, rows, scales, own, size) for rows in (parts.train, parts.validate))
    found = []
    for k in range(options.seeds):
        mine = replace(options, seed=options.seed + k)
        found.append(_run(seen, unseen, mine, scales, size, part_of(progress, k, options.seeds)))
    best = min(range(len(found)), key=lambda k: found[k][1].loss)
    runs = []
    law = NetworkLaw(found[best][0], (0,), data.period)
    _, expected, _ = gathered(data, parts.validate)
    slack = slacks(data, parts.validate)
    for layers, run in found:
        torques = np.concatenate(along(replace(law, layers=layers), data.tracks, parts.validate))
        errors = beyond(np, torques - expected, slack)
        runs.append(replace(run, rmse=float(np.sqrt(np.mean(errors**2)))))
    return Trained(found[best][0], runs[best], tuple(runs))


def along(law: NetworkLaw, tracks: Sequence[Track], rows: Sequence[Rows]) -> list[Array]:
    """Torque at rows of tracks [N*m or N], the state settled over the rows before each stretch, one array a track."""
    import numpy as np

    found = [np.full(len(track.time), np.nan) for track in tracks]
    courses = []
    for k, (track, mine) in enumerate(zip(tracks, rows, strict=True)):
        for stretch in stretches(track, mine):
            before = stretch[0] - track.stride * np.arange(WARM, 0, -1)
            courses.append((k, np.concatenate([before, stretch])))
    # All at once, the longest first: what has ended drops out.
    courses.sort(key=lambda course: -len(course[1]))
    longest = len(courses[0][1]) if courses else 0
    lengths = np.array([len(course) for _, course in courses])
    error, velocity = (np.zeros((longest, len(courses))) for _ in range(2))
    for i, (k, course) in enumerate(courses):
        error[: len(course), i] = tracks[k].error[course]
        velocity[: len(course), i] = tracks[k].velocity[course]
    torque, state = np.zeros_like(error), None
    for step in range(longest):
        on = int((lengths > step).sum())
        if state is not None:
            state = tuple(part[:, :on] for part in state)
        torque[step, :on], state = law.torque(error[step, :on, None], velocity[step, :on, None], state)
    for i, (k, course) in enumerate(courses):
        found[k][course[WARM:]] = torque[WARM : len(course), i]
    return [torques[mine] for torques, mine in zip(found, rows, strict=True)]


def stretches(track: Track, rows: Rows) -> list[Rows]:
    """Rows that follow each other by a sample's time, parted."""
    import numpy as np

    found = []
    for phase in range(track.stride):
        mine = rows[rows % track.stride == phase]
        if len(mine):
            found += np.split(mine, np.flatnonzero(np.diff(mine) != track.stride) + 1)
    return found


def _scales(tracks: Sequence[Track], rows: Sequence[Rows]) -> Array:
    """Root mean squares of error and velocity, shape (2,)."""
    import numpy as np

    found = []
    for name in ("error", "velocity"):
        values = np.concatenate([getattr(t, name)[mine] for t, mine in zip(tracks, rows, strict=True)])
        found.append(float(np.sqrt(np.mean(values**2))) or 1.0)
    return np.array(found)


def _pieces(data: Dataset, rows: Sequence[Rows], scales: Array, own: Array, size: float) -> tuple[Any, ...]:
    """Inputs, shape (n, WARM + BODY, 2), torques, weights and slack, shape (n, BODY), in units of their sizes."""
    import numpy as np

    index = {joint.joint: i for i, joint in enumerate(data.actuators)}
    x, y, weight, slack = [], [], [], []
    for track, mine in zip(data.tracks, rows, strict=True):
        j = index[track.joint]
        for stretch in stretches(track, mine):
            # The last piece ends with the stretch; a short stretch is one piece, and what is before it counts not.
            for end in range(len(stretch), 0, -BODY):
                last = stretch[end - 1]
                body = last - track.stride * np.arange(BODY - 1, -1, -1)
                told = np.isin(body, stretch[max(end - BODY, 0) : end])
                course = last - track.stride * np.arange(WARM + BODY - 1, -1, -1)
                course = np.where(course < stretch[0] - track.stride * WARM, stretch[0], course)
                body = np.where(told, body, stretch[0])
                x.append(np.stack([track.error[course], track.velocity[course]], axis=1) / scales)
                y.append(track.torque[body] / size)
                weight.append(told * (size / own[j]) ** 2)
                slack.append((np.zeros(BODY) if track.slack is None else track.slack[body]) / size)
    return tuple(single_tensor(np.stack(part)) for part in (x, y, weight, slack))


def _run(
    seen: Any,
    unseen: Any,
    options: TrainOptions,
    scales: Array,
    size: float,
    progress: Callable[[int, int], Any],
) -> tuple[Layers, Run]:
    import numpy as np
    import torch

    torch.manual_seed(options.seed)
    lstm = torch.nn.LSTM(2, options.hidden[0], len(options.hidden), batch_first=True)
    head = torch.nn.Linear(options.hidden[0], 1)
    network = torch.nn.ModuleList([lstm, head])

    def mean(part: Any, rows: Any) -> Any:
        x, y, weight, slack = part
        left = beyond(torch, head(lstm(x[rows])[0][:, WARM:])[..., 0] - y[rows], slack[rows])
        return (weight[rows] * left * left).sum() / (weight[rows] > 0).sum()

    def judge() -> float:
        with torch.no_grad():
            return float(mean(unseen, slice(None)))

    count = len(seen[0])
    batch = min(max(count // 20, BATCH[0]), BATCH[1], count)
    run = descend(network, count, batch, lambda rows: mean(seen, rows), judge, options, progress)

    def of(name: str) -> Array:
        found: Array = getattr(lstm, name).detach().numpy().astype(float)
        return found

    layers = []
    for k in range(len(options.hidden)):
        inputs = of(f"weight_ih_l{k}") / (scales if k == 0 else np.ones(1))
        layers.append(LstmLayer(inputs, of(f"weight_hh_l{k}"), of(f"bias_ih_l{k}") + of(f"bias_hh_l{k}")))
    weight, bias = (part.detach().numpy().astype(float) * size for part in (head.weight, head.bias))
    return single(Layers(tuple(layers), (Dense(weight, bias),))), run
