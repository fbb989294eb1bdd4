"""Calls of functions and classes, and stores into objects; part of the interpreter.

Only functions of the files that are read are followed. While there is a doubt (a loop, a test that is not known)
every store leaves the doubt's reason instead of a value.
"""

from __future__ import annotations

import ast
from collections.abc import Sequence

from actspec.diagnostics import Span
from actspec.readings.python import calls
from actspec.readings.python.arithmetic import bounded
from actspec.readings.python.fold import Expressions
from actspec.readings.python.source import Library
from actspec.readings.python.unapplied import Unapplied
from actspec.readings.python.values import (
    Bound,
    Cls,
    Data,
    External,
    Func,
    Key,
    Obj,
    Scope,
    Seq,
    Table,
    Unknown,
    Value,
    ancestors,
    clone,
    is_configclass,
    perhaps,
    possible,
    reason_of,
    shallow,
)

_COPIES = {"copy.copy": shallow, "copy.deepcopy": clone}

_CHANGE_A_LIST = frozenset({"append", "extend", "insert", "remove", "clear", "pop", "sort", "reverse"})

_KEPT = frozenset({"property", "staticmethod", "classmethod", "cache", "lru_cache", "override"})
"""Decorators that leave a function what it is."""


class Objects(Expressions):
    """Calls and stores.

    Attributes:
        doubt: Why it is not certain that the present statement happens, or how often; None when it is.
        unapplied: Assignments to what is not read.
    """

    def __init__(self, library: Library) -> None:
        super().__init__(library)
        self.doubt: str | None = None
        self.unapplied = Unapplied()

    def run(self, body: Sequence[ast.stmt], scope: Scope) -> bool:
        """Take statements."""
        raise NotImplementedError

    # Calls.

    def call(self, function: Value, args: list[Value], named: dict[str, Value], span: Span) -> Value:
        data = function.data
        made: Value | Data
        if isinstance(data, External):
            made = self._call_external(data, args, named, span)
        elif isinstance(data, Cls):
            made = self._instance(data, args, named, span)
        elif isinstance(data, Func):
            made = self._call_function(data, args, named, span)
        elif isinstance(data, Bound) and isinstance(data.method, Func):
            static = "staticmethod" in data.method.decorators
            made = self._call_function(data.method, args if static else [data.owner, *args], named, span)
        elif isinstance(data, Bound) and isinstance(data.method, str):
            made = self._method(data.owner, data.method, args, named, span)
        else:
            made = Unknown(reason_of(data) or "calls what is no function")
        if isinstance(made, Value) and isinstance(made.data, (Obj, Seq, Table)):
            return made
        # A number that a function computes is written where it is called.
        return Value(made.data if isinstance(made, Value) else made, span)

    def _call_external(
        self, what: External, args: list[Value], named: dict[str, Value], span: Span
    ) -> Value | Data:
        if what.root == "builtins":
            if what.name in ("getattr", "hasattr", "setattr", "super", "isinstance", "print", "type"):
                return self._reflect(what.name, args, span)
            if what.dotted not in calls.NUMERIC:
                return calls.builtin(what.name, args, named, Value(None, span), self.budget)
        if what.dotted in _COPIES and len(args) == 1 and not named:
            return _COPIES[what.dotted](args[0], self.budget)
        if what.dotted == "dataclasses.replace" and len(args) == 1:
            return self._replaced(shallow(args[0], self.budget), named)
        function = calls.NUMERIC.get(calls.known(what.dotted))
        if function is not None:
            return calls.numeric(function, args, named)
        path = calls.path_call(what.dotted, args)
        if path is not None:
            return path
        if what.is_class or what.dotted == "dataclasses.field":
            obj = Obj(what, dict(named), list(args), span)
            return self._settled(Value(obj, span)) if is_configclass(what) else obj
        if what.name in ("copy", "replace"):
            # Of an object that another package has.
            self.unapplied.replaced(what, named, span)
            return Unknown(External(what.dotted.rpartition(".")[0], what.why).reason)
        if what.name == "from_file" and args:
            # mujoco.MjSpec.from_file: the path is what a robot's `spec_fn` tells.
            return Obj(what, {}, list(args), span)
        return Unknown(f"calls {what.name}(): {what.reason}", among=possible([*args, *named.values()]))

    def _reflect(self, name: str, args: list[Value], span: Span) -> Value | Data:
        attribute = args[1].data if len(args) > 1 else None
        if name == "print":
            return None
        if name not in ("getattr", "hasattr", "setattr") or not isinstance(attribute, str):
            return Unknown(f"calls {name}(), which is not folded")
        if name == "setattr" and len(args) == 3:
            self.store_attribute(args[0], attribute, args[2], span)
            return None
        found = self.attribute(args[0], attribute)
        if reason_of(found.data) is None:
            return found if name == "getattr" else True
        return Unknown(reason_of(found.data) or "", among=possible((found,)))

    def _instance(self, cls: Cls, args: list[Value], named: dict[str, Value], span: Span) -> Value:
        obj = Obj(cls, {}, [], span)
        value = Value(obj, span)
        order: list[str] = []
        classes = ancestors(cls)
        self.budget.spend(len(classes))
        for one in reversed(classes):
            if not isinstance(one, Cls):
                continue
            order.extend(name for name in one.annotated if name not in order)
            for name, default in one.scope.names.items():
                held = self.resolved(default, one.scope)
                if name.startswith("__") or isinstance(held.data, Func):
                    continue
                # A class in a class is a field only where it is annotated: `class_type: type = Motor`.
                if isinstance(held.data, Cls) and name not in one.annotated:
                    continue
                made = self._default(held)
                if made is None:
                    obj.fields.pop(name, None)
                else:
                    obj.fields[name] = made
        start = self.member(cls, "__init__")
        if isinstance(start, Func):
            self._call_function(start, [value, *args], named, span)
            return value
        for name, arg in zip(order, args, strict=False):
            obj.fields[name] = arg
        obj.args = args[len(order) :] if not order else []
        obj.fields.update(named)
        self._post_init(value)
        return self._settled(value) if is_configclass(cls) else value

    def _default(self, held: Value) -> Value | None:
        """A field's default for a new object; None when it has none."""
        if isinstance(held.data, External) and held.data.name == "MISSING":
            return None
        given = calls.field_default(held.data) if isinstance(held.data, Obj) else None
        if given is None:
            return clone(held, self.budget)
        kind, value = given
        return self.call(value, [], {}, held.span) if kind == "default_factory" else value

    def _post_init(self, value: Value) -> None:
        if isinstance(value.data, Obj) and isinstance(value.data.cls, Cls):
            after = self.member(value.data.cls, "__post_init__")
            if isinstance(after, Func):
                self._call_function(after, [value], {}, value.span)

    def _settled(self, value: Value) -> Value:
        """What `configclass` does last: the object shares nothing with what it was given."""
        if isinstance(value.data, Obj):
            value.data.fields = {name: clone(one, self.budget) for name, one in value.data.fields.items()}
        return value

    def _replaced(self, value: Value, named: dict[str, Value]) -> Value:
        """A copy with other fields; `__post_init__` runs again, as in Python."""
        if isinstance(value.data, Obj):
            value.data.fields.update(named)
            self._post_init(value)
        return value

    def call_super(
        self, node: ast.Call, args: list[Value], named: dict[str, Value], scope: Scope
    ) -> Value | None:
        function = node.func
        if not (
            isinstance(function, ast.Attribute)
            and isinstance(function.value, ast.Call)
            and isinstance(function.value.func, ast.Name)
            and function.value.func.id == "super"
            and scope.this is not None
            and isinstance(scope.this.data, Obj)
            and isinstance(scope.this.data.cls, Cls)
            and scope.cls is not None
        ):
            return None
        order = ancestors(scope.this.data.cls)
        span = scope.source.span(node)
        for one in order[order.index(scope.cls) + 1 :] if scope.cls in order else []:
            if isinstance(one, Cls) and function.attr in one.scope.names:
                found = self.resolved(one.scope.names[function.attr], one.scope).data
                if isinstance(found, Func):
                    return self._call_function(found, [scope.this, *args], named, span)
        return Value(None, span)

    def _call_function(self, function: Func, args: list[Value], named: dict[str, Value], span: Span) -> Value:
        scope = Scope("function", function.scope.source, function.scope, cls=function.owner)
        if function.owner is not None and args:
            scope.this = args[0]
        spec = function.node.args
        ordered = [arg.arg for arg in (*spec.posonlyargs, *spec.args)]
        names: dict[str, Value] = {**function.defaults, **dict(zip(ordered, args, strict=False))}
        extra: dict[Key, Value] = {
            name: value for name, value in named.items() if name not in (*ordered, *_keyword_only(spec))
        }
        names.update({name: value for name, value in named.items() if name not in extra})
        if spec.vararg:
            names[spec.vararg.arg] = Value(Seq(args[len(ordered) :], "tuple"), span)
        if spec.kwarg:
            names[spec.kwarg.arg] = Value(Table(extra), span)
        elif extra:
            return Value(Unknown(f"{function.name}() takes no {next(iter(extra))}"), span)
        for name in (*ordered, *_keyword_only(spec)):
            names.setdefault(name, Value(Unknown(f"{name} of {function.name}() is not given"), span))
        scope.names.update(names)
        self.budget.spend(len(names))
        if isinstance(function.node, ast.Lambda):
            return self.eval(function.node.body, scope)
        strange = next((name for name in function.decorators if name not in _KEPT), None)
        if strange is not None:
            return Value(Unknown(f"{function.name}() is decorated by {strange}"), span)
        if self._is_generator(function.node):
            return Value(Unknown(f"{function.name}() is a generator"), span)
        self.run(function.node.body, scope)
        result = scope.returned or Value(None, span)
        if scope.maybe:
            reason = reason_of(scope.maybe[0].data) or "a branch"
            return perhaps([result, *scope.maybe], reason, span)
        return result

    def _is_generator(self, node: ast.FunctionDef) -> bool:
        waiting: list[ast.AST] = list(node.body)
        while waiting and self.budget.spend():
            one = waiting.pop()
            if isinstance(one, (ast.Yield, ast.YieldFrom)):
                return True
            if not isinstance(one, (ast.FunctionDef, ast.Lambda, ast.ClassDef)):
                waiting.extend(ast.iter_child_nodes(one))
        return False

    # Methods of Python's own types.

    def _method(
        self, owner: Value, name: str, args: list[Value], named: dict[str, Value], span: Span
    ) -> Value | Data:
        data = owner.data
        if isinstance(data, Unknown):
            if name in ("append", "extend", "update", "pop", "setdefault"):
                for one in data.among:
                    self._spoil(one, data.reason)
            among = possible(data.among)
            if name in ("values", "items", "get", "pop", "setdefault"):
                among = possible([*among, calls.look_up(owner, Unknown(data.reason))])
            return Unknown(data.reason, among=among)
        if isinstance(data, Obj):
            if is_configclass(data.cls):
                return self._settled(self._replaced(clone(owner, self.budget), named))
            return self._replaced(shallow(owner, self.budget), named)
        if isinstance(data, str):
            return calls.text_method(data, name, args)
        if isinstance(data, Table) and name in ("update", "pop", "setdefault"):
            return self._change_table(owner, data, name, args, named)
        if isinstance(data, Table):
            return calls.table_method(owner, data, name, args, named, self.budget)
        if isinstance(data, Seq) and name in _CHANGE_A_LIST:
            found = calls.elements(args[0].data, self.budget) if name == "extend" and args else args
            if name not in ("append", "extend") or self.doubt is not None or isinstance(found, Unknown):
                self._spoil(owner, self.doubt or f"changed by .{name}()")
            else:
                data.items.extend(found)
            return None
        if isinstance(data, Seq) and name == "copy":
            return shallow(owner, self.budget)
        return Unknown(f"calls .{name}(), which is not folded")

    def _change_table(
        self, owner: Value, table: Table, name: str, args: list[Value], named: dict[str, Value]
    ) -> Value | Data:
        table.filled = None
        if self.doubt is not None:
            self._spoil(owner, self.doubt)
            return calls.look_up(owner, Unknown(self.doubt))
        if name == "update":
            given = args[0].data if args else Table({})
            if isinstance(given, Table) and self.budget.spend(len(given.items)):
                table.items.update(given.items)
                table.open = table.open or given.open
            else:
                table.open = reason_of(given) or "updated by what is no dict"
            table.items.update(named)
            return None
        key = calls.key_of(args[0].data) if args else Unknown("pop() without a key")
        if isinstance(key, Unknown):
            self._spoil(owner, key.reason)
            return key
        if name == "setdefault" and len(args) == 2 and table.open is None:
            return table.items.setdefault(key, args[1])
        found = calls.table_method(owner, table, "get", args, {}, self.budget)
        if name == "pop":
            table.items.pop(key, None)
        return found

    # Stores.

    def doubted(self, value: Value) -> Value:
        """What a store leaves: the value, or while there is a doubt perhaps that."""
        return value if self.doubt is None else perhaps((value,), self.doubt)

    def store_attribute(self, owner: Value, name: str, value: Value, span: Span) -> None:
        """`owner.name = value`."""
        data = owner.data
        if isinstance(data, Unknown):
            for one in data.among:
                if isinstance(one.data, Obj):
                    one.data.fields[name] = perhaps((value,), self.doubt or data.reason, span)
            return
        value = self.doubted(value)
        if isinstance(data, Obj):
            data.fields[name] = value
        elif isinstance(data, Cls):
            data.scope.names[name] = value

    def store_item(self, owner: Value, index: Data, value: Value, span: Span) -> None:
        """`owner[index] = value`."""
        data = owner.data
        if isinstance(data, Unknown):
            for one in data.among:
                self._spoil(one, self.doubt or data.reason)
            return
        key = calls.key_of(index)
        if isinstance(key, Unknown):
            self._spoil(owner, self.doubt or key.reason)
            return
        value = self.doubted(value)
        if isinstance(data, Table):
            data.items[key], data.filled = value, None
            if isinstance(bounded(data), Unknown):
                self._spoil(owner, "a dict of too many values")
        elif isinstance(data, Seq) and isinstance(key, int) and -len(data.items) <= key < len(data.items):
            data.items[key] = value

    def _spoil(self, owner: Value, reason: str) -> None:
        """After a change that cannot be followed: what is inside may be anything."""
        data = owner.data
        self.budget.spend(len(data.items) if isinstance(data, (Seq, Table)) else 0)
        if isinstance(data, Table):
            data.open, data.filled = reason, None
            inner = Unknown(reason, among=possible(data.items.values()))
            data.items = {key: Value(inner, value.span) for key, value in data.items.items()}
        elif isinstance(data, Seq):
            inner = Unknown(reason, among=possible(data.items))
            data.items = [Value(inner, value.span) for value in data.items] or [Value(inner, owner.span)]


def _keyword_only(spec: ast.arguments) -> tuple[str, ...]:
    return tuple(arg.arg for arg in spec.kwonlyargs)
