"""What is wrong in a model or configuration that nothing names, where programs name others, is a note."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.read import read_files
from actspec.audit.rules.sym101 import LeftRightDiffer
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity
from actspec.readings.written_over import simulators_of, written_over

JOINT = """<joint name="{side}_knee" type="revolute"><parent link="base"/><child link="{side}"/>
    <limit lower="-1" upper="1" effort="{effort}" velocity="9"/></joint>"""
JOINTS = JOINT.format(side="left", effort=20) + JOINT.format(side="right", effort=30)


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # Most tests need a rule that speaks of a folder; which ones do is in test_folders.py.
    monkeypatch.setattr(LeftRightDiffer, "noted_in_folders", False)
    Path("r/models").mkdir(parents=True)
    for name in ("one", "two"):
        Path(f"r/models/{name}.urdf").write_text(
            f'<robot name="{name}"><link name="base"/><link name="left"/><link name="right"/>{JOINTS}</robot>'
        )


def severities(*named: str) -> dict[str, Severity]:
    """Of the sides that differ, by file."""
    found = audit(list(named), Settings()).findings
    return {
        Path(item.finding.span.path).stem: item.severity for item in found if item.finding.code == "SYM101"
    }


def write_go1() -> None:
    """A Go1 alone, with 110 N*m at every joint: 3.28 times the 33.5 that its maker once had at all."""
    for path in Path("r/models").iterdir():
        path.unlink()
    names = [f"{leg}_{part}_joint" for leg in ("FL", "FR", "RL", "RR") for part in ("hip", "thigh", "calf")]
    joints = "".join(
        f'<link name="{n}_link"/><joint name="{n}" type="revolute"><parent link="base"/><child link="{n}_link"/>'
        '<limit lower="-1" upper="1" effort="110" velocity="20"/></joint>'
        for n in names
    )
    Path("r/models/go1.urdf").write_text(f'<robot name="go1"><link name="base"/>{joints}</robot>')


def of_published(*named: str) -> set[tuple[str, Severity]]:
    """Files with limits that are not the published ones, and how grave that is."""
    found = audit(list(named), Settings(select=("KNW101",))).findings
    return {(Path(item.finding.span.path).name, item.severity) for item in found}


def test_nothing_is_named() -> None:
    """Models alone are for whoever takes them."""
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.WARNING}


@pytest.mark.parametrize(
    "program",
    [
        "FILE = 'models/one.urdf'\n",
        "class Cfg:\n    class asset:\n        file = '{ROOT}/models/one.urdf'\n",
        "FILE = 'models/one.urdf'\n  # or models/two.urdf\n",
        "FILE = 'models/one.urdf'\nOTHER = f'models/twos_{side if side else 0}.urdf'\n",
        "FILE = 'models/one.urdf'\nOTHER = f'models/{side}_two.urdf'\n",
        "FILE = 'models/o' + name\nOTHER = 'models/on%s.urdf' % name\n",
        "FILE = 'one.urdf'\nOTHER = f'{name}.urdf'\n",
        "FILE = 'one.urdf'\nOTHER = f'{a}{b}.urdf'\nNAMES = ['twos']\n",
        "FILE = 'robots/one.usd'\n",
        "FILE = 'one.urdf'\nos.system(\"find . -o -name '*.urdf' -delete\")\n",
        "FILE = 'one.urdf'\nOTHERS = folder.glob('*.urdf')\n",
    ],
)
def test_a_program_names_one(program: str) -> None:
    """The other is for nobody; a name on the command line is a name too."""
    Path("r/train.py").write_text(program)
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.INFO}
    assert severities("r/train.py", "r/models/two.urdf") == {"two": Severity.WARNING}
    own = audit(["r"], Settings(select=("SYM101",), as_named=True)).findings
    assert {item.severity for item in own} == {Severity.WARNING}


@pytest.mark.parametrize(
    "program",
    [
        "FILES = ['one.urdf', 'two.urdf']\n",
        "FILE = 'one.urdf'\nOTHER = f'{name}.urdf'\nNAMES = ['one', 'two']\n",
        "FILE = 'one.urdf'\nOTHER = name + '.urdf'\nNAMES = ['two']\n",
        "FILE = 'one.urdf'\nOTHER = name + f'o.urdf'\n",
        "FILE = 'one.urdf'\nOTHER = f't{a}.urdf'\n",
        "FILE = 'one.urdf'\nOTHERS = Path('models').glob('*.urdf')\n",
        "FILE = 'one.urdf'\nMODELS = 'models'\nOTHERS = glob(f'{MODELS}/**/*.urdf')\n",
        "FILE = 'one.urdf'\nNAMES = ['two']\nOTHERS = folder.glob('*.urdf')\n",
    ],
)
def test_every_one_may_be_named(program: str) -> None:
    """A name that is put together may be any."""
    Path("r/train.py").write_text(program)
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.WARNING}


@pytest.mark.parametrize(
    ("program", "text"),
    [
        ("main.cpp", '// two.urdf\n/* two.urdf */ load("package://dog/models/one.urdf");'),
        ("view.launch", '<launch><!-- two.urdf --><param textfile="$(find dog)/models/one.urdf"/></launch>'),
        ("view.xml", '<launch><!-- two.urdf --><param textfile="$(find dog)/models/one.urdf"/></launch>'),
        ("run.sh", "# two.urdf\nsim models/one.urdf"),
        ("models/one.urdf.xacro", '<robot><xacro:include filename="one.urdf"/></robot>'),
        ("view.launch", '<launch><arg model="$(find dog)/models/one.urdf.xacro"/></launch>'),
        ("train.py", 'FILE = os.path.join(ROOT, "models", "one.urdf")'),
    ],
)
def test_programs_of_other_kinds_name_one(program: str, text: str) -> None:
    """C++, launch files and scripts run models as Python does; old programs and tests do not count."""
    Path("r", program).write_text(text)
    Path("r/tests").mkdir()
    Path("r/tests/it.py").write_text("FILE = 'two.urdf'\n")
    Path("r/legacy").mkdir()
    Path("r/legacy/train.py").write_text("FILE = 'two.urdf'\n")
    Path("r/setup.py").write_text("data_files = ['models/two.urdf']\n")
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.INFO}


@pytest.mark.parametrize(("folder", "two"), [("models", Severity.WARNING), ("scripts", Severity.INFO)])
def test_a_pattern_without_a_folder(folder: str, two: Severity) -> None:
    """It is for the files beside the program; elsewhere nobody knows for which."""
    Path("r", folder).mkdir(exist_ok=True)
    Path("r", folder, "convert.py").write_text("for path in here.glob('*.urdf'):\n    convert(path)\n")
    Path("r/train.py").write_text("FILE = 'one.urdf'\n")
    assert severities("r") == {"one": Severity.WARNING, "two": two}


def test_urdfs_beside_a_xacro() -> None:
    """They were made of it, which is run."""
    Path("r/models/dog.xacro").write_text("<robot/>")
    Path("r/view.launch").write_text('<launch><arg model="$(find dog)/models/dog.xacro"/></launch>')
    Path("r/run.py").write_text("load('other/one.urdf')\n")
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.WARNING}
    # What only another xacro includes is run by nobody.
    Path("r/view.launch").unlink()
    Path("r/models/cat.xacro").write_text('<robot><xacro:include filename="dog.xacro"/></robot>')
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.INFO}


@pytest.mark.parametrize(
    ("program", "named"),
    [
        ("load('cat/urdf/r.urdf')", {"cat"}),
        ("load(ROOT / 'cat' / 'urdf' / 'r.urdf')", {"cat"}),
        ("load(f'robots/{robot}/urdf/r.urdf')\nROBOT = 'cat'", {"cat"}),
        ("load('urdf/r.urdf')\nROBOT = 'cat'", {"cat"}),
        ("load(join(get_package_share_directory('cat'), 'urdf', 'r.urdf'))\nROBOT = 'dog'", {"cat"}),
        ("load('r.urdf')\nROBOTS = 'cat', 'dog'", {"cat", "dog"}),
        ("load('r.urdf')", {"cat", "dog"}),
    ],
)
def test_models_of_one_name(program: str, named: set[str]) -> None:
    """Folders tell them apart, or of which of them the programs speak."""
    for robot in ("cat", "dog"):
        Path("r", robot, "urdf").mkdir(parents=True)
        Path("r", robot, "urdf", "r.urdf").write_text(Path("r/models/one.urdf").read_text())
    Path("r/run.py").write_text(program)
    found = audit(["r"], Settings(select=("SYM101",))).findings
    assert {
        Path(item.finding.span.path).parts[1] for item in found if item.severity is Severity.WARNING
    } == named


@pytest.mark.parametrize("find", ["$(find cat)", "$(find-pkg-share cat)", "package://cat"])
def test_models_of_one_name_in_two_packages(find: str) -> None:
    """A launch file names the package's folder."""
    for robot in ("cat", "dog"):
        Path("r", robot, "urdf").mkdir(parents=True)
        Path("r", robot, "urdf", "r.urdf").write_text(Path("r/models/one.urdf").read_text())
    Path("r/view.launch").write_text(f'<launch name="dog"><param file="{find}/urdf/r.urdf"/></launch>')
    found = audit(["r"], Settings(select=("SYM101",))).findings
    assert {Path(item.finding.span.path).parts[1] for item in found if item.severity is Severity.WARNING} == {
        "cat"
    }


def test_an_include_is_of_its_own_folder() -> None:
    """Not the model of that name in another one."""
    for robot in ("cat", "dog"):
        Path("r", robot).mkdir()
        Path("r", robot, "part.urdf").write_text(Path("r/models/one.urdf").read_text())
        Path("r", robot, f"{robot}.xml").write_text(
            "<mujoco><asset><model file='part.urdf'/></asset><worldbody/></mujoco>"
        )
    Path("r/run.py").write_text("load('dog/dog.xml')\nCATS = 'cat'\n")
    found = audit(["r"], Settings(select=("SYM101",))).findings
    assert {Path(item.finding.span.path).parts[1] for item in found if item.severity is Severity.WARNING} == {
        "dog"
    }


def test_a_model_names_another() -> None:
    """What a named scene includes is run."""
    Path("r/models/scene.xml").write_text(
        "<mujoco><!-- one.urdf --><asset><model file='two.urdf'/></asset><worldbody/></mujoco>"
    )
    Path("r/run.py").write_text("load('models/scene.xml')\n")
    assert severities("r") == {"one": Severity.INFO, "two": Severity.WARNING}


def test_a_scene_that_nothing_names() -> None:
    """What it includes is run no more than it is."""
    Path("r/models/scene.xml").write_text(
        "<mujoco><asset><model file='two.urdf'/></asset><worldbody/></mujoco>"
    )
    Path("r/run.py").write_text("load('models/one.urdf')\n")
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.INFO}


@pytest.mark.parametrize(
    ("program", "severity"),
    [
        ("load('models/plain.xml')\n", Severity.INFO),
        ("load('models/scene.xml')\n", Severity.WARNING),
        ("load('models/other.xml')\n", Severity.WARNING),
    ],
)
@pytest.mark.parametrize("named", ["r", "./r"])
def test_a_part_of_scenes(program: str, severity: Severity, named: str) -> None:
    """Drives that models include are run as little as those models: here of two scenes, of which none or one is run.

    MuJoCo takes nothing of them alone. 30 is 1.5 times 20.
    """
    for path in Path("r/models").iterdir():
        path.unlink()
    drives = "".join(
        f'<motor joint="{side}_knee" forcerange="-{limit} {limit}"/>'
        for side, limit in (("left", 20), ("right", 30))
    )
    Path("r/models/drives.xml").write_text(f"<mujoco><actuator>{drives}</actuator></mujoco>")
    bodies = "".join(f'<body><joint name="{n}_knee"/><geom size="0.1"/></body>' for n in ("left", "right"))
    text = "<mujoco><compiler angle='radian'/>{}<worldbody>" + bodies + "</worldbody></mujoco>"
    for name in ("scene", "other"):
        Path(f"r/models/{name}.xml").write_text(text.format('<include file="drives.xml"/>'))
    Path("r/models/plain.xml").write_text(text.format(""))
    Path("r/run.py").write_text(program)
    found = audit([named], Settings(select=("SYM101",))).findings
    assert {(Path(item.finding.span.path).name, item.severity) for item in found} == {
        ("drives.xml", severity)
    }


CONFIGS = """
from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg

{one} = ArticulationCfg(actuators={{"legs": ImplicitActuatorCfg(
    joint_names_expr=["left_knee", "right_knee"], stiffness={{"left_knee": 10.0, "right_knee": 20.0}}, damping=1.0)}})
{two} = ArticulationCfg(actuators={{"legs": ImplicitActuatorCfg(
    joint_names_expr=["left_knee", "right_knee"], stiffness={{"left_knee": 10.0, "right_knee": 20.0}}, damping=1.0)}})
"""


def one_config(name: str) -> str:
    """The first of the two alone."""
    return CONFIGS.format(one=name, two="OTHER_CFG").partition("OTHER_CFG")[0]


def go1_config() -> str:
    """A Go1 without a model, with 50 N*m at every joint."""
    for path in Path("r/models").iterdir():
        path.unlink()
    text = one_config("GO1_CFG")
    joints = '["[FR][LR]_hip_joint", "[FR][LR]_thigh_joint", "[FR][LR]_calf_joint"]'
    text = text.replace('["left_knee", "right_knee"]', joints)
    text = text.replace('{"left_knee": 10.0, "right_knee": 20.0}', "20.0, effort_limit_sim=50.0")
    return text


@pytest.mark.parametrize(
    ("task", "more", "lines"),
    [
        ("from robots import DOG_CFG\nrun(DOG_CFG)\n", "", {6: Severity.WARNING, 8: Severity.INFO}),
        ("from robots import DOG_CFG, CAT_CFG\nrun(CAT_CFG)\n", "", {6: Severity.INFO, 8: Severity.WARNING}),
        (
            "from robots import DOG_CFG as X, CAT_CFG\nrun(X)\n",
            "",
            {6: Severity.WARNING, 8: Severity.WARNING},
        ),
        ("# from robots import DOG_CFG\n", "", {6: Severity.WARNING, 8: Severity.WARNING}),
        ("from robots import DOG_CFG as X, CAT_CFG\n", "", {6: Severity.WARNING, 8: Severity.WARNING}),
        ("from robots import DOG_CFG\n", "ANY = [CAT_CFG]\n", {6: Severity.WARNING, 8: Severity.WARNING}),
        (
            "from robots import DOG_CFG, CAT_CFG_2\nrun(DOG_CFG)\n",
            "",
            {6: Severity.WARNING, 8: Severity.INFO},
        ),
    ],
)
def test_a_configuration_that_nothing_imports(task: str, more: str, lines: dict[int, Severity]) -> None:
    """It is run by nobody where another one of its file is; where nothing is imported, all are there for others."""
    Path("r/robots.py").write_text(CONFIGS.format(one="DOG_CFG", two="CAT_CFG") + more)
    Path("r/task.py").write_text(task)
    found = audit(["r"], Settings()).findings
    assert {
        item.finding.span.line: item.severity
        for item in found
        if item.finding.code == "SYM101" and item.finding.span.path.endswith(".py")
    } == lines


@pytest.mark.parametrize(
    ("text", "cat"),
    [
        (
            "from .robots import (\n    CAT_CFG,\n    DOG_CFG,\n)\n__all__ = ['CAT_CFG', 'DOG_CFG']\n",
            Severity.INFO,
        ),
        ("from .robots import CAT_CFG, DOG_CFG\n", Severity.INFO),
        ("from .robots import CAT_CFG, DOG_CFG\nregister('cat', CAT_CFG)\n", Severity.WARNING),
    ],
)
def test_what_a_package_hands_on(text: str, cat: Severity) -> None:
    """An `__init__.py` that imports a name, for others, runs nothing; the task imports one of two."""
    Path("r/robots.py").write_text(CONFIGS.format(one="DOG_CFG", two="CAT_CFG"))
    Path("r/__init__.py").write_text(text)
    Path("r/task.py").write_text("from . import DOG_CFG\nrun(DOG_CFG)\n")
    found = audit(["r"], Settings(select=("SYM101",))).findings
    said = {
        item.finding.span.line: item.severity for item in found if item.finding.span.path == "r/robots.py"
    }
    assert said == {6: Severity.WARNING, 8: cat}


@pytest.mark.parametrize(
    ("text", "cat"),
    [
        ('"""CAT_CFG was our first robot."""\nX = 1\n', Severity.INFO),
        ("def f():\n    '''Not of\n    CAT_CFG.\n    '''\n    return 1\n", Severity.INFO),
        ("X = 1  # was CAT_CFG\n", Severity.INFO),
        ("X = 1  # it's CAT_CFG\n", Severity.INFO),
        ("from robots import CAT_CFG, DOG_CFG\n\n__all__ = ['CAT_CFG', 'DOG_CFG']\n", Severity.INFO),
        # Texts that a program has, what it names and uses, and what is between two texts.
        ("X = 'CAT_CFG'\n", Severity.WARNING),
        ("X = '''\nCAT_CFG\n'''\n", Severity.WARNING),
        ('A = """\n1\n"""\nuse(robots.CAT_CFG)\nB = """\n2\n"""\n', Severity.WARNING),
        ("COLOUR = '#fff'; X = robots.CAT_CFG\n", Severity.WARNING),
        ("X = ('a', # the first\n  robots.CAT_CFG)\n", Severity.WARNING),
        ("from robots import CAT_CFG, DOG_CFG\nALL = [CAT_CFG, DOG_CFG]\n", Severity.WARNING),
    ],
)
def test_what_a_program_only_says(text: str, cat: Severity) -> None:
    Path("r/robots.py").write_text(CONFIGS.format(one="DOG_CFG", two="CAT_CFG"))
    Path("r/notes.py").write_text(text)
    Path("r/task.py").write_text("from robots import DOG_CFG\nrun(DOG_CFG)\n")
    found = audit(["r"], Settings(select=("SYM101",))).findings
    said = {
        item.finding.span.line: item.severity for item in found if item.finding.span.path == "r/robots.py"
    }
    assert said == {6: Severity.WARNING, 8: cat}


@pytest.mark.parametrize(
    ("made", "dog"),
    [
        ("CAT_CFG = DOG_CFG.replace(pos=(0, 0), actuators={'legs': Motor(9.0)})\n", Severity.INFO),
        ("CAT_CFG = DOG_CFG.replace(pos=(0, 0))\n", Severity.WARNING),
        ("CAT_CFG = DOG_CFG.replace(actuators={**DOG_CFG.actuators, 'arm': ARM})\n", Severity.WARNING),
        ("CAT_CFG = DOG_CFG.copy()\n", Severity.WARNING),
    ],
)
def test_a_template_whose_drives_are_replaced(made: str, dog: Severity) -> None:
    """What takes all but its drives uses none of their figures."""
    Path("r/robots.py").write_text(one_config("DOG_CFG") + made)
    Path("r/task.py").write_text("from robots import CAT_CFG\nrun(CAT_CFG)\n")
    found = audit(["r"], Settings(select=("SYM101",))).findings
    lines = {item.severity for item in found if item.finding.span.path == "r/robots.py"}
    assert lines == {dog}


@pytest.mark.parametrize(
    ("task", "aside"),
    [
        ("from r.robots.dog import DOG_CFG\nrun(DOG_CFG)\n", Severity.INFO),
        ("from ..robots.dog import DOG_CFG\nrun(DOG_CFG)\n", Severity.INFO),
        # A word of the other folder, for whatever, may be a use of it.
        (
            "from r.robots.dog import DOG_CFG\nsys.path.append('robots_early')\nrun(DOG_CFG)\n",
            Severity.WARNING,
        ),
        ("from robots import DOG_CFG\nrun(DOG_CFG)\n", Severity.WARNING),
    ],
)
def test_a_copy_of_a_folder_of_configurations(task: str, aside: Severity) -> None:
    """Of two folders with one file and its names, the one that nothing outside it names is run by nobody."""
    for folder in ("robots", "robots_early"):
        Path("r", folder).mkdir()
        Path("r", folder, "dog.py").write_text(one_config("DOG_CFG"))
        Path("r", folder, "__init__.py").write_text("from .dog import *\n")
    Path("r/task.py").write_text(task)
    found = audit(["r"], Settings(select=("SYM101",))).findings
    said = {item.finding.span.path: item.severity for item in found if item.finding.span.path.endswith(".py")}
    assert said == {"r/robots/dog.py": Severity.WARNING, "r/robots_early/dog.py": aside}


@pytest.mark.parametrize(
    ("package", "task", "aside"),
    [
        (("r/r/robots",), "from r.robots.dog import DOG_CFG\nrun(DOG_CFG)\n", Severity.INFO),
        (("r/r/robots", "r/robots"), "from r.robots.dog import DOG_CFG\nrun(DOG_CFG)\n", Severity.WARNING),
        ((), "from r.robots.dog import DOG_CFG\nrun(DOG_CFG)\n", Severity.WARNING),
        # It may be the one beside it.
        (("r/r/robots",), "from dog import DOG_CFG\nrun(DOG_CFG)\n", Severity.WARNING),
        (("r/r/robots",), "from .dog import DOG_CFG\nrun(DOG_CFG)\n", Severity.WARNING),
    ],
)
def test_a_copy_outside_of_the_package(package: tuple[str, ...], task: str, aside: Severity) -> None:
    """`r/robots/` beside the package's `r/r/robots/`: what has no `__init__.py` is no part of one."""
    for folder in ("r/robots", "r/r/robots"):
        Path(folder).mkdir(parents=True)
        Path(folder, "dog.py").write_text(one_config("DOG_CFG"))
    for folder in package:
        Path(folder, "__init__.py").touch()
    Path("r/r/task.py").write_text(task)
    found = audit(["r"], Settings(select=("SYM101",))).findings
    said = {item.finding.span.path: item.severity for item in found if item.finding.span.path.endswith(".py")}
    assert said == {"r/r/robots/dog.py": Severity.WARNING, "r/robots/dog.py": aside}


@pytest.mark.parametrize("named", ["r", "./r", "r/", "./r/../r", "."])
def test_however_the_folder_is_named(named: str) -> None:
    """What programs name and import is found in it."""
    Path("r/robots.py").write_text(CONFIGS.format(one="DOG_CFG", two="CAT_CFG"))
    Path("r/task.py").write_text("from robots import DOG_CFG\nrun(DOG_CFG, 'one.urdf')\n")
    found = audit([named], Settings(select=("SYM101",))).findings
    assert sorted(
        (Path(item.finding.span.path).name, item.finding.span.line)
        for item in found
        if item.severity is Severity.INFO
    ) == [("robots.py", 8), ("two.urdf", 3)]


@pytest.mark.parametrize(
    ("task", "more", "severity"),
    [
        ("from robots import DOG_CFG\nrun(DOG_CFG)\n", "", Severity.INFO),
        ("from robots import DOG_CFG\nfrom strays import *\n", "", Severity.WARNING),
        ("from robots import DOG_CFG\n", "if __name__ == '__main__':\n    run()\n", Severity.WARNING),
        ("from robots import DOG_CFG\nMOUSE_CFG\n", "", Severity.WARNING),
        ("", "", Severity.WARNING),
        # What a module sets of a configuration, or makes a table of its drives, is no use of it.
        ("from robots import DOG_CFG\nrun(DOG_CFG)\n", "MOUSE_CFG.spawn.x = 2\n", Severity.INFO),
        # What is imported and not used, the use being a comment.
        (
            "from robots import DOG_CFG\nfrom strays import MOUSE_CFG\nrun(DOG_CFG)\n# run(MOUSE_CFG)\n",
            "",
            Severity.INFO,
        ),
        (
            "from robots import DOG_CFG\nfrom strays import MOUSE_CFG\nrun(DOG_CFG, MOUSE_CFG)\n",
            "",
            Severity.WARNING,
        ),
        (
            "from robots import DOG_CFG\nrun(DOG_CFG)\n",
            "for a in MOUSE_CFG.actuators.values():\n    a\n",
            Severity.INFO,
        ),
        ("from robots import DOG_CFG\nrun(DOG_CFG)\n", "run(MOUSE_CFG.actuators)\n", Severity.WARNING),
        (
            "from robots import DOG_CFG\nrun(DOG_CFG)\n",
            "if there:\n    MOUSE_CFG.spawn.replace_asset(\n        there,\n    )\n",
            Severity.INFO,
        ),
        ("from robots import DOG_CFG\nrun(DOG_CFG)\n", "MOUSE_CFG.spawn.find(there)\n", Severity.INFO),
        ("from robots import DOG_CFG\nrun(DOG_CFG)\n", "MOUSE_CFG.replace(x=there)\n", Severity.WARNING),
        (
            "from robots import DOG_CFG\nrun(DOG_CFG)\n",
            "run(\n    MOUSE_CFG.spawn.replace(x=there)\n)\n",
            Severity.WARNING,
        ),
    ],
)
def test_a_file_of_configurations_that_nothing_imports(task: str, more: str, severity: Severity) -> None:
    """Where another file's are imported; neither its name nor its configurations' stand anywhere else."""
    Path("r/robots.py").write_text(CONFIGS.format(one="DOG_CFG", two="CAT_CFG"))
    Path("r/strays.py").write_text(
        CONFIGS.format(one="MOUSE_CFG", two="RAT_CFG").replace("20.0", "30.0") + more
    )
    Path("r/copy_of_strays.py").write_text(Path("r/strays.py").read_text())
    Path("r/task.py").write_text(task)
    found = audit(["r"], Settings(select=("SYM101",))).findings
    assert {
        item.severity
        for item in found
        if Path(item.finding.span.path).name == "strays.py" and item.finding.span.line == 6
    } == {severity}


@pytest.mark.parametrize(
    ("task", "severity"),
    [
        ("from cat.cat_old import X\n", Severity.INFO),
        ("from cat.cat import *\n", Severity.WARNING),
        ("import cat.cat as c\n", Severity.WARNING),
    ],
)
def test_a_module_called_as_its_package(task: str, severity: Severity) -> None:
    """The package's name in an import is not the module's."""
    Path("r/robots.py").write_text(CONFIGS.format(one="DOG_CFG", two="FOX_CFG"))
    Path("r/cat").mkdir()
    Path("r/cat/cat.py").write_text(CONFIGS.format(one="CAT_CFG", two="RAT_CFG"))
    Path("r/task.py").write_text("from robots import DOG_CFG\nrun(DOG_CFG)\n" + task)
    found = audit(["r"], Settings(select=("SYM101",))).findings
    assert {item.severity for item in found if item.finding.span.path == "r/cat/cat.py"} == {severity}


@pytest.mark.parametrize("folder", ["inverse_kinematics", "third_party", "archive", "before_the_fix"])
def test_a_model_that_is_aside(folder: str) -> None:
    """It is never stepped, or somebody else's, or old."""
    Path("r", folder).mkdir()
    Path("r/models/two.urdf").rename(f"r/{folder}/two.urdf")
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.INFO}


@pytest.mark.parametrize(
    ("name", "severity"),
    [
        ("go1_cfg.py", Severity.WARNING),
        ("go1-cfg.py", Severity.WARNING),
        ("go1_cfg (1).py", Severity.INFO),
        ("go1_cfg\u3000大KP.py", Severity.INFO),
    ],
)
def test_a_configuration_that_no_program_can_import(name: str, severity: Severity) -> None:
    """A name with a space is that of a copy; one with a hyphen may be a script's."""
    for path in Path("r/models").iterdir():
        path.unlink()
    Path("r", name).write_text(
        "from isaaclab.actuators import IdealPDActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        "GO1_CFG = ArticulationCfg(actuators={'legs': IdealPDActuatorCfg(\n"
        "    joint_names_expr=['.*_hip_joint', '.*_thigh_joint', '.*_calf_joint'],\n"
        "    effort_limit=80.0, stiffness=20.0, damping=0.5)})\n"
    )
    assert of_published("r") == {(name, severity)}
    assert of_published(f"r/{name}") == {(name, Severity.WARNING)}


@pytest.mark.parametrize("odd", ["dog.py", "dog.urdf", "dog.xml"])
def test_the_odd_one_of_three(odd: str) -> None:
    """Two kinds of file agree against the third, whichever it is; 30 is twice 15."""
    for path in Path("r/models").iterdir():
        path.unlink()
    effort = {name: 15 if name == odd else 30 for name in ("dog.py", "dog.urdf", "dog.xml")}
    joints = "".join(JOINT.format(side=side, effort=effort["dog.urdf"]) for side in ("left", "right"))
    Path("r/models/dog.urdf").write_text(
        f'<robot name="dog"><link name="base"/><link name="left"/><link name="right"/>{joints}</robot>'
    )
    text = one_config("DOG_CFG").replace("20.0", "10.0")
    Path("r/dog.py").write_text(
        text.replace("damping=1.0", f"damping=1.0, effort_limit_sim={effort['dog.py']}.0")
    )
    bodies = "".join(f'<body><joint name="{n}_knee"/><geom size="0.1"/></body>' for n in ("left", "right"))
    motors = "".join(
        f'<motor joint="{n}_knee" forcerange="-{effort["dog.xml"]} {effort["dog.xml"]}"/>'
        for n in ("left", "right")
    )
    Path("r/models/dog.xml").write_text(
        f'<mujoco model="dog"><worldbody>{bodies}</worldbody><actuator>{motors}</actuator></mujoco>'
    )
    files = ["r/dog.py", "r/models/dog.urdf", "r/models/dog.xml"]
    said = audit(files, Settings(select=("SRC101",))).findings
    assert {(Path(item.finding.span.path).name, item.severity.value) for item in said} == {(odd, "error")}


def test_a_spec_is_there_for_every_file() -> None:
    """What it holds files to does not ask who names them."""
    Path("r/train.py").write_text("FILE = 'one.urdf'\n")
    Path("r/one.yaml").write_text("actspec: 1\nrobot: {name: one, model: models/one.urdf}\n")
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.WARNING}


@pytest.mark.parametrize("name", ["two arms", "zw\u00f6lf", "\udcff"])
def test_a_name_with_a_space_or_beyond_ascii(name: str) -> None:
    """It is looked for as it is."""
    Path("r/models/two.urdf").rename(f"r/models/{name}.urdf")
    Path("r/train.py").write_text("FILE = 'one.urdf'\n")
    assert severities("r") == {"one": Severity.WARNING, name: Severity.INFO}
    Path("r/train.py").write_bytes(b"FILE = 'one.urdf', 'models/" + os.fsencode(name) + b".urdf'\n")
    assert severities("r") == {"one": Severity.WARNING, name: Severity.WARNING}


def test_launch_files_of_an_exporter() -> None:
    """Both stand beside what a CAD program exported; where programs run other models, nobody runs them."""
    for name in ("display", "gazebo"):
        Path(f"r/{name}.launch").write_text('<launch><param textfile="$(find dog)/two.urdf"/></launch>')
    assert severities("r") == {"one": Severity.INFO, "two": Severity.WARNING}
    Path("r/train.py").write_text("FILE = 'one.urdf'\n")
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.INFO}
    Path("r/display.launch").unlink()
    assert severities("r") == {"one": Severity.WARNING, "two": Severity.WARNING}


@pytest.mark.parametrize("used", [True, False])
def test_what_only_an_idle_configuration_names(used: bool) -> None:
    """Nobody runs it either."""
    text = one_config("DOG_CFG")
    Path("r/dog.py").write_text(text.replace("ArticulationCfg(act", "ArticulationCfg(spawn='two.urdf', act"))
    Path("r/run.py").write_text("FILE = 'one.urdf'\n" + "from dog import DOG_CFG\nrun(DOG_CFG)\n" * used)
    two = Severity.WARNING if used else Severity.INFO
    assert severities("r") == {"one": Severity.WARNING, "two": two, "dog": two}


def test_a_model_that_nothing_drives() -> None:
    """In a folder it is there to be seen; by name, or with a configuration that gives it actuators, it is not."""
    model = """<mujoco><worldbody><body>
    <joint name="left_knee" actuatorfrcrange="-36 36"/><joint name="right_knee" axis="0 1 0" actuatorfrcrange="-30 30"/>
    <geom size="0.1"/></body></worldbody></mujoco>"""
    for path in Path("r/models").iterdir():
        path.unlink()
    Path("r/models/dog.xml").write_text(model)
    assert severities("r") == {"dog": Severity.INFO}
    assert severities("r/models/dog.xml") == {"dog": Severity.WARNING}
    Path("r/dog.py").write_text(CONFIGS.format(one="DOG_CFG", two="DOG_2_CFG").replace("20.0", "10.0"))
    assert severities("r") == {"dog": Severity.INFO}
    Path("r/dog.py").write_text(
        "from mjlab.actuator import BuiltinPositionActuatorCfg\nfrom mjlab.entity import EntityArticulationInfoCfg\n"
        'KNEES = BuiltinPositionActuatorCfg(target_names_expr=(".*_knee",), stiffness=10.0, damping=1.0)\n'
        "DOG_ARTICULATION = EntityArticulationInfoCfg(actuators=(KNEES,))\n"
    )
    assert severities("r") == {"dog": Severity.WARNING}


def test_what_an_mjcf_was_made_of() -> None:
    """An exporter's limits of the URDF are nobody's where the MJCF has its own and no configuration takes the URDF."""
    joint = """<joint name="{}" type="revolute"><parent link="base"/><child link="{}"/>
    <limit lower="-1" upper="1" effort="10" velocity="10"/></joint>"""
    for path in Path("r/models").iterdir():
        path.unlink()
    joints = "".join(joint.format(n, side) for n, side in (("hip", "left"), ("knee", "right")))
    Path("r/models/dog.urdf").write_text(
        f'<robot name="dog"><link name="base"/><link name="left"/><link name="right"/>{joints}</robot>'
    )
    Path("r/models/dog.xml").write_text(
        '<mujoco model="dog"><worldbody><body><joint name="hip"/><joint name="knee" axis="0 1 0"/><geom size="0.1"/>'
        '</body></worldbody><actuator><position joint="hip" kp="9" forcerange="-3 3"/>'
        '<position joint="knee" kp="9" forcerange="-3 3"/></actuator></mujoco>'
    )
    Path("r/models/dog_cfg.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        'DOG_CFG = ArticulationCfg(actuators={"legs": ImplicitActuatorCfg(joint_names_expr=["hip", "knee"],\n'
        "    stiffness=9.0, damping=1.0, effort_limit_sim=3.0)})\n"
    )
    files = ["r/models/dog.urdf", "r/models/dog_cfg.py"]
    found = audit(files, Settings(select=("LIM101",))).findings
    assert {item.severity for item in found} == {Severity.INFO}
    Path("r/models/dog_cfg.py").unlink()
    files = ["r/models/dog.urdf", "r/models/dog.xml"]
    for named, severity in ((["r"], Severity.INFO), (files, Severity.WARNING)):
        found = audit(named, Settings(select=("LIM101",))).findings
        assert {item.severity for item in found} == {severity}


@pytest.mark.parametrize(("named", "severity"), [("r/dog.py", "error"), ("r", "info")])
def test_a_key_that_no_joint_of_its_group_can_have(named: str, severity: str) -> None:
    """Without a model it is said aloud of a file that is named alone: the keys of a stranger's are his own affair."""
    Path("r/dog.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        "from isaaclab.assets import ArticulationCfg\n"
        'LEGS = ImplicitActuatorCfg(joint_names_expr=["knee"], stiffness={"kene": 20.0}, damping=1.0)\n'
        'DOG_CFG = ArticulationCfg(actuators={"legs": LEGS})\n'
    )
    found = audit([named], Settings(select=("ORD104", "CFG101"))).findings
    assert [(item.finding.code, item.severity.value) for item in found] == [("ORD104", severity)]


@pytest.mark.parametrize(
    ("program", "severity"),
    [
        ("env.robot = ROBOT_CFG.replace(prim_path='/World/Robot')\n", Severity.WARNING),
        (
            "env.robot = ANY_CFG.replace(prim_path='/World', init=init(q), actuators=actuators)\n",
            Severity.INFO,
        ),
        (
            "env.robot = DOG.replace(actuators={'legs': DOG.actuators['legs'].replace(damping=1)})\n",
            Severity.WARNING,
        ),
    ],
)
def test_actuators_that_a_program_makes(program: str, severity: Severity) -> None:
    """What puts actuators of its own into any configuration has their limits from elsewhere. 50 is 1.41 times 35.55."""
    Path("r/go1.py").write_text(go1_config())
    Path("r/run.py").write_text(f"from go1 import GO1_CFG\nuse(GO1_CFG)\n{program}")
    found = audit(["r"], Settings(select=("KNW101",))).findings
    assert {item.severity for item in found} == {severity}


@pytest.mark.parametrize(
    ("lines", "noted"),
    [
        (['self.scene.robot.actuators["legs"].effort_limit = {".*": 23.7}'], {"KNW101"}),
        (['self.robot.actuators["legs"].effort_limit_sim = 23.7'], {"KNW101"}),
        (['robot.actuators["legs"].velocity_limit *= 0.5'], {"KNW103"}),
        (["for leg in self.robot.actuators.values():", "    leg.damping = 0.5"], {"UNT107"}),
        (
            [
                "for name, leg in self.robot.actuators.items():",
                "    leg.armature = 0",
                "    leg.stiffness = 20.0",
            ],
            {"KNW103", "UNT107"},
        ),
        # It reads them, or sets what they lean on of nothing.
        (["for leg in self.robot.actuators.values():", "    low = leg.effort_limit == 1"], set()),
        (["for leg in self.robot.actuators.values():", "    foot.damping = 1"], set()),
        (['assert self.robot.actuators["legs"].effort_limit == 50.0'], set()),
        (['self.robot.actuators["legs"].friction = 0.1'], set()),
    ],
)
def test_a_figure_of_actuators_that_a_task_sets(lines: list[str], noted: set[str]) -> None:
    """Isaac Lab's tasks set figures of the robot's groups in their `__post_init__`.

    50 N*m is 1.41 times 35.55, 60 rad/s 2 times 30, and 5 N*m*s/rad beside 2 N*m/rad come back in 2.5 s.
    """
    text = go1_config().replace("effort_limit_sim=50.0", "effort_limit_sim=50.0, velocity_limit_sim=60.0")
    Path("r/go1.py").write_text(
        text.replace("stiffness=20.0", "stiffness=2.0").replace("damping=1.0", "damping=5.0")
    )
    body = "\n".join(f"        {line}" for line in lines)
    Path("r/task.py").write_text(
        f"from go1 import GO1_CFG\nclass Task:\n    robot = GO1_CFG\n    def __post_init__(self):\n{body}\n"
    )
    for code in ("KNW101", "KNW103", "UNT107"):
        found = audit(["r"], Settings(select=(code,))).findings
        severity = Severity.INFO if code in noted else Severity.WARNING
        assert {item.severity for item in found} == {severity}


def test_a_class_without_a_figure_that_a_program_replaces() -> None:
    """A DC motor that is never made needs no line."""
    text = go1_config().replace("ImplicitActuatorCfg", "DCMotorCfg")
    Path("r/go1.py").write_text(
        text.replace("effort_limit_sim=50.0", "effort_limit=50.0, velocity_limit=9.0")
    )
    Path("r/run.py").write_text("from go1 import GO1_CFG\nuse(GO1_CFG)\n")

    def severities() -> set[str]:
        return {item.severity.value for item in audit(["r"], Settings(select=("CFG104",))).findings}

    assert severities() == {"error"}
    Path("r/run.py").write_text("from go1 import GO1_CFG\nuse(GO1_CFG.replace(actuators=MOTORS))\n")
    assert severities() == {"info"}
    task = "from go1 import GO1_CFG\ndef task():\n    robot = GO1_CFG.copy()\n"
    for line, severity in (("saturation_effort = 60.0", "info"), ("armature = 0.01", "error")):
        Path("r/run.py").write_text(f"{task}    robot.actuators['legs'].{line}\n    return robot\n")
        assert severities() == {severity}


@pytest.mark.parametrize(
    ("cls", "speed", "severity"),
    [
        ("IdealPD", 60.0, "info"),
        ("DelayedPD", 60.0, "info"),
        ("Implicit", 60.0, "warning"),
        # 57.3 times 28.
        ("IdealPD", '{".*_[ht][a-z]+_joint": 28.0, ".*_calf_joint": 1604.3}', "warning"),
    ],
)
def test_a_speed_that_an_ideal_pd_does_not_look_at(cls: str, speed: object, severity: str) -> None:
    """The solver's bound beside it is to be beyond the motor's 30 rad/s."""
    text = go1_config().replace("ImplicitActuator", f"{cls}Actuator")
    Path("r/go1.py").write_text(
        text.replace("effort_limit_sim=50.0", f"effort_limit=23.7, velocity_limit_sim={speed}")
    )
    found = audit(["r"], Settings(select=("KNW103",))).findings
    assert {item.severity.value for item in found} == {severity}


@pytest.mark.parametrize(
    ("cls", "severity"), [("DCMotorCfg", "info"), ("MotorCfg", "error"), ("MyDCMotorCfg", "error")]
)
def test_a_framework_that_the_folder_has_in_it(cls: str, severity: str) -> None:
    """Somebody's copy of Isaac Lab may have other fields: here `motor`."""
    text = go1_config().replace("ImplicitActuatorCfg", "DCMotorCfg")
    Path("r/go1.py").write_text(text.replace("effort_limit_sim=50.0", "motor=5"))
    Path("r/isaaclab").mkdir()
    Path("r/isaaclab/actuator_cfg.py").write_text(f"class {cls}(ActuatorBaseCfg):\n    motor: int = 0\n")
    found = audit(["r"], Settings(select=("CFG103", "CFG104"))).findings
    sure = {item.severity.value for item in found if item.finding.about != "effort_limit"}
    assert {item.finding.code for item in found} == {"CFG103", "CFG104"}
    assert sure == {severity}


@pytest.mark.parametrize(
    ("group", "gains", "severity"),
    [
        ("legs", "stiffness=100.0, damping=5.0", Severity.WARNING),
        ("locked_joints", "stiffness=500.0, damping=50.0", Severity.INFO),
        # A program computes the torque, and clips it.
        ("legs", "stiffness=0.0, damping=0.0", Severity.INFO),
        # They are not held, and their damping is the drive's.
        ("unblocked", "stiffness=0.0, damping=5.0", Severity.WARNING),
    ],
)
def test_joints_that_are_held_or_take_a_torque(group: str, gains: str, severity: Severity) -> None:
    """50 N*m is 1.41 times a Go1's largest."""
    text = go1_config().replace("stiffness=20.0", gains).replace(", damping=1.0)", ")")
    Path("r/go1.py").write_text(text.replace("legs", group))
    Path("r/run.py").write_text("from go1 import GO1_CFG\nuse(GO1_CFG)\n")
    found = audit(["r"], Settings(select=("KNW101",))).findings
    assert {item.severity for item in found} == {severity}


_STEPPED = "m = MjModel.from_xml_path('arm.xml')\nmujoco.mj_step(m, d)\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("programs", "severity"),
    [
        (
            ["m = MjModel.from_xml_path('arm.xml')\nm.opt.integrator = 2\nmujoco.mj_step(m, d)\n"],
            Severity.INFO,
        ),
        (
            [
                "s = MjSpec.from_file('arm.xml')\ns.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST\n"
            ],
            Severity.INFO,
        ),
        (["m = MjModel.from_xml_path('arm.xml')\nmujoco.mj_step(m, d)\n"], Severity.ERROR),
        # RK4 is as explicit, and what is compared or commented out is not set.
        (["m = MjModel.from_xml_path('arm.xml')\nm.opt.integrator = 1\n"], Severity.ERROR),
        (["m = MjModel.from_xml_path('arm.xml')\nassert m.opt.integrator == 2\n"], Severity.ERROR),
        (["m = MjModel.from_xml_path('arm.xml')\n# m.opt.integrator = 2\n"], Severity.ERROR),
        # Another program takes the file as it is, and one that steps nothing looks at it.
        (
            [
                "m = MjModel.from_xml_path('arm.xml')\nm.opt.integrator = 2\nmujoco.mj_step(m, d)\n",
                "m = MjModel.from_xml_path('arm.xml')\nmujoco.mj_step(m, d)\n",
            ],
            Severity.ERROR,
        ),
        (
            [
                "m = MjModel.from_xml_path('arm.xml')\nm.opt.integrator = 2\nmujoco.mj_step(m, d)\n",
                "m = MjModel.from_xml_path('arm.xml')\nprint(m.njnt)\n",
            ],
            Severity.INFO,
        ),
        (["arm = mjcf.from_path('arm.xml')\narm.option.integrator = 'implicitfast'\n"], Severity.INFO),
        (["ET.SubElement(root, 'option', {'integrator': 'implicitfast'})\n"], Severity.INFO),
        (['XML = \'<option integrator="implicit"/><include file="arm.xml"/>\'\n'], Severity.INFO),
        (["arm.option.integrator = 'RK4'\n"], Severity.ERROR),
        # Step, gains and inertia; a draw about what was there, and what is only read, are no other ones.
        ([f"{_STEPPED}m.opt.timestep = 1e-4\n"], Severity.INFO),
        ([f"{_STEPPED}n = 0.02 / m.opt.timestep\nassert m.opt.timestep == 0.01\n"], Severity.ERROR),
        # What another program does to its own model, and what a module does to the one that it is given.
        ([f"{_STEPPED}m.opt.timestep = 1e-4\n", _STEPPED], Severity.ERROR),
        ([_STEPPED, "model.opt.timestep = 1e-4\n"], Severity.INFO),
        ([f"{_STEPPED}m.actuator_gainprm[i, 0] = KP\n"], Severity.INFO),
        ([f"{_STEPPED}m.dof_armature[:] = 0.1\n"], Severity.INFO),
        ([f"{_STEPPED}m.dof_armature[:] = base * draw()\n"], Severity.ERROR),
        # What carries a tool, and what another simulator steps.
        (["arm = MjSpec.from_file('arm.xml')\narm.attach(hand, site='tool')\n"], Severity.INFO),
    ],
)
def test_an_integrator_that_programs_write_over(programs: list[str], severity: Severity) -> None:
    """h kd/I = 0.01 x 5 / 0.02 = 2.5 under Euler, where 2 diverges."""
    _write_leg_of_euler()
    for number, program in enumerate(programs):
        Path(f"arm/run_{number}.py").write_text(f"import mujoco\n{program}")
    found = audit(["arm"], Settings(select=("STB101",))).findings
    assert [item.severity for item in found] == [severity]


@pytest.mark.parametrize(
    ("program", "severity"),
    [
        ("from isaacgym import gymapi\n", Severity.INFO),
        ("from brax.io import mjcf\n", Severity.INFO),
        ("from isaacgym import gymapi\nimport mujoco\n", Severity.ERROR),
        ("print('arm.xml')\n", Severity.ERROR),
    ],
)
def test_an_mjcf_of_another_simulator(program: str, severity: Severity) -> None:
    """MuJoCo's Euler never steps it; who has no program at all has MuJoCo's."""
    _write_leg_of_euler()
    Path("arm/run.py").write_text(f"{program}FILE = 'arm.xml'\n")
    found = audit(["arm"], Settings(select=("STB101",))).findings
    assert [item.severity for item in found] == [severity]


def _write_leg_of_euler() -> None:
    Path("arm").mkdir()
    Path("arm/arm.xml").write_text(
        '<mujoco><option timestep="0.01"/><worldbody><body><joint name="knee" armature="0.01"/>'
        '<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body></worldbody>'
        '<actuator><position joint="knee" kp="100" kv="5"/></actuator></mujoco>'
    )


@pytest.mark.parametrize(
    ("program", "severity"),
    [
        ('xml["mujoco"].setdefault("compiler", {}).update({"@angle": "radian"})', "info"),
        ('root.find("compiler").set("angle", "radian")', "info"),
        ("spec.compiler.degree = 0", "info"),
        ("spec.compiler.degree = 1", "warning"),
        ('# xml["compiler"] = {"@angle": "radian"}', "warning"),
        ("""TEXT = '<compiler angle="radian"/><include file="arm.xml"/>'""", "info"),
        ("MyArm(xml_path_completion('arm/arm.xml'))", "info"),
        # What it writes of its own is another file.
        ("""print('<compiler angle="radian"/>')""", "warning"),
        ("", "warning"),
    ],
)
@pytest.mark.parametrize("compiler", ["", '<compiler autolimits="true"/>', '<compiler angle="degree"/>'])
def test_an_angle_that_a_program_sets(program: str, severity: str, compiler: str) -> None:
    """Whoever audits the folder as named gets the model with the angle, too; one that states its own has that.

    1.57 degrees are 0.0274 rad, of all three hinges.
    """
    Path("arm").mkdir()
    hinges = "".join(f'<body><geom size="0.1"/><joint name="{n}" range="-1.57 1.57"/></body>' for n in "abc")
    motors = "".join(f'<motor joint="{n}" ctrlrange="-5 5"/>' for n in "abc")
    Path("arm/arm.xml").write_text(
        f'<mujoco>{compiler}<option timestep="0.01"/><worldbody>{hinges}</worldbody>'
        f"<actuator>{motors}</actuator></mujoco>"
    )
    Path("arm/load.py").write_text(f"import mujoco\nFILE = 'arm/arm.xml'\n{program}\n")
    for settings in (Settings(), Settings(as_named=True)):
        (found,) = audit(["arm"], replace(settings, select=("UNT101",))).findings
        assert found.severity.value == ("warning" if "angle" in compiler else severity)
        said = found.finding.message.endswith(", unless what includes or loads it has the angle")
        assert said == (found.severity.value == "info")


@pytest.mark.parametrize(
    ("program", "severity"),
    [
        ("m.jnt_range[:] = LIMITS", "info"),
        ("m.jnt_limited[:] = 0", "info"),
        ("m.actuator_ctrlrange[:] = np.deg2rad(m.actuator_ctrlrange)", "info"),
        ("low, high = m.jnt_range.T", "warning"),
        ("assert m.actuator_ctrlrange[0, 1] == 90", "warning"),
    ],
)
def test_a_range_that_a_program_sets(program: str, severity: str) -> None:
    """90 is 57.3 times 1.5708, the joint's 90 degrees."""
    Path("arm").mkdir()
    Path("arm/arm.xml").write_text(
        '<mujoco><compiler angle="degree"/><worldbody><body><geom size="0.1"/><joint name="a" range="-90 90"/></body>'
        '</worldbody><actuator><position joint="a" kp="9" ctrlrange="-90 90"/></actuator></mujoco>'
    )
    Path("arm/load.py").write_text(f"import mujoco\nFILE = 'arm/arm.xml'\n{program}\n")
    (found,) = audit(["arm"], Settings(select=("UNT101",))).findings
    assert found.severity.value == severity


@pytest.mark.parametrize(
    "text",
    [
        b"tau = np.clip(",
        b"tau",
        b".replace(",
        b"tau_",
        b"x.clip(",
        b"x.clip(x,",
        b"x.clip(x,-a.",
        b" x.actuators[",
        b" for x in x.actuators.values():",
        b"\n for x in x.actuators.values():\n x",
        b"dof_damping[",
        b"m.dof_damping = x * ",
        b").damping[0] ",
        b"j.damping",
        b'props["damping"][',
        b"actuator_gainprm[i][",
        b"<compiler angle ",
        b'integrator"] ',
        b"import a ",
        b"opt.integrator = ",
        b" x.replace(actuators={",
        b" x.replace(stiffness ",
        b" x = x.actuators[a]\n",
        b"d_gains[a] * (a ",
        b"d_gains[",
        b"ArticulationAction(a",
        b"x.replace('a",
        b"\nclass A:\n x.events.a ",
        b"x.events.a.params[",
    ],
)
def test_a_line_of_a_megabyte(text: bytes) -> None:
    """Strangers' files have such lines; gone through once for each beginning on it, this takes half an hour."""
    program = b"import mujoco\n" + text * (1_000_000 // len(text))
    assert written_over((program,), simulators_of(program)) == {"urdf_limit"}


CONTROLLER = "PDJointPosControllerConfig(['pan', 'lift'], stiffness=1e3, damping=1e2, force_limit=100)\n"


@pytest.mark.parametrize(
    ("program", "severity"),
    [
        ("self.torque_limits *= self.cfg.control.torque_limits\n", Severity.INFO),
        ("self.torque_limits[i] = props['effort'][i]\n", Severity.WARNING),
        ("props['effort'][i] = self.cfg.control.all_effort[i]\n", Severity.INFO),
        ('dof_props["effort"].fill(200.0)\n', Severity.INFO),
        ("if props['effort'][i] == 0.0:\n    pass\n", Severity.WARNING),
        # The fingers of a gripper.
        ("props['effort'][7] = 200\n", Severity.WARNING),
        ("data.ctrl[:] = np.clip(kp * (q - p), -23.7, 23.7)\n", Severity.INFO),
        ("tau = np.clip(tau, -1.0 * self._max_torque, self._max_torque)\n", Severity.INFO),
        ("clip_torques = 6.0\n", Severity.INFO),
        ("tau = self.clip_torques(tau)\n", Severity.WARNING),
        ("tau = torch.clip(tau, -self.torque_limits, self.torque_limits)\n", Severity.WARNING),
        # Another program's force of each command, and kinematics, say nothing of the trainer.
        ("p.setJointMotorControl2(dog, 0, p.TORQUE_CONTROL, force=9)\n", Severity.WARNING),
        ("pinocchio.buildModelFromUrdf('go1.urdf')\n", Severity.WARNING),
        # ManiSkill's controllers give every drive its largest force; Bullet and SAPIEN alone say nothing of it.
        (f"from mani_skill.agents.controllers import *\n{CONTROLLER}", Severity.INFO),
        (f"import sapien.core as sapien\n{CONTROLLER}", Severity.INFO),
        ("from mani_skill.agents.base_agent import BaseAgent\n", Severity.WARNING),
        (f"import pybullet\n{CONTROLLER}", Severity.WARNING),
    ],
)
def test_effort_of_a_urdf_that_a_trainer_has_not(program: str, severity: Severity) -> None:
    """Forks of legged_gym have limits of their own, or clip at a number."""
    write_go1()
    Path("r/run.py").write_text(f"import isaacgym\nasset('go1.urdf')\n{program}")
    assert of_published("r") == {("go1.urdf", severity)}


def legs(name: str, cls: str, limit: str) -> str:
    """A configuration of Isaac Lab that drives every joint of go1.usd."""
    return (
        f"{name} = ArticulationCfg(spawn=UsdFileCfg(usd_path='usd/go1.usd'), actuators={{'legs': {cls}(\n"
        f"    joint_names_expr=['.*_joint'], stiffness=9.0, damping=1.0, {limit})}})\n"
    )


def write_trained(configs: str) -> None:
    """A URDF with an A1's limits, and the configurations of its robot."""
    write_go1()
    Path("r/isaaclab").mkdir()
    Path("r/train.py").write_text("from isaaclab import robots\nSOURCE = 'models/go1.urdf'\nrun(robots)\n")
    head = "from isaaclab.actuators import DCMotorCfg, IdealPDActuatorCfg, ImplicitActuatorCfg\n"
    Path("r/isaaclab/robots.py").write_text(
        f"{head}from isaaclab.assets import ArticulationCfg\nfrom isaaclab.sim import UsdFileCfg\n{configs}"
    )


@pytest.mark.parametrize(
    ("configs", "severity"),
    [
        (legs("GO1_CFG", "ImplicitActuatorCfg", "effort_limit_sim=15.0"), Severity.INFO),
        (legs("GO1_CFG", "ImplicitActuatorCfg", "effort_limit=15.0"), Severity.INFO),
        (legs("GO1_CFG", "IdealPDActuatorCfg", "effort_limit=15.0"), Severity.INFO),
        # Later versions of Isaac Lab clip an explicit drive without effort_limit at the USD's, as CFG104 says.
        (legs("GO1_CFG", "IdealPDActuatorCfg", "effort_limit_sim=15.0"), Severity.WARNING),
        (legs("GO1_CFG", "ImplicitActuatorCfg", ""), Severity.WARNING),
        (
            legs("GO1_CFG", "ImplicitActuatorCfg", "effort_limit_sim=15.0")
            + legs("GO1_SOFT_CFG", "ImplicitActuatorCfg", "effort_limit_sim=9.0"),
            Severity.INFO,
        ),
        (
            legs("GO1_CFG", "ImplicitActuatorCfg", "effort_limit_sim=15.0")
            + legs("GO1_SOFT_CFG", "ImplicitActuatorCfg", ""),
            Severity.WARNING,
        ),
        # Called after no robot, and no other model is there.
        (
            legs("MY_ROBOT_CFG", "DCMotorCfg", "effort_limit=15.0").replace("go1.usd", "my_robot.usd")
            + legs("MY_FIXED_CFG", "DCMotorCfg", "effort_limit=15.0").replace("go1.usd", "my_robot.usd"),
            Severity.INFO,
        ),
    ],
)
def test_an_effort_of_a_urdf_that_configurations_write_over(configs: str, severity: Severity) -> None:
    """Isaac Lab makes a USD of the URDF, and gives its joints the limit of the configuration."""
    write_trained(configs)
    assert of_published("r") == {("go1.urdf", severity)}
    assert of_published("r/models/go1.urdf", "r/isaaclab/robots.py") == {("go1.urdf", Severity.WARNING)}


@pytest.mark.parametrize(
    ("cls", "limits", "severity"),
    [
        ("ImplicitActuatorCfg", "effort_limit_sim=23.7, velocity_limit_sim=30.0", "info"),
        ("ImplicitActuatorCfg", "effort_limit_sim=23.7", "warning"),
        # An ideal PD does not look at it, and the solver has the USD's.
        ("IdealPDActuatorCfg", "effort_limit=23.7, velocity_limit=30.0", "warning"),
    ],
)
def test_a_speed_of_a_urdf_that_configurations_write_over(cls: str, limits: str, severity: str) -> None:
    """80 rad/s are 2.66 times a Go1's 30.1, and beyond twice them."""
    write_trained(legs("GO1_CFG", cls, limits))
    path = Path("r/models/go1.urdf")
    path.write_text(path.read_text().replace('velocity="20"', 'velocity="80"'))
    for as_named in (False, True):
        found = audit(["r"], Settings(select=("KNW103",), as_named=as_named)).findings
        mine = {item.severity.value for item in found if item.finding.span.path.endswith(".urdf")}
        assert mine == {"warning" if as_named else severity}


@pytest.mark.parametrize(
    ("limit", "severity"), [("effort_limit_sim=23.7", "info"), ("velocity_limit_sim=30.0", "error")]
)
def test_a_zero_of_a_urdf_that_configurations_write_over(limit: str, severity: str) -> None:
    """110 N*m on one side and 0 on the other are no limit of a drive that has its own."""
    write_trained(legs("GO1_CFG", "ImplicitActuatorCfg", limit))
    path = Path("r/models/go1.urdf")
    before, name, after = path.read_text().partition('joint name="FR_calf_joint"')
    path.write_text(before + name + after.replace('effort="110"', 'effort="0"', 1))
    for as_named in (False, True):
        found = audit(["r"], Settings(select=("SYM101",), as_named=as_named)).findings
        assert {item.severity.value for item in found} == {"error" if as_named else severity}


def test_an_effort_of_a_urdf_that_legged_gym_takes_too() -> None:
    """A configuration of Isaac Lab that has its own limit does not speak for the one that clips at the URDF's."""
    write_trained(legs("GO1_CFG", "ImplicitActuatorCfg", "effort_limit_sim=15.0"))
    Path("r/go1_config.py").write_text(
        "class Go1Cfg(LeggedRobotCfg):\n    class control(LeggedRobotCfg.control):\n"
        '        control_type = "P"\n        stiffness = {"joint": 40.0}\n        damping = {"joint": 5.5}\n'
        "    class asset(LeggedRobotCfg.asset):\n        file = 'models/go1.urdf'\n"
    )
    Path("r/play.py").write_text("from go1_config import Go1Cfg\nrun(Go1Cfg())\n")
    assert of_published("r") == {("go1.urdf", Severity.WARNING)}


@pytest.mark.parametrize(
    ("name", "program", "severity"),
    [
        ("run.py", "load('go1.urdf')\n", Severity.INFO),
        ("view.launch", '<launch><param textfile="$(find dog)/models/go1.urdf"/></launch>', Severity.INFO),
        ("run.py", "from isaacgym import gymapi\nload('go1.urdf')\n", Severity.WARNING),
        ("run.py", "# isaacgym\nload('go1.urdf')\n", Severity.INFO),
        ("run.py", "load('go1.urdf')\nself.torque_limits[i] = props['effort'][i].item()\n", Severity.WARNING),
        ("run.py", "import pinocchio\nload('go1.urdf')\nmost = model.effortLimit\n", Severity.WARNING),
        ("run.jl", 'parse_urdf("go1.urdf")\n[b.upper for b in effort_bounds(joint)]\n', Severity.WARNING),
        ("notes.md", "isaacgym\n", Severity.INFO),
    ],
)
def test_a_limit_of_a_urdf_that_no_trainer_takes(name: str, program: str, severity: Severity) -> None:
    """Where it is no drive's limit, a URDF is there for its links; whoever names it wants to know."""
    write_go1()
    Path("r", name).write_text(program)
    assert of_published("r") == {("go1.urdf", severity)}
    assert of_published("r/models/go1.urdf") == {("go1.urdf", Severity.WARNING)}


@pytest.mark.parametrize(
    ("named", "as_named", "severity"),
    [
        (["r"], False, Severity.INFO),
        (["r"], True, Severity.WARNING),
        (["r/leg.xml", "r/leg_config.py"], False, Severity.WARNING),
    ],
)
def test_an_explicit_drive_in_a_folder(named: list[str], as_named: bool, severity: Severity) -> None:
    """(5e-3 * 5.5 + 25e-6 * 20) / 0.01 = 2.8, where 2 diverges; what else sets an armature there, nobody sees."""
    Path("r/leg.xml").write_text(
        '<mujoco model="leg"><worldbody><body><joint name="knee"/>'
        '<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body></worldbody></mujoco>'
    )
    Path("r/leg_config.py").write_text(
        "class LegCfg(LeggedRobotCfg):\n    class control(LeggedRobotCfg.control):\n"
        '        control_type = "P"\n        stiffness = {"knee": 40.0}\n        damping = {"knee": 5.5}\n'
        "        decimation = 4\n    class sim:\n        dt = 0.005\n"
    )
    found = audit(named, Settings(select=("STB102",), as_named=as_named)).findings
    assert [(item.finding.span.path, item.severity) for item in found] == [("r/leg_config.py", severity)]


@pytest.mark.parametrize(("step", "figure"), [(0.001, None), (0.004, 2.24)])
def test_gains_that_a_class_with_a_shorter_step_inherits(step: float, figure: float | None) -> None:
    """It is what is run: (4e-3 * 5.5 + 16e-6 * 20) / 0.01 = 2.23, in the base 2.8; with 1 ms 0.55, which is quiet."""
    Path("r/leg.xml").write_text(
        '<mujoco model="leg"><worldbody><body><joint name="knee"/>'
        '<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body></worldbody></mujoco>'
    )
    Path("r/leg_config.py").write_text(
        "class LegCfg(LeggedRobotCfg):\n    class control(LeggedRobotCfg.control):\n"
        '        control_type = "P"\n        stiffness = {"knee": 40.0}\n        damping = {"knee": 5.5}\n'
        "        decimation = 4\n    class sim:\n        dt = 0.005\n\n"
        f"class LegRunCfg(LegCfg):\n    class sim:\n        dt = {step}\n"
    )
    found = audit(["r"], Settings(select=("STB102",))).findings
    assert [item.finding.value for item in found] == (
        [] if figure is None else [pytest.approx(figure, abs=0.01)]
    )


@pytest.mark.parametrize(
    ("tasks", "idle"),
    [
        ("task_registry.register('leg', Robot, LegCfg(), LegCfgPPO())\n", {"dog"}),
        ("task_registry.register('dog', Robot, DogCfg(), DogCfgPPO())\n", {"leg"}),
        # Where nothing of them is registered, somebody else registers.
        ("# task_registry.register('leg', Robot, LegCfg())\nregister(CatCfg)\n", set()),
        (
            "class Rough(LegCfg):\n    pass\nclass Rougher(Rough):\n    pass\n"
            "task_registry.register('dog', Robot, DogCfg())\ntask_registry.register('leg', Robot, Rougher())\n",
            set(),
        ),
    ],
    ids=["its own", "another's", "none", "as a base"],
)
def test_a_task_that_is_not_registered(tasks: str, idle: set[str]) -> None:
    """legged_gym runs what is registered, and what that inherits from."""
    for name in ("Leg", "Dog"):
        Path(f"r/{name.lower()}_config.py").write_text(
            f"class {name}Cfg(LeggedRobotCfg):\n    class control(LeggedRobotCfg.control):\n"
            '        control_type = "P"\n        stiffness = {"knee": 40.0}\n        damping = {"knee": 5.5}\n'
        )
    Path("r/envs.py").write_text(f"from leg_config import *\nfrom dog_config import *\n{tasks}")
    read = read_files(["r"])
    assert {Path(file.path).stem for file in read if file.idle} == {f"{name}_config" for name in idle}


@pytest.mark.parametrize("folder", ["externals", "third_party", "franka_pinocchio", "test_assets"])
def test_folders_of_others(folder: str) -> None:
    """What lies there is somebody else's, or for kinematics."""
    Path(f"r/{folder}").mkdir()
    Path("r/models/one.urdf").rename(f"r/{folder}/one.urdf")
    assert severities("r") == {"one": Severity.INFO, "two": Severity.WARNING}


def test_zero_on_both_sides_is_no_limit_on_one() -> None:
    """Whoever left a limit at 0 on both sides looked up neither; where one side alone has 0, it has no torque."""
    hip = JOINT.replace("_knee", "_hip").replace('child link="{side}"', 'child link="{side}_hip"')
    for name, effort in (("one", 0), ("two", 7)):
        joints = JOINT.format(side="left", effort=20) + JOINT.format(side="right", effort=0)
        joints += hip.format(side="left", effort=effort) + hip.format(side="right", effort=effort)
        links = "".join(
            f'<link name="{link}"/>' for link in ("base", "left", "right", "left_hip", "right_hip")
        )
        Path(f"r/models/{name}.urdf").write_text(f'<robot name="{name}">{links}{joints}</robot>')
    assert severities("r") == {"one": Severity.INFO, "two": Severity.ERROR}


@pytest.mark.parametrize(
    ("names", "severity"), [(("leg", "leg"), Severity.ERROR), (("leg", "leg_pro"), Severity.INFO)]
)
def test_most_joints_times_off(names: tuple[str, str], severity: Severity) -> None:
    """Ten times the torque at every joint, of one robot by its own name: a slip, where somebody names both files."""
    for path in Path("r/models").iterdir():
        path.unlink()
    for file, name, effort in (("leg", names[0], 30), ("leg_b", names[1], 300)):
        joints = JOINT.format(side="left", effort=effort) + JOINT.format(side="right", effort=effort)
        Path(f"r/{file}.urdf").write_text(
            f'<robot name="{name}"><link name="base"/><link name="left"/><link name="right"/>{joints}</robot>'
        )
    found = audit(["r/leg.urdf", "r/leg_b.urdf"], Settings(select=("SRC101",))).findings
    assert {item.severity for item in found} == {severity}
    assert {item.finding.joint for item in found} == {"left_knee", "right_knee"}


def test_copies_of_a_file_that_departs() -> None:
    """Each is named, so that mending one of them leaves no new finding; a note names the first."""
    for path in Path("r/models").iterdir():
        path.unlink()
    for file, effort in (("leg", 30), ("leg_a", 5), ("leg_b", 5), ("leg_c", 5), ("leg_d", 20)):
        joints = JOINT.format(side="left", effort=effort) + JOINT.format(side="right", effort=30)
        Path(f"r/{file}.urdf").write_text(
            f'<robot name="leg"><link name="base"/><link name="left"/><link name="right"/>{joints}</robot>'
        )
    files = [f"r/{name}.urdf" for name in ("leg", "leg_a", "leg_b", "leg_c", "leg_d")]
    found = audit(files, Settings(select=("SRC101",))).findings
    assert sorted((Path(item.finding.span.path).stem, item.severity.value) for item in found) == [
        ("leg_a", "error"),
        ("leg_b", "error"),
        ("leg_c", "error"),
        ("leg_d", "info"),
    ]
