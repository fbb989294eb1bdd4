"""Joints that several groups of an Isaac Lab configuration have, held to its own loop over the groups, by release."""

from __future__ import annotations

import math
import random
from pathlib import Path

import pytest

from actspec.ir import Quantity
from actspec.lift.config import lift_config
from actspec.readings.config import rows_of_config
from actspec.readings.python.read import read_python
from actspec.readings.versions import Versions
from tests.frameworks.prepare import Frameworks

HERE = Path(__file__).parent

JOINTS = ["shoulder", "elbow", "finger"]
USD = 123.0
NONE_FROM = 1e9

CFG = """from isaaclab.actuators import ImplicitActuatorCfg, IdealPDActuatorCfg, DCMotorCfg
from isaaclab.assets import ArticulationCfg
BOT_CFG = ArticulationCfg(actuators={})
"""

OF_ALL = ("stiffness", "damping", "armature", "friction", "dynamic_friction", "viscous_friction", "velocity_limit_sim",
          "effort_limit_sim")  # fmt: skip

LATE = """{
    "all": ImplicitActuatorCfg(joint_names_expr=[".*"], effort_limit_sim=87.0, velocity_limit_sim=2.0,
        stiffness=800.0, damping=40.0, armature=0.1),
    "gripper": ImplicitActuatorCfg(joint_names_expr=["finger"], stiffness=280.0, damping=None),
}"""


def cases(count: int) -> list[str]:
    """Dicts of two or three groups, of any classes, each of which states some of its fields."""
    draw, found = random.Random(5), [LATE]
    for _ in range(count):
        groups = []
        for name, joints in (("all", ".*"), ("hand", "elbow|finger"), ("gripper", "finger"))[
            : draw.choice((2, 3))
        ]:
            cls = draw.choice(("ImplicitActuatorCfg", "IdealPDActuatorCfg", "DCMotorCfg"))
            fields = {one: draw.randint(1, 99) / 4 for one in OF_ALL if draw.random() < 0.5}
            more = {"stiffness": None, "damping": None} | fields
            if cls != "ImplicitActuatorCfg" and draw.random() < 0.5:
                more["effort_limit"] = draw.randint(1, 99) / 4
            if cls == "DCMotorCfg":
                more |= {"saturation_effort": 200.0, "velocity_limit": 30.0}
            elif cls == "IdealPDActuatorCfg" and draw.random() < 0.5:
                more["velocity_limit"] = 31.0
            stated = "".join(f", {one}={value}" for one, value in more.items())
            groups.append(f'"{name}": {cls}(joint_names_expr=["{joints}"]{stated})')
        found.append("{" + ", ".join(groups) + "}")
    return found


def holds(read: Quantity | None, real: float) -> bool:
    """Whether a reading is the real number; what is unknown is the USD's, or none."""
    if read is None or read.value is None:
        return real == USD or real >= NONE_FROM
    return math.isclose(read.value, real, rel_tol=1e-6)


@pytest.mark.parametrize(("wheel", "release"), [("2.3.2.post1", "2.3.2"), ("2.2.0", "2.2.0")])
def test_what_a_joint_of_several_groups_has(
    frameworks: Frameworks, tmp_path: Path, wheel: str, release: str
) -> None:
    """Gains, limits and passive figures are those that the real loop leaves, in import and in the ledger alike."""
    texts = cases(150)
    job = {"root": str(frameworks.isaaclab(wheel)), "joints": JOINTS, "usd": USD, "cases": texts}
    said, _ = frameworks.run_probe(HERE / "overlap_probe.py", job)
    versions = Versions(isaaclab=release, isaac_sim="5.1" if release == "2.3.2" else "5.0")
    wrong = []
    for text, real in zip(texts, said, strict=True):  # type: ignore[arg-type]
        path = tmp_path / "bot_cfg.py"
        path.write_text(CFG.format(text), encoding="utf-8")
        (artifact,) = read_python(str(path)).artifacts
        rows = {row.joint: row for row in rows_of_config(artifact, 0, (), versions, joints=JOINTS)}
        for joint in lift_config(artifact, JOINTS, versions=versions).actuators.joints:
            its, row = real[joint.joint], rows[joint.joint]
            # Of an explicit drive: what the model clips at; where it does not, the solver may.
            effort = its["effort"] if its["implicit"] else min(its["model"], its["effort"])
            read = {
                "kp": (joint.kp, its["kp"]),
                "kd": (joint.kd, its["kd"]),
                "armature": (joint.armature, its["armature"]),
                "speed": (joint.velocity_limit, its["speed"]),
            }
            if release == "2.3.2":
                read |= {
                    "sliding": (joint.friction_coulomb, its["sliding"]),
                    "viscous": (joint.friction_viscous, its["viscous"]),
                }
                # A spec has no static friction that is unknown.
                if joint.friction_static is not None:
                    read["static"] = (joint.friction_static, its["static"])
            wrong += [f"{joint.joint} {name} {one}: {text}" for name, one in read.items() if not holds(*one)]
            lower = joint.effort_limit.value is not None and math.isclose(
                joint.effort_limit.value, its["model"], rel_tol=1e-6
            )
            if not holds(joint.effort_limit, effort) and not lower:
                wrong.append(f"{joint.joint} effort {joint.effort_limit}, {its}: {text}")
            # The ledger has the same.
            for field, one in (("kp", joint.kp), ("kd", joint.kd), ("armature", joint.armature)):
                assert one is not None and getattr(row, field) == one.value, (field, text)
            assert row.effort_limit in (joint.effort_limit.value, None), text
    assert not wrong, "\n".join(wrong)


def test_an_arm_under_its_gripper(tmp_path: Path) -> None:
    """The gripper's group states a stiffness alone: the rest is 87 N*m, 2 rad/s, 40 and 0.1 of the arm's."""
    path = tmp_path / "bot_cfg.py"
    path.write_text(CFG.format(LATE), encoding="utf-8")
    (artifact,) = read_python(str(path)).artifacts
    finger = lift_config(artifact, JOINTS).actuators.joint("finger")
    assert finger is not None and finger.kp is not None and finger.kd is not None
    figures = (finger.kp, finger.kd, finger.effort_limit, finger.velocity_limit, finger.armature)
    assert [one.value for one in figures] == [280.0, 40.0, 87.0, 2.0, 0.1]
    assert finger.friction_coulomb.note == "the USD's own"
