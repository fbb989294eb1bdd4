"""What a model's text makes more of than it writes: copies, cells, numbers, steps; judged before MuJoCo makes them.

Measured with MuJoCo 4.0.0: `nkey="100000"` takes 12 s and ten times as many minutes, 10,000 copies of a body 17 s,
5,000 of them 3.5 s, a height field of 10,000 by 10,000 1.5 GB, a `texture` of a cube of 8,000 over 12 s,
`nuser_jnt="100000000"` 2.3 GB. A flex of 64,000 points on the corners of a few cells takes 1.5 s.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from actspec.diagnostics import RobotError

if TYPE_CHECKING:
    from actspec.robot.xml_tree import Element, XmlDocument


class Budget(NamedTuple):
    """What a model may make of one kind, all its elements together."""

    name: str
    most: int


TOO_LARGE = "ROBOT110"
"""Code of the refusal: neither MuJoCo nor anything else reads such a model."""
COPIES = Budget("copies", 5_000)
POINTS = Budget("points", 50_000)
CELLS = Budget("cells of height fields and textures", 40_000_000)
NUMBERS = Budget("numbers of the user", 10_000_000)
STEPS = Budget("steps in search of a length range", 1_000_000)
DIVISIONS = Budget("divisions of a mesh", 2_000)

_MARKS = tuple(
    b"<replicate <flexcomp <composite <size <hfield <texture <numeric <lengthrange <user builtin actdim nsample".split()
)
"""A text that has none of them makes nothing more than it writes."""


def check(document: XmlDocument) -> None:
    """Refuse a model whose text states sizes beyond a budget.

    Raises: RobotError: ROBOT110, at the element that goes beyond it.
    """
    if not any(mark in file.data for file in document.files for mark in _MARKS):
        return
    spent: dict[Budget, float] = {}
    elements = sum(1 for _ in document.walk())
    stack = [(document.root, 1.0)]
    while stack:
        element, copies = stack.pop()
        if element.tag == "replicate":
            copies *= max(_number(element, "count"), 1.0)
        for budget, what, amount in _made(element, copies, elements):
            spent[budget] = spent.get(budget, 0.0) + amount
            if spent[budget] > budget.most:
                message = f"{what} makes more than {budget.most} {budget.name}, the most that are read"
                raise RobotError.of(TOO_LARGE, message, document.span(element))
        stack += [(child, copies) for child in reversed(element.children)]


def _made(element: Element, copies: float, elements: int) -> Iterator[tuple[Budget, str, float]]:
    """What an element makes: budget, the attribute that says so, amount."""
    tag = element.tag
    if tag == "replicate":
        yield COPIES, _said(element, "count"), copies
    elif tag == "composite" and element.get("count"):
        yield COPIES, _said(element, "count"), copies * math.prod(_numbers(element, "count"))
    elif tag == "flexcomp" and element.get("count"):
        few = element.get("rigid") == "true" or element.get("dof") in ("trilinear", "quadratic")
        yield POINTS if few else COPIES, _said(element, "type", "count", "dof"), copies * _points(element)
    elif tag == "size":
        yield COPIES, _said(element, "nkey"), _number(element, "nkey")
        yield NUMBERS, _said(element, "nuserdata"), _number(element, "nuserdata")
        for name in element.values:
            if name.startswith("nuser_"):
                yield NUMBERS, _said(element, name), _number(element, name) * elements
    elif tag == "hfield":
        cells = _number(element, "nrow") * _number(element, "ncol")
        yield CELLS, _said(element, "nrow", "ncol"), cells
    elif tag == "texture" and element.get("builtin", "none") != "none":
        width, height = _number(element, "width"), _number(element, "height")
        faces = width * height if element.get("type") == "2d" else 6.0 * width * width
        yield CELLS, _said(element, "width", "height"), faces
    elif tag == "mesh" and element.get("builtin"):
        # Points go with the square, and the time for their hull.
        yield DIVISIONS, _said(element, "params"), max(_numbers(element, "params"), default=0.0)
    elif tag == "lengthrange":
        step = _number(element, "timestep") or 0.01
        yield STEPS, _said(element, "inttotal", "timestep"), (_number(element, "inttotal") or 10.0) / step
    elif tag == "numeric":
        yield NUMBERS, _said(element, "size"), _number(element, "size")
    elif tag == "user":
        yield NUMBERS, _said(element, "dim"), _number(element, "dim") * copies
    for name in ("actdim", "nsample"):
        if name in element.values:
            yield NUMBERS, _said(element, name), _number(element, name) * copies


def _points(element: Element) -> float:
    """Points that a flex makes of its count, each a body unless few bodies carry all; measured with MuJoCo 4.0.0."""
    count, kind = _numbers(element, "count"), element.get("type", "grid")
    if kind in ("mesh", "gmsh", "direct"):
        # Theirs are in a file, or written out.
        return 0.0
    if kind == "circle":
        # Closed: the last is the first.
        return max(_number(element, "count") - 1.0, 0.0)
    whole, inside = math.prod(count), math.prod(max(one - 2.0, 0.0) for one in count)
    # A shell, and one in the middle; infinite counts have no difference.
    return whole - inside + 1.0 if kind in ("box", "cylinder", "ellipsoid") and inside < whole else whole


def _said(element: Element, *names: str) -> str:
    """The element with what it says, as it stands there."""
    values = (f'{name}="{element.values[name][:24]}"' for name in names if name in element.values)
    return f"<{' '.join((element.tag, *values))}>"


def _number(element: Element, name: str) -> float:
    return next(iter(_numbers(element, name)), 0.0)


def _numbers(element: Element, name: str) -> list[float]:
    """The numbers of an attribute; 0 in place of what is none, which MuJoCo refuses."""
    found = []
    for text in (element.get(name) or "").split()[:8]:
        try:
            number = abs(float(text))
        except ValueError:
            number = 0.0
        found.append(0.0 if math.isnan(number) else number)
    return found
