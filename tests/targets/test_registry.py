"""A new target is its folder and one line: everything else asks the table of kinds."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest

from actspec.api import compile as compile_spec
from actspec.diagnostics import SpecError
from actspec.ir import ActuatorSet
from actspec.robot.view import RobotView
from actspec.spec.models import KINDS, Target, VersionedTarget
from actspec.spec.schema import schema
from actspec.targets.base import Emission, EmittedFile, TargetOptions
from actspec.targets.choose import emitter
from actspec.targets.kit.joint import delta_action_loss

SPEC = """actspec: 1
robot: {name: leg, model: none, joints: [hip, knee]}
timing: {physics_dt: 5 ms}
actuators: {legs: {joints: [".*"], level: ideal_pd, kp: 25, kd: 0.5, effort_limit: 9 N*m}}
targets:
  toy: {version: "1.0"}
  second: {target: toy}
"""


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """A simulator that takes a list of joints."""
    text = f"{options.version}: {' '.join(joint.name for joint in robot.joints)}\n"
    lost = delta_action_loss(actuators, options.name, "a toy runs no network")
    return Emission((EmittedFile("toy.txt", text.encode()),), lost)


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> None:
    """The folder `targets/toy` and its line."""
    module = ModuleType("actspec.targets.toy.emit")
    module.emit = emit  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "actspec.targets.toy", ModuleType("actspec.targets.toy"))
    monkeypatch.setitem(sys.modules, "actspec.targets.toy.emit", module)
    monkeypatch.setitem(KINDS, "toy", VersionedTarget)


@pytest.mark.usefixtures("toy")
def test_a_target_is_its_folder_and_one_line(tmp_path: Path) -> None:
    """A spec names it, `-t` asks for it, the schema offers it, and its files are written."""
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC, encoding="utf-8")
    compiled = compile_spec(path)
    assert [options.name for options in compiled.targets] == ["toy", "second"]
    assert [e.files[0].data for e in compiled.emissions] == [b"1.0: hip knee\n", b": hip knee\n"]
    (asked,) = compile_spec(path, targets=["toy==2.0"]).emissions
    assert asked.files[0].data == b"2.0: hip knee\n"
    assert "toy" in schema("spec")["$defs"]["Target"]["properties"]["target"]["enum"]


@pytest.mark.usefixtures("toy")
def test_it_has_the_options_of_its_line(tmp_path: Path) -> None:
    """Another kind's option is refused, with those that it has."""
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC.replace('version: "1.0"', "class: auto"), encoding="utf-8")
    with pytest.raises(SpecError) as caught:
        compile_spec(path)
    (said,) = caught.value.diagnostics
    assert (said.code, said.help) == ("SPEC163", "`class` is for isaaclab; toy has version")


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_its_folder_and_its_options(kind: str) -> None:
    """The line's class is a part of what the spec is read with, and the folder has `emit`."""
    assert issubclass(Target, KINDS[kind])
    assert callable(emitter(kind))
