"""Reads specs as plain YAML, vendors' URDFs and rigid bodies, for tests of the robots that ship."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

ROOT = Path(__file__).parents[2]
ROBOTS = ROOT / "robots"

NUMBER_TOLERANCE = 1e-9  # a transcription error is larger; MuJoCo's diagonalisation of an inertia is not
MASS_MATRIX_TOLERANCE = 1e-6  # relative to the largest entry of a block of the same unit

Link = tuple[str, float, tuple[float, float, float], np.ndarray]
"""Name, mass [kg], centre of mass [m] and inertia about it [kg*m^2], axes of the link."""


@dataclass(frozen=True)
class Published:
    """A model of ours, and what its vendor says of it.

    Attributes:
        robot: Its folder below `robots/`, and its spec.
        urdf: The vendor's URDF, below the corpus.
        base: The root link of that.
        joints: In the order of our model.
        links: All of them.
        mass: Of the robot [kg].
        limits: Torque limits of the joints [N*m].
        others: As in `check_limits`.
        file: Our model's name, where it is not the robot's.
    """

    robot: str
    urdf: str
    base: str
    joints: list[str]
    links: list[Link]
    mass: float
    limits: list[float]
    file: str = ""
    others: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __str__(self) -> str:
        """Our model's name."""
        return self.file or self.robot

    @cached_property
    def ours(self) -> Any:
        """The robot alone, as written."""
        import mujoco

        return mujoco.MjModel.from_xml_path(str(ROBOTS / self.robot / f"{self}.xml"))

    @cached_property
    def theirs(self) -> Any:
        """The vendor's URDF with a free base."""
        return vendor_model(self.urdf, self.base)


def plain(path: Path) -> dict[str, Any]:
    """A YAML file as data, read by another reader than actspec's."""
    data: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return data


def spec_of(name: str) -> dict[str, Any]:
    """A robot's spec with the motors and sources that it includes."""
    spec = plain(ROBOTS / f"{name}.yaml")
    for included in spec.pop("include", []):
        for section, entries in plain(ROBOTS / included).items():
            spec[section] = {**entries, **spec.get(section, {})}
    return spec


def number(given: Any) -> float:
    """The figure of a spec value that is written in SI, or in ms."""
    text = given["value"] if isinstance(given, dict) else given
    factor = 1e-3 if str(text).endswith(" ms") else 1.0
    return float(str(text).split()[0]) * factor


def pose(spec: dict[str, Any], joints: Sequence[str]) -> list[float]:
    """A spec's default position of each joint [rad]; 0 where no pattern matches."""
    patterns = {pattern: number(value) for pattern, value in spec["robot"]["default_pose"].items()}
    found = []
    for name in joints:
        matches = [value for pattern, value in patterns.items() if re.fullmatch(pattern, name)]
        assert len(matches) <= 1, name
        found.append(matches[0] if matches else 0.0)
    return found


def tensor(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> np.ndarray:
    """Symmetric 3 x 3 matrix."""
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def inertia(model: Any, body: int) -> np.ndarray:
    """3 x 3 inertia of a body about its centre of mass, axes of the body [kg*m^2]."""
    import mujoco

    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.body_iquat[body])
    matrix = rotation.reshape(3, 3)
    return matrix @ np.diag(model.body_inertia[body]) @ matrix.T


def vendor_model(path: str, base: str) -> Any:
    """A vendor's URDF with a free base, read by MuJoCo from stated inertias only; skips where it is not there.

    Args:
        path: File below the corpus (ACTSPEC_CORPUS, or `shared/corpus` beside or in the checkout).
        base: The root link.
    """
    import mujoco

    given = os.environ.get("ACTSPEC_CORPUS")
    places = [Path(given)] if given else [ROOT / "shared" / "corpus", ROOT.parent / "shared" / "corpus"]
    file = next((place / path for place in places if (place / path).is_file()), None)
    if file is None:
        pytest.skip("no vendor files: set ACTSPEC_CORPUS")
    text = re.sub(r"<!--.*?-->", "", file.read_text(encoding="utf-8"), flags=re.DOTALL)
    # Meshes are not there; and shapes would give massless links a mass.
    text = re.sub(r"<(visual|collision)>.*?</\1>", "", text, flags=re.DOTALL)
    text, there = re.subn(r'(<joint name="floating_base" type=)"fixed"', r'\1"floating"', text)
    if not there:
        free = f'<joint name="root" type="floating"><parent link="world"/><child link="{base}"/></joint>'
        text = text.replace("</robot>", f'<link name="world"/>{free}</robot>')
    return mujoco.MjModel.from_xml_string(text)


def mass_matrix(model: Any, joints: Sequence[str], angles: np.ndarray) -> np.ndarray:
    """Mass matrix with the base at the origin, rows ordered base, then `joints`."""
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:] = 0.0
    data.qpos[3] = 1.0
    for name, angle in zip(joints, angles, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = angle
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    for column, unit in enumerate(np.eye(model.nv)):
        mujoco.mj_mulM(model, data, full[column], unit)
    order = [*range(6), *(int(model.joint(name).dofadr[0]) for name in joints)]
    return full[np.ix_(order, order)]


def poses(model: Any, joints: Sequence[str], seed: int | None) -> np.ndarray:
    """Joint angles of the first keyframe, or drawn over the joints' ranges."""
    if seed is None:
        return np.array(model.key(0).qpos[7:])
    limits = np.array([model.joint(name).range for name in joints])
    return np.random.default_rng(seed).uniform(limits[:, 0], limits[:, 1])


def check_links(model: Any, links: Sequence[Link]) -> None:
    """Every body of a model is a link, with its mass, centre of mass and full inertia."""
    assert {model.body(index).name for index in range(1, model.nbody)} == {link[0] for link in links}
    for name, mass, centre, matrix in links:
        body = model.body(name).id
        assert model.body_mass[body] == pytest.approx(mass, abs=NUMBER_TOLERANCE), name
        assert model.body_ipos[body] == pytest.approx(centre, abs=NUMBER_TOLERANCE), name
        np.testing.assert_allclose(inertia(model, body), matrix, atol=NUMBER_TOLERANCE, rtol=0, err_msg=name)


def check_mass_matrix(ours: Any, theirs: Any, joints: Sequence[str], angles: np.ndarray) -> None:
    """Two models have the same mass matrix at a pose."""
    found, expected = (mass_matrix(model, joints, angles) for model in (ours, theirs))
    for rows in (slice(0, 3), slice(3, None)):
        for columns in (slice(0, 3), slice(3, None)):
            scale = np.abs(expected[rows, columns]).max()
            np.testing.assert_allclose(
                found[rows, columns], expected[rows, columns], atol=MASS_MATRIX_TOLERANCE * scale, rtol=0
            )


def check_limits(
    ours: Any, theirs: Any, joints: Sequence[str], others: Mapping[str, tuple[float, float]] | None = None
) -> None:
    """Two models have the same joint axes and ranges, and the motors of ours the torque limits of theirs.

    Args:
        ours: Our model.
        theirs: The vendor's.
        joints: What is compared.
        others: Limits that ours has from another source [N*m], and the vendor's, by the end of the joint's name.
    """
    motors = {ours.joint(ours.actuator_trnid[index, 0]).name: index for index in range(ours.nu)}
    for name in joints:
        mine, other = ours.joint(name), theirs.joint(name)
        assert mine.range == pytest.approx(other.range, abs=NUMBER_TOLERANCE), name
        assert mine.axis == pytest.approx(other.axis), name
        limit, published = ours.actuator_ctrlrange[motors[name]], theirs.jnt_actfrcrange[other.id]
        known = next((pair for end, pair in (others or {}).items() if name.endswith(end)), None)
        if known is None:
            assert limit == pytest.approx(published), name
        else:
            assert (limit[1], published[1]) == pytest.approx(known), name


def check_bare_motors(model: Any, joints: Sequence[str], imu: Sequence[str]) -> None:
    """Motors of gear 1 and joint sensors in the order of the joints, torque limited, and no passive joint value."""
    import mujoco

    assert [model.joint(index).name for index in range(model.njnt)] == ["root", *joints]
    stems = [name.removesuffix("_joint") for name in joints]
    assert [model.actuator(index).name for index in range(model.nu)] == stems
    assert model.actuator_trnid[:, 0].tolist() == [model.joint(name).id for name in joints]
    sensors = [model.sensor(index).name for index in range(model.nsensor)]
    assert sensors == [*(f"{stem}_pos" for stem in stems), *(f"{stem}_vel" for stem in stems), *imu]
    assert (model.actuator_gaintype == mujoco.mjtGain.mjGAIN_FIXED).all()
    assert (model.actuator_biastype == mujoco.mjtBias.mjBIAS_NONE).all()
    assert (model.actuator_gainprm[:, 0] == 1.0).all()
    assert (model.actuator_gear[:, 0] == 1.0).all()
    assert model.actuator_ctrllimited.all()
    for values in (model.dof_damping, model.dof_frictionloss, model.dof_armature, model.jnt_stiffness):
        assert not np.any(values)


def check_ranges_mirror(model: Any, parts: Sequence[str]) -> None:
    """The right side's ranges are the left's, mirrored where the axis is x or z."""
    for part in parts:
        left, right = (model.joint(f"{side}_{part}_joint") for side in ("left", "right"))
        mirrored = left.range if left.axis[1] else -left.range[::-1]
        assert right.range == pytest.approx(mirrored), part


def check_no_self_collision(model: Any) -> None:
    """No pose makes two links of a robot touch, so neighbours cannot push each other apart."""
    import mujoco

    data = mujoco.MjData(model)
    limits = np.array([model.jnt_range[index] for index in range(1, model.njnt)])
    for angles in np.random.default_rng(7).uniform(limits[:, 0], limits[:, 1], size=(50, len(limits))):
        data.qpos[7:] = angles
        mujoco.mj_forward(model, data)
        assert data.ncon == 0
