"""Names, modules and attributes of the files of one reading: where a value comes from."""

from __future__ import annotations

from actspec.diagnostics import Span
from actspec.readings.python import calls, texts
from actspec.readings.python.source import Library, Source
from actspec.readings.python.values import (
    Bound,
    Budget,
    Cls,
    External,
    Func,
    Lazy,
    Module,
    Obj,
    PathText,
    Scope,
    Seq,
    Table,
    Unknown,
    Value,
    ancestors,
    possible,
)

BUILTINS = frozenset(
    {
        "abs",
        "bool",
        "dict",
        "enumerate",
        "float",
        "frozenset",
        "getattr",
        "hasattr",
        "int",
        "isinstance",
        "len",
    }
    | {"list", "max", "min", "print", "range", "reversed", "round", "set", "setattr", "sorted", "str", "sum"}
    | {"super", "tuple", "type", "zip"}
)
"""Python's own names that a configuration may use without importing them."""

_METHODS = frozenset(
    {"append", "copy", "extend", "get", "items", "keys", "pop", "replace", "setdefault", "update", "values"}
)
"""Methods that are followed on what is only known to be one of several objects."""


class Names:
    """Looks names up.

    Attributes:
        library: The files.
        budget: Steps that are left.
        modules: Files whose statements were taken, by path.
    """

    def __init__(self, library: Library) -> None:
        self.library = library
        self.budget = Budget()
        self.modules: dict[str, Value] = {}
        self.depth = 0
        self.searching: set[tuple[str, str]] = set()

    def load(self, source: Source) -> Value:
        """A file's module, its statements taken in order."""
        raise NotImplementedError

    def call(self, function: Value, args: list[Value], named: dict[str, Value], span: Span) -> Value:
        """What a call gives."""
        raise NotImplementedError

    def lookup(self, name: str, scope: Scope, span: Span) -> Value:
        """The value of a name."""
        for one in scope.visible():
            if name in one.names:
                return self.resolved(one.names[name], one)
        if name in BUILTINS:
            return Value(External(f"builtins.{name}"), span)
        found = self._starred(name, scope.module)
        if found is not None:
            return found
        return Value(Unknown(f"{name} is not defined here"), span)

    def resolved(self, value: Value | Lazy, scope: Scope) -> Value:
        """A name's value; its import is followed when it is used for the first time."""
        if isinstance(value, Value):
            return value
        if value.value is None:
            # Set first, so that imports in a circle end.
            dotted = f"{'.' * value.level}{value.module}"
            value.value = Value(Unknown(f"{value.name or dotted} is imported in a circle"), value.span)
            value.value = self._imported(value, dotted, scope)
        return value.value

    def _imported(self, lazy: Lazy, dotted: str, scope: Scope) -> Value:
        source = scope.module.source
        if not lazy.name:
            found = self.library.find(source, lazy.level, lazy.module)
            return (
                self.load(found) if isinstance(found, Source) else Value(External(dotted, found), lazy.span)
            )
        found = self.library.find(source, lazy.level, lazy.module)
        if isinstance(found, Source):
            module = self.load(found)
            value = self._member(module, lazy.name)
            if value is not None:
                return value
        inner = self.library.find(source, lazy.level, f"{lazy.module}.{lazy.name}".strip("."))
        if isinstance(inner, Source):
            return self.load(inner)
        if isinstance(found, Source):
            return Value(Unknown(f"{lazy.name} is not defined in {found.path.rpartition('/')[2]}"), lazy.span)
        outside = f"{dotted}.{lazy.name}" if dotted.strip(".") else f"{dotted}{lazy.name}"
        return Value(calls.CONSTANTS.get(outside, External(outside, found)), lazy.span)

    def _member(self, module: Value, name: str) -> Value | None:
        if isinstance(module.data, Module):
            scope = module.data.scope
            if name in scope.names:
                return self.resolved(scope.names[name], scope)
            return self._starred(name, scope)
        return None

    def _submodule(self, source: Source, name: str) -> Value | None:
        """`package.module`, which an import elsewhere has bound."""
        if not source.path.endswith("__init__.py"):
            return None
        inner = self.library.find(source, 1, name)
        return self.load(inner) if isinstance(inner, Source) else None

    def _starred(self, name: str, scope: Scope) -> Value | None:
        """A name that only an `import *` can give: of a file that has it, else of a package that is not read."""
        asked = (scope.source.path, name)
        if asked in self.searching or not self.budget.spend(1 + len(scope.stars)):
            return None
        outside: Value | None = None
        self.searching.add(asked)
        try:
            for star in reversed(scope.stars):
                module = self.resolved(star, scope)
                found = self._member(module, name)
                if found is not None:
                    return found
                if isinstance(module.data, External) and outside is None:
                    dotted = f"{module.data.dotted}.{name}"
                    outside = Value(calls.CONSTANTS.get(dotted, External(dotted, module.data.why)), star.span)
        finally:
            self.searching.discard(asked)
        return outside

    def attribute(self, owner: Value, name: str) -> Value:
        """`owner.name`."""
        data = owner.data
        if isinstance(data, Obj):
            if name in data.fields:
                return data.fields[name]
            if name in ("copy", "replace") and not isinstance(self.member(data.cls, name), Func):
                return Value(Bound(owner, name), owner.span)
            found = self.member(data.cls, name)
            if isinstance(found, Func):
                method = Value(Bound(owner, found), owner.span)
                return self.call(method, [], {}, owner.span) if "property" in found.decorators else method
            return found if isinstance(found, Value) else Value(found, owner.span)
        if isinstance(data, Cls):
            found = self.member(data, name)
            if isinstance(found, Func):
                bound = Bound(owner, found) if "classmethod" in found.decorators else found
                return Value(bound, owner.span)
            return found if isinstance(found, Value) else Value(found, owner.span)
        if isinstance(data, Module):
            found_there = self._member(owner, name) or self._submodule(data.scope.source, name)
            return found_there or Value(Unknown(f"{name} is not defined there"), owner.span)
        if isinstance(data, External):
            dotted = f"{data.dotted}.{name}"
            return Value(calls.CONSTANTS.get(dotted, External(dotted, data.why)), owner.span)
        if isinstance(data, PathText):
            path = texts.path_attribute(data, name)
            if path is not None:
                return Value(path, owner.span)
        if isinstance(data, Unknown):
            among = possible(self.attribute(one, name) for one in data.among if isinstance(one.data, Obj))
            if data.text is not None and data.among == ():
                path = texts.path_attribute(data.text, name)
                if isinstance(path, str):
                    return Value(Unknown(data.reason, path), owner.span)
            if name in _METHODS:
                return Value(Bound(owner, name), owner.span)
            return Value(Unknown(data.reason, among=among), owner.span)
        if isinstance(data, (str, Seq, Table)):
            return Value(Bound(owner, name), owner.span)
        return Value(Unknown(f".{name} of it is not folded"), owner.span)

    def member(self, cls: Cls | External, name: str) -> Value | Func | External | Unknown:
        """What a class has under a name, or why that is not known."""
        classes = ancestors(cls) if isinstance(cls, Cls) else [cls]
        self.budget.spend(len(classes))
        outside: External | Unknown | None = None
        for one in classes:
            if isinstance(one, Cls):
                if name in one.scope.names:
                    found = self.resolved(one.scope.names[name], one.scope)
                    return found.data if isinstance(found.data, Func) else found
            elif outside is None:
                outside = one
        if isinstance(outside, External):
            inner = External(f"{outside.dotted}.{name}", outside.why)
            if inner.is_class:
                return inner
            return Unknown(f"{name} has the default of {outside.name}, which comes from {outside.root}")
        if outside is not None:
            return outside
        return Unknown(f"{cls.name} has no {name}")
