"""What is changed, and which commands then read it: a folder of sound files, and for each kind of file its runs."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of file.

    Attributes:
        format: How its parts are found: see `tests.fuzz.mutation`.
        paths: Files of the scene that are changed, one at a time.
        runs: Command lines, of which each execution takes one; `@` is the changed file.
    """

    format: str
    paths: tuple[str, ...]
    runs: tuple[str, ...]


_JSON = " --output-format json"
_AUDIT = (
    "",
    _JSON,
    " --output-format sarif",
    " --output-format junit",
    " --output-format github",
    " --ledger",
)


def _audits(files: str) -> tuple[str, ...]:
    return tuple(f"audit {files}{form}" for form in _AUDIT)


READ = {
    "spec": Kind(
        "yaml", ("plain.yaml", "biped.yaml", "robots/a1.yaml"), ("validate @", "validate @" + _JSON)
    ),
    "motors": Kind("yaml", ("motors.yaml",), ("validate plain.yaml", "validate plain.yaml" + _JSON)),
    "results": Kind("yaml", ("results.yaml",), ("validate plain.yaml", "validate plain.yaml" + _JSON)),
    "deploy": Kind("yaml", ("biped_deploy.yaml", "out/deploy/plain_deploy.yaml"), _audits("@")),
    "cfg": Kind(
        "python",
        (
            "biped_cfg.py",
            "out/isaaclab/plain_cfg.py",
            "out/mjlab/plain_cfg.py",
            "a1out/mjlab/unitree_a1_cfg.py",
        ),
        (*_audits("@"), "audit biped.urdf @", "audit biped_deploy.yaml @" + _JSON),
    ),
    "urdf": Kind("xml", ("biped.urdf",), (*_audits("@"), "audit @ biped_cfg.py")),
    "toml": Kind(
        "toml",
        ("settings.toml",),
        ("audit biped_deploy.yaml --config @", "audit biped_cfg.py biped.urdf" + _JSON + " --config @"),
    ),
    "baseline": Kind("json", ("base.json",), ("audit biped_cfg.py biped_deploy.yaml --baseline @",)),
}
"""What parsers read, without MuJoCo."""

WHOLE = {
    "compile": Kind(
        "yaml",
        ("plain.yaml", "plain.yaml", "motors.yaml", "results.yaml"),
        (
            "compile plain.yaml -o new",
            "compile plain.yaml#soft -o new" + _JSON,
            "compile plain.yaml -o out --diff",
            "compile plain.yaml -o new -t isaaclab==3.0 -t randomization",
            "show plain.yaml",
            "show plain.yaml hip" + _JSON,
            "diff plain.yaml plain.yaml#soft" + _JSON,
            "lock plain.yaml",
            "audit out --spec plain.yaml",
        ),
    ),
    "manifest": Kind(
        "json",
        ("out/isaaclab/manifest.json", "out/deploy/manifest.json"),
        ("compile plain.yaml -o out", "compile plain.yaml -o out --check" + _JSON, "audit out"),
    ),
    "import": Kind(
        "xml",
        ("biped.urdf",),
        ("import @ biped_cfg.py", "import @ -o new.yaml", "diff @ biped_cfg.py", "lock @"),
    ),
    "import-cfg": Kind(
        "python",
        ("biped_cfg.py", "out/isaaclab/plain_cfg.py", "out/mjlab/plain_cfg.py"),
        (
            "import @ --joints hip,knee",
            "import biped.urdf @ -o new.yaml",
            "diff @ biped_deploy.yaml" + _JSON,
            "lock @",
        ),
    ),
    "import-deploy": Kind(
        "yaml", ("biped_deploy.yaml",), ("import biped.urdf @", "diff @ biped.urdf", "lock @")
    ),
    "lock": Kind("json", ("actspec.lock",), ("lock --check", "lock --check" + _JSON, "lock")),
    "fix": Kind(
        "python",
        ("biped_cfg.py", "out/mjlab/plain_cfg.py"),
        ("audit @ --fix --unsafe-fixes", "audit @ --fix --diff"),
    ),
    "log": Kind("csv", ("log.csv",), ("diagnose plain.yaml @", "diagnose plain.yaml @" + _JSON)),
    "sidecar": Kind(
        "yaml", ("log.yaml",), ("diagnose plain.yaml log.csv", "diagnose plain.yaml log.csv" + _JSON)
    ),
}
"""Whole commands, without MuJoCo."""

MUJOCO = {
    "mjcf": Kind(
        "xml",
        ("biped.xml", "robots/a1/a1.xml", "a1out/mujoco/a1.xml"),
        (*_audits("@"), "import @", "lock @", "diff @ biped.urdf", "audit @ --fix --unsafe-fixes"),
    ),
    "model": Kind(
        "xml",
        ("robots/a1/a1.xml",),
        (
            "compile robots/a1.yaml -o new",
            "show robots/a1.yaml",
            "compile robots/a1.yaml -t mujoco -o new --canonical",
        ),
    ),
    "model-urdf": Kind("xml", ("biped.urdf",), ("compile biped.yaml -o new", "show biped.yaml" + _JSON)),
    "robot": Kind(
        "yaml",
        ("robots/a1.yaml", "biped.yaml"),
        ("compile @ -o new", "compile @ -o new" + _JSON, "show @", "audit robots/a1/a1.xml --spec @"),
    ),
    "usd": Kind(
        "usda",
        ("a1out/newton/unitree_a1_newton.usda",),
        (
            "verify robots/a1.yaml --built a1out -t newton --fields-only",
            "compile robots/a1.yaml -o a1out -t newton",
        ),
    ),
    "built": Kind(
        "xml",
        ("a1out/mujoco/a1.xml",),
        ("verify robots/a1.yaml --built a1out -t mujoco --fields-only" + _JSON,),
    ),
}
"""Whole commands that let MuJoCo, or USD, read a stranger's model."""

GROUPS = {"read": READ, "whole": WHOLE, "mujoco": MUJOCO}
KINDS = READ | WHOLE | MUJOCO


def make(folder: Path) -> None:
    """Put the sound files into an empty folder, which is the working one, and what commands make of them."""
    from actspec.cli.main import main

    shutil.copytree(ROOT / "tests" / "fuzz" / "scene", folder, dirs_exist_ok=True)
    shutil.copytree(ROOT / "docs" / "example", folder, dirs_exist_ok=True)
    shutil.copytree(ROOT / "robots" / "motors", folder / "robots" / "motors")
    shutil.copytree(ROOT / "robots" / "a1", folder / "robots" / "a1")
    shutil.copy(ROOT / "robots" / "a1.yaml", folder / "robots" / "a1.yaml")
    sound: Sequence[str] = (
        "import biped.urdf biped_cfg.py biped_deploy.yaml -o biped.yaml",
        "compile plain.yaml -o out",
        "compile plain.yaml -o rout -t randomization",
        "compile biped.yaml -o bout",
        "compile robots/a1.yaml -o a1out",
        "lock plain.yaml biped_cfg.py biped.urdf",
        "audit biped_cfg.py biped_deploy.yaml --write-baseline base.json",
    )
    for line in sound:
        if main(line.split()) > 1:
            raise RuntimeError(f"not sound any more: actspec {line}")
