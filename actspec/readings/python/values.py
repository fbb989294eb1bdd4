"""What Python expressions fold to: plain data, stand-ins for objects and classes, and what is not known.

Lists, dicts and objects are shared as in Python: `b = a; b.x = 1` changes `a` too. A value carries the place
where it is written, through names and attributes.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeAlias

from actspec.diagnostics import Span
from actspec.readings.python.source import FRAMEWORKS, OUTSIDE

if TYPE_CHECKING:
    from actspec.readings.python.source import Source

MAX_STEPS = 200_000
"""Folding steps for one named file and all that it imports. Chosen: Isaac Lab's and mjlab's largest take 21 000."""

MAX_DEPTH = 100
"""Nested expressions, statements and calls. Chosen: a tenth of Python's own limit, each takes a few frames."""

MAX_NESTING = 40
"""Lists, dicts and objects within each other. Chosen: a whole task of Isaac Lab has about 10."""

MAX_ITEMS = 10_000
"""Values in one list or dict. Chosen: the largest table of Isaac Lab's robots has 300."""

MAX_TEXT = 65_536
"""Characters of one text. Chosen: far above any path or pattern."""


@dataclass(frozen=True, slots=True)
class Value:
    """Something folded, and where it is written."""

    data: Data
    span: Span


@dataclass(frozen=True, slots=True)
class Unknown:
    """Not folded.

    Attributes:
        reason: Why.
        text: The text as far as it is known, with `{NAME}` for what is not; None when it is no text.
        among: Objects that it may be; a store into it may change any of them.
    """

    reason: str
    text: str | None = None
    among: tuple[Value, ...] = ()


_FROM = " comes from "


@dataclass(frozen=True, slots=True)
class External:
    """A name of a module that is not read: `isaaclab.actuators.DCMotorCfg`."""

    dotted: str
    why: str = OUTSIDE

    @property
    def name(self) -> str:
        """The last part of the name."""
        return self.dotted.rpartition(".")[2]

    @property
    def root(self) -> str:
        """The top package; the whole of a relative module's name."""
        return self.dotted.partition(".")[0] or self.dotted.rpartition(".")[0]

    @property
    def reason(self) -> str:
        """Why it is not known."""
        if self.root == "builtins":
            return f"{self.name} is not folded"
        if self.root in sys.stdlib_module_names:
            return f"{self.name}{_FROM}Python's {self.root}, which is not run"
        return f"{self.name}{_FROM}{self.root}, which {self.why}"

    @property
    def is_class(self) -> bool:
        """Whether it is spelt like a class: `DCMotorCfg`, but neither `UNITREE_GO2_CFG` nor `sqrt`."""
        name = self.name.lstrip("_")
        return name[:1].isupper() and any(c.islower() for c in name)


class PathText(str):
    """A `pathlib.Path`, as the text that it would print."""

    __slots__ = ()


@dataclass(eq=False, slots=True)
class Seq:
    """A list, tuple or set (in the author's order)."""

    items: list[Value]
    kind: str = "list"


@dataclass(eq=False, slots=True)
class Table:
    """A dict.

    Attributes:
        items: Its values.
        open: Why there may be others; None when there are none.
        filled: It as loops of its module leave it, of one that is open for them alone.
    """

    items: dict[Key, Value]
    open: str | None = None
    filled: Value | None = None


@dataclass(eq=False, slots=True)
class Obj:
    """An object: what a class was called with, and what was assigned since.

    Attributes:
        cls: Its class.
        fields: By name; a field that is not here has the class's default, if any.
        args: Positional arguments of a class whose fields nobody here knows.
        span: The call that made it; kept by copies.
        open: Why fields may differ from what is here; None when they do not.
    """

    cls: Cls | External
    fields: dict[str, Value]
    args: list[Value]
    span: Span
    open: str | None = None


@dataclass(eq=False, slots=True)
class Cls:
    """A class of a file that is read.

    Attributes:
        name: As written.
        bases: Classes, or why they are not known.
        scope: Its body's names.
        annotated: Its annotated names, in order: the fields of a dataclass.
        configclass: Whether Isaac Lab's decorator is on it.
        span: Where it is.
    """

    name: str
    bases: list[Cls | External | Unknown]
    scope: Scope
    annotated: list[str]
    configclass: bool
    span: Span


@dataclass(eq=False, slots=True)
class Func:
    """A function of a file that is read."""

    name: str
    node: ast.FunctionDef | ast.Lambda
    scope: Scope
    defaults: dict[str, Value]
    decorators: tuple[str, ...]
    owner: Cls | None = None


@dataclass(frozen=True, slots=True)
class Bound:
    """A method of a value: one of a class that is read, or by name one of Python's own."""

    owner: Value
    method: Func | str


@dataclass(eq=False, slots=True)
class Module:
    """A file that was read."""

    scope: Scope


@dataclass(eq=False, slots=True)
class Lazy:
    """An import that nobody has used yet."""

    level: int
    module: str
    name: str
    span: Span
    value: Value | None = None


@dataclass(eq=False, slots=True)
class Scope:
    """Names of a module, class, function or comprehension.

    Attributes:
        kind: Which of these.
        source: The file.
        parent: The scope around it, None for a module.
        names: Its names.
        stars: Modules that `import *` takes names from, latest last.
        this: `self` of a method; cls: the class it is written in.
        globals: Names declared `global`.
        returned: What the function returns for certain; None as long as it does not.
        maybe: What it returns where a test is not known.
    """

    kind: str
    source: Source
    parent: Scope | None = None
    names: dict[str, Value | Lazy] = field(default_factory=dict)
    stars: list[Lazy] = field(default_factory=list)
    this: Value | None = None
    cls: Cls | None = None
    globals: set[str] = field(default_factory=set)
    returned: Value | None = None
    maybe: list[Value] = field(default_factory=list)

    @property
    def module(self) -> Scope:
        """The scope of the file."""
        scope = self
        while scope.parent is not None:
            scope = scope.parent
        return scope

    def visible(self) -> Iterator[Scope]:
        """Scopes that a name is looked for in: a class body is seen by itself alone."""
        scope: Scope | None = self
        while scope is not None:
            if scope is self or scope.kind != "class":
                yield scope
            scope = scope.parent


Scalar: TypeAlias = bool | int | float | str | None
Key: TypeAlias = Scalar | tuple[Scalar, ...]
Data: TypeAlias = Scalar | Seq | Table | Obj | Cls | Func | Bound | Module | External | Unknown


@dataclass(slots=True)
class Budget:
    """Steps that are left."""

    left: int = MAX_STEPS

    def spend(self, steps: int = 1) -> bool:
        """Take steps; False when there are none left."""
        self.left -= steps
        return self.left >= 0


SPENT = Unknown(f"the file takes more than {MAX_STEPS} folding steps")


def ancestors(cls: Cls) -> list[Cls | External | Unknown]:
    """A class and its bases, nearest first, depth first; cut after `MAX_DEPTH` of them."""
    found: list[Cls | External | Unknown] = []
    waiting: list[Cls | External | Unknown] = [cls]
    while waiting and len(found) < MAX_DEPTH:
        one = waiting.pop(0)
        if one not in found:
            found.append(one)
            if isinstance(one, Cls):
                waiting[:0] = one.bases[:MAX_DEPTH]
    return found


def class_names(cls: Cls | External) -> list[str]:
    """Names of a class and of the bases that are known, nearest first."""
    if isinstance(cls, External):
        return [cls.name]
    return [one.name for one in ancestors(cls) if not isinstance(one, Unknown)]


def class_roots(cls: Cls | External) -> set[str]:
    """Top packages of the classes, not read, that a class is or derives from."""
    if isinstance(cls, External):
        return {cls.root}
    return {one.root for one in ancestors(cls) if isinstance(one, External)}


def unread_module(cls: Cls | External) -> str | None:
    """Module of the class, or of the base, whose file is not there; None: all are read or a framework's."""
    chain = [cls] if isinstance(cls, External) else ancestors(cls)
    for one in chain:
        if not isinstance(one, External) or one.why != OUTSIDE or not one.root.isidentifier():
            continue
        if one.root.partition("_")[0] not in FRAMEWORKS:
            return one.dotted.rpartition(".")[0] or None
    return None


def is_configclass(cls: Cls | External) -> bool:
    """Whether making one copies what it is given, as Isaac Lab's `configclass` does.

    Source: Isaac Lab 2.3.2, isaaclab/utils/configclass.py, `_custom_post_init`.
    """
    if isinstance(cls, Cls) and any(isinstance(one, Cls) and one.configclass for one in ancestors(cls)):
        return True
    return any(root.startswith("isaaclab") or root == "omni" for root in class_roots(cls))


def clone(value: Value, budget: Budget, depth: int = 0, seen: dict[int, Value] | None = None) -> Value:
    """A deep copy; what it shares inside, the copy shares too."""
    data = value.data
    if not isinstance(data, (Seq, Table, Obj)):
        return value
    seen = {} if seen is None else seen
    if id(data) in seen:
        return seen[id(data)]
    if not budget.spend():
        return Value(SPENT, value.span)
    if depth > MAX_NESTING:
        return Value(Unknown(f"nested deeper than {MAX_NESTING}"), value.span)

    def copied(one: Value) -> Value:
        budget.spend()
        return clone(one, budget, depth + 1, seen)

    made: Seq | Table | Obj
    if isinstance(data, Seq):
        made = Seq([], data.kind)
        result = seen[id(data)] = Value(made, value.span)
        made.items.extend(copied(one) for one in data.items)
    elif isinstance(data, Table):
        made = Table({}, data.open, data.filled)
        result = seen[id(data)] = Value(made, value.span)
        made.items.update((key, copied(one)) for key, one in data.items.items())
    else:
        made = Obj(data.cls, {}, [], data.span, data.open)
        result = seen[id(data)] = Value(made, value.span)
        made.fields.update((key, copied(one)) for key, one in data.fields.items())
        made.args.extend(copied(one) for one in data.args)
    return result


def shallow(value: Value, budget: Budget) -> Value:
    """A copy that shares what is inside."""
    data = value.data
    if isinstance(data, Seq) and budget.spend(len(data.items)):
        return Value(Seq(list(data.items), data.kind), value.span)
    if isinstance(data, Table) and budget.spend(len(data.items)):
        return Value(Table(dict(data.items), data.open, data.filled), value.span)
    if isinstance(data, Obj) and budget.spend(len(data.fields)):
        return Value(Obj(data.cls, dict(data.fields), list(data.args), data.span, data.open), value.span)
    return value


def same(one: Value, other: Value) -> bool:
    """Whether two values are known and equal: one object, one name of another package, or equal scalars."""
    a, b = one.data, other.data
    if isinstance(a, External) and isinstance(b, External):
        return a.dotted == b.dotted
    if isinstance(a, (bool, int, float, str, type(None))):
        return type(a) is type(b) and a == b
    return a is b and not isinstance(a, Unknown)


def possible(values: Iterable[Value]) -> tuple[Value, ...]:
    """The objects among values, and those that unknown ones may be; each once."""
    found: dict[int, Value] = {}
    for value in values:
        for one in value.data.among if isinstance(value.data, Unknown) else (value,):
            if isinstance(one.data, (Seq, Table, Obj)) and len(found) < MAX_ITEMS:
                found[id(one.data)] = one
    return tuple(found.values())


def perhaps(values: Sequence[Value], reason: str, span: Span | None = None) -> Value:
    """What may be any of several values, at the place of the first unless another is given."""
    return Value(Unknown(reason, among=possible(values)), span or values[0].span)


def either(values: Sequence[Value], reason: str) -> Value:
    """One of several values, of which nobody knows which: known where they are equal."""
    first, *others = values
    return first if all(same(first, one) for one in others) else perhaps(values, reason)


def truth(value: Value) -> bool | None:
    """Python's truth of a value; None when it is not known."""
    data = value.data
    if isinstance(data, (Unknown, External)):
        return None
    if isinstance(data, Seq):
        return bool(data.items)
    if isinstance(data, Table):
        return True if data.items else (None if data.open else False)
    if isinstance(data, (Obj, Cls, Func, Bound, Module)):
        return True
    return bool(data)


def elsewhere(reason: str) -> str:
    """The name that has to be read in another file, where that is why something is not known; else ""."""
    before, blamed, _ = reason.partition(_FROM)
    return before.removesuffix(", which").rpartition(" ")[2] if blamed else ""


def reason_of(data: Data) -> str | None:
    """Why data are not known; None for what is."""
    return data.reason if isinstance(data, (Unknown, External)) else None
