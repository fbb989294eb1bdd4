"""`net inspect` and `net convert` on networks of others: made by torch, with known slopes."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.cli.main import main
from actspec.learn.foreign import read_network_file
from actspec.readings.onnx_network import NetworkUnknown, read_onnx
from tests.learn.pendulums import MODEL, SPEC
from tests.network_files import onnx_mlp
from tests.schemas import fits

torch = pytest.importorskip("torch")

ROOT = Path(__file__).parents[2]
MANIFEST = {
    "format": "actspec-network/1",
    "kind": "mlp",
    "inputs": "velocity_position",
    "taps": [0, 1, 2],
    "tap_period": "20 ms",
    "position_scale": -2.0,
    "velocity_scale": 0.5,
    "torque_scale": 3.0,
    "initial_history": "zero",
}


def script(folder: Path, module: Any, name: str = "net.pt") -> str:
    """A TorchScript file."""
    torch.jit.save(torch.jit.script(module.eval()), str(folder / name))
    return str(folder / name)


def linear(weights: list[float]) -> Any:
    """A network that is linear near 0: 10 tanh(w x / 10)."""
    first, last = torch.nn.Linear(len(weights), 1, bias=False), torch.nn.Linear(1, 1, bias=False)
    first.weight.data = torch.tensor([weights]) / 10.0
    last.weight.data = torch.tensor([[10.0]])
    return torch.nn.Sequential(first, torch.nn.Tanh(), last)


def said(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, Any]]:
    code = main(["net", "inspect", *arguments, "--output-format", "json"])
    found = json.loads(capsys.readouterr().out)
    fits("net-inspect", found)
    return code, found


def test_sign_order_gains_and_delay(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As the network published for the Go1: measured - target, mostly one sample ago; errors first."""
    net = linear([0.0, -18.0, -2.0, -0.9, 0.0, 0.0])
    code, found = said(capsys, script(tmp_path, net), "--trust")
    assert code == 0
    assert (found["inputs"], found["error_sign"]) == ("position_velocity", "measured_minus_target")
    assert found["stiffness"] == pytest.approx(20.0, rel=1e-3)
    assert found["damping"] == pytest.approx(0.9, rel=1e-3)
    # (18 x 1 + 2 x 2) / 20
    assert found["delay_taps"] == pytest.approx(1.1, rel=1e-3)
    # 10 tanh(6): at 3 rad; 95 % of it at atanh(0.95) x 10 / 20 = 0.916 rad, the next of the grid is 0.95.
    assert found["saturation"]["torque"] == pytest.approx(10.0 * np.tanh(6.0), rel=1e-5)
    assert found["saturation"]["error"] == pytest.approx(0.95)


def test_velocities_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The block that answers with more torque is that of errors."""
    (tmp_path / "net.onnx").write_bytes(onnx_mlp([([[-0.5, -0.2, 30.0, 10.0]], [0.25], "")]))
    _, found = said(capsys, str(tmp_path / "net.onnx"))
    assert (found["inputs"], found["error_sign"]) == ("velocity_position", "target_minus_measured")
    assert found["stiffness"] == pytest.approx(40.0) and found["damping"] == pytest.approx(0.7)
    assert found["at_rest"] == pytest.approx(0.25) and found["saturation"]["error"] is None


def test_manifest_of_the_other_sign(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A manifest whose scale has the wrong sign, or too few taps, is contradicted: exit 1."""
    path = script(tmp_path, linear([-0.9, 0.0, 0.0, 0.0, -18.0, -2.0]))
    (tmp_path / "m.json").write_text(json.dumps(MANIFEST))
    code, found = said(capsys, path, "--trust", "--manifest", str(tmp_path / "m.json"))
    assert code == 0 and found["contradictions"] == []
    # d tau / d e = 3 x -2 x -20
    assert found["stiffness"] == pytest.approx(120.0, rel=1e-3)
    assert found["damping"] == pytest.approx(3 * 0.5 * 0.9, rel=1e-3)
    (tmp_path / "m.json").write_text(json.dumps({**MANIFEST, "position_scale": 2.0}))
    code, found = said(capsys, path, "--trust", "--manifest", str(tmp_path / "m.json"))
    assert code == 1 and "away from the target" in found["contradictions"][0]
    # Of two inputs it says nothing about six, whose weights tell: by them errors are last, at 20 N*m/rad.
    (tmp_path / "m.json").write_text(
        json.dumps({**MANIFEST, "inputs": "position_velocity", "taps": [0], "position_scale": 2.0})
    )
    code, found = said(capsys, path, "--trust", "--manifest", str(tmp_path / "m.json"))
    assert code == 1 and "6 inputs" in found["contradictions"][0]
    assert (found["inputs"], found["guessed"]) == ("velocity_position", True)
    assert found["stiffness"] == pytest.approx(20.0, rel=1e-3)


def test_saturation_of_an_error_that_stays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """10 tanh((18 + 2) e / 10) of an error at all taps, also where a history begins with zeros; 0.95 as above."""
    path = script(tmp_path, linear([0.0, 18.0, 2.0, -0.9, 0.0, 0.0]))
    scales = {"position_scale": 1.0, "velocity_scale": 1.0, "torque_scale": 1.0}
    manifest = {**MANIFEST, "inputs": "position_velocity", **scales}
    (tmp_path / "m.json").write_text(json.dumps(manifest))
    for more in ([], ["--manifest", str(tmp_path / "m.json")]):
        code, found = said(capsys, path, "--trust", *more)
        assert code == 0 and found["saturation"]["error"] == pytest.approx(0.95)
        assert found["saturation"]["torque"] == pytest.approx(10.0 * np.tanh(6.0), rel=1e-5)


@pytest.mark.parametrize(("damping", "doubtful"), [(0.9, False), (0.01, True), (-0.9, True)])
def test_an_order_in_doubt(
    damping: float, doubtful: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """18 N*m/rad: 0.018 N*m*s/rad are a thousandth of a second."""
    (tmp_path / "net.onnx").write_bytes(onnx_mlp([([[18.0, -damping]], [0.0], "")]))
    assert main(["net", "inspect", str(tmp_path / "net.onnx")]) == 0
    out = capsys.readouterr().out
    assert "position_velocity, by its weights" in out and ("(doubtful:" in out) == doubtful


def test_manifest_of_the_other_order(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Velocities first: -0.9 to the first input, 18 to the second. The order is told, and its consequences are not.

    Errors first gives -0.9 N*m/rad and 18 N*m*s/rad, both of the wrong sign; in the right order both are right. With
    the other sign of `position_scale` the right order gives -18 N*m/rad, and that is told with it.
    """
    path = script(tmp_path, linear([-0.9, 18.0]))
    first = {
        **MANIFEST,
        "inputs": "position_velocity",
        "taps": [0],
        "velocity_scale": 1.0,
        "torque_scale": 1.0,
    }
    asked = "velocities count more than errors: are the inputs velocity_position?"
    for scale, then in (
        (1.0, ""),
        (
            -1.0,
            " In that order an error of target - measured gives a torque away from the target: -18 N*m/rad; ",
        ),
    ):
        (tmp_path / "m.json").write_text(json.dumps({**first, "position_scale": scale}))
        code, found = said(capsys, path, "--trust", "--manifest", str(tmp_path / "m.json"))
        (told,) = found["contradictions"]
        assert code == 1 and told.startswith(asked + then) and (then or told == asked)


class Plain(torch.nn.Module):  # type: ignore[misc,name-defined]
    """Three layers, and one activation for both hidden ones, made first or last or called as a function."""

    def __init__(self, how: str, activation: Any) -> None:
        super().__init__()
        if how == "first":
            self.act = activation
        self.one, self.two, self.last = (torch.nn.Linear(n, m) for n, m in ((4, 8), (8, 8), (8, 1)))
        if how == "last":
            self.act = activation

    def forward(self, x: torch.Tensor) -> torch.Tensor:  # type: ignore[name-defined]
        return self.last(self.act(self.two(self.act(self.one(x)))))


class Called(Plain):
    """With a function."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:  # type: ignore[name-defined]
        return self.last(torch.nn.functional.elu(self.two(torch.nn.functional.elu(self.one(x)))))


class Odd(Plain):
    """With an activation behind the first layer alone, which no order of the parts tells, and a factor."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:  # type: ignore[name-defined]
        return 2.0 * self.last(self.two(self.act(self.one(x))))


@pytest.mark.parametrize("how", ["first", "last", "function"])
@pytest.mark.parametrize("activation", [torch.nn.Softsign(), torch.nn.ELU(), torch.nn.LeakyReLU(0.2)])
def test_one_activation_of_all_layers(how: str, activation: Any, tmp_path: Path) -> None:
    """A network in the usual style is read; its own answers tell where the activation is called."""
    torch.manual_seed(5)
    net = Called("", None) if how == "function" else Plain(how, activation)
    read = read_network_file(script(tmp_path, net), trust=True)
    x = torch.randn(20, 4)
    with torch.no_grad():
        assert read(x.double().numpy())[0] == pytest.approx(net(x).double().numpy(), abs=1e-5)


def test_what_more_than_layers_is_refused_with_a_way_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A factor behind the last layer is in no part of the file."""
    torch.manual_seed(5)
    assert main(["net", "inspect", script(tmp_path, Odd("last", torch.nn.Tanh())), "--trust"]) == 2
    err = capsys.readouterr().err
    assert "LRN013" in err and "it does more than its layers" in err and "torch.nn.Sequential" in err


@pytest.mark.parametrize("offset", [1.0, 2.0])
def test_softsign_in_three_operations(offset: float, tmp_path: Path) -> None:
    """x / (|x| + 1), as torch exports a Softsign; with another offset it is none, and refused."""
    from onnx import TensorProto, helper, numpy_helper

    weights = {"w": [[2.0, -1.0], [0.5, 3.0]], "b": [0.1, -0.2], "v": [[1.0, -2.0]], "c": [offset]}
    nodes = [
        helper.make_node("Gemm", ["x", "w", "b"], ["a"], transB=1),
        helper.make_node("Abs", ["a"], ["size"]),
        helper.make_node("Add", ["size", "c"], ["below"]),
        helper.make_node("Div", ["a", "below"], ["s"]),
        helper.make_node("Gemm", ["s", "v"], ["y"], transB=1),
    ]
    values = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, [None, width])
        for name, width in (("x", 2), ("y", 1))
    ]
    tensors = [numpy_helper.from_array(np.array(value, np.float32), name) for name, value in weights.items()]
    data = helper.make_model(
        helper.make_graph(nodes, "net", values[:1], values[1:], tensors)
    ).SerializeToString()
    if offset != 1.0:
        with pytest.raises(NetworkUnknown):
            read_onnx(data)
        return
    # By hand: 2 x 1 - 0.5 + 0.1 = 1.6 and 0.5 + 1.5 - 0.2 = 1.8; 1.6 / 2.6 - 2 x 1.8 / 2.8.
    assert read_onnx(data)(np.array([[1.0, 0.5]]))[0] == pytest.approx(1.6 / 2.6 - 3.6 / 2.8)


def test_convert(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Scales are in the weights afterwards, errors come first; torques are the same."""
    torch.manual_seed(3)
    net = torch.nn.Sequential(torch.nn.Linear(6, 8), torch.nn.Softsign(), torch.nn.Linear(8, 1))
    path = script(tmp_path, net)
    (tmp_path / "m.json").write_text(json.dumps(MANIFEST))
    arguments = [
        "net",
        "convert",
        path,
        "--manifest",
        str(tmp_path / "m.json"),
        "-o",
        str(tmp_path / "out" / "legs"),
    ]
    assert main(arguments) == 2
    assert "LRN016" in capsys.readouterr().err and not (tmp_path / "out").exists()
    # Weights of chance may drive a joint away from its target: 1 as well.
    assert main([*arguments, "--trust", "--output-format", "json"]) in (0, 1)
    written = json.loads(capsys.readouterr().out)
    fits("net-convert", written)
    ends = {"onnx": "onnx", "torchscript": "pt", "manifest": "json"}
    assert written["files"] == {name: str(tmp_path / "out" / f"legs.{end}") for name, end in ends.items()}
    manifest = json.loads((tmp_path / "out" / "legs.json").read_text())
    assert (manifest["inputs"], manifest["position_scale"], manifest["torque_scale"]) == (
        "position_velocity",
        1.0,
        1.0,
    )
    assert manifest["taps"] == [0, 1, 2] and manifest["tap_period"] == "20 ms"
    e, v = np.random.default_rng(1).normal(size=(2, 5, 3))
    with torch.no_grad():
        x = torch.tensor(np.concatenate([0.5 * v, -2.0 * e], axis=1), dtype=torch.float32)
        expected = 3.0 * net(x).numpy()
    found = read_onnx((tmp_path / "out" / "legs.onnx").read_bytes())(np.concatenate([e, v], axis=1))[0]
    assert found == pytest.approx(expected, abs=1e-5)


def test_convert_by_a_manifest_of_the_other_sign(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Files that drive a joint away from its target are written with a warning and exit 1, never silently."""
    monkeypatch.chdir(tmp_path)
    net = script(tmp_path, linear([0.0, -18.0, -2.0, -0.9, 0.0, 0.0]))
    convert = ["net", "convert", net, "--trust", "--manifest", "m.json", "--output-format", "json", "-o"]
    spec = SPEC.replace("level: ideal_pd, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad", "level: actuator_net")
    Path("robot.xml").write_text(MODEL)
    found = {}
    for name, scale in (("good", -1.0), ("bad", 1.0)):
        scales = {"position_scale": scale, "velocity_scale": 1.0, "torque_scale": 1.0}
        Path("m.json").write_text(json.dumps({**MANIFEST, "inputs": "position_velocity", **scales}))
        code = main([*convert, name])
        record = json.loads(capsys.readouterr().out)
        fits("net-convert", record)
        found[name] = code, [(item["code"], item["file"]) for item in record["findings"]]
        named = f"level: actuator_net, network: {{manifest: {name}.json}}"
        Path(f"{name}.yaml").write_text(
            spec.replace("level: actuator_net", named) + "targets: {mujoco: {}}\n"
        )
    assert found == {"good": (0, []), "bad": (1, [("LRN034", "m.json")])}
    for command in (["validate"], ["compile", "-o", "build", "--force"]):
        warned = {}
        for name in ("good", "bad"):
            assert main([command[0], f"{name}.yaml", *command[1:]]) == 0
            warned[name] = [line for line in capsys.readouterr().err.splitlines() if "NET016" in line]
        assert warned["good"] == []
        # By hand: the errors' weights are 0 - 18 - 2.
        assert len(warned["bad"]) == 1 and "away from the target: -20 N*m/rad" in warned["bad"][0]


@pytest.mark.slow
def test_lstm(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An LSTM as Isaac Lab's class takes it is read and converted."""

    class Net(torch.nn.Module):  # type: ignore[misc,name-defined]
        def __init__(self) -> None:
            super().__init__()
            self.lstm = torch.nn.LSTM(2, 4, 1, batch_first=True)
            self.head = torch.nn.Linear(4, 1)

        def forward(
            self, x: torch.Tensor, state: tuple[torch.Tensor, torch.Tensor]
        ) -> tuple[torch.Tensor, tuple[torch.Tensor, torch.Tensor]]:
            out, state = self.lstm(x, state)
            return self.head(out[:, -1]), state

    torch.manual_seed(4)
    module = Net().eval()
    example = (torch.zeros(1, 1, 2), (torch.zeros(1, 1, 4), torch.zeros(1, 1, 4)))
    torch.jit.save(torch.jit.trace(module, example), str(tmp_path / "net.pt"))
    code, found = said(capsys, str(tmp_path / "net.pt"), "--trust")
    assert code == 0 and found["kind"] == "lstm"
    manifest = {**MANIFEST, "kind": "lstm", "taps": [0], "inputs": "position_velocity", "tap_period": "5 ms"}
    (tmp_path / "m.json").write_text(json.dumps(manifest))
    out = str(tmp_path / "lstm")
    assert main(
        [
            "net",
            "convert",
            str(tmp_path / "net.pt"),
            "--trust",
            "--manifest",
            str(tmp_path / "m.json"),
            "-o",
            out,
        ]
    ) in (0, 1)
    layers = read_onnx((tmp_path / "lstm.onnx").read_bytes())
    x = np.array([[0.3, -0.7]])
    with torch.no_grad():
        scaled = torch.tensor(x * [-2.0, 0.5], dtype=torch.float32)[:, None]
        expected = 3.0 * module(scaled, (torch.zeros(1, 1, 4), torch.zeros(1, 1, 4)))[0].numpy()
    assert layers(x)[0] == pytest.approx(expected, abs=1e-5)


def test_what_is_no_network(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A pickle, weights without a program, an unknown part, a file that is not there: exit 2, nothing run."""

    class Strange(torch.nn.Module):  # type: ignore[misc,name-defined]
        def __init__(self) -> None:
            super().__init__()
            self.part = torch.nn.Linear(2, 1)

        def forward(self, x: torch.Tensor) -> torch.Tensor:
            return torch.sin(self.part(x))

    (tmp_path / "a.pt").write_bytes(pickle.dumps({"a": 1}))
    torch.save(linear([1.0, 1.0]).state_dict(), str(tmp_path / "b.pt"))
    torch.save(linear([1.0, 1.0]), str(tmp_path / "module.pt"))
    whole = Path(script(tmp_path, linear([1.0, 1.0]), "whole.pt")).read_bytes()
    (tmp_path / "cut.pt").write_bytes(whole[: len(whole) // 2])
    script(tmp_path, linear([1.0, 1.0, 1.0]), "odd.pt")
    script(tmp_path, Strange(), "c.pt")
    for name, words in (
        ("a.pt", "pickle"),
        ("b.pt", "by torch.save, of a module or of weights alone: such a file may run anything"),
        ("module.pt", "torch.jit.save(torch.jit.script(network), 'net.pt'), or torch.onnx.export"),
        ("cut.pt", "something else, or damaged"),
        ("odd.pt", "3 inputs and 1 output: an actuator network has as many errors as velocities"),
        ("c.pt", "more than its layers"),
        ("d.pt", "no such"),
    ):
        assert main(["net", "inspect", str(tmp_path / name), "--trust"]) == 2
        assert words in capsys.readouterr().err
