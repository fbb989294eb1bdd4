"""Which models of a folder its programs load: what is wrong in these is more than a note."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.read import read_files
from actspec.readings.loads import what_loads

MODEL = "<mujoco><worldbody><body><joint name='j'/><geom size='1'/></body></worldbody></mujoco>"
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
        ("a.sh", "urdf2mjcf robot.urdf -o leg.xml\nxacro a.xacro > leg.xml\n"),
        ("a.py", "FILE = '/opt/mujoco_menagerie/unitree_go2/leg.xml'\nload(FILE)\n"),
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
        ("pole.xml", "mujoco.MjModel.from_xml_path(path(model), {})\n", True),
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
    ],
)
def test_whose_simulator_loads_a_model(program: str, nothing: set[str]) -> None:
    """By the programs that name it: the one that loads the arm is of MuJoCo."""
    Path("r/leg.py").write_text(program)
    of = {"compiled", "step", "dynamics", "gains"}
    written = {Path(file.path).stem: file.written & of for file in read_files(["r"])}
    assert written == {"arm": frozenset(), "leg": nothing}


def test_a_program_that_names_no_simulator_has_one_of_the_folder() -> None:
    """MuJoCo's or mujoco_py's, where the folder has both."""
    Path("r/leg.py").write_text("env = Environment('leg.xml')\n")
    Path("r/environment.py").write_text("import mujoco_py\n")
    written = {Path(file.path).stem: "compiled" in file.written for file in read_files(["r"])}
    assert written == {"arm": False, "leg": True}
