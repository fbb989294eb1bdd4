"""Arrays of a compiled model as lists."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import mujoco


_ADDRESSES = {
    "mjOBJ_ACTUATOR": "name_actuatoradr",
    "mjOBJ_BODY": "name_bodyadr",
    "mjOBJ_JOINT": "name_jntadr",
    "mjOBJ_KEY": "name_keyadr",
    "mjOBJ_SITE": "name_siteadr",
    "mjOBJ_TENDON": "name_tendonadr",
}
"""Kind of an object to the array that says where its names begin."""


class ModelLists:
    """A model's arrays by name, each turned into a list when it is first asked for.

    One element of an array costs as much as the whole list, and a reader looks at most of them.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        """Keep the model.

        Args:
            model: Compiled; not to be changed afterwards.
        """
        self.model = model
        self._names: dict[int, str] = {}
        start = 0
        for name in model.names.split(b"\0"):
            self._names[start] = name.decode()
            start += len(name) + 1

    def __getattr__(self, name: str) -> Any:
        """The array as a list, of lists where it has several columns."""
        found = getattr(self.model, name).tolist()
        setattr(self, name, found)
        return found

    def name(self, kind: str, index: int) -> str:
        """Name of an object; "" when it has none.

        Args:
            kind: One of `_ADDRESSES`.
            index: Of the object.
        """
        found: str = self._names[getattr(self, _ADDRESSES[kind])[index]]
        return found


def named_parents(model: ModelLists, names: Sequence[str]) -> list[str]:
    """For each joint the nearest named one before it on the way to the world; "" where there is none."""
    first, count = model.body_jntadr, model.body_jntnum
    found = [""] * len(names)
    # The nearest named joint at or above each body; a body comes after its parent.
    last = [""] * len(first)
    for body, parent in enumerate(model.body_parentid):
        above = last[parent]
        for joint in range(first[body], first[body] + count[body]):
            found[joint] = above
            above = names[joint] or above
        last[body] = above
    return found
