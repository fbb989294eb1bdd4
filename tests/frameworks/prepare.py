"""The frameworks' environment as the tests need it: that of `actspec verify --setup`, and MJX for Playground.

frameworks = prepare()
said, arrays = frameworks.run_probe(Path("probe.py"), {"text": text}, {"q": q})
"""

from __future__ import annotations

import hashlib
from contextlib import suppress
from pathlib import Path

from actspec.verify.environments import (
    INSTALL_TIME,
    ISAACLAB,
    NEWTON,
    PYTHONS,
    EngineUnavailableError,
    Frameworks,
    ProbeAnswer,
    pip,
    prepare_frameworks,
    prepare_release,
    quiet,
    run,
    whole,
)

__all__ = ["EXTRA", "ISAACLAB", "NEWTON", "PYTHONS", "Frameworks", "ProbeAnswer", "prepare", "training"]

EXTRA = ("jax[cpu]==0.10.2", "mujoco-mjx==3.11.0")
"""MJX, for which the Playground function is written: 400 MB, most of it jaxlib."""


def prepare(folder: Path | None = None) -> Frameworks:
    """Make the environment unless it is there already; minutes, the first time.

    Args:
        folder: Where to keep it; default that of `actspec verify`.

    Raises: EngineUnavailableError: a package cannot be had for this Python and platform.
    """
    return prepare_frameworks(folder, EXTRA)


TRAINING = (
    "rsl-rl-lib==5.4.2",
    "tensordict==0.15.3",
    "pyvers==0.2.3",
    "cloudpickle==3.1.2",
    "GitPython==3.2.1",
    "gitdb==4.0.12",
    "smmap==5.0.3",
    "tensorboard==2.21.0",
    "grpcio==1.85.1",
    "markdown==3.11.3",
    "werkzeug==3.1.9",
    "requests==2.34.2",
    "tqdm==4.70.1",
    "pyyaml==6.0.3",
)
"""What mjlab's training imports beyond its simulation, without wandb, a service: 85 MB."""


def training(frameworks: Frameworks) -> Path:
    """The folder of `TRAINING`, for PYTHONPATH beside an environment; made unless it is there already.

    Raises: EngineUnavailableError: a package cannot be had for this Python and platform.
    """
    digest = hashlib.sha256("\n".join((*TRAINING, str(frameworks.folder))).encode("utf-8")).hexdigest()

    def make(made: Path) -> None:
        command = [*pip(frameworks.python()), "install", "--no-compile", "--no-deps"]
        run([*command, "--target", str(made), *TRAINING], "mjlab's training", INSTALL_TIME)
        (made / "wandb.py").write_text(
            "run = None  # in its place: nothing is sent anywhere\n", encoding="utf-8"
        )

    return whole(frameworks.folder.parent / f"training-{digest[:12]}", make, quiet)


RELEASES = {
    "mjlab": ("1.6.0", "1.0.0", "1.2.0", "1.3.0", "1.5.3"),
    "mujoco-mjx": ("3.17.0",),
}
"""Beside the environment; of mjlab the one whose robots are read, and one on each side of every change of its table."""


def everything() -> Path:
    """Fetch what tests ask for, so that none of them waits for it; the folder of the environment.

    Raises: EngineUnavailableError: a package of the environment cannot be had; tests say what else cannot.
    """
    from tests.agree.engines import VERSIONS

    for project, versions in {"mujoco": VERSIONS, **RELEASES}.items():
        for version in versions:
            with suppress(EngineUnavailableError):
                prepare_release(project, version)
    frameworks = prepare()
    training(frameworks)
    return frameworks.folder


if __name__ == "__main__":
    print(everything())
