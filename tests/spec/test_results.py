"""Results files: what a fit writes, and how they are loaded beside a spec."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.diagnostics import Severity, SpecError
from actspec.spec.document import document_from_text
from actspec.spec.results import validate_results
from actspec.spec.validate import load_spec

GOOD = """format: actspec-results/1
robot: unitree_a1
method: rollout
date: 2026-11-21
temperature: warm
data: [{path: logs/chirp.csv, sha256: "%s"}]
held_out_rmse: 3 mrad
condition: 120.5
joints:
  hip:
    kp: {value: 24.1 N*m/rad, std: 0.4 N*m/rad}
    friction: {coulomb: {value: 0.21, std: 0.02}}
    delay: {value: 6 ms, std: 0.5 ms}
    closed_loop_bandwidth: 4.2 Hz
    bounds_hit: [bandwidth]
    unidentifiable: [armature]
""" % ("0123456789abcdef" * 4)
SPEC = """actspec: 1
robot: {name: r, model: none, joints: [hip]}
actuators:
  a: {joints: [hip], level: ideal_pd, kp: identified, kd: 1, identified: %s}
"""


def test_read() -> None:
    """Every number carries its std, in SI."""
    found = validate_results(document_from_text(GOOD, "r.yaml"))
    hip = found.joints["hip"]
    assert hip.kp is not None and hip.delay is not None and hip.friction.coulomb is not None
    assert (hip.kp.value, hip.kp.std) == (24.1, 0.4)
    assert (hip.delay.value, hip.delay.std) == (0.006, 0.0005)
    assert (hip.friction.coulomb.std, hip.bounds_hit, hip.unidentifiable) == (
        0.02,
        ("bandwidth",),
        ("armature",),
    )
    assert hip.armature is None


def test_all_errors_at_once() -> None:
    """A results file is checked as strictly as a spec: kinds, keys, empty values."""
    text = (
        GOOD.replace("24.1 N*m/rad", "24.1 N*m")
        .replace("joints:", "joint:\njoints:")
        .replace("120.5", "many")
    )
    text = text.replace("{value: 6 ms, std: 0.5 ms}", "")
    with pytest.raises(SpecError) as caught:
        validate_results(document_from_text(text, "r.yaml"))
    assert [(d.code, d.where) for d in caught.value.diagnostics] == [
        ("SPEC106", "condition"),
        ("SPEC101", "joint"),
        ("SPEC110", "joints.hip.kp.value"),
        ("SPEC103", "joints.hip.delay"),
    ]


@pytest.mark.parametrize(
    ("stated", "code", "message"),
    [
        ("{kp: [25, 26]}", "SPEC176", "the interval of kp is 25 to 26, its value 24.1"),
        ("{kp: [24.5, 24]}", "SPEC176", "the interval of kp is 24.5 to 24, its value 24.1"),
        ("{kp: [.nan, 26]}", "SPEC016", "must be a finite number, got .nan"),
        ("{kd: [0.1, 0.2]}", "SPEC176", "kd has an interval and no value"),
        ("{armature: [0.1, 0.2]}", "SPEC176", "armature has an interval and no value"),
        ("{stiffness: [0.1, 0.2]}", "SPEC174", "'stiffness' is no field of a joint's results"),
    ],
)
def test_an_interval_is_about_its_value(stated: str, code: str, message: str) -> None:
    """Both ends, in order, the value between them; of a field that has one."""
    text = GOOD.replace("    bounds_hit", f"    intervals: {stated}\n    bounds_hit")
    with pytest.raises(SpecError) as caught:
        validate_results(document_from_text(text, "r.yaml"))
    (found,) = caught.value.diagnostics
    assert found.span is not None and (found.code, found.message, found.span.line) == (code, message, 15)


def test_loaded_beside_the_spec(tmp_path: Path) -> None:
    """`identified` is relative to the spec's folder, and each file is read once."""
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "r.yaml").write_text(GOOD, encoding="utf-8")
    (tmp_path / "s.yaml").write_text(SPEC % "results/r.yaml", encoding="utf-8")
    assert list(load_spec(str(tmp_path / "s.yaml")).results) == ["results/r.yaml"]


def test_results_of_another_robot(tmp_path: Path) -> None:
    """The names differ: a warning, once for each file, at the first group that names it; equal names say nothing."""
    (tmp_path / "other.yaml").write_text(GOOD, encoding="utf-8")
    (tmp_path / "own.yaml").write_text(GOOD.replace("unitree_a1", "r"), encoding="utf-8")
    groups = "".join(
        f"  {name}: {{joints: [{name}], level: ideal_pd, kp: 1, kd: 1, identified: {file}}}\n"
        for name, file in (("a", "own.yaml"), ("b", "other.yaml"), ("c", "other.yaml"))
    )
    text = "actspec: 1\nrobot: {name: r, model: none, joints: [a, b, c]}\nactuators:\n" + groups
    (tmp_path / "s.yaml").write_text(text, encoding="utf-8")
    (found,) = load_spec(str(tmp_path / "s.yaml")).diagnostics
    assert found.span is not None
    assert (found.code, found.severity, found.where, found.span.line) == (
        "RES012",
        Severity.WARNING,
        "actuators.b.identified",
        5,
    )
    assert found.message == "'other.yaml' has the results of the robot 'unitree_a1', the spec is for 'r'"


@pytest.mark.parametrize(
    ("named", "code"),
    [
        pytest.param("results/none.yaml", "SPEC001", id="missing"),
        pytest.param("../r.yaml", "SPEC013", id="above"),
        pytest.param("/etc/hostname", "SPEC013", id="absolute"),
        pytest.param("results", "SPEC001", id="folder"),
        pytest.param('""', "SPEC001", id="empty"),
        pytest.param("link.yaml", "SPEC013", id="link"),
    ],
)
def test_where_results_may_lie(named: str, code: str, tmp_path: Path) -> None:
    """Results lie below the spec's folder; the error stands where the spec names them."""
    folder = tmp_path / "spec"
    (folder / "results").mkdir(parents=True)
    (tmp_path / "r.yaml").write_text(GOOD, encoding="utf-8")
    (folder / "link.yaml").symlink_to(tmp_path / "r.yaml")
    (folder / "s.yaml").write_text(SPEC % named, encoding="utf-8")
    with pytest.raises(SpecError) as caught:
        load_spec(str(folder / "s.yaml"))
    (found,) = caught.value.diagnostics
    assert found.span is not None
    assert (found.code, found.where, found.span.line) == (code, "actuators.a.identified", 4)
