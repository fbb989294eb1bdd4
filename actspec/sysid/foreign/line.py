"""Friction as a line: torque k v + b over speed, fitted by hand or by a spreadsheet."""

from __future__ import annotations

from typing import Any

from pydantic_core import PydanticCustomError

from actspec.diagnostics import Collector, Path, Span, dotted
from actspec.logs import LogError
from actspec.spec.values import Number, SpecValue
from actspec.sysid.foreign.figures import Figure, Found, Given, JointFound, Options, document
from actspec.units import Kind

OPTIONS = ("joints",)
EXPORT = "write YAML: `k: 0.02 N*m*s/rad` and `b: 0.35 N*m`, for all joints or under the name of each"
SLOPE, OFFSET = (
    Number(Kind.VELOCITY_GAIN, at_least=0.0, unknown=False),
    Number(Kind.TORQUE, at_least=0.0, unknown=False),
)


def read(given: Given, options: Options, collector: Collector) -> Found:
    """`{k, b}`, or a joint's name to that; k is viscous and b Coulomb friction.

    Both need their unit: the tools that fit lines know none. A std beside the value is taken along.
    """
    found = document(given, EXPORT)
    data: dict[str, Any] = found.data
    shared = set(data) <= {"k", "b"}
    if shared and not options.joints:
        raise LogError.of("SYS071", "of which joints are k and b?", Span(given.path), help="--joint hip knee")
    wanted = options.joints or tuple(data)
    joints: dict[str, JointFound] = {}
    for name in wanted:
        path: Path = () if shared else (name,)
        entry = data if shared else data.get(name)
        if not isinstance(entry, dict) or set(entry) != {"k", "b"}:
            message = f"{name} has not just k and b" if name in data or shared else f"has no joint '{name}'"
            collector.error("SYS070", message, where=dotted(path), span=found.spans.value(path), help=EXPORT)
            continue
        joint = JointFound()
        for key, field, kind in (("k", "friction.viscous", SLOPE), ("b", "friction.coulomb", OFFSET)):
            value = _value(entry[key], kind, (*path, key), found.spans.value((*path, key)), collector)
            if value is not None and value.value is not None:
                joint.figures[field] = Figure(value.value, value.unit, value.std)
        joints[name] = joint
    return Found(given, "line", "", joints)


def _value(given: Any, kind: Number, path: Path, span: Span, collector: Collector) -> SpecValue | None:
    """A number with its unit; None after an error."""
    try:
        value = kind(given)
    except PydanticCustomError as err:
        context = err.context or {}
        collector.error(
            "SYS072", str(context["message"]), where=dotted(path), span=span, help=context.get("help")
        )
        return None
    if value.linear is None:
        unit = "N*m*s/rad (or N*s/m)" if path[-1] == "k" else "N*m (or N)"
        collector.error(
            "SYS072",
            f"{value.written} has no unit",
            where=dotted(path),
            span=span,
            help=f"write it in {unit}",
        )
        return None
    return value
