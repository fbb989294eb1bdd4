"""Deploy files whose lists have no names of joints, beside a robot: what is passed over is said, with why."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.cli.main import main

NAMES = ("hip", "thigh", "calf", "toe")


def urdf(names: tuple[str, ...], mimic: str = "") -> str:
    """A chain of joints; one may follow the first."""
    parts, last = ["<robot name='leg'><link name='base'/>"], "base"
    for name in names:
        follows = f"<mimic joint='{names[0]}'/>" if name == mimic else ""
        parts.append(
            f"<link name='{name}_link'/><joint name='{name}' type='revolute'><parent link='{last}'/>"
            f"<child link='{name}_link'/><limit lower='-1' upper='1' effort='9' velocity='9'/>{follows}</joint>"
        )
        last = f"{name}_link"
    return "".join([*parts, "</robot>"])


def imported(
    folder: Path, deploy: str, capsys: pytest.CaptureFixture[str], robot: str = urdf(NAMES)
) -> tuple[str, str, str]:
    """The spec of a URDF and a deploy file, what is said, and the errors."""
    (folder / "leg.urdf").write_text(robot, encoding="utf-8")
    (folder / "deploy.yaml").write_text(deploy, encoding="utf-8")
    spec = folder / "leg.yaml"
    assert main(["import", str(folder / "leg.urdf"), str(folder / "deploy.yaml"), "-o", str(spec)]) == 0
    said = capsys.readouterr()
    return spec.read_text(encoding="utf-8"), said.out, said.err


def test_lists_without_names(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They are neither taken nor missing: the file has so many, and names of joints are what lacks."""
    deploy = "policy_dt: 0.02\nkps: [30, 30, 40, 50]\nkds: [1, 1, 2, 2]\ndefault_angles: [0, 0.5, -1, 0]\n"
    text, out, err = imported(tmp_path, deploy, capsys)
    remark = (
        "deploy.yaml: no joint is named for kps, kds, default_angles (4 entries each), so they are left out: add to "
        "the file joint_names: [...] in the order of its lists"
    )
    assert f"  {remark}\n" in out and remark in text.replace("\n  # ", " ")
    assert "  kp is left out, deploy.yaml:2 has 4 without joint names: legs\n" in out
    assert "no file states kp" not in out and "no file has gains" not in text
    assert "    kp: unknown    # deploy.yaml:2 has 4 without joint names\n" in text
    assert "    kd: unknown    # deploy.yaml:3 has 4 without joint names\n" in text
    assert "# pose at zero action, by pattern; deploy.yaml:4 has 4 without joint names\n" in text
    assert "  control_dt: {value: 20 ms, source: deploy}    # deploy.yaml:1\n" in text
    # Said once: not by the reader too.
    assert "DEPLOY002" not in err


def test_lists_of_unlike_lengths(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each has its number of entries; the two of a range are of no joint."""
    deploy = "kps: [30, 40, 50]\nkds: [1, 2, 2]\ndefault_angles: [0, 0.5, -1, 0]\ntorque_limits: [1, 2]\n"
    _, out, err = imported(tmp_path, deploy, capsys)
    assert "torque_limits: it is a list without joint names" in err and "kps" not in err
    assert (
        "no joint is named for kps (3 entries), kds (3 entries), default_angles (4 entries), so they are"
        in out
    )


def test_lists_of_another_robot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of five entries for four joints nothing is taken, no time and no scale, and no deploy file is to be written."""
    deploy = "policy_dt: 0.02\naction_scale: 0.25\nkps: [3, 3, 4, 5, 6]\nkds: [1, 1, 2, 2, 2]\n"
    text, out, err = imported(tmp_path, deploy, capsys)
    assert (
        f"{tmp_path / 'deploy.yaml'}:3:6: DRF008 [warning]: kps has 5 entries, and {tmp_path / 'leg.urdf'} 4 joints: "
        "the file is taken for another robot's, and nothing of it is used\n"
    ) in err
    assert "control_dt: {" not in text and "action_scale" not in text and "deploy" not in text
    assert f"from {tmp_path / 'leg.urdf'}\n" in out and "  no file states kp: legs\n" in out


@pytest.mark.parametrize(
    "count, robot, taken",
    [
        (4, urdf(NAMES), True),
        # Legs of a humanoid: for whom of the four is not said.
        (3, urdf(NAMES), False),
        # The one that follows has no drive of its own.
        (3, urdf(NAMES, "toe"), True),
    ],
    ids=["all", "some", "all that move"],
)
def test_equal_entries(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], count: int, robot: str, taken: bool
) -> None:
    """They are every joint's where they are as many."""
    deploy = f"action_scale: 0.25\nkps: {[30] * count}\nkds: {[1] * count}\n"
    text, out, _ = imported(tmp_path, deploy, capsys, robot)
    assert ("    kp: {value: 30 N*m/rad, source: deploy}" in text) is taken
    assert ("    kp: unknown    # deploy.yaml:2 has 3 without joint names" in text) is not taken
    assert (f"no joint is named for kps, kds ({count} entries each)" in out) is not taken
    assert "    action_scale: {value: 0.25, source: deploy}" in text
