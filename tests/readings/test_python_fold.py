"""Constant folding of Python configurations: each form by a value worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from actspec.readings.artifact import RobotConfig, Setting
from actspec.readings.python.read import read_python

HEAD = "from isaaclab.actuators import DCMotorCfg\n"
TAIL = "\nROBOT = DCMotorCfg(joint_names_expr=['.*'], any_value={})\n"


def robot(folder: Path, text: str, name: str = "ROBOT") -> RobotConfig:
    """The configuration of that name in a file with this text."""
    path = folder / "cfg.py"
    path.write_text(text, encoding="utf-8")
    reading = read_python(str(path))
    assert reading.reason is None, reading.reason
    return next(one.config for one in reading.artifacts if one.config is not None and one.name == name)


def folded(folder: Path, before: str, expression: str) -> Setting:
    """What an expression folds to, after some statements."""
    return robot(folder, HEAD + before + TAIL.format(expression)).groups[0].settings["any_value"]


EXPRESSIONS = {
    # 2 - 3 * 4 / 8 = 0.5
    "arithmetic": ("2 - 3 * 4 / 8", 0.5),
    # 7 // 2 = 3, 7 % 4 = 3: 3 * 10 + 3
    "whole division": ("7 // 2 * 10 + 7 % 4", 33),
    # -2 ** 2 is -(2 ** 2)
    "power before sign": ("-2 ** 2", -4),
    "small power": ("2.0 ** -1", 0.5),
    "bits": ("1 << 3 | 1", 9),
    "texts": ("'FL' '_hip' + '_joint'", "FL_hip_joint"),
    "f-string": ("f'{1 + 1}_{\"a\"}_{0.25:.1f}'", "2_a_0.2"),
    "repeated list": ("[0.5] * 3", (0.5, 0.5, 0.5)),
    "joined tuples": ("(1, 2) + (3,)", (1, 2, 3)),
    "unpacked": ("[*[1, 2], 3]", (1, 2, 3)),
    "dict of patterns": ("{'.*_hip': 2 * 10.0, '.*_knee': 4e1}", {".*_hip": 20.0, ".*_knee": 40.0}),
    "unpacked dict": ("{**{'a': 1, 'b': 2}, 'b': 3}", {"a": 1, "b": 3}),
    "joined dicts": ("{'a': 1} | {'a': 2}", {"a": 2}),
    "dict of words": ("dict(a=1, b=2)", {"a": 1, "b": 2}),
    "dict of pairs": ("dict([('a', 1), ('b', 2)], b=3)", {"a": 1, "b": 3}),
    "item of a dict": ("{'a': 1, 'b': 2}['b']", 2),
    "item by a tuple": ("{('L', 'hip'): 1, ('R', 'hip'): 2}['R', 'hip']", 2),
    "tuples as keys": (
        "{s + j: k for (s, j), k in {('L', 'hip'): 1, ('R', 'hip'): 2}.items()}",
        {"Lhip": 1, "Rhip": 2},
    ),
    "item from the end": ("[1, 2, 3][-1]", 3),
    "slice": ("[1, 2, 3, 4][1:3]", (2, 3)),
    "known test": ("1 if 2 > 1 else 3", 1),
    "chain of tests": ("10 if 1 < 2 < 2 else 20", 20),
    "or": ("0 or 5", 5),
    "not in": ("5 if 'a' not in ('b',) else 6", 5),
    "lambda": ("(lambda x, y=2: x * y)(3)", 6),
    "list comprehension": ("[2 * x for x in (1, 2, 3) if x != 2]", (2, 6)),
    "dict comprehension": ("{f'{s}_knee': k for s, k in zip('LR', (1, 2))}", None),
    "two loops": ("[f'{a}{b}' for a in ['F', 'R'] for b in ['L', 'R']]", ("FL", "FR", "RL", "RR")),
    "sum and max": ("sum([1, 2]) + max(3, 4) + len('abc')", 10),
    "enumerate": ("[i * x for i, x in enumerate([5, 6])]", (0, 6)),
    "converted": ("float('1e3') + int(2.9)", 1002.0),
    "nothing": ("None", None),
    "truth": ("not 1 == 1.0", False),
}


@pytest.mark.parametrize("expression, value", EXPRESSIONS.values(), ids=EXPRESSIONS)
def test_expression(tmp_path: Path, expression: str, value: object) -> None:
    """An expression of literals folds to Python's own value."""
    found = folded(tmp_path, "", expression)
    if expression.startswith("{f"):
        # A text is not iterated over: which is said, not guessed.
        assert (found.value, found.unknown) == (None, "built in a comprehension: iterated over")
    else:
        assert (found.value, found.unknown) == (value, None)


NUMBERS = {
    "pi": ("import math", "2 * math.pi", 6.283185307179586),
    "numpy's pi": ("import numpy as np", "np.pi / 4", 0.7853981633974483),
    "torch's pi": ("import torch", "torch.pi", math.pi),
    # 180 degrees
    "radians": ("import math", "math.radians(180)", math.pi),
    "deg2rad": ("import numpy", "numpy.deg2rad(-90)", -math.pi / 2),
    "degrees": ("from math import degrees as d, pi", "d(pi)", 180.0),
    "root": ("from math import sqrt", "sqrt(2.25)", 1.5),
    "power": ("import math", "math.pow(2, 10)", 1024.0),
    # J N^2 = 2e-4 * 9 = 1.8e-3
    "one stage": ("from mjlab.utils.actuator import reflected_inertia as r", "r(2e-4, 3)", 1.8e-3),
    # 1e-4 (2 * 3)^2 + 2e-4 * 3^2 + 3e-4 = 36e-4 + 18e-4 + 3e-4
    "two stages": (
        "from mjlab.utils.actuator import reflected_inertia_from_two_stage_planetary as r",
        "r((1e-4, 2e-4, 3e-4), (1, 2, 3))",
        57e-4,
    ),
    # 60 rpm is one turn a second
    "rpm": ("from mjlab.utils.actuator import rpm_to_rad", "rpm_to_rad(60)", 2 * math.pi),
    # J / r^2 = 0.5 / 0.25; w r = 10 * 0.5; T / r = 3 / 0.5
    "linear": (
        "from mjlab.utils.actuator import reflect_rotary_to_linear as r\n(m, v, f) = r(0.5, 10.0, 3.0, 0.5)",
        "m * 100 + v * 10 + f",
        256.0,
    ),
}


@pytest.mark.parametrize("before, expression, value", NUMBERS.values(), ids=NUMBERS)
def test_published_function(tmp_path: Path, before: str, expression: str, value: float) -> None:
    """Functions of math, numpy and mjlab give what is published about them."""
    assert folded(tmp_path, before, expression).value == pytest.approx(value, rel=1e-14)


STATEMENTS = {
    "last assignment counts": ("K = 1\nX = K\nK = 2", "(X, K)", (1, 2)),
    "annotated": ("K: float = 3", "K", 3),
    "two targets": ("A = B = 4", "A + B", 8),
    "tuple of targets": ("A, (B, C) = 1, (2, 3)", "(C, B, A)", (3, 2, 1)),
    "added to": ("K = 1\nK += 2\nK *= 3", "K", 9),
    "alias": ("A = [1]\nB = A\nB.append(2)", "A", (1, 2)),
    "copy of a list": ("A = [1]\nB = A.copy()\nB.append(2)", "A", (1,)),
    "deep copy": (
        "import copy\nA = {'a': [1]}\nB = copy.deepcopy(A)\nB['a'][0] = 5",
        "(A, B)",
        ({"a": (1,)}, {"a": (5,)}),
    ),
    "item": ("A = {'a': 1}\nA['b'] = 2\ndel A['a']", "A", {"b": 2}),
    "update": ("A = {'a': 1}\nA.update({'b': 2})", "A", {"a": 1, "b": 2}),
    "popped": ("A = {'a': 1, 'b': 2}\nK = A.pop('a')", "(K, A)", (1, {"b": 2})),
    "known branch": ("USE = False\nif USE:\n  K = 1\nelif not USE:\n  K = 2", "K", 2),
    "never run": ("K = 1\nif __name__ == '__main__':\n  K = 2", "K", 1),
    "equal branches": ("import os\nif os.environ.get('A'):\n  K = 1\nelse:\n  K = 1", "K", 1),
    "raising branch": ("import os\nif os.environ.get('A'):\n  raise ValueError\nelse:\n  K = 4", "K", 4),
    "missing package": ("try:\n  from numpy import pi as K\nexcept ImportError:\n  K = 3", "K", math.pi),
    "function": ("def f(n, k=2, *, j=1):\n  m = n * k\n  return m + j", "f(5, j=3)", 13),
    "early return": ("def f(n):\n  if n > 1:\n    return 1\n  return 2", "(f(2), f(0))", (1, 2)),
    "global": ("def f():\n  global K\n  K = 2\n  return 1\nK = 1\nY = f()", "K", 2),
    "class attribute": ("class A:\n  x = 2\n  y = x * 2\nclass B(A):\n  x = 5", "(B.x, B.y, A.x)", (5, 4, 2)),
    "dataclass": (
        "from dataclasses import dataclass, field, replace\n@dataclass\nclass M:\n  a: float\n  b: float = 2\n"
        "  c: list = field(default_factory=lambda: [7])\nm = replace(M(1), b=3)",
        "(m.a, m.b, m.c)",
        (1, 3, (7,)),
    ),
    "method": (
        "class M:\n  def __init__(self, k):\n    self.k = k\n  def twice(self):\n    return 2 * self.k",
        "M(4).twice()",
        8,
    ),
    "property": ("class M:\n  k = 3\n  @property\n  def p(self):\n    return self.k + 1", "M().p", 4),
    "after init": (
        "from isaaclab.utils import configclass\n@configclass\nclass P:\n  k = 1\n  def __post_init__(self):\n"
        "    self.k = self.k + 1\n@configclass\nclass Q(P):\n  def __post_init__(self):\n    super().__post_init__()\n"
        "    self.k *= 10",
        "Q().k",
        20,
    ),
    "named tuple": (
        "from typing import NamedTuple\nclass N(NamedTuple):\n  a: float\n  b: float\nx, y = N(1, 2)",
        "y",
        2,
    ),
}


@pytest.mark.parametrize("before, expression, value", STATEMENTS.values(), ids=STATEMENTS)
def test_statements(tmp_path: Path, before: str, expression: str, value: object) -> None:
    """Statements are taken in order, with Python's sharing of lists and objects."""
    found = folded(tmp_path, before, expression)
    assert (found.value, found.unknown) == (value, None)


UNKNOWN = {
    "loop": ("K = 1\nfor i in range(3):\n  K = i", "K", "built in a loop"),
    "loop over a dict": ("K = {}\nfor i in ('a', 'b'):\n  K[i] = 1", "K", "built in a loop"),
    "while": ("K = 1\nwhile K < 5:\n  K += 1", "K", "built in a loop"),
    "alias in a loop": ("A = [1]\nfor b in [A]:\n  b.append(2)", "A", "built in a loop"),
    "elsewhere": (
        "from my_robots import GAINS",
        "GAINS['a']",
        "GAINS comes from my_robots, which is not beside this file",
    ),
    "elsewhere in a dict": (
        "import my_robots",
        "{'a': 1, 'b': my_robots.KP}",
        "b: KP comes from my_robots, which is not beside this file",
    ),
    "never defined": ("", "NOBODY", "NOBODY is not defined here"),
    "unknown test": (
        "import os\nif os.environ.get('A'):\n  K = 1\nelse:\n  K = 2",
        "K",
        "depends on a condition: calls get(): get comes from Python's os, which is not run",
    ),
    "one branch": (
        "import os\nK = 1\nif os.environ.get('A'):\n  K = 2",
        "K",
        "depends on a condition: calls get(): get comes from Python's os, which is not run",
    ),
    "only in one branch": (
        "import os\nif os.name:\n    K = 2",
        "K",
        "depends on a condition: name comes from Python's os, which is not run",
    ),
    "unknown index": (
        "import os\nA = {'a': 1}",
        "A[os.name]",
        "name comes from Python's os, which is not run",
    ),
    "no such key": ("A = {'a': 1}", "A['b']", "there is no 'b' in it"),
    "division by zero": ("", "1 / 0", "Div: division by zero"),
    "caught": ("K = 1\ntry:\n  pass\nexcept KeyError:\n  K = 2", "K", "depends on an exception"),
    "maybe returned": (
        "import os\ndef f():\n  if os.name:\n    return 1\n  return 2",
        "f()",
        "depends on a condition: name comes from Python's os, which is not run",
    ),
    "other decorator": ("import x\n@x.y\ndef f():\n  return 1", "f()", "f() is decorated by y"),
    "generator": ("def f():\n  yield 1", "f()", "f() is a generator"),
    "input": ("", "input()", "input is not defined here"),
    "text of an unknown": ("import x", "f'{x.a}/b' + 'c'", "a comes from x, which is not beside this file"),
}


@pytest.mark.parametrize("before, expression, reason", UNKNOWN.values(), ids=UNKNOWN)
def test_unknown(tmp_path: Path, before: str, expression: str, reason: str) -> None:
    """What cannot be folded has its reason and no value."""
    found = folded(tmp_path, before, expression)
    assert (found.value, found.unknown) == (None, reason)


# `ROBOT = DCMotorCfg(` is 19 characters, `joint_names_expr=[.*], ` with its quotes 25, `any_value=` 10.
PLACES = {
    "literal": ("", "40.0", (2, 55)),
    "constant": ("K = 40.0", "K", (2, 5)),
    "expression": ("K = 40.0", "2 * K", (3, 55)),
    "field": ("class M:\n  k = 3", "M.k", (3, 7)),
    "after letters of two bytes": ("Ä = 'ä'; K = 1", "K", (2, 14)),
    "negative": ("", "-3", (2, 55)),
    # `K = ` is 4 characters; the product is written in the function, the number for this joint is asked for here.
    "number of a function": ("def f(x):\n  return 2 * x\nK = f(3)", "K", (4, 5)),
}


@pytest.mark.parametrize("before, expression, place", PLACES.values(), ids=PLACES)
def test_place(tmp_path: Path, before: str, expression: str, place: tuple[int, int]) -> None:
    """A setting points at where its number is written, columns in characters."""
    text = (HEAD + before + TAIL).replace("\n\n", "\n")
    span = robot(tmp_path, text.format(expression)).groups[0].settings["any_value"].span
    assert (span.line, span.column) == place


def test_imports(tmp_path: Path) -> None:
    """Imports are followed below the package: relative ones, absolute ones, stars, modules, and no circle hangs."""
    package = tmp_path / "lab"
    (package / "robots" / "go").mkdir(parents=True)
    for folder in (package, package / "robots"):
        (folder / "__init__.py").write_text("", encoding="utf-8")
    (package / "robots" / "__init__.py").write_text("from .motors import *\n", encoding="utf-8")
    (package / "robots" / "motors.py").write_text(
        "from lab.robots.go import cfg\nKP = 20.0\n", encoding="utf-8"
    )
    (package / "gains.py").write_text("from .robots.motors import KP as K2\nKD = 0.5\n", encoding="utf-8")
    # `go` has no __init__.py, as the robots of legged_gym have none.
    path = package / "robots" / "go" / "cfg.py"
    path.write_text(
        "from isaaclab.actuators import DCMotorCfg\nfrom lab.robots import KP\nfrom ..motors import cfg\n"
        "import lab.gains as gains\nimport lab\n"
        "A = DCMotorCfg(joint_names_expr=['.*'], stiffness=KP, damping=gains.KD, armature=lab.gains.K2, x=cfg.Q)\n",
        encoding="utf-8",
    )
    reading = read_python(str(path))
    (artifact,) = reading.artifacts
    assert artifact.config is not None
    settings = artifact.config.groups[0].settings
    assert {name: one.value for name, one in settings.items()} == {
        "stiffness": 20.0,
        "damping": 0.5,
        "armature": 20.0,
        "x": None,
    }
    assert (settings["stiffness"].span.path, settings["stiffness"].span.line) == (
        str(package / "robots" / "motors.py"),
        2,
    )
    assert reading.files[0].path == str(path)
    names = sorted(str(Path(one.path).relative_to(package)) for one in reading.files[1:])
    assert names == ["__init__.py", "gains.py", "robots/__init__.py", "robots/motors.py"]


def _lay_out(folder: Path, importer: str, statement: str, module: str) -> None:
    """A robot that takes K from a module by a statement; the folder `code` is a package."""
    for path in (importer, module, "code/__init__.py"):
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
    (folder / "code" / "__init__.py").write_text("", encoding="utf-8")
    (folder / module).write_text("K = 25.0\n", encoding="utf-8")
    (folder / importer).write_text(HEAD + statement + TAIL.format("K"), encoding="utf-8")


@pytest.mark.parametrize(
    "importer, statement, module",
    [
        # A program started in `code` imports `robot` of it, which needs no `__init__.py`.
        ("code/robot/cfg.py", "from robot import gains\nK = gains.K", "code/robot/gains.py"),
        ("code/robot/cfg.py", "from robot.gains import K", "code/robot/gains.py"),
        ("code/tasks/walk/cfg.py", "from robot.gains import K", "code/robot/gains.py"),
        ("code/tasks/walk/cfg.py", "from walk.gains import K", "code/tasks/walk/gains.py"),
        ("code/tasks/walk/cfg.py", "import robot.gains as g\nK = g.K", "code/robot/gains.py"),
        # No package at all: what is beside the file by its folder's name.
        ("alone/robot/cfg.py", "from robot import gains\nK = gains.K", "alone/robot/gains.py"),
        ("alone/robot/cfg.py", "from alone.robot.gains import K", "alone/robot/gains.py"),
        ("alone/robot/cfg.py", "from robot.motors.gains import K", "alone/robot/motors/gains.py"),
    ],
)
def test_imports_of_folders_without_init(tmp_path: Path, importer: str, statement: str, module: str) -> None:
    """A folder is a package to Python without an `__init__.py`, below any folder where a program may be started."""
    _lay_out(tmp_path, importer, statement, module)
    (artifact,) = read_python(str(tmp_path / importer)).artifacts
    assert artifact.config is not None
    assert artifact.config.groups[0].settings["any_value"].value == 25.0


@pytest.mark.parametrize(
    "importer, statement, other",
    [
        # The parent is no part of what was named.
        ("alone/robot/cfg.py", "from alone.gains import K", "alone/gains.py"),
        ("alone/robot/cfg.py", "from gains import K", "alone/gains.py"),
        ("alone/robot/cfg.py", "from robot import K", "alone/robot.py"),
        ("code/robot/cfg.py", "from gains import K", "gains.py"),
        # A folder of this name is not the framework, nor Python's own module.
        ("code/cfg.py", "from isaaclab.gains import K", "code/isaaclab/gains.py"),
        ("code/robot/cfg.py", "from statistics import K", "code/statistics.py"),
    ],
)
def test_other_folders_are_not_searched(tmp_path: Path, importer: str, statement: str, other: str) -> None:
    """What is neither in the file's package nor beside it is not read, whatever it is called."""
    _lay_out(tmp_path, importer, statement, other)
    reading = read_python(str(tmp_path / importer))
    (artifact,) = reading.artifacts
    assert artifact.config is not None
    assert artifact.config.groups[0].settings["any_value"].value is None
    assert len(reading.files) == 1


@pytest.mark.parametrize(
    "statement", ["from . import secret", "from .. import secret", "from ...etc import secret"]
)
def test_imports_stay_inside(tmp_path: Path, statement: str) -> None:
    """No import leaves the folder of the named file, by dots or by a symbolic link."""
    (tmp_path / "secret.py").write_text("K = 1\n", encoding="utf-8")
    inner = tmp_path / "inner"
    inner.mkdir()
    (inner / "secret.py").symlink_to(tmp_path / "secret.py")
    found = folded(inner, statement, "secret.K")
    assert found.value is None
    assert found.unknown is not None and (
        "not beside this file" in found.unknown or "link to outside" in found.unknown
    )


def test_broken_import(tmp_path: Path) -> None:
    """A file that cannot be parsed makes its names unknown, and says the line."""
    (tmp_path / "gains.py").write_text("K = 1\nK = (\n", encoding="utf-8")
    found = folded(tmp_path, "from gains import K", "K")
    assert found.unknown == "K comes from gains, which cannot be read: '(' was never closed (gains.py:2:5)"
