"""Which models of a folder its programs load: what is wrong in these is more than a note."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.read import read_files
from actspec.readings.loads import what_loads

MODEL = "<mujoco><worldbody><body><joint name='j'/><geom size='1'/></body></worldbody></mujoco>"
ALL = frozenset({"compiled", "step", "dynamics", "gains"})
LOADS = "import mujoco\nmodel = mujoco.MjModel.from_xml_path('arm.xml')\n"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    for name in ("arm", "leg"):
        Path(f"r/{name}.xml").write_text(MODEL)
    Path("r/run.py").write_text(LOADS)


def in_use() -> set[str]:
    """Names of the models of the folder that a program loads."""
    return {Path(file.path).stem for file in read_files(["r"]) if file.run}


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("files.json", '{"files": ["leg.xml", "arm.xml"]}'),
        ("a.py", '"""Formerly leg.xml."""\n'),
        ("a.py", "def f():\n    '''\n    load('leg.xml')\n    '''\n"),
        ("a.py", "FILE = 'arm.xml'  # or 'leg.xml'\nload(FILE)\n"),
        ("a.yaml", "model: arm.xml # or leg.xml\n"),
        ("a.py", "print('written: leg.xml')\nlogger.info('leg.xml')\n"),
        ("a.py", "parser.add_argument('--model', help='such as leg.xml')\n"),
        ("a.py", "parser.add_argument(\n    'leg.xml',\n    required=True)\n"),
        ("a.py", "mujoco.mj_saveLastXML('leg.xml', model)\ntree.write('leg.xml')\n"),
        ("a.py", "if os.path.exists('leg.xml'):\n    os.remove('leg.xml')\n"),
        ("a.py", "OUT = 'leg.xml'\nwith open(OUT, 'w') as file:\n    file.write(text)\n"),
        ("a.py", "LEG = HERE / 'leg.xml'\nmodel = from_xml_string(LEG.read_text())\n"),
        ("a.py", "model = from_xml_string((HERE / 'leg.xml').read_text())\n"),
        ("a.py", "with open(join(dirname(abspath(__file__)), 'leg.xml')) as file:\n    text = file.read()\n"),
        ("a.py", "if not FILE:\n    raise FileNotFoundError('put leg.xml beside it')\n"),
        ("a.cpp", 'std::ifstream in("leg.xml");\nprintf("usage: sim leg.xml\\n"); std::cerr << "leg.xml";\n'),
        (
            "a.ipynb",
            '{"cells": [{"cell_type": "markdown", "source": ["`leg.xml` did not work"]},'
            ' {"cell_type": "code", "source": ["a = 1\\n", "#load(\\"leg.xml\\")\\n"],'
            ' "outputs": [{"text": ["loaded leg.xml"]}]}]}',
        ),
        ("a.sh", "urdf2mjcf robot.urdf -o leg.xml\nxacro a.xacro > leg.xml\n"),
        ("a.py", "FILE = '/opt/mujoco_menagerie/unitree_go2/leg.xml'\nload(FILE)\n"),
        ("mkdocs.yml", "nav:\n  - Leg: leg.xml\n"),
        ("pyproject.toml", '[tool.setuptools.package-data]\nx = ["leg.xml"]\n'),
    ],
)
def test_a_name_that_loads_nothing(name: str, text: str) -> None:
    """It is shown, written, opened as text, or of a file of elsewhere."""
    Path("r", name).write_text(text)
    assert in_use() == {"arm"}


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.py", 'A = """\nmodel\n"""\nFILE = "leg.xml"\nB = """\n"""\nload(FILE)\n'),
        ("a.py", "FILE = 'leg.xml'  # or cat.xml\nload(FILE)\n"),
        ("a.py", "COLOR = '  #fff'\nFILE = 'leg.xml'\nload(FILE)\n"),
        ("a.py", "FILE = 'leg.xml'\nprint(open(FILE).read())\nload(FILE)\n"),
        ("a.py", "FILE = 'leg.xml'\n"),
        ("a.py", "parser.add_argument('--model', default='leg.xml')\n"),
        ("a.yaml", "model: leg.xml\n"),
        ("a.ipynb", '{"cells": [{"cell_type": "code", "source": ["a = 1\\n", "load(\\"leg.xml\\")"]}]}'),
        ("a.cpp", 'out << name; sprintf(path, "leg.xml"); load(path);\n'),
        ("a.js", 'fs.writeFile("/srv/a", await (await fetch("leg.xml")).text());\n'),
        ("a.sh", "simulate leg.xml -o log.txt\n"),
        ("a.py", "load('assets/leg.xml')\n"),
        ("a.py", "load(os.path.join(ROOT, 'r', 'leg.xml'))\n"),
    ],
)
def test_a_name_that_loads_a_model(name: str, text: str) -> None:
    """Beside words that look like those that load none."""
    Path("r", name).write_text(text)
    assert in_use() == {"arm", "leg"}


@pytest.mark.parametrize(
    "text",
    [
        b"open(",
        b"print(a)",
        b" #",
        b'"',
        b'"""',
        b"'''\n",
        b"x='",
        b"help='",
        b" -o",
        b"OUT=1\n",
        b"open((a)",
        b"open((((",
        b"open((((a))",
        b" ",
    ],
)
def test_a_long_program(text: bytes) -> None:
    """Gone through once for each beginning, a line of a megabyte takes half an hour."""
    assert len(what_loads(".py", b"open(" + text * (1_000_000 // len(text)))) <= 1_000_005


@pytest.mark.parametrize(
    ("include", "program", "used"),
    [
        ("pole.xml", "", True),
        ("pole.xml", "open('pole.xml', 'w').write(POLE)\n", False),
        ("pole.xml", "ASSETS = {'parts/pole.xml': POLE}\n", False),
        ("pole.xml", "open('maypole.xml', 'w').write(POLE)\n", True),
        # With files that it hands over beside the model, or with the include itself; a plain one is read as it stands.
        ("pole.xml", "mujoco.MjModel.from_xml_string(text, assets=read(ROOT))\n", False),
        ("pole.xml", "mujoco.MjSpec.from_file(join(dirname(__file__), 'a'), assets=files)\n", False),
        ("pole.xml", "mujoco.MjModel.from_xml_string(file.read_text(), ASSETS)\n", False),
        ("pole.xml", "mujoco.MjModel.from_xml_path(path(model), {})\n", True),
        ("pole.xml", "mujoco.MjModel.from_xml_path(filename=path(model), assets=None)\n", True),
        ("pole.xml", "mujoco.MjModel.from_xml_path('assets/cat.xml')\n", True),
        ("pole.xml", 'lines.append("  <include file=\\"made_{}.xml\\"/>".format(os.getpid()))\n', False),
        ("pole.xml", 'lines.append("<include file=\\"other.xml\\"/>")\n', True),
        # Files of dm_control's suite, which it hands to MuJoCo itself.
        ("./common/skybox.xml", "from dm_control.suite import common\n", False),
        ("./common/skybox.xml", "common = 1\n", True),
        ("./commons/skybox.xml", "from dm_control.suite import common\n", True),
    ],
)
def test_an_include_that_a_program_brings(include: str, program: str, used: bool) -> None:
    """Nobody finds it here, and the program may have it."""
    Path("r/arm.xml").write_text(f'<mujoco><include file="{include}"/><worldbody/></mujoco>')
    Path("r/run.py").write_text(program + LOADS)
    assert in_use() == ({"arm"} if used else set())


@pytest.mark.parametrize(
    ("loads", "used"),
    [
        ("mujoco.MjModel.from_xml_string(read('arm.xml').replace('POLE', 'poles/a'))", False),
        ("mujoco.MjModel.from_xml_path('arm.xml')", True),
        ("mujoco.MjModel.from_xml_path('arm.xml')\nmujoco.MjModel.from_xml_string(FLOOR)", True),
    ],
)
def test_an_include_of_a_model_that_a_program_reads(loads: str, used: bool) -> None:
    """Of a text MuJoCo looks in the folder that the program works in, and the program may put another name there."""
    Path("r/arm.xml").write_text('<mujoco><include file="POLE.xml"/><worldbody/></mujoco>')
    Path("r/run.py").write_text(f"import mujoco\nmodel = {loads}\n")
    assert in_use() == ({"arm"} if used else set())


@pytest.mark.parametrize(
    ("ignored", "used"),
    [
        ("*.pyc\ngenerated/\n", False),
        ("/r/generated/*\n", False),
        ("/r/generated", False),
        ("*.xml\n!arm.xml\n# generated poles\n", True),
        ("generated_old/\n", True),
    ],
)
def test_an_include_that_git_ignores(ignored: str, used: bool) -> None:
    """It is made or fetched when the project is set up."""
    Path("r/arm.xml").write_text('<mujoco><include file="generated/pole.xml"/><worldbody/></mujoco>')
    Path(".gitignore").write_text(ignored)
    assert in_use() == ({"arm"} if used else set())


@pytest.mark.parametrize(
    ("archive", "used"), [("plate.zip", False), ("plate.tar.gz", False), ("plates.zip", True)]
)
def test_an_include_that_lies_in_an_archive(archive: str, used: bool) -> None:
    """`unzip plate.zip` is a step of the set-up."""
    Path("r/arm.xml").write_text('<mujoco><include file="parts/plate/plate.xml"/><worldbody/></mujoco>')
    Path("r/parts").mkdir()
    Path("r/parts", archive).touch()
    assert in_use() == ({"arm"} if used else set())


@pytest.mark.parametrize(
    ("program", "nothing"),
    [
        ("import mujoco\nload('leg.xml')\n", set()),
        ("from mujoco import viewer\nload('leg.xml')\n", set()),
        ("from gymnasium.envs.mujoco import MujocoEnv\nload('leg.xml')\n", set()),
        ("load('leg.xml')\n", set()),
        ("from mujoco_py import load_model_from_path\nload_model_from_path('leg.xml')\n", {"compiled"}),
        ("import mujoco_py, mujoco\nload('leg.xml')\n", {"compiled"}),
        ("import isaacgym\ngym.load_asset(sim, 'leg.xml')\n", {"compiled", "step", "dynamics", "gains"}),
        ("import pybullet\nload('leg.xml')  # as in mujoco\n", {"compiled", "step", "dynamics", "gains"}),
        ("import pybullet\nrun('leg.xml', 'gazebo_ros')\n", {"compiled"}),
        ("import pybullet, mujoco\nload('leg.xml')\n", set()),
        # A text that names one does without it, and a path is no program's.
        ('"""Without isaacgym."""\nload("leg.xml")\n', set()),
        (
            "import isaacgym\nROOT = 'dm_control/'\nload('leg.xml')\n",
            {"compiled", "step", "dynamics", "gains"},
        ),
        # MuJoCo compiles it for them.
        ("import genesis\nMJCF(file='leg.xml')\n", {"step"}),
        # What it lacks may be in another one, or in the text that the program makes of it.
        ("import mujoco\nbody.attach(MjSpec.from_file('leg.xml'))\n", {"compiled", "step"}),
        (
            "import mujoco\nspec = MjSpec.from_file('leg.xml')\nspec.body('a').add_geom(mass=1)\n",
            {"compiled"},
        ),
        ("import mujoco\nfrom_xml_string('<mujoco><include file=\"leg.xml\"/></mujoco>')\n", {"compiled"}),
    ],
)
def test_whose_simulator_loads_a_model(program: str, nothing: set[str]) -> None:
    """By the programs that name it: the one that loads the arm is of MuJoCo."""
    Path("r/leg.py").write_text(program)
    written = {Path(file.path).stem: file.written & ALL for file in read_files(["r"])}
    assert written == {"arm": frozenset(), "leg": nothing}


@pytest.mark.parametrize(
    ("programs", "nothing"),
    [
        # One that names its own models takes no other's.
        ({"leg.py": "env = Env('leg.xml')\n", "env.py": "import mujoco_py\n"}, {"compiled"}),
        (
            {
                "leg.yaml": "model: leg.xml\n",
                "sim.py": "import yaml, mujoco\n",
                "render.py": "import mujoco_py\na.xml",
            },
            set(),
        ),
        (
            {"leg.yaml": "model: leg.xml\n", "sim.py": "import mujoco\n", "render.py": "import mujoco_py\n"},
            {"compiled"},
        ),
        # The layout of unitree_rl_gym: a configuration of MuJoCo beside the task of another simulator.
        (
            {
                "leg.yaml": "model: leg.xml\n",
                "sim.py": "import mujoco\n",
                "task.py": "import isaacgym\nload('leg.xml')\n",
            },
            set(),
        ),
        # IsaacGymEnvs'.
        ({"leg.yaml": "assetFileName: leg.xml\n", "sim.py": "import mujoco\n"}, ALL),
    ],
)
def test_a_program_that_names_no_simulator(programs: dict[str, str], nothing: set[str]) -> None:
    """It may hand a model to one that names none itself, or else to any of the folder."""
    for name, text in programs.items():
        Path("r", name).write_text(text)
    written = {Path(file.path).stem: file.written & ALL for file in read_files(["r"])}
    assert written == {"arm": frozenset(), "leg": nothing}


@pytest.mark.parametrize("program", ["import gymnasium\n", "use mujoco_rs::prelude::*;\n", ""])
def test_where_nobody_says_a_simulator(program: str) -> None:
    """MuJoCo alone reads an MJCF."""
    Path("r/run.py").write_text(program + "load('leg.xml')\nload('arm.xml')\n")
    assert [file.written & ALL for file in read_files(["r"])] == [frozenset()] * 2


def test_another_simulator_in_the_folder() -> None:
    """It reads an MJCF its own way, where none is there that has MuJoCo compile it; Gazebo reads none."""
    Path("r/world.launch").write_text("<launch><node pkg='gazebo_ros'/></launch>")
    Path("r/run.py").write_text("load('leg.xml')\nload('arm.xml')\n")
    Path("r/sim.py").write_text("import pybullet\nload('cat.xml')\n")
    assert [file.written & ALL for file in read_files(["r"])] == [ALL] * 2


def test_a_urdf_that_a_configuration_names_too() -> None:
    """Unlike an MJCF, nobody guesses that it is for the MuJoCo of the folder."""
    Path("r/dog.urdf").write_text(
        "<robot name='dog'><link name='base'/><link name='leg'/><joint name='hip' type='fixed'>"
        "<parent link='base'/><child link='leg'/></joint></robot>"
    )
    Path("r/dog.yaml").write_text("model: dog.urdf\n")
    Path("r/sim.py").write_text("import mujoco\n")
    Path("r/task.py").write_text("import isaacgym\nload('dog.urdf')\n")
    written = {Path(file.path).stem: file.written & ALL for file in read_files(["r"])}
    assert (written["arm"], written["dog"]) == (frozenset(), ALL - {"compiled"})
