"""Constant folding: the value of an expression of a Python file, computed from its syntax and never executed.

What cannot be folded is `Unknown` with the reason. Every step is counted, nesting and sizes are limited.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from typing import Any

from actspec.diagnostics import Span
from actspec.readings.python import arithmetic, calls
from actspec.readings.python.source import Library, Source
from actspec.readings.python.values import (
    MAX_DEPTH,
    MAX_TEXT,
    SPENT,
    Bound,
    Budget,
    Cls,
    Data,
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
    either,
    perhaps,
    possible,
    reason_of,
    truth,
)

BUILTINS = frozenset(
    {
        "abs", "bool", "dict", "enumerate", "float", "frozenset", "getattr", "hasattr", "int", "isinstance", "len",
        "list", "max", "min", "print", "range", "reversed", "round", "set", "setattr", "sorted", "str", "sum",
        "super", "tuple", "type", "zip",
    }
)  # fmt: skip
"""Python's own names that a configuration may use without importing them."""

_METHODS = frozenset(
    {"append", "copy", "extend", "get", "items", "keys", "pop", "replace", "setdefault", "update", "values"}
)
"""Methods that are followed on what is only known to be one of several objects."""


_STOCK = frozenset(
    {
        "ActuatorBaseCfg", "ActuatorNetLSTMCfg", "ActuatorNetMLPCfg", "DCMotorCfg", "DelayedPDActuatorCfg",
        "IdealPDActuatorCfg", "ImplicitActuatorCfg", "RemotizedPDActuatorCfg",
    }
)  # fmt: skip
"""Isaac Lab's own actuator cfgs, which are known here. Source: Isaac Lab 2.3.2, isaaclab/actuators/__init__.py."""


class Expressions:
    """Looks names up and folds expressions; what runs functions and classes is `Interpreter`.

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

    def call_super(
        self, node: ast.Call, args: list[Value], named: dict[str, Value], scope: Scope
    ) -> Value | None:
        """What `super().method(...)` gives; None when a call is none."""
        raise NotImplementedError

    def bind(self, target: ast.expr, value: Value, scope: Scope) -> None:
        """Assign to a target."""
        raise NotImplementedError

    # Names.

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
        if (other := self.library.defining(lazy.module, lazy.name)) is not None:
            module = self.load(other)
            return self._member(module, lazy.name) or module
        outside = f"{dotted}.{lazy.name}" if dotted.strip(".") else f"{dotted}{lazy.name}"
        return self._outside(outside, found, lazy.span)

    def _outside(self, dotted: str, why: str, span: Span) -> Value:
        """A name of a package that is not read, but for an actuator cfg that a fork of Isaac Lab has added."""
        module, _, name = dotted.rpartition(".")
        if "Cfg" in name and name not in _STOCK and isinstance(found := self.library.fork(module), Source):
            added = self._member(self.load(found), name)
            if added is not None and isinstance(added.data, Cls):
                return added
        return Value(calls.CONSTANTS.get(dotted, External(dotted, why)), span)

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
                    outside = self._outside(f"{module.data.dotted}.{name}", module.data.why, star.span)
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
            return self._outside(f"{data.dotted}.{name}", data.why, owner.span)
        if isinstance(data, PathText):
            path = calls.path_attribute(data, name)
            if path is not None:
                return Value(path, owner.span)
        if isinstance(data, Unknown):
            among = possible(self.attribute(one, name) for one in data.among if isinstance(one.data, Obj))
            if data.text is not None and data.among == ():
                path = calls.path_attribute(data.text, name)
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

    # Expressions.

    def eval(self, node: ast.expr, scope: Scope) -> Value:
        """The value of an expression."""
        span = scope.source.span(node)
        if not self.budget.spend():
            return Value(SPENT, span)
        if self.depth >= MAX_DEPTH:
            return Value(Unknown(f"nested deeper than {MAX_DEPTH}"), span)
        handler: Callable[[Any, Scope], Value | Data] | None = getattr(
            self, f"fold_{type(node).__name__}", None
        )
        if handler is None:
            return Value(Unknown(f"{calls.operator_name(node)} is not folded"), span)
        self.depth += 1
        try:
            found = handler(node, scope)
        finally:
            self.depth -= 1
        data = found.data if isinstance(found, Value) else found
        if isinstance(data, str):
            # Texts cost what they take: names may hold many.
            self.budget.spend(len(data) // 64)
        return found if isinstance(found, Value) else Value(data, span)

    # Expressions, by the name of their node.

    def fold_Constant(self, node: ast.Constant, scope: Scope) -> Data:
        if node.value is None or isinstance(node.value, (bool, int, float, str)):
            return arithmetic.bounded(node.value)
        return Unknown(f"a {type(node.value).__name__} is not folded")

    def fold_Name(self, node: ast.Name, scope: Scope) -> Value:
        return self.lookup(node.id, scope, scope.source.span(node))

    def fold_Attribute(self, node: ast.Attribute, scope: Scope) -> Value:
        return self.attribute(self.eval(node.value, scope), node.attr)

    def fold_Subscript(self, node: ast.Subscript, scope: Scope) -> Value | Data:
        owner = self.eval(node.value, scope)
        if not isinstance(node.slice, ast.Slice):
            index = self.eval(node.slice, scope).data
            if reason_of(index) is not None and isinstance(owner.data, (Seq, Table)):
                self.budget.spend(len(owner.data.items))
            return calls.look_up(owner, index)
        ends = [
            self.eval(end, scope).data if end else None
            for end in (node.slice.lower, node.slice.upper, node.slice.step)
        ]
        known = [end for end in ends if end is None or isinstance(end, int)]
        if len(known) == 3 and known[2] != 0:
            part = slice(*known)
            if isinstance(owner.data, str):
                return owner.data[part]
            if isinstance(owner.data, Seq) and self.budget.spend(len(owner.data.items)):
                return Seq(owner.data.items[part], owner.data.kind)
        return Unknown(reason_of(owner.data) or "a slice of it is not folded")

    def fold_BinOp(self, node: ast.BinOp, scope: Scope) -> Data:
        left, right = self.eval(node.left, scope).data, self.eval(node.right, scope).data
        made = arithmetic.binary(node.op, left, right)
        if isinstance(made, (Seq, Table)) and not self.budget.spend(len(made.items)):
            return SPENT
        return made

    def fold_UnaryOp(self, node: ast.UnaryOp, scope: Scope) -> Data:
        operand = self.eval(node.operand, scope)
        if isinstance(node.op, ast.Not):
            known = truth(operand)
            return Unknown(reason_of(operand.data) or "a test") if known is None else not known
        return arithmetic.unary(node.op, operand.data)

    def fold_BoolOp(self, node: ast.BoolOp, scope: Scope) -> Value:
        wanted = isinstance(node.op, ast.Or)
        value = self.eval(node.values[0], scope)
        for operand in node.values[1:]:
            known = truth(value)
            if known is None:
                # `unknown or x` may be either.
                other = self.eval(operand, scope)
                return perhaps((value, other), reason_of(value.data) or "a test")
            if known is wanted:
                return value
            value = self.eval(operand, scope)
        return value

    def fold_Compare(self, node: ast.Compare, scope: Scope) -> Data:
        left = self.eval(node.left, scope).data
        for op, comparator in zip(node.ops, node.comparators, strict=True):
            right = self.eval(comparator, scope).data
            self.budget.spend(len(right.items) if isinstance(right, Seq) else 0)
            result = arithmetic.compare(op, left, right)
            if result is not True:
                return result
            left = right
        return True

    def fold_IfExp(self, node: ast.IfExp, scope: Scope) -> Value | Data:
        test = self.eval(node.test, scope)
        known = truth(test)
        if known is not None:
            return self.eval(node.body if known else node.orelse, scope)
        return either(
            [self.eval(node.body, scope), self.eval(node.orelse, scope)],
            f"depends on a condition: {reason_of(test.data) or 'unknown'}",
        )

    def _items(self, nodes: Sequence[ast.expr], scope: Scope) -> list[Value] | Unknown:
        items: list[Value] = []
        for node in nodes:
            if isinstance(node, ast.Starred):
                inner = calls.elements(self.eval(node.value, scope).data, self.budget)
                if isinstance(inner, Unknown):
                    return inner
                items.extend(inner)
            else:
                items.append(self.eval(node, scope))
        return items

    def fold_Tuple(self, node: ast.Tuple | ast.List | ast.Set, scope: Scope) -> Data:
        items = self._items(node.elts, scope)
        kind = {ast.Tuple: "tuple", ast.List: "list"}.get(type(node), "set")
        return items if isinstance(items, Unknown) else arithmetic.bounded(Seq(items, kind))

    fold_List = fold_Set = fold_Tuple

    def fold_Dict(self, node: ast.Dict, scope: Scope) -> Data:
        table = Table({})
        for key, one in zip(node.keys, node.values, strict=True):
            value = self.eval(one, scope)
            if key is None:
                if isinstance(value.data, Table) and self.budget.spend(len(value.data.items)):
                    table.items.update(value.data.items)
                    table.open = table.open or value.data.open
                else:
                    table.open = reason_of(value.data) or "unpacks what is no dict"
                continue
            name = calls.key_of(self.eval(key, scope).data)
            if isinstance(name, Unknown):
                table.open = f"a key is not known: {name.reason}"
            else:
                table.items[name] = value
        return arithmetic.bounded(table)

    def fold_JoinedStr(self, node: ast.JoinedStr, scope: Scope) -> Data:
        text, reason, textual = "", None, True
        for part in node.values:
            data: Data
            if isinstance(part, ast.FormattedValue):
                spec = self.eval(part.format_spec, scope).data if part.format_spec else ""
                value = self.eval(part.value, scope).data
                plain = part.conversion in (-1, ord("s")) and isinstance(spec, str)
                data = (
                    arithmetic.formatted(value, spec)
                    if plain and isinstance(spec, str)
                    else Unknown("a format")
                )
            else:
                data = self.eval(part, scope).data
            known = arithmetic.text_of(data)
            textual = textual and known is not None
            text += known or ""
            reason = reason or reason_of(data)
            if len(text) > MAX_TEXT:
                return arithmetic.bounded(text)
        return text if reason is None else Unknown(reason, text if textual else None)

    def fold_Lambda(self, node: ast.Lambda, scope: Scope) -> Data:
        return self.function(node, scope, ())

    def function(self, node: ast.FunctionDef | ast.Lambda, scope: Scope, decorators: tuple[str, ...]) -> Func:
        """A function, its defaults folded where it is defined."""
        arguments = node.args
        ordered = [*arguments.posonlyargs, *arguments.args]
        given = zip(ordered[len(ordered) - len(arguments.defaults) :], arguments.defaults, strict=True)
        named = zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)
        defaults = {
            arg.arg: self.eval(default, scope) for arg, default in [*given, *named] if default is not None
        }
        name = node.name if isinstance(node, ast.FunctionDef) else "a lambda"
        return Func(name, node, scope, defaults, decorators)

    def fold_ListComp(
        self, node: ast.ListComp | ast.SetComp | ast.GeneratorExp | ast.DictComp, scope: Scope
    ) -> Data:
        table, items = Table({}), list[Value]()

        def take(inner: Scope) -> Unknown | None:
            if isinstance(node, ast.DictComp):
                key = calls.key_of(self.eval(node.key, inner).data)
                if isinstance(key, Unknown):
                    return key
                table.items[key] = self.eval(node.value, inner)
            else:
                items.append(self.eval(node.elt, inner))
            return None

        problem = self._generate(node.generators, Scope("comprehension", scope.source, scope), take)
        if problem is not None:
            return Unknown(f"built in a comprehension: {problem.reason}", among=problem.among)
        if isinstance(node, ast.DictComp):
            return arithmetic.bounded(table)
        kinds = {ast.ListComp: "list", ast.SetComp: "set"}
        return arithmetic.bounded(Seq(items, kinds.get(type(node), "tuple")))

    fold_SetComp = fold_GeneratorExp = fold_DictComp = fold_ListComp

    def _generate(
        self, loops: Sequence[ast.comprehension], scope: Scope, take: Callable[[Scope], Unknown | None]
    ) -> Unknown | None:
        if not loops:
            return take(scope)
        if len(loops) > 4:
            return Unknown("of more than four loops")
        first, *rest = loops
        found = calls.elements(self.eval(first.iter, scope).data, self.budget)
        if isinstance(found, Unknown):
            return found
        for one in found:
            if not self.budget.spend():
                return SPENT
            self.bind(first.target, one, scope)
            tests = [self.eval(test, scope) for test in first.ifs]
            unknown = next((test for test in tests if truth(test) is None), None)
            if unknown is not None:
                return Unknown(reason_of(unknown.data) or "a test")
            if all(truth(test) for test in tests):
                problem = self._generate(rest, scope, take)
                if problem is not None:
                    return problem
        return None

    def fold_NamedExpr(self, node: ast.NamedExpr, scope: Scope) -> Value:
        value = self.eval(node.value, scope)
        self.bind(node.target, value, scope)
        return value

    def fold_Call(self, node: ast.Call, scope: Scope) -> Value:
        span = scope.source.span(node)
        args = self._items(node.args, scope)
        if isinstance(args, Unknown):
            return Value(args, span)
        named: dict[str, Value] = {}
        unpacked: str | None = None
        for keyword in node.keywords:
            value = self.eval(keyword.value, scope)
            if keyword.arg is not None:
                named[keyword.arg] = value
            elif isinstance(value.data, Table) and self.budget.spend(len(value.data.items)):
                named.update({key: one for key, one in value.data.items.items() if isinstance(key, str)})
                unpacked = unpacked or value.data.open
            else:
                unpacked = reason_of(value.data) or "unpacks what is no dict"
        inherited = self.call_super(node, args, named, scope)
        if inherited is not None:
            return inherited
        made = self.call(self.eval(node.func, scope), args, named, span)
        if unpacked is not None and isinstance(made.data, Obj) and made.data.span == span:
            made.data.open = unpacked
        elif unpacked is not None:
            return Value(Unknown(unpacked), span)
        return made
