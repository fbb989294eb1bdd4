"""Functions that are folded by what is published about them: Python's, numpy's and mjlab's pure ones.

Each takes positional and named arguments and gives data, or `Unknown`. The methods of dicts, texts and paths that
change nothing are here too.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping, Sequence

from actspec.diagnostics import Span
from actspec.readings.python.arithmetic import bounded, text_of
from actspec.readings.python.values import (
    MAX_ITEMS,
    MAX_TEXT,
    Budget,
    Data,
    External,
    Key,
    Obj,
    PathText,
    Seq,
    Table,
    Unknown,
    Value,
    class_names,
    possible,
    reason_of,
    shallow,
    truth,
)

MAX_KEY = 8
"""Values in a tuple that is a dict's key. Chosen: names of a side and a joint are two."""

_NOWHERE = Span("")

Args = Sequence[Value]
Named = Mapping[str, Value]
Number = Callable[..., object]

CONSTANTS: dict[str, float] = {
    **dict.fromkeys(("math.pi", "numpy.pi", "torch.pi"), math.pi),
    **dict.fromkeys(("math.e", "numpy.e"), math.e),
    **dict.fromkeys(("math.inf", "numpy.inf", "torch.inf"), math.inf),
    "math.tau": math.tau,
}
"""Names of other modules that are numbers."""

_OF_ONE_PATH = frozenset(
    f"os.path.{name}" for name in ("abspath", "realpath", "normpath", "fspath", "dirname")
)


def _two_stage(rotor_inertia: tuple[float, ...], gear_ratio: tuple[float, ...]) -> float:
    """Inertia of three rotors at a two-stage planetary gear's output: J1 (g1 g2)^2 + J2 g2^2 + J3 [kg*m^2].

    Source: mjlab 1.6.0, mjlab/utils/actuator.py, `reflected_inertia_from_two_stage_planetary`.
    """
    (first, second, third), (_, inner, outer) = rotor_inertia, gear_ratio
    return first * (inner * outer) ** 2 + second * outer**2 + third


def _linear(
    armature_rotary: float,
    velocity_limit_rotary: float,
    effort_limit_rotary: float,
    transmission_ratio: float,
) -> tuple[float, float, float]:
    """Armature [kg], speed [m/s] and force [N] behind a transmission of r [m/rad]: J/r^2, r w, T/r.

    Source: mjlab 1.6.0, mjlab/utils/actuator.py, `reflect_rotary_to_linear`.
    """
    ratio = transmission_ratio
    return armature_rotary / ratio**2, velocity_limit_rotary * ratio, effort_limit_rotary / ratio


def _rounded(number: float, digits: int | None = None) -> float:
    """`round`, which for a whole number and a great many digits would take for ever."""
    if digits is not None and abs(digits) > 300:
        raise ValueError("so many digits")
    return round(number, digits)


_SHARED = (
    "sqrt", "radians", "degrees", "sin", "cos", "tan", "exp", "log", "hypot", "fabs", "floor", "ceil",
)  # fmt: skip
"""Functions that math and numpy have under one name."""

NUMERIC: dict[str, Number] = {
    **{f"{module}.{name}": getattr(math, name) for module in ("math", "numpy") for name in _SHARED},
    **{f"math.{name}": getattr(math, name) for name in ("asin", "acos", "atan", "atan2", "pow")},
    "numpy.deg2rad": math.radians,
    "numpy.rad2deg": math.degrees,
    "numpy.abs": abs,
    "numpy.arctan2": math.atan2,
    "numpy.power": math.pow,
    "builtins.abs": abs,
    "builtins.round": _rounded,
    # Source: mjlab 1.6.0, mjlab/utils/actuator.py: J N^2; 2 pi / 60.
    "mjlab.reflected_inertia": lambda rotor_inertia, gear_ratio: rotor_inertia * gear_ratio**2,
    "mjlab.rpm_to_rad": lambda rpm: rpm * 2 * math.pi / 60,
    "mjlab.reflect_rotary_to_linear": _linear,
    "mjlab.reflected_inertia_from_two_stage_planetary": _two_stage,
}
"""Functions of numbers and tuples of numbers."""


def known(dotted: str) -> str:
    """The name under which a function is in the tables: mjlab re-exports its own from several modules."""
    root, _, rest = dotted.partition(".")
    return f"mjlab.{rest.rpartition('.')[2]}" if root == "mjlab" else dotted


def numeric(function: Number, args: Args, named: Named) -> Data:
    """A function of `NUMERIC`."""
    # Elsewhere a tuple would be repeated by a product, as often as the file likes.
    tuples = function is _two_stage
    try:
        plain = [_number(value, tuples) for value in args]
        by_name = {key: _number(value, tuples) for key, value in named.items()}
        result: object = function(*plain, **by_name)
    except _NotANumberError as err:
        return Unknown(str(err))
    except (ArithmeticError, ValueError, TypeError) as err:
        return Unknown(f"{getattr(function, '__name__', 'it')}: {err}")
    if isinstance(result, tuple):
        span = (*args, *named.values())[0].span
        return Seq([Value(one, span) for one in result], "tuple")
    return bounded(result) if isinstance(result, (int, float)) else Unknown("a complex number")


class _NotANumberError(Exception):
    pass


def _number(value: Value, tuples: bool) -> float | tuple[object, ...]:
    data = value.data
    reason = reason_of(data)
    if reason is not None:
        raise _NotANumberError(reason)
    if isinstance(data, (int, float)):
        return data
    if isinstance(data, Seq) and tuples:
        return tuple(_number(one, False) for one in data.items)
    raise _NotANumberError("an argument that is no number")


def elements(data: Data, budget: Budget) -> list[Value] | Unknown:
    """What iterating gives; a dict gives its keys, each at its value's place."""
    reason = reason_of(data)
    if reason is not None:
        return Unknown(reason, among=data.among if isinstance(data, Unknown) else ())
    if isinstance(data, Seq) and budget.spend(len(data.items)):
        return list(data.items)
    if isinstance(data, Table) and data.open is None and budget.spend(len(data.items)):
        return [_key_value(key, value.span) for key, value in data.items.items()]
    if isinstance(data, Obj) and "NamedTuple" in class_names(data.cls):
        return list(data.fields.values())
    return Unknown("iterated over")


def key_of(data: Data) -> Key | Unknown:
    """Data as a dict's key."""
    if isinstance(data, (str, int, float, type(None))):
        return data
    if isinstance(data, Seq) and data.kind == "tuple" and len(data.items) <= MAX_KEY:
        parts = [one.data for one in data.items]
        scalars = [part for part in parts if isinstance(part, (str, int, float, type(None)))]
        if len(scalars) == len(parts):
            return tuple(scalars)
    return Unknown(reason_of(data) or "a key that is neither text nor number")


def _key_value(key: Key, span: Span) -> Value:
    """A dict's key as a value."""
    return Value(Seq([Value(part, span) for part in key], "tuple") if isinstance(key, tuple) else key, span)


def builtin(name: str, args: Args, named: Named, value: Value, budget: Budget) -> Data:
    """A function of Python's own; `value` is the call, for its place."""
    first = args[0].data if args else None
    if name == "dict":
        return _dict(args, named, budget)
    if name in ("float", "int", "str", "bool") and len(args) == 1 and not named:
        return _converted(name, first)
    if named:
        return Unknown(f"{name}() with named arguments is not folded")
    if name == "len" and len(args) == 1 and isinstance(first, (str, Seq)):
        return len(first if isinstance(first, str) else first.items)
    if name == "range" and 1 <= len(args) <= 3:
        return _range(args)
    if name in ("min", "max", "sum") and args:
        found = elements(first, budget) if len(args) == 1 else list(args)
        if isinstance(found, Unknown):
            return found
        functions: dict[str, Number] = {"min": min, "max": max, "sum": sum}
        return numeric(lambda *plain: functions[name](plain), found, {})
    if name in ("tuple", "list", "set", "frozenset", "sorted", "reversed", "enumerate", "zip"):
        return _sequence(name, args, value, budget)
    return Unknown(f"calls {name}(), which is not folded")


def _sequence(name: str, args: Args, value: Value, budget: Budget) -> Data:
    lists: list[list[Value]] = []
    for arg in args:
        found = elements(arg.data, budget)
        if isinstance(found, Unknown):
            return found
        lists.append(found)
    if name == "zip":
        return Seq(
            [Value(Seq(list(pair), "tuple"), value.span) for pair in zip(*lists, strict=False)], "tuple"
        )
    if len(lists) > 1 or (not lists and name in ("sorted", "reversed", "enumerate")):
        return Unknown(f"{name}() with {len(lists)} arguments is not folded")
    items = lists[0] if lists else []
    if name == "enumerate":
        pairs = [[Value(i, one.span), one] for i, one in enumerate(items)]
        return Seq([Value(Seq(pair, "tuple"), value.span) for pair in pairs], "tuple")
    if name == "reversed":
        return Seq(items[::-1], "tuple")
    if name == "sorted":
        try:
            return Seq(sorted(items, key=lambda one: one.data))  # type: ignore[arg-type,return-value]
        except TypeError:
            return Unknown("sorted() of mixed values")
    return Seq(items, {"frozenset": "set"}.get(name, name))


def _range(args: Args) -> Data:
    numbers = [arg.data for arg in args]
    whole = [number for number in numbers if isinstance(number, int)]
    if len(whole) < len(numbers) or (len(whole) == 3 and whole[2] == 0):
        return Unknown(next((r for r in map(reason_of, numbers) if r), "range() of what is no whole number"))
    found = range(*whole)
    # len() of a range that is too long for the machine raises.
    if found[MAX_ITEMS : MAX_ITEMS + 1]:
        return Unknown(f"more than {MAX_ITEMS} values")
    return Seq([Value(number, args[0].span) for number in found], "tuple")


def _dict(args: Args, named: Named, budget: Budget) -> Data:
    table = Table({})
    if args:
        first = args[0].data
        budget.spend(len(first.items) if isinstance(first, (Seq, Table)) else 0)
        if isinstance(first, Table):
            table = Table(dict(first.items), first.open)
        else:
            pairs = [one.data for one in first.items] if isinstance(first, Seq) else []
            if not all(isinstance(pair, Seq) and len(pair.items) == 2 for pair in pairs) or not pairs:
                return Unknown(reason_of(first) or "dict() of what is no dict")
            for pair in pairs:
                assert isinstance(pair, Seq)
                key = key_of(pair.items[0].data)
                if isinstance(key, Unknown):
                    return key
                table.items[key] = pair.items[1]
    table.items.update(named)
    return table


def _converted(name: str, data: Data) -> Data:
    if name == "str":
        return str(data) if isinstance(data, (str, int, float)) else _as_text(data)
    reason = reason_of(data)
    if reason is not None:
        return Unknown(reason)
    if name == "bool":
        known_truth = truth(Value(data, _NOWHERE))
        return Unknown("bool() of it") if known_truth is None else known_truth
    try:
        if isinstance(data, (int, float, str)):
            return bounded(float(data) if name == "float" else int(data))
    except (ValueError, OverflowError) as err:
        return Unknown(f"{name}(): {err}"[:100])
    return Unknown(f"{name}() of what is no number")


def _as_text(data: Data) -> Data:
    reason = reason_of(data)
    return Unknown(reason, text_of(data)) if reason is not None else Unknown("str() of an object")


def look_up(owner: Value, index: Data) -> Value:
    """`owner[index]`; for an index that is not known, any of the values."""
    data = owner.data
    if isinstance(data, Unknown) and data.among:
        return Value(Unknown(data.reason, among=_inside(data.among)), owner.span)
    reason = reason_of(data)
    if reason is not None:
        return Value(Unknown(reason), owner.span)
    reason = reason_of(index)
    if reason is not None and isinstance(data, (Seq, Table)):
        return Value(Unknown(reason, among=_inside((owner,))), owner.span)
    if isinstance(data, Table):
        key = key_of(index)
        if isinstance(key, Unknown):
            return Value(key, owner.span)
        if key in data.items:
            return data.items[key]
        return Value(Unknown(data.open or f"there is no {str(key)[:40]!r} in it"), owner.span)
    if isinstance(data, (Seq, str)) and isinstance(index, int):
        size = len(data.items if isinstance(data, Seq) else data)
        if -size <= index < size:
            return data.items[index] if isinstance(data, Seq) else Value(data[index], owner.span)
        return Value(Unknown(f"there is no item {index} in it"), owner.span)
    return Value(Unknown(reason_of(index) or "indexed in a way that is not folded"), owner.span)


def _inside(owners: Sequence[Value]) -> tuple[Value, ...]:
    """Objects one step inside."""
    found: list[Value] = []
    for owner in owners:
        data = owner.data
        found.extend(
            data.items.values() if isinstance(data, Table) else data.items if isinstance(data, Seq) else ()
        )
    return possible(found)


def table_method(
    owner: Value, table: Table, name: str, args: Args, named: Named, budget: Budget
) -> Data | Value:
    """A method of a dict that changes nothing."""
    if name in ("keys", "values", "items") and not args:
        if table.open is not None or not budget.spend(len(table.items)):
            return Unknown(table.open or "iterated over", among=possible(table.items.values()))
        if name == "values":
            return Seq(list(table.items.values()), "tuple")
        keys = [_key_value(key, value.span) for key, value in table.items.items()]
        if name == "keys":
            return Seq(keys, "tuple")
        pairs = [[key, value] for key, value in zip(keys, table.items.values(), strict=True)]
        return Seq([Value(Seq(pair, "tuple"), pair[1].span) for pair in pairs], "tuple")
    if name == "copy" and not args:
        return shallow(owner, budget)
    if name == "get" and 1 <= len(args) <= 2 and not named:
        key = key_of(args[0].data)
        if not isinstance(key, Unknown) and key not in table.items and table.open is None:
            return args[1] if len(args) == 2 else None
        return look_up(owner, args[0].data)
    return Unknown(f"calls .{name}() of a dict, which is not folded")


def path_call(name: str, args: Args) -> Data | None:
    """`Path(...)` and the functions of `os.path`; None for any other."""
    texts = [text_of(arg.data) for arg in args]
    joins = name in ("pathlib.Path", "pathlib.PurePath", "os.path.join")
    if not texts or not (joins or (name in _OF_ONE_PATH and len(texts) == 1)):
        return None
    reason = next((reason_of(arg.data) for arg in args if reason_of(arg.data)), None)
    text, *others = (one or "" for one in texts)
    if None in texts:
        return Unknown(reason or "a path of what is no text")
    for part in others:
        text = part if part.startswith("/") else f"{text.rstrip('/')}/{part}" if text else part
    if name == "os.path.dirname":
        text = _parent(text)
    if len(text) > MAX_TEXT:
        return Unknown("a path that is too long")
    return Unknown(reason, text) if reason is not None else PathText(text)


def _parent(text: str) -> str:
    return text.rstrip("/").rpartition("/")[0] or "."


def path_attribute(path: str, name: str) -> Data | None:
    """An attribute of a `pathlib.Path`; None where it has none that is folded."""
    if name == "parent":
        return PathText(_parent(path))
    if name == "name":
        return path.rpartition("/")[2]
    if name == "stem":
        return path.rpartition("/")[2].rpartition(".")[0] or path.rpartition("/")[2]
    if name == "parents":
        found = []
        for _ in range(8):
            path = _parent(path)
            found.append(Value(PathText(path), _NOWHERE))
        return Seq(found, "tuple")
    return None


def text_method(text: str, name: str, args: Args) -> Data:
    """A method of a text."""
    if isinstance(text, PathText) and name in ("resolve", "absolute", "expanduser", "as_posix"):
        return str(text) if name == "as_posix" else text
    plain = [arg.data for arg in args]
    reason = next((r for r in map(reason_of, plain) if r), None)
    if reason is not None:
        return Unknown(reason)
    if name in ("lower", "upper", "strip", "title") and not plain:
        return str(getattr(text, name)())
    texts = [one for one in plain if isinstance(one, str)]
    if len(texts) == len(plain):
        if name in ("startswith", "endswith") and len(texts) == 1:
            return text.startswith(texts[0]) if name == "startswith" else text.endswith(texts[0])
        if name == "replace" and len(texts) == 2 and (text.count(texts[0]) + 1) * len(texts[1]) <= MAX_TEXT:
            return bounded(text.replace(texts[0], texts[1]))
    if name == "join" and len(plain) == 1 and isinstance(plain[0], Seq):
        parts = [one.data for one in plain[0].items]
        words = [part for part in parts if isinstance(part, str)]
        if len(words) == len(parts) and sum(map(len, words)) + len(text) * len(words) <= MAX_TEXT:
            return text.join(words)
    return Unknown(f"calls .{name}() of a text, which is not folded")


def field_default(obj: Obj) -> tuple[str, Value] | None:
    """What `dataclasses.field(...)` holds: ("default" or "default_factory", its value); None for another object."""
    if isinstance(obj.cls, External) and obj.cls.dotted == "dataclasses.field":
        for name in ("default", "default_factory"):
            if name in obj.fields:
                return name, obj.fields[name]
    return None


def operator_name(node: ast.AST) -> str:
    """A node's kind in words: `a GeneratorExp`."""
    name = type(node).__name__
    return f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"
