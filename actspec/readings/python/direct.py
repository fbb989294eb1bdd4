"""What a direct task's code makes of an action, where that can be read for sure.

Source: Isaac Lab 2.3.2, isaaclab/envs/direct_rl_env.py, `step`: `_pre_physics_step(action)`, then `_apply_action()` in
each physics step. `action_scale` is a name of the task's author, by which Isaac Lab's own tasks scale a position
(anymal_c), a change of one (franka_cabinet) and a torque (cartpole, ant, humanoid).
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from functools import lru_cache

_SCALE = "self.cfg.action_scale"
_ZERO = re.compile(r"self\.\w+\.data\.default_joint_pos")

_CLAMPS = frozenset({"clamp", "clip"})

_SAME = _CLAMPS | {"clone", "detach", "to"}
"""Methods of a tensor that leave its numbers, or those between two ends."""


@lru_cache(maxsize=1)  # A file has many tasks.
def scales_positions(tree: ast.Module) -> bool:
    """Whether every environment of a file commands `default_joint_pos + action_scale x action`, of all joints.

    False where that is not seen at once: with branches, helpers and base classes, or without an environment.
    """
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    methods = [{one.name: one for one in cls.body if isinstance(one, ast.FunctionDef)} for cls in classes]
    acting = [one for one in methods if not {"_pre_physics_step", "_apply_action"}.isdisjoint(one)]
    try:
        return bool(acting) and all(map(_scales_positions, acting))
    except RecursionError:
        return False


def _scales_positions(methods: Mapping[str, ast.FunctionDef]) -> bool:
    before, apply = methods.get("_pre_physics_step"), methods.get("_apply_action")
    if before is None or apply is None or len(before.args.args) != 2:
        return False
    known: dict[str, str] = {before.args.args[1].arg: "action"}
    commands = []
    for statement in (*before.body, *apply.body):
        match statement:
            case ast.Expr(value=ast.Constant()):
                pass
            case ast.Assign(targets=[ast.Name() | ast.Attribute() as target], value=value):
                known[ast.unparse(target)] = _meaning(value, known)
            case ast.Expr(
                value=ast.Call(
                    func=ast.Attribute(attr="set_joint_position_target"), args=[value], keywords=[]
                )
            ):
                commands.append(_meaning(value, known))
            case _:
                return False
    return commands == ["command"]


def _meaning(node: ast.expr, known: Mapping[str, str]) -> str:
    """What an expression is of the law: `action`, `scale`, their `product`, `zero` or the `command`; "" for others."""
    match node:
        case ast.Name() | ast.Attribute():
            text = ast.unparse(node)
            silent = "scale" if text == _SCALE else "zero" if _ZERO.fullmatch(text) else ""
            return known.get(text, silent)
        case ast.Call(func=ast.Attribute(value=ast.Name(id="torch"), attr=name), args=[one, *_]) if (
            name in _CLAMPS
        ):
            return _meaning(one, known)
        case ast.Call(func=ast.Attribute(value=one, attr=name)) if name in _SAME:
            return _meaning(one, known)
        case ast.BinOp(left=left, op=op, right=right):
            parts = {_meaning(left, known), _meaning(right, known)}
            if isinstance(op, ast.Mult) and parts == {"action", "scale"}:
                return "product"
            return "command" if isinstance(op, ast.Add) and parts == {"product", "zero"} else ""
    return ""
