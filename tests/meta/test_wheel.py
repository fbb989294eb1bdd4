"""The wheel is whole: what a user installs has every module and every shipped file."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
KINDS = ("robots", "schemas", "templates")
IGNORED = shutil.ignore_patterns("__pycache__", "*.pyc", "MUJOCO_LOG.TXT")

ASK = """
import hashlib, pathlib, actspec, sys
from actspec.resources import data_path
assert pathlib.Path(actspec.__file__).is_relative_to(sys.argv[1]), actspec.__file__
for name in sys.stdin.read().splitlines():
    kind, _, rest = name.partition("/")
    path = data_path(kind, rest)
    assert path.is_relative_to(sys.argv[1]), path
    print(hashlib.sha256(path.read_bytes()).hexdigest(), name)
"""


def run(*command: str | Path, cwd: Path, given: str = "") -> str:
    """Run a command outside the checkout and hand back what it prints."""
    done = subprocess.run(
        list(map(str, command)),
        check=False,
        cwd=cwd,
        input=given,
        env={"PATH": "/usr/bin:/bin", "PIP_DISABLE_PIP_VERSION_CHECK": "1"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of what the wheel is made of, so that building leaves nothing in the real one."""
    copy = tmp_path_factory.mktemp("wheel") / "checkout"
    copy.mkdir()
    shutil.copytree(ROOT / "actspec", copy / "actspec", ignore=IGNORED)
    for kind in KINDS:
        if not (ROOT / kind).is_dir():
            pytest.skip(f"no {kind}/ yet")
        shutil.copytree(ROOT / kind, copy / kind, ignore=IGNORED)
    for name in ("pyproject.toml", "LICENSE", "README.md"):
        if not (ROOT / name).is_file():
            pytest.skip(f"no {name} yet")
        shutil.copy(ROOT / name, copy / name)
    return copy


@pytest.fixture(scope="module")
def wheel(checkout: Path) -> Path:
    """The wheel, built offline with the installed hatchling."""
    pytest.importorskip("hatchling")
    out = checkout.parent / "dist"
    options = ("--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--wheel-dir", out)
    run(sys.executable, "-m", "pip", "wheel", *options, checkout, cwd=checkout.parent)
    (built,) = out.glob("actspec-*-py3-none-any.whl")
    return built


def shipped(checkout: Path) -> list[str]:
    """Names of the data files, as `kind/path`."""
    files = (path for kind in KINDS for path in (checkout / kind).rglob("*") if path.is_file())
    return sorted(path.relative_to(checkout).as_posix() for path in files)


@pytest.mark.slow
def test_wheel_holds_the_package_and_nothing_else(checkout: Path, wheel: Path) -> None:
    """Every module, the typing marker, the licence and the data folders are in; tests are not."""
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    code = {p.relative_to(checkout).as_posix() for p in (checkout / "actspec").rglob("*") if p.is_file()}
    info = {name for name in names if name.split("/")[0].endswith(".dist-info")}
    assert names - info == code | {f"actspec/_data/{name}" for name in shipped(checkout)}
    assert "actspec/py.typed" in names
    assert any(name.endswith("/LICENSE") for name in info)


@pytest.mark.slow
def test_installed_wheel_finds_its_files(checkout: Path, wheel: Path, tmp_path: Path) -> None:
    """Installed away from the checkout, `data_path` finds every file, byte for byte, in the installation."""
    target = tmp_path / "site"
    options = ("--quiet", "--no-deps", "--no-index", "--no-compile", "--target", target)
    run(sys.executable, "-m", "pip", "install", *options, wheel, cwd=tmp_path)
    names = shipped(checkout)
    assert {name.split("/")[0] for name in names} == set(KINDS)
    # -I keeps the checkout's own path out, whatever the surroundings set.
    code = f"import sys; sys.path.insert(0, {str(target)!r})\n{ASK}"
    said = run(sys.executable, "-I", "-c", code, target, cwd=tmp_path, given="\n".join(names))
    expected = [f"{hashlib.sha256((checkout / name).read_bytes()).hexdigest()} {name}" for name in names]
    assert said.splitlines() == expected


@pytest.mark.slow
def test_console_script_is_declared(wheel: Path) -> None:
    """`actspec` on the command line is `actspec.__main__:entry`."""
    with zipfile.ZipFile(wheel) as archive:
        entry = next(name for name in archive.namelist() if name.endswith("/entry_points.txt"))
        assert "actspec = actspec.__main__:entry" in archive.read(entry).decode().splitlines()
