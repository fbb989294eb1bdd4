"""Compile a spec's text for Newton, and read the overlay back without USD."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import pytest

from actspec.diagnostics import EmitError
from actspec.ir import ActuatorSet
from actspec.robot.view import RobotView
from actspec.targets.base import Approximation, Emission
from actspec.targets.newton.emit import emit
from tests.compiling import target_options
from tests.targets import leg
from tests.targets.leg import LEG

ROOT = "/leg"
THIGH = "/leg/Geometry/trunk/thigh"


@dataclass(frozen=True)
class Written:
    """A spec compiled for Newton.

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
        """The overlay."""
        return self.emission.files[0].data.decode("utf-8")

    @property
    def prims(self) -> dict[str, dict[str, Any]]:
        """Every prim by its path: `is` its first words, `apis`, and each attribute's text."""
        return parsed(self.text)

    def attributes(self, path: str) -> dict[str, Any]:
        """A prim's numbers by their names, and other attributes as text."""
        return {k: v for k, v in self.prims[path].items() if k not in ("is", "apis", "active")}

    def lost(self, field: str) -> Approximation:
        """The one approximation of a field."""
        return leg.lost(self.emission, field)


def parsed(text: str) -> dict[str, dict[str, Any]]:
    """The prims of an overlay as actspec lays it out: one thing a line."""
    found: dict[str, dict[str, Any]] = {}
    path: list[str] = []
    for line in text.splitlines():
        bare = line.strip()
        prim = re.fullmatch(r'(over|def \w+) "((?:[^"\\]|\\.)*)"( \()?', bare)
        attribute = re.fullmatch(r"(\w+) ([\w:]+) = (.*?)(?:  # .*)?", bare)
        if prim:
            path.append(prim[2])
            found["/" + "/".join(path)] = {"is": prim[1], "apis": []}
        elif bare == "}" and path:
            path.pop()
        elif bare.startswith("prepend apiSchemas"):
            found["/" + "/".join(path)]["apis"] = re.findall(r'"([^"]*)"', bare)
        elif bare == "active = false":
            found["/" + "/".join(path)]["active"] = False
        elif attribute and path:
            number = attribute[1] in ("float", "int")
            found["/" + "/".join(path)][attribute[2]] = float(attribute[3]) if number else attribute[3]
    assert not path
    return found


def written(actuators: str, model: str | None = LEG, version: str = "1.8", **rest: Any) -> Written:
    """Compile the `actuators` of a spec for this version of Newton.

    Args:
        actuators: Lines, each indented by two.
        model: An MJCF; None: `robot` says `model: none` itself.
        version: Of Newton.
        rest: More of the spec, as `tests.targets.leg.resolved` takes it, and options of the target.

    Raises: EmitError: with what is wrong.
    """
    spec = {key: rest.pop(key) for key in ("robot", "motors", "timing", "path") if key in rest}
    return emitted(*leg.resolved(actuators, model, **spec), version, **rest)


def emitted(actuators: ActuatorSet, view: RobotView, version: str = "1.8", **options: Any) -> Written:
    """Actuators, compiled."""
    options |= {"joint_paths": dict(options.get("joint_paths", ()))}
    target = target_options("newton", version, **options)
    return Written(actuators, view, emit(actuators, view, target))


def refused(actuators: str, model: str | None = LEG, version: str = "1.8", **rest: Any) -> list[str]:
    """What the target says against a spec: `CODE where: message`."""
    with pytest.raises(EmitError) as caught:
        written(actuators, model, version, **rest)
    return [f"{d.code} {d.where}: {d.message}" for d in caught.value.diagnostics]
