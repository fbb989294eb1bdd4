"""Operators on folded data, within the bounds of a pocket calculator."""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable
from typing import Any

from actspec.readings.python.values import (
    MAX_ITEMS,
    MAX_TEXT,
    Data,
    External,
    Obj,
    PathText,
    Seq,
    Table,
    Unknown,
    reason_of,
)

MAX_BITS = 256
"""Size of a whole number. Chosen: any physical quantity fits, and none takes time."""

MAX_POWER = 4096
"""Bits that a power of whole numbers may take on the way. Chosen: computed at once."""

_NUMERIC: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.BitOr: operator.or_,
    ast.BitAnd: operator.and_,
    ast.BitXor: operator.xor,
    ast.RShift: operator.rshift,
}

_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}

_FORMAT = re.compile(r"[<>^=]?[-+ ]?0?\d{0,3},?(\.\d{1,3})?[bdeEfFgGosxX%]?")
"""Format specs that are followed. Chosen: no width above 999."""

_SCALARS = (bool, int, float, str, type(None))


def bounded(data: Data) -> Data:
    """Data, or why they are too large to go on with."""
    if isinstance(data, int) and data.bit_length() > MAX_BITS:
        return Unknown(f"a whole number of more than {MAX_BITS} bits")
    if isinstance(data, str) and len(data) > MAX_TEXT:
        return Unknown(f"a text of more than {MAX_TEXT} characters")
    if isinstance(data, (Seq, Table)) and len(data.items) > MAX_ITEMS:
        return Unknown(f"more than {MAX_ITEMS} values")
    return data


def binary(op: ast.operator, left: Data, right: Data) -> Data:
    """`left op right`."""
    joined = _joined(op, left, right)
    if joined is not None:
        return joined
    for data in (left, right):
        reason = reason_of(data)
        if reason is not None:
            return Unknown(reason)
    if isinstance(left, (int, float)) and isinstance(right, (int, float)):
        return _numeric(op, left, right)
    if isinstance(op, ast.Add):
        if isinstance(left, str) and isinstance(right, str):
            return _text(left + right, left)
        if isinstance(left, Seq) and isinstance(right, Seq) and left.kind == right.kind != "set":
            return bounded(Seq([*left.items, *right.items], left.kind))
    if isinstance(op, ast.Mult):
        for one, times in ((left, right), (right, left)):
            if isinstance(one, (str, Seq)) and isinstance(times, int):
                return _repeated(one, times)
    if isinstance(op, ast.BitOr) and isinstance(left, Table) and isinstance(right, Table):
        return bounded(Table({**left.items, **right.items}, left.open or right.open))
    return Unknown(f"{type(op).__name__} of {_kind(left)} and {_kind(right)} is not folded")


def _joined(op: ast.operator, left: Data, right: Data) -> Data:
    """Paths and texts of which a part is not known; None when it is neither."""
    if isinstance(op, ast.Div) and isinstance(right, str):
        if isinstance(left, PathText):
            return right if right.startswith("/") else bounded(PathText(f"{left.rstrip('/')}/{right}"))
        known = text_of(left)
        if known is not None and not isinstance(left, str):
            return cut(Unknown(reason_of(left) or "", f"{known.rstrip('/')}/{right}"))
    if isinstance(op, ast.Add) and (isinstance(left, str) or isinstance(right, str)):
        reason = reason_of(left) or reason_of(right)
        one, other = text_of(left), text_of(right)
        if reason is not None and one is not None and other is not None:
            return cut(Unknown(reason, one + other))
    return None


def text_of(data: Data) -> str | None:
    """A text, with `{NAME}` where a name of another package stands; None for what is no text."""
    if isinstance(data, str):
        return data
    if isinstance(data, External):
        return f"{{{data.name}}}"
    return data.text if isinstance(data, Unknown) else None


def cut(data: Unknown) -> Unknown:
    """Without its text when that is too long."""
    return Unknown(data.reason) if data.text is not None and len(data.text) > MAX_TEXT else data


def _text(text: str, like: str) -> Data:
    return bounded(PathText(text) if isinstance(like, PathText) else text)


def _repeated(one: str | Seq, times: int) -> Data:
    size = len(one) if isinstance(one, str) else len(one.items)
    if size * max(times, 0) > (MAX_TEXT if isinstance(one, str) else MAX_ITEMS):
        return Unknown("repeated too often")
    return one * times if isinstance(one, str) else Seq(one.items * times, one.kind)


def _numeric(op: ast.operator, left: int | float, right: int | float) -> Data:
    if isinstance(left, int) and isinstance(right, int):
        if isinstance(op, ast.Pow) and abs(left).bit_length() * abs(right) > MAX_POWER:
            return Unknown("a power too large to compute")
        if isinstance(op, ast.LShift):
            return bounded(left << right) if 0 <= right <= MAX_BITS else Unknown("shifted too far")
    try:
        result = _NUMERIC[type(op)](left, right)
    except (ArithmeticError, ValueError, TypeError, KeyError) as err:
        return Unknown(f"{type(op).__name__}: {err}")
    return bounded(result) if isinstance(result, (int, float)) else Unknown("a complex number")


def unary(op: ast.unaryop, operand: Data) -> Data:
    """`op operand`; `not` is the caller's."""
    reason = reason_of(operand)
    if reason is not None:
        return Unknown(reason)
    if isinstance(operand, (int, float)):
        if isinstance(op, ast.USub):
            return -operand
        if isinstance(op, ast.UAdd):
            return +operand
        if isinstance(operand, int):
            return ~operand
    return Unknown(f"{type(op).__name__} of {_kind(operand)} is not folded")


def compare(op: ast.cmpop, left: Data, right: Data) -> bool | Unknown:
    """`left op right`."""
    for data in (left, right):
        reason = reason_of(data)
        if reason is not None:
            return Unknown(reason)
    if isinstance(op, (ast.Is, ast.IsNot)):
        if None not in (left, right) and not (isinstance(left, bool) and isinstance(right, bool)):
            return Unknown("whether two values are one object is not folded")
        return (left is right) == isinstance(op, ast.Is)
    if isinstance(op, (ast.In, ast.NotIn)):
        found = _contains(right, left)
        return found if isinstance(found, Unknown) else found == isinstance(op, ast.In)
    if isinstance(left, _SCALARS) and isinstance(right, _SCALARS):
        try:
            return _COMPARE[type(op)](left, right)
        except TypeError as err:
            return Unknown(str(err))
    return Unknown(f"{type(op).__name__} of {_kind(left)} and {_kind(right)} is not folded")


def _contains(container: Data, item: Data) -> bool | Unknown:
    if isinstance(item, _SCALARS):
        if isinstance(container, str) and isinstance(item, str):
            return item in container
        if isinstance(container, Table) and not container.open:
            return item in container.items
        if isinstance(container, Seq) and all(isinstance(one.data, _SCALARS) for one in container.items):
            return any(one.data == item for one in container.items)
    return Unknown("membership is not folded")


def formatted(data: Data, spec: str) -> Data:
    """One part of an f-string."""
    known = text_of(data)
    reason = reason_of(data)
    if reason is not None:
        return Unknown(reason, known)
    if isinstance(data, (str, int, float, type(None))) and _FORMAT.fullmatch(spec):
        try:
            return format(data, spec) if spec else str(data)
        except (ValueError, TypeError, OverflowError) as err:
            return Unknown(f"format {spec!r}: {err}")
    return Unknown(f"{_kind(data)} with format {spec[:20]!r} is not folded")


def _kind(data: Data) -> str:
    if isinstance(data, Seq):
        return f"a {data.kind}"
    if isinstance(data, Obj):
        return f"a {data.cls.name}"
    names = {Table: "a dict", str: "a text", PathText: "a path", type(None): "None", bool: "a truth value"}
    return names.get(type(data), "a number" if isinstance(data, (int, float)) else "what it is")
