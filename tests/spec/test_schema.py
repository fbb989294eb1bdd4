"""The JSON Schemas: as committed, good for editors, and in step with the validator."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from actspec.diagnostics import SpecError
from actspec.spec.document import load_document
from actspec.spec.schema import FILES, schema, schema_text
from tests.spec.test_models import EVERYTHING

ROOT = Path(__file__).resolve().parents[2]
ERRORS = ROOT / "tests" / "errors"
ROBOTS = sorted((ROOT / "robots").glob("*.yaml"))


made = cache(schema)


def validator(name: str = "spec") -> jsonschema.Draft202012Validator:
    """A validator of the committed schema."""
    found = json.loads((ROOT / "schemas" / FILES[name]).read_text(encoding="utf-8"))
    return jsonschema.Draft202012Validator(found)


def parts(node: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Every mapping of a schema with its path."""
    if isinstance(node, dict):
        yield path, node
        for key, value in node.items():
            yield from parts(value, f"{path}/{key}")
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from parts(value, f"{path}/{index}")


def properties(name: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Every property of a schema: where, and what it is."""
    for path, node in parts(made(name)):
        if path.endswith("/properties"):
            for key, value in node.items():
                yield f"{path}/{key}", value


@pytest.mark.parametrize("name", FILES)
def test_committed_schemas_are_current(name: str, request: pytest.FixtureRequest) -> None:
    """The file in `schemas/` is what `actspec schema` prints; `--regen` writes it anew."""
    path = ROOT / "schemas" / FILES[name]
    text = schema_text(name)
    if request.config.getoption("--regen"):
        path.write_text(text, encoding="utf-8")
    assert path.read_text(encoding="utf-8") == text


def test_no_other_file_is_committed() -> None:
    """Every schema of the specs' family is generated."""
    assert set(FILES.values()) <= {path.name for path in (ROOT / "schemas").iterdir()}


@pytest.mark.parametrize("name", FILES)
def test_references_of_a_schema(name: str) -> None:
    """Every reference leads somewhere."""
    found = made(name)
    for _, node in parts(found):
        if isinstance(node.get("$ref"), str):
            assert node["$ref"].removeprefix("#/$defs/") in found["$defs"]


@pytest.mark.parametrize("name", FILES)
def test_null_is_nowhere(name: str) -> None:
    """An optional field is left out, never empty: an editor must not offer null."""
    for path, node in parts(made(name)):
        assert node.get("type") != "null", path
        assert "default" not in node or node["default"] is not None, path
        assert "actspec-definition" not in node, path


@pytest.mark.parametrize("name", FILES)
def test_every_property_is_described(name: str) -> None:
    """Hovering over a key says what it means."""
    described = dict(properties(name))
    assert described
    assert [path for path, node in described.items() if not node.get("description")] == []


@pytest.mark.parametrize("name", FILES)
def test_every_number_has_its_unit(name: str) -> None:
    """The description of a number has its unit in brackets, of hinge and slide where they differ."""
    units = {
        "torque": "[N*m or N]", "stiffness": "[N*m/rad or N/m]", "velocity_gain": "[N*m*s/rad or N*s/m]",
        "inertia": "[kg*m^2", "speed": "[rad/s or m/s]", "position": "[rad or m]", "time": "[s]",
        "frequency": "[Hz]", "ratio": "[-]", "voltage": "[V]", "current": "[A]", "torque_constant": "[N*m/A or N/A]",
        "length": "[m]", "lead": "[m/rad]",
    }  # fmt: skip
    for path, node in properties(name):
        for reference in re.findall(r"#/\$defs/([a-z_0-9]+)", json.dumps(node.get("$ref", ""))):
            kind = re.sub(r"^(positive_|nonnegative_)|(_to_\d+)?(_or_(unknown|identified))*$", "", reference)
            assert units[kind] in node["description"], path


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.stem)
def test_robots_fit(path: Path) -> None:
    """Our own specs are valid to an editor, whose comment finds the committed schema."""
    assert list(validator().iter_errors(load_document(str(path)).data)) == []
    first = path.read_text(encoding="utf-8").splitlines()[0]
    named = first.removeprefix("# yaml-language-server: $schema=")
    assert (path.parent / named).resolve() == ROOT / "schemas" / FILES["spec"]


def test_the_whole_language_fits(tmp_path: Path) -> None:
    """The example with every key is valid to an editor."""
    path = tmp_path / "s.yaml"
    path.write_text(EVERYTHING, encoding="utf-8")
    assert list(validator().iter_errors(load_document(str(path)).data)) == []


CAUGHT = (
    "unknown_key", "bare_number", "out_of_range", "empty_value", "shapes", "version_unquoted", "missing_keys",
    "no_actuators", "newer_version", "unknown_target", "source_shapes", "randomized_field",
)  # fmt: skip
"""Bad specs that a schema can catch; units, references, patterns and sums are beyond one."""


@pytest.mark.parametrize("name", CAUGHT)
def test_bad_specs_are_marked(name: str) -> None:
    """An editor marks what has the wrong shape, range or word, and lacks a unit."""
    assert list(validator().iter_errors(load_document(str(ERRORS / f"{name}.yaml")).data))


def _loadable() -> list[str]:
    found = []
    for path in sorted(ERRORS.glob("*.yaml")):
        try:
            load_document(str(path))
        except SpecError:
            continue
        found.append(path.stem)
    return found


@pytest.mark.parametrize("name", [n for n in _loadable() if n not in CAUGHT])
def test_the_schema_is_no_stricter_than_the_validator(name: str) -> None:
    """A spec without faults of shape is not marked: an editor's false alarm would teach to ignore it."""
    said = (ERRORS / f"{name}.txt").read_text(encoding="utf-8")
    shape = re.findall(r"(SPEC10[0-9]|SPEC110|SPEC160)[ :]", said)
    if not shape:
        assert list(validator().iter_errors(load_document(str(ERRORS / f"{name}.yaml")).data)) == []


RESULTS = """{"format": "actspec-results/1", "robot": "r", "method": "rollout", "joints": {"hip":
{"kp": {"value": 24, "std": 0.4}, "delay": "6 ms", "friction": {"coulomb": 0.2}}}}"""
NETWORK = """{"format": "actspec-network/1", "kind": "mlp", "inputs": "position_velocity", "taps": [0, 1, 2],
"tap_period": "5 ms", "position_scale": 1.0, "velocity_scale": 0.05, "torque_scale": 20,
"initial_history": "zero", "sha256": "%s"}""" % ("ab" * 32)

LOG = """{"format": "actspec-log/1", "robot": "a1", "date": "2026-11-22", "temperature": "warm", "supply": "24 V",
"units": {"position": "rad"}, "columns": {"q": "hip.position"}, "torque": "drive", "base": {"orientation": [1, 0, 0, 0]
}, "gains": {"hip": {"kp": 25, "kd": "0.5 N*m*s/rad"}}, "accuracy": {"torque": "3 %", "masses": 0.05}}"""


@pytest.mark.parametrize(
    ("name", "text", "key", "wrong"),
    [
        pytest.param("results", RESULTS, "format", "actspec-results/2", id="results format"),
        pytest.param("results", RESULTS, "joints", {"hip": {"damping": 1}}, id="results key"),
        pytest.param("results", RESULTS, "joints", {"hip": {"kp": -1}}, id="results range"),
        pytest.param("log", LOG, "temperature", "hot", id="log temperature"),
        pytest.param("log", LOG, "gains", {"hip": {"kp": 25}}, id="log gains"),
        pytest.param("log", LOG, "base", {"orientation": [1, 0, 0]}, id="log base"),
        pytest.param("log", LOG, "supply", -24, id="log supply"),
        pytest.param("network", NETWORK, "kind", "cnn", id="network kind"),
        pytest.param("network", NETWORK, "tap_period", 5, id="network period"),
        pytest.param("network", NETWORK, "taps", [-1], id="network taps"),
        pytest.param("network", NETWORK, "sha256", "12", id="network hash"),
    ],
)
def test_results_and_network(name: str, text: str, key: str, wrong: Any) -> None:
    """The other schemas take the good file and mark the bad one."""
    good = json.loads(text)
    assert list(validator(name).iter_errors(good)) == []
    assert list(validator(name).iter_errors({**good, key: wrong}))
