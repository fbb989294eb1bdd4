"""What a project asks for, by hand: which requirements leave MuJoCo 4.0.0 out because it is too new."""

from __future__ import annotations

from pathlib import Path
from time import process_time

import pytest

from actspec.files import MOST_ABOVE
from actspec.readings.pins import Pins


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # Nothing above belongs to the project.
    Path(".git").mkdir()
    Path("assets/hand").mkdir(parents=True)


def older(path: str = "assets/hand/leg.xml", installed: tuple[int, ...] = (4, 0, 0)) -> str | None:
    """In the words of a message."""
    asked = Pins(installed).older(path)
    return None if asked is None else asked.told


@pytest.mark.parametrize(
    ("name", "text", "asked"),
    [
        ("requirements.txt", "numpy\nmujoco==2.3.7\n", ":2 asks for mujoco==2.3.7, which"),
        ("requirements-rl.txt", "mujoco[usd] <= 2.3.3 ; python_version > '3'", ":1 asks for mujoco<= 2.3.3, which"),
        ("requirements.txt", "mujoco~=3.2", ":1 asks for mujoco~=3.2, which"),
        ("requirements.txt", "mujoco-py<2.2,>=2.1", ":1 asks for mujoco-py<2.2,>=2.1, whose MuJoCo, 2.1 or older,"),
        ("requirements.txt", "mujoco_py # old", ":1 asks for mujoco_py, whose MuJoCo, 2.1 or older,"),
        ("setup.py", "setup(\n  install_requires=['numpy', 'mujoco==2.3.6'])", ":2 asks for mujoco==2.3.6, which"),
        (
            "setup.py",
            "extras = {\n'mujoco': ['mujoco_py>=1.50, <2.0', 'imageio'],\n}",
            ":2 asks for mujoco_py>=1.50, <2.0, whose MuJoCo, 2.1 or older,",
        ),
        ("pyproject.toml", 'dependencies = [\n"mujoco>=3.1.0,<4.0.0"]', ":2 asks for mujoco>=3.1.0,<4.0.0, which"),
        ("pyproject.toml", 'mujoco = "3.2.6"', ":1 asks for mujoco==3.2.6, which"),
        ("pyproject.toml", 'mujoco = {version = "^3.2", optional = true}', ":1 asks for mujoco^3.2, which"),
        ("environment.yml", "dependencies:\n  - pip:\n    - mujoco==3.2.3\n", ":3 asks for mujoco==3.2.3, which"),
        ("environment.yaml", "  - mujoco=2.1.5=py38\n", ":1 asks for mujoco==2.1.5, which"),
        (
            "conda_environment.yaml",
            "- pip:\n  - free-mujoco-py==2.1.6\n",
            ":2 asks for free-mujoco-py==2.1.6, whose MuJoCo, 2.1 or older,",
        ),
        ("conda.yml", "- mujoco=3.2\n", ":1 asks for mujoco==3.2, which"),
        (
            "CMakeLists.txt",
            "project(leg)\ninclude_directories(/home/ada/.mujoco/mujoco-2.3.1/include/)",
            ":2 builds with mujoco-2.3.1, which",
        ),
        ("CMakeLists.txt", 'set(MUJOCO "C:/dev/mujoco_3.3")', ":1 builds with mujoco_3.3, which"),
        ("Makefile", "INC := -I$(HOME)/.mujoco/mujoco210/include", ":1 builds with mujoco210, which"),
        ("requirements.txt", "dm_control==1.0.5", ":1 asks for dm_control==1.0.5, whose MuJoCo"),
        ("pyproject.toml", 'dependencies = ["dm-control<1.0.20"]', ":1 asks for dm-control<1.0.20, whose MuJoCo"),
        ("env.py", "from gym.envs.mujoco import mujoco_env", ":1 imports gym.envs.mujoco, whose MuJoCo, 2.1 or older,"),
        ("run.py", "import numpy\nfrom mujoco_py import MjSim", ":2 imports mujoco_py, whose MuJoCo, 2.1 or older,"),
    ],
)  # fmt: skip
def test_what_is_older(name: str, text: str, asked: str) -> None:
    Path(name).write_text(text)
    assert older() == f"{name}{asked} may take it"
    Path(name).unlink()
    Path("assets", name).write_text(text)
    assert older() == f"assets/{name}{asked} may take it"
    assert older("leg.xml") is None


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("CMakeLists.txt", "# include_directories(~/mujoco-3.2.0/include)\nfind_package(mujoco 3.1 REQUIRED)"),
        ("CMakeLists.txt", "link_directories(/opt/mujoco-4.0.0/lib)"),
        ("CMakeLists.txt", "add_subdirectory(libmujoco-2.3.1)\nadd_subdirectory(mujoco-2.3.1.4 mujoco2101 mujoco_w03)"),
        ("requirements.txt", "mujoco"),
        ("requirements.txt", "mujoco>=3.3"),
        ("requirements.txt", "dm_control>=1.0.5"),
        ("requirements.txt", "dm_control"),
        ("requirements.txt", "dm_control==1.0.5\nmujoco==4.0.0"),
        ("env.py", "from gymnasium.envs.mujoco import mujoco_env"),
        ("requirements.txt", "mujoco==4.0.0"),
        ("requirements.txt", "mujoco==4.*"),
        ("requirements.txt", "mujoco~=4.0"),
        ("requirements.txt", "mujoco==4.1"),
        ("requirements.txt", "mujoco<5"),
        ("requirements.txt", "mujoco!=3.2"),
        ("requirements.txt", "# mujoco==2.3.7\nmujoco-python-viewer==0.1.2\nmujoco-mjx==3.2.3\ngym[mujoco]==0.29"),
        ("requirements.txt", "# via\n#   mujoco_py"),
        ("pyproject.toml", '[project]\nname = "mujoco_controllers"\nversion = "0.1"'),
        ("notes.txt", "mujoco==2.3.7"),
        ("run.py", "import mujoco\n# import mujoco_py"),
        ("run.py", "print('import mujoco_py')"),
    ],
)  # fmt: skip
def test_what_is_not(name: str, text: str) -> None:
    Path(name).write_text(text)
    assert older() is None


def test_of_what_is_installed() -> None:
    """`3.17` may be any patch of it, and a pin of a newer release asks for no older one."""
    Path("requirements.txt").write_text("mujoco==3.17")
    assert older(installed=(3, 17, 2)) is None
    assert older(installed=(3, 16, 0)) is None
    assert older(installed=(4, 0, 0)) is not None


def test_the_nearest_version_decides() -> None:
    """A package in a repository has requirements of its own; one without a version leaves it to those above."""
    Path("requirements.txt").write_text("mujoco==2.3.7")
    Path("assets/setup.py").write_text("setup(install_requires=['mujoco'])")
    assert older() == "requirements.txt:1 asks for mujoco==2.3.7, which may take it"
    Path("assets/setup.py").write_text("setup(install_requires=['mujoco>=3.3'])")
    assert older() is None


def test_programs_of_both() -> None:
    """Where something on the way takes MuJoCo itself, mujoco_py may be of other models."""
    Path("requirements.txt").write_text("mujoco_py==2.1.2.14")
    assert older() is not None
    Path("assets/view.py").write_text("import yaml as y, os.path, mujocosim\n")
    assert older() is not None
    for line in ("import mujoco\n", "import yaml as y, os.path, mujoco\n"):
        Path("assets/view.py").write_text(line)
        assert older() is None
    Path("requirements.txt").write_text("mujoco_py==2.1.2.14\nmujoco==2.2.0\n")
    assert older() == "requirements.txt:2 asks for mujoco==2.2.0, which may take it"


@pytest.mark.parametrize("name", ["train/requirements.txt", "assets/mjx/setup.py"])
def test_of_a_package_beside_it(name: str) -> None:
    """A repository of several packages has its models in one; another's pin counts where none is nearer."""
    Path(name).parent.mkdir()
    Path(name).write_text("'mujoco==2.3.7'")
    assert older() == f"{name}:1 asks for mujoco==2.3.7, which may take it"
    # One that the installed release meets, or that is nearer, leaves nothing to guess.
    Path(name).with_name("requirements.txt").write_text("mujoco==2.3.7\n")
    Path("assets/requirements.txt").write_text("mujoco>=3\n")
    assert older() is None
    Path("assets/requirements.txt").unlink()
    Path(name).parent.with_name("sim").mkdir()
    Path(name).parent.with_name("sim").joinpath("requirements.txt").write_text("mujoco>=3\n")
    assert older() is None


def test_what_is_beside_it_and_not_its_own(tmp_path: Path) -> None:
    """Submodules, what only imports mujoco_py, and what is no repository's nor in the folder that was named."""
    Path("train").mkdir()
    Path("train/run.py").write_text("import mujoco_py\n")
    assert older() is None
    Path("train/requirements.txt").write_text("mujoco==2.3.7\n")
    assert older() is not None
    Path("train/.git").write_text("gitdir: ../.git/modules/train\n")
    assert older() is None
    Path("train/.git").unlink()
    Path(".git").rmdir()
    assert older() is None
    pins = Pins((4, 0, 0))
    assert pins.older("assets/hand/leg.xml", "assets") is None
    assert pins.older("assets/hand/leg.xml", ".") is not None


def test_how_far_it_looks(tmp_path: Path) -> None:
    """No farther than the repository, and eight folders where there is none; no link is followed."""
    Path("requirements.txt").write_text("mujoco==2.3.7")
    Path("assets/.git").write_text("gitdir: ../.git/modules/assets\n")
    assert older() is None
    Path("assets/.git").unlink()
    Path(".git").rmdir()
    assert older() is not None
    deep = "/".join("abcdefgh")
    assert len(deep.split("/")) == MOST_ABOVE
    assert older(f"{deep}/leg.xml") is not None
    assert older(f"{deep}/i/leg.xml") is None
    assert Pins((4, 0, 0)).older(f"{deep}/i/leg.xml", ".") is not None
    assert Pins((4, 0, 0)).older(f"{deep}/i/leg.xml", "a") is None
    Path("requirements.txt").rename("other.txt")
    Path("requirements.txt").symlink_to("other.txt")
    assert older() is None


def test_files_as_windows_writes_them() -> None:
    """`pip freeze > requirements.txt` of PowerShell is UTF-16."""
    Path("requirements.txt").write_bytes("numpy\r\nmujoco==2.3.7\r\n".encode("utf-16"))
    assert older() == "requirements.txt:2 asks for mujoco==2.3.7, which may take it"


@pytest.mark.parametrize(
    "text",
    ['"mujoco' * 9000, '"mujoco = {' * 9000, '"mujoco==1' + " " * 60000 + '"', "mujoco" + "<1," * 9000],
)
def test_hostile_text_takes_no_time(text: str) -> None:
    """A tenth of a second, not minutes."""
    Path("pyproject.toml").write_text(text)
    before = process_time()
    older()
    assert process_time() - before < 5.0
