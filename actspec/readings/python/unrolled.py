"""A dict that loops of a module fill: `for a in ARTICULATION.actuators: SCALE[n] = 0.25 * e / s`, as mjlab has it.

The interpreter takes a loop once and leaves what it assigns unknown. Here a loop is taken for each element, where it
does nothing but fill the dict: assignments to names of its own, tests that are known, and expressions that change
nothing. Anything else is unknown. Values are those at the module's end: nothing may be changed after the loop.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import Span
from actspec.readings.python import calls
from actspec.readings.python.run import Interpreter
from actspec.readings.python.source import Source, definitions
from actspec.readings.python.values import Module, Scope, Seq, Table, Unknown, Value, truth

_CALLS = frozenset(
    {"values", "items", "keys", "get", "isinstance", "len", "float", "int", "abs", "min", "max", "sum"}
)
"""What may be called: it changes nothing."""

_KINDS: dict[str, type | tuple[type, ...]] = {
    "dict": Table,
    "list": Seq,
    "tuple": Seq,
    "str": str,
    "float": float,
    "int": int,
}

_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)

Statements = Sequence[ast.stmt]


class _NotPlainError(Exception):
    pass


SCALE = "_ACTION_SCALE"
"""Ending of the names of such dicts, beside a robot's name; by itself, and in other letters, a name too."""

_MOST = 200
"""Dicts of one file. Chosen: one a robot."""


class Unrolling(Interpreter):
    """Folds the files of one reading, and what loops of their modules fill."""

    def load(self, source: Source) -> Value:
        taken = source.path in self.modules
        module = super().load(source)
        if not taken and isinstance(module.data, Module):
            # Before what imports it changes anything.
            doubt, self.doubt = self.doubt, None
            try:
                for name, value in filled(self, module.data.scope).items():
                    held = module.data.scope.names.get(name)
                    if (
                        isinstance(held, Value)
                        and isinstance(held.data, Table)
                        and isinstance(value.data, Table)
                    ):
                        held.data.filled = value
            finally:
                self.doubt = doubt
        return module


def filled(interpreter: Interpreter, scope: Scope) -> dict[str, Value]:
    """The dicts of a module that its loops fill and whose names say what they are: tables, or why there is none."""
    body = scope.source.tree.body
    named = [one for one in definitions(body).items() if f"_{one[0]}".upper().endswith(SCALE)]
    return {
        name: unrolled(name, place.value, body, interpreter, scope)
        for name, place in named[:_MOST]
        if isinstance(place, (ast.Assign, ast.AnnAssign)) and place.value is not None and loops_of(name, body)
    }


def loops_of(name: str, body: Statements) -> list[ast.For]:
    """Loops at the top of a module that fill a dict."""
    return [
        node
        for node in body
        if isinstance(node, ast.For) and any(_fills(name, one) for one in ast.walk(node))
    ]


def unrolled(name: str, start: ast.expr, body: Statements, interpreter: Interpreter, scope: Scope) -> Value:
    """The dict that loops of a module fill; unknown where they do more than that, or where a value is not known.

    Args:
        name: Of the dict.
        start: What it is before.
        body: Statements of the module, loops of the dict among them.
        interpreter: Which has taken them.
        scope: Of the module.

    Returns: A table, at the place of the first store; or why there is none, at that of the first loop.
    """
    made = interpreter.eval(start, scope).data
    loops = loops_of(name, body)
    unread = Value(Unknown("it is computed in a loop, which is not run"), scope.source.span(loops[0]))
    if not isinstance(made, Table) or made.open is not None:
        return unread
    later = body[list(body).index(loops[0]) + 1 :]
    for one in _taken([one for one in later if one not in loops], interpreter, scope):
        if any(_changes(name, node) for node in _outside_definitions(one)):
            why = f"it is computed in a loop, and line {scope.source.span(one).line} may change it afterwards"
            return replace(unread, data=Unknown(why))
    taking = _Taking(name, Table(dict(made.items)), interpreter, Scope("function", scope.source, scope))
    try:
        for loop in loops:
            if not all(map(_is_harmless, ast.walk(loop))):
                return unread
            taking.statement(loop)
    except _NotPlainError:
        return unread
    return unread if taking.place is None else Value(taking.table, taking.place)


def _taken(body: Statements, interpreter: Interpreter, scope: Scope) -> Iterator[ast.stmt]:
    """Statements, and of `if __name__ == "__main__":`, which is of a program and not of a module, what is taken."""
    for one in body:
        if isinstance(one, ast.If) and _names_in(one.test) == {"__name__"}:
            known = truth(interpreter.eval(one.test, scope))
            if known is not None:
                yield from _taken(one.body if known else one.orelse, interpreter, scope)
                continue
        yield one


def _names_in(test: ast.expr) -> set[str]:
    return {node.id for node in ast.walk(test) if isinstance(node, ast.Name)}


def _fills(name: str, node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Subscript)
        and isinstance(node.ctx, ast.Store)
        and isinstance(node.value, ast.Name)
        and node.value.id == name
    )


def _outside_definitions(statement: ast.stmt) -> list[ast.AST]:
    return [] if isinstance(statement, _DEFINITIONS) else list(ast.walk(statement))


def _changes(name: str, node: ast.AST) -> bool:
    """Whether a statement after the loop may change what the loop read, or the dict: another dict of its kind aside."""
    if isinstance(node, ast.Expr):
        return isinstance(node.value, ast.Call)
    if isinstance(node, ast.Attribute):
        return isinstance(node.ctx, (ast.Store, ast.Del))
    if isinstance(node, ast.Name):
        return node.id == name and not isinstance(node.ctx, ast.Load)
    if not isinstance(node, ast.Subscript) or isinstance(node.ctx, ast.Load):
        return False
    return (
        not isinstance(node.value, ast.Name) or node.value.id == name or not node.value.id.endswith("_SCALE")
    )


def _is_harmless(node: ast.AST) -> bool:
    if isinstance(node, ast.Call):
        called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        return called in _CALLS
    return not isinstance(
        node, (ast.NamedExpr, ast.Lambda, ast.Await, ast.Yield, ast.YieldFrom, *_DEFINITIONS)
    )


class _Taking:
    """Statements of a loop, taken in order."""

    def __init__(self, name: str, table: Table, interpreter: Interpreter, scope: Scope) -> None:
        self.name = name
        self.table = table
        self.interpreter = interpreter
        self.scope = scope
        self.place: Span | None = None

    def statement(self, node: ast.stmt) -> bool:
        """Take one; True where the rest of the loop's body is passed over."""
        if not self.interpreter.budget.spend():
            raise _NotPlainError
        if isinstance(node, ast.Continue):
            return True
        if isinstance(node, ast.For) and not node.orelse:
            over = calls.elements(self.interpreter.eval(node.iter, self.scope).data, self.interpreter.budget)
            if not isinstance(over, list):
                raise _NotPlainError
            for one in over:
                self.interpreter.bind(_names(node.target), one, self.scope)
                self.block(node.body)
            return False
        if isinstance(node, ast.If):
            return self.block(node.body if self.test(node.test) else node.orelse)
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            self.assign(node.targets[0], self.interpreter.eval(node.value, self.scope), node)
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            self.assign(node.target, self.interpreter.eval(node.value, self.scope), node)
        elif not isinstance(node, (ast.Assert, ast.Pass)):
            raise _NotPlainError
        return False

    def block(self, body: Statements) -> bool:
        return any(self.statement(node) for node in body)

    def test(self, node: ast.expr) -> bool:
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return not self.test(node.operand)
        if isinstance(node, ast.BoolOp):
            tests = (self.test(one) for one in node.values)
            return all(tests) if isinstance(node.op, ast.And) else any(tests)
        if (
            isinstance(node, ast.Call)
            and getattr(node.func, "id", "") == "isinstance"
            and len(node.args) == 2
        ):
            kind = _KINDS.get(getattr(node.args[1], "id", ""))
            value = self.interpreter.eval(node.args[0], self.scope)
            if kind is None or truth(value) is None:
                raise _NotPlainError
            return isinstance(value.data, kind)
        known = truth(self.interpreter.eval(node, self.scope))
        if known is None:
            raise _NotPlainError
        return known

    def assign(self, target: ast.expr, value: Value, node: ast.stmt) -> None:
        if not _fills(self.name, target):
            self.interpreter.bind(_names(target), value, self.scope)
            return
        assert isinstance(target, ast.Subscript)
        key = calls.key_of(self.interpreter.eval(target.slice, self.scope).data)
        if not isinstance(key, str) or not isinstance(value.data, (int, float)):
            raise _NotPlainError
        span = self.scope.source.span(node)
        self.place = self.place or span
        self.table.items[key] = Value(value.data, span)


def _names(target: ast.expr) -> ast.expr:
    """A target that binds names of the loop's own alone."""
    parts = target.elts if isinstance(target, (ast.Tuple, ast.List)) else [target]
    if not all(isinstance(part, ast.Name) for part in parts):
        raise _NotPlainError
    return target
