"""Parsers, called on small texts as they are called by commands, without MuJoCo and without what comes after them.

The texts are those of the scene and of the audit's rule cases. A parser has to answer, or to refuse with an
`ActspecError`; anything else is a failure.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

import yaml

from actspec.diagnostics import ActspecError, Collector, Severity, SpecError
from tests.fuzz import trial
from tests.fuzz.mutation import mutated, parts
from tests.fuzz.scenes import ROOT

MOST = 2000
"""Characters of a text that is changed: most of the time is to go into parsers, not into length."""

REFUSED = 2
"""Code of an execution that ended in an `ActspecError`, as a command's would be."""


@dataclass(frozen=True, slots=True)
class Parser:
    """One parser.

    Attributes:
        format: How the parts of its texts are found: see `tests.fuzz.mutation`.
        file: The name under which it finds its bytes in the working folder; "": it takes the bytes.
        read: The parser, given the bytes.
        guest: Whether it is a library's, which actspec gives a process of its own: what ends that one is met there.
    """

    format: str
    file: str
    read: Callable[[bytes], object]
    guest: bool = False


def _spec(path: str) -> None:
    from actspec.spec.validate import load_spec
    from actspec.spec.variants import named

    for name in load_spec(path).model.variants:
        load_spec(named(path, name))


def _results(data: bytes) -> None:
    from actspec.spec.document import document_from_text
    from actspec.spec.results import validate_results

    validate_results(document_from_text(data, "results.yaml"))


def _manifest(data: bytes) -> None:
    from actspec.output import Origin, Output, is_ours

    is_ours(Output("x", ".", "plain_cfg.py", b"", b"", Origin("arm.yaml", "arm")))
    is_ours(Output("x", ".", "manifest.json", data, data, Origin("arm.yaml", "arm")))


def _robot(path: str) -> None:
    """A robot's file by its text alone, as after a refusal of MuJoCo."""
    from actspec.readings.read import read_robot

    read_robot(path, keep_matrices=False, refusal="it was not asked")


def _cfg(_: bytes) -> None:
    from actspec.readings.python.read import read_python

    read_python("x_cfg.py")


def _deploy(data: bytes) -> None:
    from actspec.readings.deploy import read_deploy

    read_deploy("x.yaml", data)


def _settings(_: bytes) -> None:
    from actspec.audit.rules import all_rules
    from actspec.audit.settings import load_settings

    load_settings(all_rules(), "actspec.toml")


def _lock(data: bytes) -> None:
    from actspec.audit.lock import read_lock

    read_lock("actspec.lock", data)


def _baseline(_: bytes) -> None:
    from actspec.audit.baseline import read_baseline

    read_baseline("base.json", {})


def _log(data: bytes) -> None:
    from actspec.logs.text import read_text

    read_text("log.csv", data)


def _sidecar(_: bytes) -> None:
    from actspec.logs.sidecar import load_sidecar

    load_sidecar("log.csv")


def _foreign(tool: str, **more: Any) -> Callable[[bytes], None]:
    def read(_: bytes) -> None:
        from actspec.sysid.foreign import foreign_text, read_foreign
        from actspec.sysid.foreign.figures import Options

        foreign_text(read_foreign(tool, "params.json", Options(("hip", "knee"), **more), Collector()), "leg")

    return read


def _usd(data: bytes) -> None:
    from actspec.robot.usda import layer_of

    layer_of(data, "x.usda")


PARSERS = {
    "parse-spec": Parser("yaml", "included/x.yaml", lambda _: _spec("included/x.yaml")),
    "parse-motors": Parser("yaml", "motors.yaml", lambda _: _spec("holder.yaml")),
    "parse-results": Parser("yaml", "", _results),
    "parse-manifest": Parser("json", "manifest.json", _manifest),
    "parse-mjcf": Parser("xml", "x.xml", lambda _: _robot("x.xml")),
    "parse-urdf": Parser("xml", "x.urdf", lambda _: _robot("x.urdf")),
    "parse-cfg": Parser("python", "x_cfg.py", _cfg),
    "parse-deploy": Parser("yaml", "", _deploy),
    "parse-toml": Parser("toml", "actspec.toml", _settings),
    "parse-lock": Parser("json", "", _lock),
    "parse-baseline": Parser("json", "base.json", _baseline),
    "parse-log": Parser("csv", "", _log),
    "parse-sidecar": Parser("yaml", "log.yaml", _sidecar),
    "parse-bam": Parser("json", "params.json", _foreign("bam")),
    "parse-line": Parser("yaml", "params.json", _foreign("line")),
    "parse-usd": Parser("usda", "", _usd, guest=True),
}

_HOLDER = """\
actspec: 1
include: [motors.yaml]
robot: {name: held, model: none, joints: [hip]}
actuators: {hip: {joints: [hip], motor: small, level: dc_motor, kp: 1, kd: 1, effort_limit: 1, armature: 0}}
targets: {deploy: {}}
"""
_BAM = (
    '{"kt": 1.5, "R": 3.0, "armature": 0.012, "friction_base": 0.1, "friction_viscous": 0.03, "model": "m1", \
"actuator": "mx64"}'
)
_BAM_2 = _BAM.replace('"m1"', '"m2", "friction_stribeck": 0.05, "dtheta_stribeck": 0.8, "alpha": 1.0')
_LINE = "hip: {k: {value: 0.2 N*m*s/rad, std: 0.01}, b: 0.1 N*m}\nknee: {k: 1 N*m*s/rad, b: 2 N*m}\n"
_USD = """\
#usda 1.0
(
    customLayerData = {
        string creator = "actspec 0.1.0"
    }
)

over "leg"
{
    over "hip" (
        prepend apiSchemas = ["NewtonJointAPI", "PhysicsDriveAPI:angular"]
    )
    {
        float drive:angular:physics:stiffness = 0.0  # the NewtonActuator is the drive
        float drive:angular:physics:maxForce = 33.5
        float newton:armature = 0.01  # kg*m^2, authored, menagerie_a1
    }

    def Scope "NewtonActuators"
    {
        def NewtonActuator "hip" (
            prepend apiSchemas = ["NewtonPDControlAPI", "NewtonDCMotorClampingAPI"]
        )
        {
            rel newton:targets = </leg/hip>
            float newton:kp = 25.0
            float[] newton:positions = [0.5, 1, -2e-3]
            asset newton:network = @nets/hip.onnx@
        }
    }
}
"""
_PYTHON = """\
from legged_gym.envs.base.legged_robot_config import LeggedRobotCfg
import math
class RoughCfg(LeggedRobotCfg):
    class control(LeggedRobotCfg.control):
        stiffness = {"hip": 20.0, **{name: 30.0 for name in ("knee", "ankle")}}
        damping = dict(hip=0.5, knee=math.sqrt(0.25))
        action_scale = 0.25
    class asset(LeggedRobotCfg.asset):
        file = "{LEGGED_GYM_ROOT_DIR}/resources/robots/x.urdf"
        names = [f"{side}_{part}" for side in ("left", "right") for part in ["hip", "knee"]]
def limits(scale, *, most=23.5):
    values = []
    for name in RoughCfg.asset.names:
        if "knee" in name:
            values.append(most * scale)
        else:
            continue
    return values
"""


def seeds(sound: Path) -> dict[str, tuple[str, ...]]:
    """The texts of each parser.

    Args:
        sound: A folder that `tests.fuzz.scenes.make` filled.
    """
    named = {
        "parse-spec": ("plain.yaml", "biped.yaml"),
        "parse-motors": ("motors.yaml",),
        "parse-results": ("results.yaml",),
        "parse-manifest": ("out/isaaclab/manifest.json", "out/deploy/manifest.json"),
        "parse-mjcf": ("biped.xml",),
        "parse-urdf": ("biped.urdf",),
        "parse-cfg": ("biped_cfg.py", "out/isaaclab/plain_cfg.py", "out/mjlab/plain_cfg.py"),
        "parse-deploy": ("biped_deploy.yaml", "out/deploy/plain_deploy.yaml"),
        "parse-toml": ("settings.toml",),
        "parse-lock": ("actspec.lock",),
        "parse-baseline": ("base.json",),
        "parse-log": ("log.csv",),
        "parse-sidecar": ("log.yaml",),
    }
    found = {kind: [(sound / path).read_text("utf-8") for path in paths] for kind, paths in named.items()}
    found |= {"parse-bam": [_BAM, _BAM_2], "parse-line": [_LINE], "parse-usd": [_USD]}
    found["parse-cfg"].append(_PYTHON)
    for case in sorted((ROOT / "tests" / "audit" / "rules" / "cases").glob("*.yaml")):
        for name, text in _files(
            yaml.load(case.read_text("utf-8"), getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        ):
            kind = _kind(name, text)
            if kind is not None and len(text) <= MOST and _sound(text, PARSERS[kind].format):
                found[kind].append(text)
    return {kind: tuple(dict.fromkeys(texts)) for kind, texts in found.items()}


def _files(cases: dict[str, Any]) -> list[tuple[str, str]]:
    """Names and texts of the files of a rule's cases."""
    shared = cases.get("shared", {})
    found = []
    for case in cases.values():
        for name, text in case.get("files", {}).items() if isinstance(case.get("files"), dict) else ():
            if isinstance(text, dict):
                text = _filled(shared[text["shared"]], text.get("with", {}))
            if isinstance(text, str):
                found.append((name, text))
    return found


def _filled(text: str, holes: dict[str, Any]) -> str:
    return re.sub(r"@(\w+)@", lambda hole: str(holes.get(hole[1], "")), text)


def _kind(name: str, text: str) -> str | None:
    from actspec.spec.yaml_text import is_spec

    if name.endswith(".py"):
        return "parse-cfg"
    if name.endswith((".xml", ".urdf")):
        return "parse-urdf" if "<robot" in text else "parse-mjcf"
    if name.endswith((".yaml", ".yml")):
        return "parse-spec" if is_spec(text.encode()) else "parse-deploy"
    return None


def _sound(text: str, form: str) -> bool:
    """Whether its parts can be found: some cases hold files that are wrong."""
    try:
        return text.isascii() and len(parts(text, form)) > 3
    except (SyntaxError, ValueError, IndexError, yaml.YAMLError):
        return False


def prepare(folder: Path) -> None:
    """Make the parsers' working folder, with what they need beside the changed file."""
    folder.mkdir()
    (folder / "holder.yaml").write_text(_HOLDER)
    (folder / "included").mkdir()
    for name in ("motors.yaml", "results.yaml"):
        shutil.copy(ROOT / "tests" / "fuzz" / "scene" / name, folder / "included" / name)
    (folder / "log.csv").write_text("time [s]\n0\n")


def changed(kind: str, seed: int, number: int, texts: tuple[str, ...]) -> bytes:
    """The bytes of an execution."""
    choice = Random(f"{seed}/{kind}/{number}")
    gently = choice.random() < 0.5
    return mutated(choice.choice(texts), choice.choice(texts), PARSERS[kind].format, choice, gently=gently)


def run(kind: str, data: bytes) -> tuple[int, tuple[str, ...]]:
    """Execute one parser in the working folder.

    Returns: 0, or `REFUSED`; and what counts as a failure.
    """
    parser = PARSERS[kind]
    if parser.file:
        # As a file is written: nothing of it is to be watched.
        handle = os.open(parser.file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        os.write(handle, data)
        os.close(handle)
    watching = trial.watch()
    watching.written.clear()
    watching.forbidden.clear()
    failures, code = [], 0
    watching.folder = "/nowhere"
    signal.setitimer(signal.ITIMER_PROF, trial.TIME)
    try:
        parser.read(data)
    except ActspecError as refusal:
        code = REFUSED
        failures += _told(refusal)
    except MemoryError as fault:
        code = REFUSED
        if not parser.guest:
            failures.append(f"MemoryError came out: {fault!s:.200}")
    except trial.TooLong:
        failures.append(f"more than {trial.TIME:g} s of processor time")
    except BaseException as fault:
        failures.append(f"{type(fault).__name__} came out: {fault!s:.200}")
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        watching.folder = None
    return code, (*failures, *watching.forbidden)


def _told(refusal: ActspecError) -> list[str]:
    """What is wrong with a refusal."""
    if isinstance(refusal, SpecError) and not refusal.diagnostics:
        return ["refused without a reason"]
    return [
        f"refused without a line: {item!s:.200}"
        for item in refusal.diagnostics
        if item.severity is Severity.ERROR and not (item.span and item.span.path and item.span.line)
        # Nothing, and UTF-16, have no lines.
        if "is empty" not in item.message and item.code != "LOG003"
    ]
