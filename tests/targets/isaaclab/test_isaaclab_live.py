"""`actspec.isaaclab` without Isaac Lab, and for which versions it compiles; tests/frameworks has the real package."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from actspec.diagnostics import EmitError
from actspec.isaaclab import actuators, module

pytestmark = pytest.mark.skipif(bool(find_spec("isaaclab")), reason="Isaac Lab is installed here")

SPEC = """actspec: 1
robot: {name: bot, model: none, joints: [a]}
timing: {physics_dt: 5 ms}
actuators:
  legs:
    joints: [a]
    level: ideal_pd
    kp: 20 N*m/rad
    kd: 0.5 N*m*s/rad
    effort_limit: 9 N*m
    armature: 0.01 kg*m^2
    friction: {coulomb: 0.2 N*m, viscous: 0.04 N*m*s/rad}
"""

# The names that the text imports, as records of what they are given.
CLASSES = """
class IdealPDActuatorCfg:
    def __init__(self, **fields):
        self.__dict__.update(fields)


class ImplicitActuatorCfg(IdealPDActuatorCfg):
    pass
"""


class Installed:
    """A folder of packages to compile for."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def package(self, below: str = "", text: str = CLASSES) -> None:
        """An `isaaclab` below a folder, put on the path."""
        made = self.folder / below / "isaaclab"
        made.mkdir(parents=True)
        (made / "__init__.py").write_text("", encoding="utf-8")
        (made / "actuators.py").write_text(text, encoding="utf-8")
        sys.path.insert(0, str(made.parent))

    def distribution(self, name: str, version: str) -> None:
        """The metadata of a distribution."""
        made = self.folder / f"{name}-{version}.dist-info"
        made.mkdir()
        (made / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n", encoding="utf-8"
        )

    def spec(self, targets: str = "") -> Path:
        """SPEC with targets."""
        made = self.folder / "bot.yaml"
        made.write_text(f"{SPEC}{targets}", encoding="utf-8")
        return made

    def fields(self, targets: str = "", **options: Any) -> dict[str, Any]:
        """Fields of the one cfg."""
        (cfg,) = actuators(self.spec(targets), **options).values()
        return {"class": type(cfg).__name__, **vars(cfg)}


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Installed]:
    """An empty folder on the path, and none of its modules left behind."""
    before = set(sys.modules)
    monkeypatch.syspath_prepend(tmp_path)
    yield Installed(tmp_path)
    for name in set(sys.modules) - before:
        if name.startswith(("isaaclab", "_actspec_")):
            del sys.modules[name]


def test_without_isaaclab(installed: Installed) -> None:
    """The error names the package that is missing and what to do without it."""
    with pytest.raises(
        ModuleNotFoundError, match=r"isaaclab is not installed here: .*--target isaaclab"
    ) as caught:
        actuators(installed.spec())
    assert caught.value.name == "isaaclab"


def test_without_its_simulator(installed: Installed) -> None:
    """An Isaac Lab whose simulator does not run says what it lacks and how to start it, and leaves no module."""
    installed.package(text="import a_simulator_that_runs\n")
    installed.distribution("isaaclab", "2.3.2.post1")
    with pytest.raises(
        ModuleNotFoundError, match=r"cannot be imported: .*a_simulator_that_runs.*; start .*AppLauncher"
    ):
        actuators(installed.spec())
    assert not [name for name in sys.modules if name.startswith("_actspec_")]


def test_without_a_version(installed: Installed) -> None:
    """A package that nothing tells the version of is an error, not a guess."""
    installed.package()
    with pytest.raises(ModuleNotFoundError, match="the version of Isaac Lab is unknown"):
        actuators(installed.spec())


EFFORT = {"friction": 0.2, "dynamic_friction": 0.2, "viscous_friction": 0.04}


@pytest.mark.parametrize(
    "isaaclab, isaacsim, targets, friction",
    [
        # Isaac Lab 2.3 runs on Isaac Sim 5.1 at its newest: friction is a torque.
        ("2.3.2.post1", None, "", EFFORT),
        # Below Isaac Sim 5 it is a factor on a load that nobody knows.
        ("2.3.2.post1", "4.5.0.0", "", {}),
        ("2.3.2.post1", None, 'targets: {isaaclab: {version: "2.3", isaac_sim: "4.5"}}\n', {}),
        # What runs decides, not what the spec is otherwise compiled for.
        ("2.3.2.post1", "5.1.0.0", 'targets: {isaaclab: {version: "2.3", isaac_sim: "4.5"}}\n', EFFORT),
        ("2.3.2.post1", "5.0.0.0", 'targets: {isaaclab: {version: "3.0", isaac_sim: "6.0"}}\n', EFFORT),
        # What is stated for another version says nothing of this one.
        (
            "2.3.2.post1",
            None,
            'targets: {isaaclab: {version: "3.0", isaac_sim: "6.0", backend: newton}}\n',
            EFFORT,
        ),
        ("2.3.2.post1", None, 'targets: {isaaclab: {version: "2.2", isaac_sim: "4.5"}}\n', EFFORT),
        # 2.2 on Isaac Sim 5 writes friction nowhere.
        ("2.2.0", None, "", {}),
        # One that is newer than all that 2.3 is known to run on counts as the newest.
        ("2.3.2.post1", "5.4.0.0", "", EFFORT),
    ],
    ids=[
        "default",
        "sim",
        "stated-sim",
        "sim-before-stated",
        "stated-for-other",
        "other",
        "older",
        "2.2",
        "newer-sim",
    ],
)
def test_compiled_for_what_is_installed(
    installed: Installed, isaaclab: str, isaacsim: str | None, targets: str, friction: dict[str, float]
) -> None:
    """The text is made for the installed versions of both distributions."""
    installed.package()
    installed.distribution("isaaclab", isaaclab)
    if isaacsim is not None:
        installed.distribution("isaacsim", isaacsim)
    found = installed.fields(targets)
    assert found["class"] == "IdealPDActuatorCfg"
    assert (found["stiffness"], found["effort_limit"]) == (20.0, 9.0)
    # Without a field of its own the viscous friction is in the damping: 0.5 + 0.04.
    assert found["damping"] == (0.5 if friction else 0.54)
    assert {name: found[name] for name in EFFORT if name in found} == friction


def test_a_checkout_tells_its_release(installed: Installed) -> None:
    """In a checkout the distribution has the version of the package alone, and the root's VERSION the release."""
    installed.package("IsaacLab/source/isaaclab")
    (installed.folder / "IsaacLab" / "VERSION").write_text("2.3.2\n", encoding="utf-8")
    installed.distribution("isaaclab", "0.54.2")
    assert installed.fields()["viscous_friction"] == 0.04


def test_an_unknown_release(installed: Installed) -> None:
    """A release that actspec has no row for is named; a newer one than all counts as the newest."""
    installed.package()
    installed.distribution("isaaclab", "1.4.1")
    with pytest.raises(
        EmitError, match=r"ISL001 targets.isaaclab.version: actspec does not know Isaac Lab '1.4'"
    ):
        actuators(installed.spec())


def test_newer_than_all(installed: Installed) -> None:
    """A release that is newer than every known one is compiled for as the newest."""
    installed.package()
    installed.distribution("isaaclab", "3.1.0")
    assert "for Isaac Lab 3.0." in module(installed.spec())["__doc__"]


def test_an_unknown_simulator(installed: Installed) -> None:
    """A simulator that the release does not run on is an error at the target that asks for the release."""
    installed.package()
    installed.distribution("isaaclab", "2.3.2.post1")
    installed.distribution("isaacsim", "4.2.0.0")
    with pytest.raises(EmitError) as caught:
        actuators(installed.spec('targets: {isaaclab: {isaac_sim: "5.1"}}\n'))
    (found,) = caught.value.diagnostics
    assert (found.code, str(found.span)) == ("ISL001", f"{installed.folder / 'bot.yaml'}:13:11")
    assert "'4.2'" in found.message


TWO = """targets:
  old: {target: isaaclab, version: "2.2", class: implicit}
  new: {target: isaaclab, version: "2.3.2"}
  mjlab: {}
"""


@pytest.mark.parametrize(
    "version, options, cls",
    [
        ("2.3.2", {}, "IdealPDActuatorCfg"),
        ("2.2.0", {}, "ImplicitActuatorCfg"),
        ("2.3.2", {"target": "old"}, "ImplicitActuatorCfg"),
    ],
    ids=["2.3", "2.2", "named"],
)
def test_which_target(installed: Installed, version: str, options: dict[str, str], cls: str) -> None:
    """Of several targets for Isaac Lab it is the one for the installed version, or the one that is named."""
    installed.package()
    installed.distribution("isaaclab", version)
    assert installed.fields(TWO, **options)["class"] == cls


@pytest.mark.parametrize(
    "options, message",
    [
        ({}, "several isaaclab targets, old, new: name one with `target`"),
        ({"target": "mjlab"}, "no isaaclab target 'mjlab', got old, new"),
        ({"target": "newer"}, "no isaaclab target 'newer', got old, new"),
    ],
    ids=["none-fits", "other-kind", "unknown"],
)
def test_no_such_target(installed: Installed, options: dict[str, str], message: str) -> None:
    """A target that cannot be told is asked for, with the names that there are."""
    installed.package()
    installed.distribution("isaaclab", "2.1.0")
    with pytest.raises(ValueError, match=message):
        installed.fields(TWO, **options)


def test_the_one_target_s_class(installed: Installed) -> None:
    """The class is the one target's, whatever it is called, and each call gives objects of its own."""
    installed.package()
    installed.distribution("isaaclab", "2.3.2.post1")
    spec = installed.spec('targets: {lab: {target: isaaclab, version: "2.2", class: implicit}}\n')
    first, second = actuators(spec), actuators(spec)
    assert type(first["legs"]).__name__ == "ImplicitActuatorCfg"
    assert first["legs"] is not second["legs"]
