"""The head of a configuration that actspec wrote says for which versions it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.cli.main import main
from actspec.readings.versions import Versions, limited_by_solver, step_of, written_for
from actspec.report.ledger import ledger_sheets

ROOT = Path(__file__).parents[2]
LIMITED = """from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
BOT_CFG = ArticulationCfg(actuators={"legs": IdealPDActuatorCfg(joint_names_expr=["knee"], stiffness=1.0,
    damping=1.0, LIMITS)})
"""
SPEC = """actspec: 1
robot: {name: leg, model: none, joints: [knee]}
actuators:
  legs:
    joints: [knee]
    level: ideal_pd
    kp: 40 N*m/rad
    kd: 1 N*m*s/rad
    effort_limit: 12 N*m
    armature: 0.01 kg*m^2
    friction: {coulomb: 0.2 N*m, viscous: 0.01 N*m*s/rad}
targets: {isaaclab: {version: "VERSION", isaac_sim: "SIM"}}
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    "lab, sim, told",
    [
        ("2.3", "5.1", {"isaaclab": "2.3", "isaac_sim": "5.1", "backend": "physx"}),
        ("2.1", "4.5", {"isaaclab": "2.1", "isaac_sim": "4.5", "backend": "physx"}),
    ],
    ids=["2.3", "2.1"],
)
def test_what_the_target_writes(lab: str, sim: str, told: dict[str, str]) -> None:
    """The reader of heads takes what the target writes."""
    Path("leg.yaml").write_text(SPEC.replace("VERSION", lab).replace("SIM", sim), encoding="utf-8")
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0
    assert written_for(Path("out/isaaclab/leg_cfg.py").read_bytes()) == told


def test_what_the_target_of_ranges_writes() -> None:
    """Its head names no backend."""
    text = (
        SPEC.replace("VERSION", "2.3")
        .replace("SIM", "5.1")
        .replace(
            "targets: {",
            "    randomize: {kp: {scale: [0.9, 1.1]}}\ntargets: {randomization: {for: [isaaclab]}, ",
        )
    )
    Path("leg.yaml").write_text(text, encoding="utf-8")
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0
    data = Path("out/randomization/leg_isaaclab_events.py").read_bytes()
    assert written_for(data) == {"isaaclab": "2.3", "isaac_sim": "5.1"}


@pytest.mark.parametrize(
    "text",
    [
        "",
        "# Written by hand",
        "import x\n# Written by actspec 1 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do",
    ],
    ids=["empty", "another", "not at the top"],
)
def test_other_heads(text: str) -> None:
    """Nothing is known of a file with another head."""
    assert written_for(text.encode()) == {}


TIMED = (
    SPEC.replace("actuators:", "timing: {physics_dt: 4 ms, decimation: 5}\nactuators:")
    .replace("VERSION", "2.3")
    .replace("SIM", "5.1")
    .replace("    armature", "    delay: 8 ms\n    armature")
    .replace("targets: {", "targets: {mjlab: {version: '1.6'}, ")
)


@pytest.mark.parametrize("target", ["isaaclab", "mjlab"])
@pytest.mark.parametrize("rate", [60, 300, 480])
def test_a_step_that_no_six_digits_give(rate: int, target: str) -> None:
    """1/60 s, the step of Isaac Lab's reach tasks, is read back as 1/60 s, not as 0.0166667 s; verify allows 1e-6."""
    text = TIMED.replace("4 ms", f"{1.0 / rate!r} s").replace("8 ms", f"{2.0 / rate!r} s")
    Path("leg.yaml").write_text(text, encoding="utf-8")
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0
    found = step_of(Path(f"out/{target}/leg_cfg.py").read_bytes())
    assert found is not None
    assert found[0] == pytest.approx(1.0 / rate, rel=1e-10)


@pytest.mark.parametrize("target", ["isaaclab", "mjlab"])
def test_the_step_that_lags_count(target: str) -> None:
    """A configuration that actspec wrote says how long its steps are: 2 steps of 4 ms are 8 ms."""
    Path("leg.yaml").write_text(TIMED, encoding="utf-8")
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0
    path = Path(f"out/{target}/leg_cfg.py")
    found = step_of(path.read_bytes())
    assert found is not None
    step, line = found
    assert step == 0.004
    assert "0.004" in path.read_text(encoding="utf-8").splitlines()[line - 1]
    report = audit([str(path)], Settings())
    assert [row.delay for row in report.case.rows] == [0.008]


@pytest.mark.parametrize(
    "text",
    [
        "# physics_dt 0.004 s\n",
        "# Written by actspec 0.1.0\n",
        "# Written by actspec 0.1.0\n# physics_dt 1e-9e-9 s\n",
        "# Written by actspec 0.1.0\n# physics_dt 0 s\n",
        "# Written by actspec 0.1.0\nx = 1 # physics_dt 0.004 s\n",
    ],
    ids=["by hand", "silent", "no number", "zero", "not a line of its own"],
)
def test_no_step(text: str) -> None:
    """Only a head that actspec wrote, with a time above 0, says the step."""
    assert step_of(text.encode()) is None


HEAD = (
    "# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do not edit: change the spec.\n"
)
CFG = """from isaaclab.actuators import DCMotorCfg
LEGS = {
    "legs": DCMotorCfg(joint_names_expr=["knee"], effort_limit=12.0, saturation_effort=12.0, velocity_limit=20.0,
                       stiffness=40.0, damping=1.0, friction=0.2, dynamic_friction=0.2, viscous_friction=0.01),
}
"""
ROBOT = """from isaaclab.assets.articulation import ArticulationCfg
from leg_cfg import LEGS
LEG_CFG = ArticulationCfg(actuators=LEGS)
"""


def _friction(*files: str, versions: Versions | None = None) -> list[str]:
    report = audit(files, Settings(select=("FRC102",), versions=versions or Versions()))
    return [item.finding.code for item in report.findings]


def test_the_head_tells_what_friction_is() -> None:
    """FRC102 asks for the versions of a hand-written file, not of one that names them; also through an import."""
    Path("leg_cfg.py").write_text(CFG, encoding="utf-8")
    Path("robot_cfg.py").write_text(ROBOT, encoding="utf-8")
    assert _friction("robot_cfg.py") == ["FRC102"]
    Path("leg_cfg.py").write_text(HEAD + CFG, encoding="utf-8")
    assert _friction("robot_cfg.py") == []
    report = audit(["robot_cfg.py"], Settings())
    assert [row.frictionloss for row in report.case.rows] == [0.2]
    # What the user says counts before the head, all of it: 2.3 alone does not tell the simulator.
    assert _friction("robot_cfg.py", versions=Versions(isaaclab="2.3")) == ["FRC102"]


@pytest.mark.parametrize(
    ("version", "clips"),
    [
        ("1.4", False), ("2", None), ("2.0", None), ("2.0.1", False), ("2.0.2", True), ("2.1", True), ("2.2.1", True),
        ("2.3", None), ("2.3.0", True), ("2.3.1", False), ("2.4", False), ("3", False), ("3.0", False),
    ],
)  # fmt: skip
def test_whose_limit_stands_in(version: str, clips: bool | None) -> None:
    """2.0.2 to 2.3.0 take the solver's limit for that of the model; `2.0` and `2.3` may be either."""
    assert limited_by_solver(Versions(isaaclab=version)) is clips
    assert limited_by_solver(Versions()) is None


@pytest.mark.parametrize(
    ("version", "limits", "columns"),
    [
        # The solver clips at 45 N*m in all; from 2.0.2 to 2.3.0 the model does.
        ("2.2", "effort_limit_sim=45.0", {"effort limit": "45"}),
        ("2.3.2", "effort_limit_sim=45.0", {"effort limit of the solver": "45"}),
        (None, "effort_limit_sim=45.0", {"effort limit of the solver": "45"}),
        (
            "2.2",
            "effort_limit=60.0, effort_limit_sim=45.0",
            {"effort limit": "60", "effort limit of the solver": "45"},
        ),
        ("2.2", "effort_limit=30.0, effort_limit_sim=45.0", {"effort limit": "30"}),
    ],
)
def test_ledger_shows_the_clamp(
    folder: Path, version: str | None, limits: str, columns: dict[str, str]
) -> None:
    """A limit of the solver stands in the table where it is the lower one."""
    (folder / "cfg.py").write_text(LIMITED.replace("LIMITS", limits), encoding="utf-8")
    settings = Settings(versions=Versions(isaaclab=version))
    (sheet,) = ledger_sheets(audit(["cfg.py"], settings).case)
    ((_, _, *cells),) = sheet.rows
    shown = {title: cell for (title, _), cell in zip(sheet.heads[2:], cells, strict=True)}
    assert {title: cell for title, cell in shown.items() if "effort" in title} == columns
