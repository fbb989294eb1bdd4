"""The frameworks' environment as the tests need it: that of `actspec verify --setup`, and MJX for Playground.

frameworks = prepare()
said, arrays = frameworks.run_probe(Path("probe.py"), {"text": text}, {"q": q})
"""

from __future__ import annotations

from pathlib import Path

from actspec.verify.environments import ISAACLAB, NEWTON, PYTHONS, Frameworks, ProbeAnswer, prepare_frameworks

__all__ = ["EXTRA", "ISAACLAB", "NEWTON", "PYTHONS", "Frameworks", "ProbeAnswer", "prepare"]

EXTRA = ("jax[cpu]==0.10.2", "mujoco-mjx==3.11.0")
"""MJX, for which the Playground function is written: 400 MB, most of it jaxlib."""


def prepare(folder: Path | None = None) -> Frameworks:
    """Make the environment unless it is there already; minutes, the first time.

    Args:
        folder: Where to keep it; default that of `actspec verify`.

    Raises: EngineUnavailableError: a package cannot be had for this Python and platform.
    """
    return prepare_frameworks(folder, EXTRA)


if __name__ == "__main__":
    print(prepare().folder)
