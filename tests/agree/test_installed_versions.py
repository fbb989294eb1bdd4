"""actspec under other installed MuJoCo releases: the command works, and writes the same bytes."""

from __future__ import annotations

import os
import site
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.agree.engines import Engine
from tests.compiling import MOTORS

ROOT = Path(__file__).parents[2]
RELEASES = ("3.7.0", "3.11.0", "3.12.0", "3.17.0")
TARGETS = ("3.4", "3.6", "3.8", "3.11", "3.12", "3.15", "3.17", "4.0")
"""One of each dialect, whatever is installed."""

ROBOT = """<mujoco model="rich">
  <!-- every kind of edit at once -->
  <compiler angle="degree"/>
  <option timestep=".002" integrator="implicitfast"/>
  <default>
    <default class="leg">
      <joint damping="1.5" armature=".2"/>
      <position kp="7" kv="3" forcerange="-2 2"/>
    </default>
  </default>
  <worldbody>
    <body><joint name="a" class="leg" range="-60 60" actuatorfrcrange="-1 1"/><geom size=".1"/>
      <body pos=".3 0 0"><joint name="b" springdamper=".1 1"/><geom size=".1"/>
        <body pos=".3 0 0"><joint name="c" type="slide" axis="1 0 0"/><geom size=".1"/>
          <body pos=".3 0 0"><joint name="d" stiffness="2"/><geom size=".1"/></body>
        </body>
      </body>
    </body>
  </worldbody>
  <include file="drives.xml"/>
  <sensor><actuatorfrc actuator="a2"/><jointpos joint="d"/></sensor>
  <keyframe><key name="home" qpos=".1 .2 .3 .4" ctrl="1 2 3 4"/></keyframe>
</mujoco>
"""
DRIVES = """<mujocoinclude>
  <actuator>
    <position name="a1" joint="a" class="leg" gear="2"/>
    <motor name="a2" joint="a"/>
    <motor name="b1" joint="b"/>
    <general name="c1" joint="c" gainprm="5" biastype="affine" biasprm="0 -5 -1"/>
  </actuator>
</mujocoinclude>
"""
SPEC = f"""actspec: 1
robot: {{name: rich, model: rich.xml}}
timing: {{physics_dt: 5 ms}}
motors:{MOTORS}
actuators:
  a:
    joints: [a]
    motor: line
    level: dc_motor
    kp: 80
    kd: 2
    delay: 15 ms
    friction: {{coulomb: 0.2, viscous: 0.05}}
  b:
    joints: [b]
    level: ideal_pd
    kp: 40
    kd: 1
    effort_limit: 9
    encoder_bias: 0.02 rad
    command_filter: {{cutoff: 20 Hz}}
    delay: 10 ms
  c:
    joints: [c]
    level: dc_motor
    motor: line_s
    command: velocity
    kd: 60
    armature: 0.3
  d:
    joints: [d]
    level: ideal_pd
    command: effort
    effort_limit: 3
    command_filter: {{cutoff: 5 Hz}}
targets:
"""


def written(folder: Path) -> dict[str, bytes]:
    """Every file below a folder."""
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def compile_with(engine: Engine | None, spec: Path, folder: Path, *more: str) -> dict[str, bytes]:
    """Run `actspec compile` in a process whose `mujoco` is the engine's; what it wrote, and under "" what it said.

    Args:
        engine: The release; None: the installed one.
        spec: The spec.
        folder: Where to write.
    """
    places = [str(ROOT), *site.getsitepackages()]
    code = (
        "import mujoco, sys; from actspec.cli.main import main; print(mujoco.__version__); sys.exit(main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, "compile", str(spec), "-o", str(folder), *more],
        check=False,
        cwd=spec.parent,
        env={
            **os.environ,
            "MUJOCO_GL": "disabled",
            "PYTHONPATH": os.pathsep.join([*([str(engine.folder)] if engine else []), *places]),
        },
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    if engine is not None:
        assert done.stdout.splitlines()[0] == engine.version
    return {**written(folder), "": (done.stdout + done.stderr).encode()}


@pytest.fixture(scope="module")
def rich(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A spec that uses everything, for one target of each dialect."""
    folder = tmp_path_factory.mktemp("rich")
    (folder / "rich.xml").write_text(ROBOT)
    (folder / "drives.xml").write_text(DRIVES)
    lines = "".join(f'  mujoco_{v.replace(".", "_")}: {{target: mujoco, version: "{v}"}}\n' for v in TARGETS)
    (folder / "rich.yaml").write_text(SPEC + lines)
    return folder / "rich.yaml"


@pytest.fixture(scope="module")
def expected(rich: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """What the installed release writes."""
    return compile_with(None, rich, tmp_path_factory.mktemp("installed") / "out")


@pytest.mark.parametrize("release", RELEASES)
def test_written_bytes_do_not_depend_on_what_is_installed(
    release: str,
    rich: Path,
    expected: dict[str, bytes],
    engine_of: Callable[[str], Engine],
    tmp_path: Path,
) -> None:
    """Under each release the whole compile works, checks included, and every file is the same."""
    # Relative paths in the files are those of a folder at the same depth.
    found = compile_with(engine_of(release), rich, tmp_path / "out")
    found.pop("")
    there = {name: data for name, data in expected.items() if name}
    assert sorted(found) == sorted(there)
    assert len(found) == 3 * len(TARGETS)  # the model, its include and the manifest
    for name, data in found.items():
        if not name.endswith("manifest.json"):
            assert _without_folder(data) == _without_folder(there[name]), name


@pytest.mark.parametrize(("release", "told"), [("3.11.0", True), ("3.17.0", False)])
def test_which_release_loads_what_no_version_is_stated_for(
    release: str, told: bool, engine_of: Callable[[str], Engine], tmp_path: Path
) -> None:
    """Without a stated version 3.12 is written for: an older MuJoCo, which does not load it, is told what to state."""
    spec = tmp_path / "own.yaml"
    (tmp_path / "m.xml").write_text(
        '<mujoco><worldbody><body><joint name="a"/><geom size=".1"/></body></worldbody></mujoco>'
    )
    spec.write_text(
        "actspec: 1\nrobot: {name: own, model: m.xml}\ntargets: {mujoco: {}}\n"
        "actuators: {a: {joints: [a], level: dc_motor, kp: 9, kd: 1, effort_limit: 5, armature: 0.01,\n"
        "  motor: m}}\nmotors: {m: {side: joint, stall_torque: 9 N*m, no_load_speed: 9 rad/s}}\n"
    )
    engine = engine_of(release)
    files = compile_with(engine, spec, tmp_path / "out")
    assert (b"MJC032" in files[""]) is told
    stated = compile_with(engine, spec, tmp_path / "at", "-t", "mujoco==" + release.rpartition(".")[0])
    assert b"MJC032" not in stated[""]
    assert (engine.load(tmp_path / "out" / "mujoco" / "m.xml").error is not None) is told
    assert engine.load(tmp_path / "at" / "mujoco" / "m.xml").error is None


def _without_folder(data: bytes) -> bytes:
    """A file without the relative paths of its assets and includes."""
    import re

    return re.sub(rb'(file|meshdir|texturedir)="[^"]*"', rb"\1", data)


@pytest.mark.parametrize("release", ["3.2.7", "3.5.0", "3.7.0", "3.11.0", "3.17.0", "4.0.0"])
def test_reset_recipe_has_no_jump(release: str, engine_of: Callable[[str], Engine], tmp_path: Path) -> None:
    """`actspec.runtime.reset` starts filter and delay at the pose in every release; a bare reset jumps."""
    delay = 'delay=".01" nsample="5"' if engine_of(release).number >= (3, 5) else ""
    (tmp_path / "robot.xml").write_text(
        f"""<mujoco><option timestep=".002"/>
        <worldbody><body><joint name="a"/><geom size=".1"/></body></worldbody>
        <actuator><position joint="a" kp="50" kv="1" timeconst=".05" {delay}/></actuator>
        <keyframe><key qpos=".4" ctrl=".4"/></keyframe></mujoco>"""
    )
    code = """
import mujoco
from actspec.learn.reset import reset
model = mujoco.MjModel.from_xml_path("robot.xml")
data = mujoco.MjData(model)
def torques():
    found = []
    for _ in range(8):
        mujoco.mj_forward(model, data)
        found.append(float(data.qfrc_actuator[0]))
        mujoco.mj_step(model, data)
        data.qpos[0], data.qvel[0] = 0.4, 0.0
    return found
reset(model, data)
print(max(map(abs, torques())))
mujoco.mj_resetDataKeyframe(model, data, 0)
print(torques()[0])
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        check=False,
        cwd=tmp_path,
        env={
            **os.environ,
            "MUJOCO_GL": "disabled",
            "PYTHONPATH": os.pathsep.join([str(engine_of(release).folder), str(ROOT)]),
        },
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    recipe, bare = (float(line) for line in done.stdout.split())
    # 50 (0 - 0.4): the filter of the bare reset is at 0
    assert bare == pytest.approx(-20.0)
    assert abs(recipe) < 1e-12
