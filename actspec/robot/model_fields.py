"""Compiled models, field by field."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import mujoco

NOT_COMPARED = frozenset({"signature", "paths", "npaths", "nbuffer", "narena"})
"""Not physics: buffer sizes, file paths (assets are re-pointed) and the spec's own signature."""

DERIVED = frozenset(
    {
        "actuator_acc0",
        "actuator_length0",
        "actuator_lengthrange",
        "body_invweight0",
        "dof_M0",
        "dof_invweight0",
        "tendon_invweight0",
        "flexedge_invweight0",
        "stat.meaninertia",
        "stat.meanmass",
        "stat.meansize",
        "stat.extent",
        "stat.center",
        "tree_sleep_policy",
    }
)
"""What MuJoCo computes from masses, armature and whether a tree has actuators."""


def differences(first: mujoco.MjModel, second: mujoco.MjModel) -> list[str]:
    """Fields in which two models differ, with the first differing entry; empty: none do."""
    found = []
    theirs = dict(model_fields(second))
    for name, value in model_fields(first):
        other = theirs.pop(name, None)
        text = unequal(value, other)
        if text is not None:
            found.append(f"{name}: {text}")
    found += [f"{name}: only in one" for name in theirs]
    return found


def model_fields(model: Any) -> Iterator[tuple[str, Any]]:
    """Every number and array of a model, its options and statistics included."""
    import numpy as np

    for prefix, owner in (("", model), ("opt.", model.opt), ("stat.", model.stat)):
        for name in dir(owner):
            if name.startswith("_") or name in NOT_COMPARED or name.endswith("pathadr"):
                continue
            value = getattr(owner, name)
            if isinstance(value, (int, float, bytes, np.ndarray, np.generic)):
                yield prefix + name, value


def unequal(first: Any, second: Any) -> str | None:
    """What differs between two values of a field, or None."""
    import numpy as np

    if second is None:
        return "only in one"
    if isinstance(first, bytes) or isinstance(second, bytes):
        return None if first == second else "differs"
    a, b = np.asarray(first), np.asarray(second)
    if a.shape != b.shape:
        return f"shape {a.shape} against {b.shape}"
    bad = a != b
    if a.dtype.kind == "f":
        bad &= ~(np.isnan(a) & np.isnan(b))
    if not bad.any():
        return None
    where = tuple(int(i) for i in np.argwhere(bad)[0]) if a.ndim else ()
    return f"{a[where].item()!r} against {b[where].item()!r} at {list(where)}"
