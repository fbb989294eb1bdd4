"""Variants: what is merged, what is replaced, where it is reported, and every command that takes one."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from actspec import api
from actspec.cli.main import main
from actspec.diagnostics import SpecError
from actspec.spec.document import load_document
from actspec.spec.variants import split

SPEC = """\
actspec: 1
robot: {name: arm, model: none, joints: [a, b]}
timing: {physics_dt: 5 ms}
include: [motors.yaml]
sources: {bench: {title: Bench}, sheet: {title: Sheet}}
actuators:
  upper:
    joints: [a]
    motor: small
    level: ideal_pd
    kp: {value: 40 N*m/rad, source: bench, note: soft}
    kd: 1 N*m*s/rad
    effort_limit: peak
    friction: {coulomb: 0.2 N*m, viscous: 0.1 N*m*s/rad}
  lower:
    joints: [b]
    motor: small
    level: ideal_pd
    kp: 20 N*m/rad
    kd: 0.5 N*m*s/rad
    effort_limit: peak
variant: light
variants:
  strong:
    motors: {small: {peak_torque: 9 N*m}}
    actuators:
      upper:
        kp: {value: 60 N*m/rad, source: sheet}
        friction: {coulomb: 0.3 N*m}
  swapped:
    actuators:
      upper: {joints: [b]}
      lower: {joints: [a], overrides: {a: {kd: 0.7 N*m*s/rad}}}
"""
MOTORS = """\
motors:
  small: {side: joint, peak_torque: 6 N*m, reflected_inertia: 0.01 kg*m^2}
"""


@pytest.fixture
def spec(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The spec above, in the working folder."""
    monkeypatch.chdir(tmp_path)
    Path("arm.yaml").write_text(SPEC)
    Path("motors.yaml").write_text(MOTORS)
    return "arm.yaml"


def test_fields_are_merged_and_values_replaced(spec: str) -> None:
    """A variant's value brings its own source and no note of the other; what it does not state stays."""
    strong = api.resolve(f"{spec}#strong").joint("a")
    assert strong is not None and strong.kp is not None and strong.kd is not None
    assert (strong.kp.require(), strong.kd.require()) == (60.0, 1.0)
    # Line and column of `{value: 60 ...` in the variant.
    assert strong.kp.span is not None
    assert (strong.kp.span.path, strong.kp.span.line) == (
        "arm.yaml",
        SPEC[: SPEC.index("60 N")].count("\n") + 1,
    )
    assert load_document(f"{spec}#strong").data["actuators"]["upper"]["kp"] == {
        "value": "60 N*m/rad",
        "source": "sheet",
    }
    # Of an included motor one figure is another, and `peak` follows it.
    assert strong.effort_limit.require() == 9.0
    assert (strong.friction_coulomb.require(), strong.friction_viscous.require()) == (0.3, 0.1)


def test_the_spec_itself_stays(spec: str) -> None:
    """Without a name, and by its own, the spec is as it stands."""
    for path in (spec, f"{spec}#light"):
        joint = api.resolve(path).joint("a")
        assert joint is not None and joint.kp is not None
        assert (joint.kp.require(), joint.effort_limit.require()) == (40.0, 6.0)
    assert load_document(spec).text_sha256 == load_document(f"{spec}#light").text_sha256
    assert len({load_document(f"{spec}#{name}").text_sha256 for name in ("light", "strong", "swapped")}) == 3


def test_lists_are_replaced(spec: str) -> None:
    """Joints that change their group leave the old one."""
    found = {joint.joint: joint for joint in api.resolve(f"{spec}#swapped").joints}
    assert {name: joint.group for name, joint in found.items()} == {"a": "lower", "b": "upper"}
    assert [found[name].kd.require() for name in "ab"] == [0.7, 1.0]  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "kp: {value: 60 N*m/rad,",
            "kp: {value: 60 N*m,",
            "arm.yaml:28:21: SPEC110 actuators.upper.kp.value (variant strong)",
        ),
        (
            "upper: {joints: [b]}",
            "uper: {kp: 1 N*m/rad}",
            "arm.yaml:32:7: SPEC016 actuators.uper (variant swapped): the spec",
        ),
        (
            "  strong:\n",
            "  strong:\n    include: [x.yaml]\n",
            "arm.yaml:25:5: SPEC016 include (variant strong): `include`",
        ),
        (
            "  strong:\n",
            "  strong:\n    colour: {red: 1}\n",
            "arm.yaml:25:5: SPEC101 colour (variant strong)",
        ),
        ("  strong:\n", "  str/ong:\n", "SPEC106 variants"),
    ],
    ids=["unit", "group", "include", "key", "name"],
)
def test_validate_checks_every_variant(
    spec: str, old: str, new: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A mistake in a variant is reported at its own line, with the variant's name."""
    assert main(["validate", spec]) == 0
    assert "variants light, strong, swapped" in capsys.readouterr().out
    assert old in SPEC
    Path(spec).write_text(SPEC.replace(old, new))
    assert main(["validate", spec]) == 2
    assert said in capsys.readouterr().err
    if "(variant strong)" in said:
        # Another variant is not concerned.
        assert main(["validate", spec, "--variant", "swapped"]) == 0


@pytest.mark.parametrize(
    ("command", "code"),
    [
        (["validate", "SPEC"], "SPEC016"),
        (["audit", "SPEC"], "AUD008"),
        (["audit", "--skip-other", "SPEC"], "AUD008"),
        (["diff", "FILE", "SPEC"], "DIF001"),
        (["lock", "-o", "a.lock", "SPEC"], "DIF001"),
    ],
)
def test_every_command_says_that_a_variant_is_not_there(
    command: list[str], code: str, spec: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The file is there: the place is its `variants`, and the help names the nearest."""
    names = {"SPEC": f"{spec}#strng", "FILE": spec}
    assert main([names.get(word, word) for word in command]) in (1, 2)
    caught = capsys.readouterr()
    said = caught.out + caught.err
    assert (code in said, "did you mean 'strong'?" in said) == (True, True), said
    assert f"{spec}:{SPEC[: SPEC.index('variants:')].count(chr(10)) + 1}:1" in said
    assert "no such file" not in said


def test_a_variant_of_a_file_that_is_not_there(spec: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Neither of a spec that is missing nor of another kind of file is a variant missing."""
    Path("x.xml").write_text("<mujoco/>")
    for name in ("no.yaml#strong", "x.xml#strong"):
        assert main(["audit", name]) == 2
        assert f"{name}: AUD016: there is no such file or folder" in capsys.readouterr().err


def test_an_unknown_variant_names_the_nearest(spec: str) -> None:
    """There is no variant of that name, and one that is near."""
    with pytest.raises(SpecError) as caught:
        load_document(f"{spec}#strng")
    (item,) = caught.value.diagnostics
    assert (item.code, item.message) == ("SPEC016", "the spec has no variant 'strng'")
    assert item.help == "did you mean 'strong'?"
    # Of names that differ by their numbers none is a slip for another.
    Path(spec).write_text(SPEC.replace("  strong:", "  mode_15:").replace("  swapped:", "  mode_5:"))
    for name, help in (
        ("mode_12", "its variants: light, mode_15, mode_5"),
        ("mode5", "did you mean 'mode_5'?"),
        ("mod_15", "did you mean 'mode_15'?"),
    ):
        with pytest.raises(SpecError) as caught:
            load_document(f"{spec}#{name}")
        assert caught.value.diagnostics[0].help == help
    Path("plain.yaml").write_text(SPEC.split("variant:")[0])
    with pytest.raises(SpecError, match="no variant 'strong'"):
        load_document("plain.yaml#strong")


def test_a_file_of_the_whole_name_goes_first(spec: str) -> None:
    """`#` is allowed in the name of a file."""
    assert split(f"{spec}#strong") == (spec, "strong")
    Path(f"{spec}#strong").write_text("actspec: 1\n")
    assert split(f"{spec}#strong") == (f"{spec}#strong", None)
    assert split("#x") == ("#x", None)


def test_commands(spec: str, capsys: pytest.CaptureFixture[str]) -> None:
    """compile, show, diff, lock and audit take a variant; manifest and written files name it."""
    assert main(["compile", spec, "--variant", "strong", "-t", "deploy"]) == 0
    assert capsys.readouterr().out.startswith("arm (strong): 2 joints")
    folder = Path("build/arm-strong/deploy")
    assert json.loads((folder / "manifest.json").read_text())["variant"] == "strong"
    assert "# variant strong\n" in (folder / "arm_deploy.yaml").read_text()
    assert main(["compile", spec, "-t", "deploy"]) == 0
    assert json.loads(Path("build/arm/deploy/manifest.json").read_text())["variant"] == "light"

    capsys.readouterr()
    assert main(["show", spec, "a", "--variant", "strong"]) == 0
    assert "60 N*m/rad" in capsys.readouterr().out
    assert main(["diff", spec, f"{spec}#strong"]) == 1
    out = capsys.readouterr().out
    assert "stiffness kp 40 -> 60 N*m/rad" in out
    # Friction of `a` alone, the limit of both.
    assert "dry friction 0.2 -> 0.3 N*m" in out and "effort limit 6 -> 9 N*m" in out
    assert main(["diff", f"{spec}#light", spec]) == 0

    assert main(["lock", f"{spec}#strong"]) == 0
    assert main(["lock", "--check"]) == 0
    Path(spec).write_text(SPEC.replace("60 N*m/rad", "61 N*m/rad"))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    assert "arm.yaml#strong" in capsys.readouterr().out

    arguments = ["audit", str(folder / "arm_deploy.yaml"), "--select", "SPC", "--output-format", "json"]
    assert main([*arguments, "--spec", spec]) in (0, 1)
    # By its limit the file is of `strong`, which the changed kp is not any more.
    findings = json.loads(capsys.readouterr().out)["findings"]
    assert {item["code"] for item in findings} == {"SPC101", "SPC107"}
    said = f"this file is of strong, by effort limit; the spec is read as light: use {spec}#strong"
    assert {item["message"] for item in findings if item["code"] == "SPC107"} == {said}
    Path(spec).write_text(SPEC)
    assert main([*arguments, "--spec", f"{spec}#strong"]) == 0
    assert json.loads(capsys.readouterr().out)["findings"] == []


def test_two_variants_at_once(spec: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The name behind `#` and that of `--variant` are told; the same name twice is one."""
    assert main(["validate", f"{spec}#strong", "--variant", "light"]) == 2
    said = capsys.readouterr().err
    assert "two variants are named: 'strong' behind the `#`, and 'light' by `--variant`" in said
    assert main(["validate", f"{spec}#strong", "--variant", "strong"]) == 0


def test_a_missing_file_is_not_like_every_other(tmp_path: Path) -> None:
    """The ending that all have makes no name nearer."""
    (tmp_path / "kd5e.yaml").write_text("actspec: 1\n", encoding="utf-8")
    for name, help in (
        ("nofile", "the folder has kd5e.yaml"),
        ("kd5", f"did you mean '{tmp_path / 'kd5e.yaml'}'?"),
    ):
        with pytest.raises(SpecError) as caught:
            load_document(str(tmp_path / f"{name}.yaml"))
        assert caught.value.diagnostics[0].help == help
