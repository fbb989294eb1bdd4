"""Compile a spec's text for mjlab, and read the module back without running it."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import Any

import pytest

from actspec.diagnostics import EmitError
from actspec.ir import ActuatorSet
from actspec.robot.view import RobotView
from actspec.targets.base import Approximation, Emission, TargetOptions
from actspec.targets.mjlab.emit import emit
from tests.targets import leg
from tests.targets.leg import LEG


@dataclass(frozen=True)
class Written:
    """A spec compiled for mjlab.

    Attributes:
        actuators: What it means.
        robot: Its robot.
        emission: What was written.
    """

    actuators: ActuatorSet
    robot: RobotView
    emission: Emission

    @property
    def text(self) -> str:
        """The module."""
        return self.emission.files[0].data.decode("utf-8")

    @property
    def constants(self) -> dict[str, Any]:
        """Every constant: a call as (class, fields), a dict or tuple as it is."""
        found = {}
        for node in ast.parse(self.text).body:
            if isinstance(node, ast.AnnAssign | ast.Assign) and node.value is not None:
                target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
                assert isinstance(target, ast.Name)
                found[target.id] = _value(node.value)
        return found

    @property
    def cfgs(self) -> dict[str, tuple[str, dict[str, Any]]]:
        """Every actuator cfg, by its constant."""
        return {name: value for name, value in self.constants.items() if "_ACTUATOR" in name}

    @property
    def cfg(self) -> tuple[str, dict[str, Any]]:
        """The one actuator cfg: class and fields without names of joints."""
        ((kind, fields),) = self.cfgs.values()
        return kind, {name: value for name, value in fields.items() if name != "target_names_expr"}

    def lost(self, field: str) -> Approximation:
        """The one approximation of a field."""
        return leg.lost(self.emission, field)


def _value(node: ast.expr) -> Any:
    if isinstance(node, ast.Call):
        if isinstance(node.func, ast.Name) and node.keywords:
            return node.func.id, {str(k.arg): _value(k.value) for k in node.keywords}
        return ast.unparse(node)
    try:
        return ast.literal_eval(node)
    except ValueError:
        return ast.unparse(node)


def written(actuators: str, model: str | None = LEG, version: str = "1.6", **rest: Any) -> Written:
    """Compile the `actuators` of a spec for this version of mjlab; `rest` as `tests.targets.leg.resolved` takes it.

    Raises: EmitError: with what is wrong.
    """
    resolved, view = leg.resolved(actuators, model, **rest)
    options = TargetOptions("mjlab", "mjlab", version, None, "out")
    return Written(resolved, view, emit(resolved, view, options))


def refused(actuators: str, model: str | None = LEG, version: str = "1.6", **rest: Any) -> list[str]:
    """What the target says against a spec: `CODE where: message`."""
    with pytest.raises(EmitError) as caught:
        written(actuators, model, version, **rest)
    return [f"{d.code} {d.where}: {d.message}" for d in caught.value.diagnostics]
