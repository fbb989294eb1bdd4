"""The law of networks, against numbers by hand, torch's LSTM and onnx's own evaluator."""

from __future__ import annotations

import numpy as np
import pytest

from actspec.laws.network import Dense, Layers, LstmLayer, NetworkLaw, sequence
from actspec.readings.onnx_network import NetworkFileError, NetworkUnknown, read_onnx
from tests.network_files import onnx_mlp, onnx_operation

LINEAR = Layers((), (Dense(np.array([[1.0, 10.0, 100.0, 1000.0]]), np.array([0.5])),))


def test_taps_scales_and_order() -> None:
    """tau = 2 (0.5 + 3 e_k + 30 e_k-2 + 100 x 5 w_k + 1000 x 5 w_k-2); the history begins with its first sample."""
    law = NetworkLaw(LINEAR, (0, 1), 0.01, position_scale=3.0, velocity_scale=5.0, torque_scale=2.0)
    error, velocity = np.array([0.1, 0.2, 0.4]), np.array([0.01, 0.02, 0.04])
    # k=2: 2 (0.5 + 3 x 0.4 + 30 x 0.1 + 500 x 0.04 + 5000 x 0.01) = 2 x 74.7
    # k=0: 2 (0.5 + 33 x 0.1 + 5500 x 0.01) = 2 x 58.8
    assert sequence(law, error, velocity, 2) == pytest.approx([117.6, 2 * (0.5 + 6.6 - 3 + 10 + 50), 149.4])
    zero = NetworkLaw(LINEAR, (0, 1), 0.01, backfill=False)
    # k=0: 0.5 + 0.1 + 100 x 0.01
    assert sequence(zero, error, velocity, 2)[0] == pytest.approx(1.6)
    turned = NetworkLaw(LINEAR, (0, 1), 0.01, velocity_first=True)
    # 0.5 + 11 x 0.01 + 1100 x 0.1
    assert sequence(turned, error, velocity, 2)[0] == pytest.approx(110.61)


@pytest.mark.parametrize(
    ("name", "at_minus_two", "at_one"),
    [
        ("Relu", 0.0, 1.0),
        ("Elu", np.exp(-2.0) - 1.0, 1.0),
        ("Tanh", np.tanh(-2.0), np.tanh(1.0)),
        ("Softsign", -2.0 / 3.0, 0.5),
        ("Sigmoid", 1.0 / (1.0 + np.exp(2.0)), 1.0 / (1.0 + np.exp(-1.0))),
        ("Softplus", np.log(1.0 + np.exp(-2.0)), np.log(1.0 + np.exp(1.0))),
    ],
)
def test_activations_of_onnx(name: str, at_minus_two: float, at_one: float) -> None:
    """An activation is what ONNX defines it to be."""
    found = read_onnx(onnx_mlp([([[1.0]], [0.0], name)]))
    assert found(np.array([[-2.0], [1.0]]))[0][:, 0] == pytest.approx([at_minus_two, at_one], abs=1e-7)


def test_perceptron_is_that_of_onnx() -> None:
    """Three layers give what onnx's own evaluator gives."""
    from onnx import load_model_from_string
    from onnx.reference import ReferenceEvaluator

    random = np.random.default_rng(3)
    sizes = [6, 5, 4, 1]
    layers = [
        (random.normal(size=(b, a)), random.normal(size=b), kind)
        for a, b, kind in zip(sizes, sizes[1:], ["Elu", "Softsign", ""], strict=False)
    ]
    data = onnx_mlp(layers)
    x = random.normal(size=(7, 6))
    (expected,) = ReferenceEvaluator(load_model_from_string(data)).run(None, {"x": x.astype(np.float32)})
    assert read_onnx(data)(x)[0] == pytest.approx(expected, abs=1e-5)


def test_lstm_is_that_of_torch() -> None:
    """Two layers over four samples give what torch.nn.LSTM gives."""
    import torch

    torch.manual_seed(1)
    theirs = torch.nn.LSTM(2, 3, 2, batch_first=True)
    layers = tuple(
        LstmLayer(
            getattr(theirs, f"weight_ih_l{k}").detach().numpy(),
            getattr(theirs, f"weight_hh_l{k}").detach().numpy(),
            (getattr(theirs, f"bias_ih_l{k}") + getattr(theirs, f"bias_hh_l{k}")).detach().numpy(),
        )
        for k in range(2)
    )
    head = Dense(np.array([[1.0, -2.0, 3.0]]), np.array([0.1]))
    law = NetworkLaw(Layers(layers, (head,)), (0,), 0.005)
    x = np.random.default_rng(2).normal(size=(4, 5, 2)).astype(np.float32)
    with torch.no_grad():
        hidden, _ = theirs(torch.tensor(x.transpose(1, 0, 2)))
    expected = (hidden.numpy() @ np.array([1.0, -2.0, 3.0]) + 0.1).T
    assert sequence(law, x[..., 0], x[..., 1], 1) == pytest.approx(expected, abs=1e-5)


def test_files_that_are_none() -> None:
    """Cut off, empty, no protobuf; an operation that is not known is named."""
    good = onnx_mlp([([[1.0, 2.0]], [0.0], "Tanh")])
    for data in (b"", good[:-20], b"\x80\x04pickle", b"PK\x03\x04"):
        with pytest.raises(NetworkFileError):
            read_onnx(data)
    with pytest.raises(NetworkUnknown, match="Sin"):
        read_onnx(onnx_operation("Sin"))


def test_weights_in_another_file() -> None:
    """A file that names others is refused: nothing is followed."""
    import onnx

    model = onnx.load_model_from_string(onnx_mlp([([[1.0, 2.0]], [0.0], "")]))
    tensor = model.graph.initializer[0]
    tensor.data_location = onnx.TensorProto.EXTERNAL
    entry = tensor.external_data.add()
    entry.key, entry.value = "location", "/etc/passwd"
    with pytest.raises(NetworkFileError, match="another file"):
        read_onnx(model.SerializeToString())
