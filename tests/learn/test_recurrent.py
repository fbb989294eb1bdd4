"""LSTMs on logs: pieces that they are trained on, and their torque along a recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from actspec import api
from actspec.diagnostics import Collector
from actspec.laws.network import NetworkLaw, sequence
from actspec.learn.recurrent import BODY, TAPS, WARM, _pieces, along, stretches
from actspec.learn.windows import Dataset, dataset
from tests.learn.pendulums import folder, log
from tests.learn.test_files import lstm

pytest.importorskip("torch")


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """Two pendulums over 300 rows, one of which was not read at row 150."""
    path = folder(tmp_path_factory.mktemp("lstm"))
    one = log(path / "1.npz", rows=300)
    hip = one.joints["hip"]
    assert hip.position is not None
    position = np.where(np.arange(300) == 150, np.nan, hip.position)
    one = replace(one, joints={**one.joints, "hip": replace(hip, position=position)})
    spec = api.load(str(path / "spec.yaml"))
    return dataset(api.resolve(spec, api.load_robot(spec)), [one], Collector(), taps=TAPS)


def test_along_a_recording(data: Dataset) -> None:
    """Each stretch from a state of 0, settled over the samples before its first row; every second row alike."""
    law = NetworkLaw(lstm(2), (0,), 0.005)
    rows = [track.rows for track in data.tracks]
    assert [len(stretches(t, mine)) for t, mine in zip(data.tracks, rows, strict=True)] == [2, 1]
    for stride in (1, 2):
        tracks = [replace(track, stride=stride) for track in data.tracks]
        # With as many told rows behind as two samples a row apart need.
        mine = [r[np.isin(r - WARM, r)] for r in rows]
        for track, found, asked in zip(tracks, along(law, tracks, mine), mine, strict=True):
            for stretch in stretches(track, asked):
                course = np.concatenate([stretch[0] - stride * np.arange(WARM, 0, -1), stretch])
                expected = sequence(law, track.error[course], track.velocity[course], 1)[WARM:]
                assert found[np.isin(asked, stretch)] == pytest.approx(expected, rel=1e-12)


def test_pieces(data: Dataset) -> None:
    """Every row counts once; the last sample of a piece is its last row's, and warm-up has no torque."""
    scales, own = np.array([0.5, 2.0]), np.array([1.0, 2.0])
    rows = [track.rows for track in data.tracks]
    x, y, weight, slack = (part.numpy() for part in _pieces(data, rows, scales, own, 4.0))
    # Rows 20 to 149 and 171 to 299 of the hip, 20 to 299 of the arm: 3 + 3 + 5 pieces.
    assert x.shape == (11, WARM + BODY, 2) and y.shape == weight.shape == slack.shape == (11, BODY)
    assert (weight > 0).sum() == sum(map(len, rows)) == 130 + 129 + 280
    assert set(weight[:6][weight[:6] > 0]) == {16.0} and set(weight[6:][weight[6:] > 0]) == {4.0}
    arm = data.tracks[1]
    assert x[6, -1] == pytest.approx([arm.error[299] / 0.5, arm.velocity[299] / 2.0], rel=1e-5)
    assert x[6, 0] == pytest.approx([arm.error[220] / 0.5, arm.velocity[220] / 2.0], rel=1e-5)
    assert y[6] == pytest.approx(arm.torque[240:300] / 4.0, rel=1e-5)
    # Of the 40 rows that are left the piece begins before the first: what is put there counts for nothing.
    assert (weight[10] > 0).sum() == 40 and weight[10, 19] == 0.0
    assert x[10, -40 - WARM :, 0] == pytest.approx(arm.error[:60] / 0.5, rel=1e-5)
