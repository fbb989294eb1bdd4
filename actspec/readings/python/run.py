"""Takes the statements of a Python file in order: what names hold at its end, without executing anything.

A loop is taken once, and what it assigns is unknown afterwards. Where a test is not known, both branches are
taken, and what they leave different is unknown.
"""

from __future__ import annotations

import ast
from collections.abc import Sequence

from actspec.diagnostics import Span
from actspec.readings.python import calls
from actspec.readings.python.arithmetic import binary
from actspec.readings.python.objects import Objects
from actspec.readings.python.source import Source
from actspec.readings.python.values import (
    MAX_DEPTH,
    Cls,
    External,
    Lazy,
    Module,
    Obj,
    PathText,
    Scope,
    Table,
    Unknown,
    Value,
    either,
    perhaps,
    possible,
    reason_of,
    truth,
)

LOOP = "built in a loop"
"""Reason of what a loop assigns."""


class Interpreter(Objects):
    """Folds the files of one reading."""

    def load(self, source: Source) -> Value:
        if source.path not in self.modules:
            scope = Scope("module", source)
            span = Span(source.path, 1)
            if self.depth >= MAX_DEPTH - 10:
                return Value(Unknown("imported too deep in other imports"), span)
            scope.names["__name__"] = Value(".".join(source.package) or "module", span)
            scope.names["__file__"] = Value(PathText(source.path), span)
            self.modules[source.path] = Value(Module(scope), span)
            # What imports it is half way through a statement, whose reason is none of this file's.
            doubt, self.doubt = self.doubt, None
            depth, self.depth = self.depth, self.depth + 10
            try:
                self.run(source.tree.body, scope)
            finally:
                self.doubt, self.depth = doubt, depth
        return self.modules[source.path]

    def run(self, body: Sequence[ast.stmt], scope: Scope) -> bool:
        """Take statements; True when the function has returned or the branch ends for certain."""
        if self.depth >= MAX_DEPTH:
            return True
        self.depth += 1
        try:
            return any(self._statement(statement, scope) for statement in body)
        finally:
            self.depth -= 1

    def _statement(self, node: ast.stmt, scope: Scope) -> bool:
        if not self.budget.spend():
            return True
        if isinstance(node, ast.Return):
            value = self.eval(node.value, scope) if node.value else Value(None, scope.source.span(node))
            scope.returned = value
            return True
        if isinstance(node, (ast.Raise, ast.Break, ast.Continue)):
            return True
        if isinstance(node, ast.If):
            return self._if_statement(node, scope)
        if isinstance(node, ast.Match):
            cases = [case.body for case in node.cases]
            return self._branches([*cases, []], scope, "depends on a match, which is not folded")
        if isinstance(node, (ast.For, ast.AsyncFor, ast.While)):
            self._loop(node, scope)
        elif isinstance(node, (ast.With, ast.AsyncWith)):
            return self.run(node.body, scope)
        elif isinstance(node, ast.Try) or type(node).__name__ == "TryStar":
            return self._try(node, scope)  # type: ignore[arg-type]
        else:
            self._simple(node, scope)
        return False

    def _simple(self, node: ast.stmt, scope: Scope) -> None:
        if isinstance(node, ast.Assign):
            value = self.eval(node.value, scope)
            self.unapplied.statement = node
            for target in node.targets:
                self.bind(target, value, scope)
        elif isinstance(node, ast.AnnAssign):
            if isinstance(node.target, ast.Name) and scope.kind == "class" and scope.cls is not None:
                scope.cls.annotated.append(node.target.id)
            if node.value is not None:
                value = self.eval(node.value, scope)
                self.unapplied.statement = node
                self.bind(node.target, value, scope)
        elif isinstance(node, ast.AugAssign):
            left, right = self.eval(node.target, scope), self.eval(node.value, scope)
            self.unapplied.statement = node
            self.bind(
                node.target,
                Value(binary(node.op, left.data, right.data), scope.source.span(node.value)),
                scope,
            )
        elif isinstance(node, ast.Expr):
            self.eval(node.value, scope)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            self._import(node, scope)
        elif isinstance(node, ast.FunctionDef):
            self._function(node, scope)
        elif isinstance(node, ast.AsyncFunctionDef):
            scope.names[node.name] = Value(Unknown("a coroutine"), scope.source.span(node))
        elif isinstance(node, ast.ClassDef):
            scope.names[node.name] = Value(self._class(node, scope), scope.source.span(node))
        elif isinstance(node, ast.Global):
            scope.globals.update(node.names)
        elif isinstance(node, ast.Delete):
            for target in node.targets:
                self._delete(target, scope)

    # Definitions.

    def _import(self, node: ast.Import | ast.ImportFrom, scope: Scope) -> None:
        span = scope.source.span(node)
        if isinstance(node, ast.Import):
            for alias in node.names:
                # `import a.b` binds `a`, through which `b` is reached.
                name = alias.name if alias.asname else alias.name.partition(".")[0]
                scope.names[alias.asname or name] = Lazy(0, name, "", span)
            return
        for alias in node.names:
            if alias.name == "*":
                scope.module.stars.append(Lazy(node.level, node.module or "", "", span))
            else:
                scope.names[alias.asname or alias.name] = Lazy(
                    node.level, node.module or "", alias.name, span
                )

    def _decorators(self, nodes: Sequence[ast.expr]) -> tuple[str, ...]:
        names = []
        for node in nodes:
            inner = node.func if isinstance(node, ast.Call) else node
            named = inner.attr if isinstance(inner, ast.Attribute) else getattr(inner, "id", "?")
            names.append(named)
        return tuple(names)

    def _function(self, node: ast.FunctionDef, scope: Scope) -> None:
        function = self.function(node, scope, self._decorators(node.decorator_list))
        function.owner = scope.cls if scope.kind == "class" else None
        span = scope.source.span(node)
        scope.names[node.name] = Value(function, span)

    def _class(self, node: ast.ClassDef, scope: Scope) -> Cls:
        bases: list[Cls | External | Unknown] = []
        for base in node.bases:
            data = self.eval(base, scope).data
            if isinstance(data, (Cls, External)):
                bases.append(data)
            else:
                bases.append(data if isinstance(data, Unknown) else Unknown("a base that is no class"))
        inner = Scope("class", scope.source, scope)
        decorators = self._decorators(node.decorator_list)
        span = scope.source.span(node)
        inner.cls = Cls(node.name, bases, inner, [], "configclass" in decorators, span)
        self.run(node.body, inner)
        return inner.cls

    # Branches and loops.

    def _if_statement(self, node: ast.If, scope: Scope) -> bool:
        test = self.eval(node.test, scope)
        known = truth(test)
        if isinstance(test.data, External) and test.data.name == "TYPE_CHECKING":
            known = False
        if known is not None:
            return self.run(node.body if known else node.orelse, scope)
        reason = f"depends on a condition: {reason_of(test.data) or 'unknown'}"
        # A branch that raises is not the one that the author means to take.
        for branch, other in ((node.body, node.orelse), (node.orelse, node.body)):
            if branch and isinstance(branch[-1], ast.Raise):
                return self.run(other, scope)
        return self._branches([node.body, node.orelse], scope, reason)

    def _branches(self, bodies: Sequence[Sequence[ast.stmt]], scope: Scope, reason: str) -> bool:
        """Take one of several bodies, nobody knows which: names that they leave different are unknown."""
        before = dict(scope.names)
        self.budget.spend(len(before) * len(bodies) // 16)
        left: list[dict[str, Value | Lazy]] = []
        returned: list[Value] = []
        ended = 0
        doubt, self.doubt = self.doubt, self.doubt or reason
        try:
            for body in bodies:
                scope.names = dict(before)
                done, value = self._take(body, scope)
                ended += done
                left.append(scope.names)
                returned.extend([value] if value is not None else [])
        finally:
            self.doubt = doubt
        scope.names = before
        changed = {
            name: None for names in left for name, value in names.items() if before.get(name) is not value
        }
        for name in changed:
            values = [names.get(name) for names in left]
            known = [self.resolved(value, scope) for value in values if value is not None]
            merged = either(known, reason)
            if len(known) < len(values):
                merged = perhaps(known, reason, merged.span)
            scope.names[name] = merged
        if ended == len(bodies):
            scope.returned = either(returned, reason) if returned else None
            return True
        scope.maybe.extend(perhaps((value,), reason) for value in returned)
        return False

    def _take(self, body: Sequence[ast.stmt], scope: Scope) -> tuple[bool, Value | None]:
        """Take statements that may not happen: whether they end what they stand in, and what they return."""
        done = self.run(body, scope)
        returned, scope.returned = scope.returned, None
        return done, returned

    def _loop(self, node: ast.For | ast.AsyncFor | ast.While, scope: Scope) -> None:
        before = dict(scope.names)
        self.budget.spend(len(before) // 16)
        doubt, self.doubt = self.doubt, self.doubt or LOOP
        try:
            if not isinstance(node, ast.While):
                over = self.eval(node.iter, scope)
                found = calls.elements(over.data, self.budget)
                one = Unknown(LOOP, among=possible(found) if isinstance(found, list) else found.among)
                self.bind(node.target, Value(one, scope.source.span(node)), scope, nested=True)
            _, returned = self._take(node.body, scope)
        finally:
            self.doubt = doubt
        if returned is not None:
            scope.maybe.append(perhaps((returned,), LOOP))
        for name, value in scope.names.items():
            if before.get(name) is not value:
                values = [value, *([before[name]] if name in before else [])]
                scope.names[name] = perhaps([self.resolved(one, scope) for one in values], LOOP)
        self.run(node.orelse, scope)

    def _try(self, node: ast.Try, scope: Scope) -> bool:
        ended = self.run(node.body, scope) or self.run(node.orelse, scope)
        bodies = [handler.body for handler in node.handlers if not _import_error(handler)]
        bodies = [body for body in bodies if not (body and isinstance(body[-1], ast.Raise))]
        if bodies and not ended:
            self._branches([[], *bodies], scope, "depends on an exception")
        return self.run(node.finalbody, scope) or ended

    # Assignment.

    def bind(self, target: ast.expr, value: Value, scope: Scope, nested: bool = False) -> None:
        if isinstance(target, ast.Name):
            where = scope.module if target.id in scope.globals else scope
            where.names[target.id] = value if where is scope else self.doubted(value)
        elif isinstance(target, (ast.Tuple, ast.List)):
            self._unpack(target.elts, value, scope, nested)
        elif isinstance(target, ast.Attribute):
            owner = self.place(target.value, scope)
            self.unapplied.add(owner, target, value, scope.source.span(target))
            self.store_attribute(owner, target.attr, value, scope.source.span(target))
        elif isinstance(target, ast.Subscript):
            owner = self.place(target.value, scope)
            sliced = isinstance(target.slice, ast.Slice)
            index = Unknown("a slice") if sliced else self.eval(target.slice, scope).data
            self.unapplied.add(owner, target, value, scope.source.span(target))
            self.store_item(owner, index, value, scope.source.span(target))
        elif isinstance(target, ast.Starred):
            self.bind(target.value, Value(Unknown("a starred target"), value.span), scope)

    def _unpack(self, targets: Sequence[ast.expr], value: Value, scope: Scope, nested: bool) -> None:
        found = calls.elements(value.data, self.budget)
        if isinstance(found, list) and len(found) == len(targets) and not _starred(targets):
            for target, one in zip(targets, found, strict=True):
                self.bind(target, one, scope)
            return
        among: tuple[Value, ...] = ()
        if isinstance(value.data, Unknown):
            # Of a loop over pairs, each target may be anything in any pair.
            inner = [calls.elements(one.data, self.budget) for one in value.data.among] if nested else []
            among = possible(
                [*value.data.among, *(one for items in inner if isinstance(items, list) for one in items)]
            )
        reason = reason_of(value.data) or "unpacked into another number of names"
        for target in targets:
            self.bind(target, Value(Unknown(reason, among=among), value.span), scope, nested)

    def place(self, node: ast.expr, scope: Scope) -> Value:
        """What is assigned into: a field that only the class's default gives is made on the way."""
        if not isinstance(node, ast.Attribute):
            return self.eval(node, scope)
        if self.depth >= MAX_DEPTH:
            return self.eval(node, scope)
        self.depth += 1
        try:
            owner = self.place(node.value, scope)
        finally:
            self.depth -= 1
        value = self.attribute(owner, node.attr)
        if isinstance(owner.data, Obj) and isinstance(value.data, Unknown) and not value.data.among:
            span = scope.source.span(node)
            made = Obj(External(f"?.{node.attr}"), {}, [], span, open=value.data.reason)
            owner.data.fields[node.attr] = Value(made, span)
            return owner.data.fields[node.attr]
        return value

    def _delete(self, target: ast.expr, scope: Scope) -> None:
        if isinstance(target, ast.Name):
            scope.names.pop(target.id, None)
        elif isinstance(target, ast.Subscript) and not isinstance(target.slice, ast.Slice):
            owner = self.eval(target.value, scope).data
            key = calls.key_of(self.eval(target.slice, scope).data)
            if isinstance(owner, Table):
                owner.filled = None
            if isinstance(owner, Table) and not isinstance(key, Unknown):
                if self.doubt is None:
                    owner.items.pop(key, None)
                elif key in owner.items:
                    owner.items[key] = Value(Unknown(self.doubt), owner.items[key].span)


def _import_error(handler: ast.ExceptHandler) -> bool:
    """Whether a handler is there for a package that may be missing; the import above it is what is meant."""
    names = [node.id for node in ast.walk(handler.type) if isinstance(node, ast.Name)] if handler.type else []
    return bool(names) and all(name in ("ImportError", "ModuleNotFoundError") for name in names)


def _starred(targets: Sequence[ast.expr]) -> bool:
    return any(isinstance(target, ast.Starred) for target in targets)
