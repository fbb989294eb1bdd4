"""Arrays of a compiled model as lists."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import mujoco


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

    def __getattr__(self, name: str) -> Any:
        """The array as a list, of lists where it has several columns."""
        found = getattr(self.model, name).tolist()
        setattr(self, name, found)
        return found

    def name(self, kind: str, index: int) -> str:
        """Name of an object; "" when it has none.

        Args:
            kind: `mjOBJ_JOINT`, say.
            index: Of the object.
        """
        import mujoco

        return mujoco.mj_id2name(self.model, getattr(mujoco.mjtObj, kind), index) or ""
