"""A layer of USD's text form as data: its prims with their types, API schemas, attributes and relationships."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from actspec.diagnostics import Span


@dataclass(frozen=True, slots=True)
class Asset:
    """A file that an attribute names, as written."""

    path: str


Value = float | int | bool | str | Asset | tuple["Value", ...] | None


@dataclass(frozen=True, slots=True)
class UsdaAttribute:
    """An attribute or relationship of a prim.

    Attributes:
        type: `float`, `token[]`, ...; `rel` of a relationship.
        name: With its namespaces, `newton:kp`.
        value: Arrays and tuples as a tuple, of a relationship its paths as texts; None: it has none, or is blocked.
        span: Where it is written.
    """

    type: str
    name: str
    value: Value
    span: Span


@dataclass(frozen=True, slots=True)
class UsdaPrim:
    """A prim as far as one layer has it.

    Attributes:
        path: `/World/Robot`.
        specifier: `def`, `over` or `class`.
        type: `NewtonActuator`, ...; "" where the layer does not say.
        apis: API schemas that the layer applies, the strongest first.
        attributes: By name.
        active: False: the layer switches it off, or a prim above it.
        span: Where it is written.
    """

    path: str
    specifier: str
    type: str
    apis: tuple[str, ...]
    attributes: Mapping[str, UsdaAttribute]
    active: bool
    span: Span

    @property
    def name(self) -> str:
        """The last name of its path."""
        return self.path.rpartition("/")[2]


@dataclass(frozen=True, slots=True)
class UsdaLayer:
    """One file.

    Attributes:
        path: The file as the user named it.
        prims: By path, in the file's order.
        head: Comments before anything else, without their marks.
        unfollowed: Words of the layer that bring in others (`subLayers`, `references`), and their places.
    """

    path: str
    prims: Mapping[str, UsdaPrim]
    head: tuple[str, ...] = ()
    unfollowed: tuple[tuple[str, Span], ...] = ()
