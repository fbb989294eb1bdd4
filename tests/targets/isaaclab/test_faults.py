"""What the Isaac Lab target refuses: named, with its place and what to do."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import pytest

from actspec import api
from actspec.diagnostics import EmitError
from tests.frameworks.isaaclab_asking import compiled
from tests.network_files import torchscript
from tests.targets.isaaclab.emitting import cfgs

PLAIN = """actspec: 1
robot: {name: bot, model: none, joints: [a]}
timing: {physics_dt: 5 ms}
actuators:
  legs: {joints: [a], level: ideal_pd, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 9 N*m}
"""

NET = """actspec: 1
robot: {name: bot, model: none, joints: [a]}
timing: {physics_dt: 5 ms}
actuators:
  legs:
    joints: [a]
    level: actuator_net
    effort_limit: 9 N*m
    network: {file: net.pt, manifest: net.json}
"""

MANIFEST: dict[str, Any] = {
    "format": "actspec-network/1",
    "kind": "mlp",
    "inputs": "position_velocity",
    "taps": [0, 1],
    "tap_period": "10 ms",
    "position_scale": 1.0,
    "velocity_scale": 1.0,
    "torque_scale": 1.0,
    "initial_history": "zero",
}


def faults(
    text: str, version: str = "2.3", cls: str | dict[str, str] = "auto", *, path: str = "s.yaml", **more: Any
) -> list[str]:
    """What is said against a spec: `CODE where: message | help`."""
    with pytest.raises(EmitError) as caught:
        compiled(text, version, cls, path=path, **more)
    assert all(d.span is not None or d.where.startswith("targets.") for d in caught.value.diagnostics)
    return [f"{d.code} {d.where}: {d.message} | {d.help}" for d in caught.value.diagnostics]


@pytest.mark.parametrize(
    "version, more, said",
    [
        (
            "2.4",
            {},
            "ISL001 targets.isaaclab.version: actspec does not know Isaac Lab '2.4' | "
            "known: 2.1, 2.2, 2.3, 3.0; did you mean '2.3'?",
        ),
        (
            "v2",
            {},
            "ISL001 targets.isaaclab.version: actspec does not know Isaac Lab 'v2' | known: 2.1, 2.2, 2.3, 3.0",
        ),
        (
            "2.1",
            {"isaac_sim": "5.1"},
            "ISL001 targets.isaaclab.isaac_sim: Isaac Lab 2.1 does not run on Isaac Sim '5.1' | "
            'write isaac_sim: "4.5"',
        ),
        (
            "2.3",
            {"backend": "newton"},
            "ISL001 targets.isaaclab.backend: Isaac Lab 2.3 has no backend 'newton' | "
            'leave `backend` out, or write version: "3.0"',
        ),
    ],
    ids=["no-such-release", "no-number", "sim", "backend"],
)
def test_versions_that_there_are_not(version: str, more: dict[str, Any], said: str) -> None:
    """A version, Isaac Sim version or backend that does not exist is named with those that do."""
    found = faults(PLAIN, version, **more)
    # difflib's guess among near numbers is of no account.
    assert [item.partition("; did you mean")[0] for item in found] == [said.partition("; did you mean")[0]]


@pytest.mark.parametrize("version", ["2.3.2", " 2.3 ", "2.3.0"])
def test_versions_with_a_patch_are_known(version: str) -> None:
    """A patch release is its minor release."""
    assert "for Isaac Lab 2.3 on Isaac Sim 5.1" in compiled(PLAIN, version).text


def test_own_class_on_3() -> None:
    """Isaac Lab 3.0 runs its actuators natively: no class of one's own."""
    assert faults(PLAIN, "3.0", "custom") == [
        "ISL003 targets.isaaclab.class: Isaac Lab 3.0 runs its actuators natively and refuses classes of one's own | "
        'write class: auto, or version: "2.3"'
    ]


def test_effort_limit_is_never_left_to_a_default() -> None:
    """Without a number some versions clip nothing at all."""
    (said,) = faults(PLAIN.replace("effort_limit: 9 N*m", "effort_limit: unknown"))
    assert said.startswith("ISL010 actuators.legs.effort_limit: a: effort_limit is unknown")


@pytest.mark.parametrize("command", ["position", "effort"])
def test_the_solver_has_a_limit_of_its_own(command: str) -> None:
    """With the solver's own drives the USD's limit stays, and a warning says so; it is in no field."""
    drive = "kp: 20 N*m/rad, kd: 0.5 N*m*s/rad" if command == "position" else "command: effort"
    text = PLAIN.replace("kp: 20 N*m/rad, kd: 0.5 N*m*s/rad", drive)
    done = compiled(text.replace("effort_limit: 9 N*m", "effort_limit: unknown"), "2.3", "implicit")
    (item,) = [d for d in done.emission.diagnostics if d.code == "ISL034"]
    assert item.message == "the effort limit of 1 joint is unknown, and Isaac Lab takes the USD's: a"
    assert "effort_limit_sim=None,  # unknown: the USD's own" in done.text
    assert "effort_limit_sim=9.0" in compiled(text, "2.3", "implicit").text


GAINS = """actspec: 1
robot: {name: bot, model: none, joints: [a1, a2, a3, f1, f2]}
timing: {physics_dt: 5 ms}
actuators:
  arm: {joints: ["a.*"], level: ideal_pd, kp: 20 N*m/rad, kd: unknown, effort_limit: 9 N*m, armature: 0.01 kg*m^2}
  hand: {joints: ["f.*"], level: ideal_pd, kp: 5 N*m/rad, kd: 0.1 N*m*s/rad, effort_limit: 2 N*m, armature: 0.01 kg*m^2}
"""


LIMITS = "kd: 1 N*m*s/rad, effort_limit: unknown, armature: unknown"


@pytest.mark.parametrize(
    "change, said",
    [
        (
            ("", ""),
            [
                (
                    "ISL031",
                    "actuators.arm.kd",
                    "the drive gain kd of 3 joints is unknown, {}: a1, a2, a3",
                    "state kd",
                )
            ],
        ),
        (
            ("kd: 0.1 N*m*s/rad", "kd: unknown"),
            [
                (
                    "ISL031",
                    "actuators",
                    "the drive gain kd of 5 joints is unknown, {}: arm (a1, a2, a3), hand (f1, f2)",
                    "state kd",
                )
            ],
        ),
        (
            ("kp: 5 N*m/rad, kd: 0.1 N*m*s/rad", "kp: unknown, kd: unknown"),
            [
                (
                    "ISL031",
                    "actuators.arm.kd",
                    "the drive gain kd of 3 joints is unknown, {}: a1, a2, a3",
                    "state kd",
                ),
                (
                    "ISL031",
                    "actuators.hand",
                    "kp and kd of 2 joints are unknown, {}: f1, f2",
                    "state kp and kd",
                ),
            ],
        ),
        (
            ("kd: unknown, effort_limit: 9 N*m, armature: 0.01 kg*m^2", LIMITS),
            [
                (
                    "ISL030",
                    "actuators.arm.armature",
                    "the armature of 3 joints is unknown, {}: a1, a2, a3",
                    "state armature, or rotor_inertia and gear_ratio of the motor",
                ),
                (
                    "ISL034",
                    "actuators.arm.effort_limit",
                    "the effort limit of 3 joints is unknown, {}: a1, a2, a3",
                    "state effort_limit",
                ),
            ],
        ),
    ],
    ids=["one-group", "two-groups", "groups-that-lack-other-gains", "no-gain"],
)
def test_what_is_left_to_the_usd(change: tuple[str, str], said: list[tuple[str, str, str, str]]) -> None:
    """What lacks is named, where it does, and asked for; what is stated is not."""
    found = compiled(GAINS.replace(*change), "2.3", "implicit").emission.diagnostics
    usd = "and Isaac Lab takes the USD's"
    assert {(d.code, d.where, d.message, d.help) for d in found} == {
        (code, where, message.format(usd), help) for code, where, message, help in said
    }


def test_joints_of_a_group_share_a_message() -> None:
    """What is wrong with a group is said once, with its joints; a delay of years too."""
    three = PLAIN.replace("joints: [a]", "joints: [a, b, c]")
    (said,) = faults(three.replace("effort_limit: 9 N*m", "effort_limit: unknown"))
    assert said.startswith("ISL010 actuators.legs.effort_limit: a, b, c: effort_limit is unknown")
    (said,) = faults(
        three.replace("effort_limit: 9 N*m", "effort_limit: 9 N*m, delay: {value: 100000 s, sure: true}")
    )
    assert said.startswith(
        "ISL011 actuators.legs: a, b, c: delay must be at most 1000000 steps of 0.005 s, got 100000 s"
    )


@pytest.mark.parametrize("command", ["velocity", "effort"])
def test_network_of_another_command(tmp_path: Path, command: str) -> None:
    """The classes give a network the error of a position; any other command would be ignored without a word."""
    text = NET.replace("effort_limit", f"command: {command}\n    effort_limit")
    assert faults(text, path=written(tmp_path, MANIFEST)) == [
        f"ISL022 actuators.legs.command: the network's classes take the error of a position, got command {command} | "
        "write command: position, or leave this target out"
    ]


def test_delta_action_does_not_depend_on_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The text names the network's file, not the way to it: compiled from elsewhere it is the same."""
    delta = "delta_action: {manifest: nets/delta.json}\n"
    texts = set()
    for folder, path in ((tmp_path, "s.yaml"), (tmp_path.parent, str(tmp_path / "s.yaml"))):
        monkeypatch.chdir(folder)
        texts.add(compiled(PLAIN + delta, path=path).text)
    (text,) = texts
    assert "delta_action: delta.json -> none" in text


def written(folder: Path, manifest: dict[str, Any]) -> str:
    """Path of a spec beside a network and its manifest."""
    (folder / "net.pt").write_bytes(torchscript())
    (folder / "net.json").write_text(json.dumps(manifest, indent=2), encoding="utf-8")
    return str(folder / "s.yaml")


def test_network_without_manifest(tmp_path: Path) -> None:
    """A network file alone tells neither order nor scales nor period."""
    path = written(tmp_path, MANIFEST)
    (said,) = faults(NET.replace(", manifest: net.json", ""), path=path)
    assert said.startswith("NET002 actuators.legs.network: the network has no manifest")
    assert "manifest: ..." in said


@pytest.mark.parametrize(
    "data, said",
    [
        (b"", "'net.pt' is empty | put the network's own file there"),
        (
            b"weights",
            "'net.pt' cannot be read: it is neither a TorchScript nor an ONNX file, or it is cut off | None",
        ),
    ],
    ids=["empty", "text"],
)
def test_network_file_that_is_none(tmp_path: Path, data: bytes, said: str) -> None:
    """Of a `.pt` it is not said that it is no ONNX file, and an empty file is called that."""
    path = written(tmp_path, MANIFEST)
    (tmp_path / "net.pt").write_bytes(data)
    assert faults(NET, path=path) == [f"NET011 actuators.legs.network: {said}"]


def test_network_without_a_stated_step(tmp_path: Path) -> None:
    """5 ms are no multiple of the 2 ms that are taken where nobody states a step: the step is asked for, once."""
    path = written(tmp_path, {**MANIFEST, "tap_period": "5 ms"})
    text = NET.replace("timing: {physics_dt: 5 ms}\n", "") + 'targets: {isaaclab: {version: "2.3"}}\n'
    said = (
        "NET007 actuators.legs.network: tap_period 5 ms is not a whole number of physics steps of 2 ms, MuJoCo's "
        "default: neither the spec nor its model states one | set timing.physics_dt to 5 ms or a whole part of it"
    )
    assert faults(text, path=path) == [said]
    Path(path).write_text(text)
    with pytest.raises(EmitError) as caught:
        api.compile(path)
    assert [f"{d.code} {d.where}: {d.message} | {d.help}" for d in caught.value.diagnostics] == [said]
    lstm = {**MANIFEST, "kind": "lstm", "taps": [0], "tap_period": "4 ms", "torque_scale": 1.0}
    (found,) = faults(text, path=written(tmp_path, lstm))
    assert "a tap_period of 2 physics steps (MuJoCo's default: neither" in found


@pytest.mark.parametrize(
    "change, code, words",
    [
        (
            {"tap_period": "12 ms"},
            "NET007",
            "tap_period 12 ms is not a whole number of physics steps of 5 ms",
        ),
        ({"tap_period": "2 ms"}, "NET007", "tap_period 2 ms is not a whole number"),
        ({"kind": "gru"}, "ISL020", "mlp and lstm"),
        ({"kind": "lstm"}, "ISL021", "taps [0, 1], a tap_period of 2 physics steps"),
        ({"torque_scale": "a"}, "SPEC106", "valid number"),
        ({"taps": []}, "SPEC106", "at least 1"),
        ({"sha256": "0" * 64}, "NET005", "not the one that its manifest describes"),
        ({"colour": 1}, "SPEC101", "unknown key 'colour'"),
    ],
    ids=["period", "short-period", "gru", "lstm", "scale", "no-taps", "hash", "key"],
)
def test_manifests_that_do_not_fit(tmp_path: Path, change: dict[str, Any], code: str, words: str) -> None:
    """A manifest that the classes or the physics step contradict is refused with the figures."""
    said = faults(NET, path=written(tmp_path, {**MANIFEST, **change}))
    assert len(said) == 1
    assert said[0].startswith(code), said
    assert words in said[0], said


def test_place_in_the_manifest(tmp_path: Path) -> None:
    """A fault of the manifest is shown at its line."""
    path = written(tmp_path, {**MANIFEST, "position_scale": float("inf")})
    with pytest.raises(EmitError) as caught:
        compiled(NET, path=path)
    (fault,) = caught.value.diagnostics
    assert fault.span is not None
    assert (Path(fault.span.path).name, fault.span.line) == ("net.json", 10)


@pytest.mark.parametrize("missing", ["net.pt", "net.json"])
def test_files_that_are_not_there(tmp_path: Path, missing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A missing network or manifest is an error of the compile, not of the training to come."""
    path = written(tmp_path, MANIFEST)
    (tmp_path / missing).unlink()
    # By its name alone: of a long path the message has the beginning.
    monkeypatch.chdir(tmp_path)
    (said,) = faults(NET, path=Path(path).name)
    assert missing in said


def test_network_goes_with_the_module(tmp_path: Path) -> None:
    """The network's bytes lie beside the module, which finds them by its own place."""
    digest = hashlib.sha256(torchscript()).hexdigest()
    emitted = compiled(NET, path=written(tmp_path, {**MANIFEST, "sha256": digest}))
    assert [(f.path, f.data) for f in emitted.emission.files[1:]] == [("net.pt", torchscript())]
    assert 'network_file=os.path.join(FOLDER, "net.pt"),' in emitted.text
    assert "input_idx=[0, 2]," in emitted.text
    assert str(tmp_path) not in emitted.text
    # No motor, no line: a box at the limit.
    assert "saturation_effort=1000000000.0," in emitted.text


def test_network_does_not_take_the_target_s_own_names(tmp_path: Path) -> None:
    """A network called like the manifest of the output goes under its group's name."""
    path = written(tmp_path, MANIFEST)
    (tmp_path / "manifest.json").write_bytes(torchscript())
    emitted = compiled(NET.replace("net.pt", "manifest.json"), path=path)
    assert [f.path for f in emitted.emission.files] == ["bot_cfg.py", "legs_manifest.json"]
    assert 'network_file=os.path.join(FOLDER, "legs_manifest.json"),' in emitted.text


def test_implicit_class_runs_no_network(tmp_path: Path) -> None:
    """`class: implicit` and a network exclude each other."""
    (said,) = faults(NET, cls="implicit", path=written(tmp_path, MANIFEST))
    assert said.startswith("ISL004 targets.isaaclab.class")


def test_all_at_once(tmp_path: Path) -> None:
    """Every fault of the target is shown in one go."""
    text = NET.replace("joints: [a]", "joints: [a, b]", 1) + (
        "  arm: {joints: [b], level: ideal_pd, kp: 1 N*m/rad, kd: 0 N*m*s/rad, effort_limit: unknown}\n"
    )
    path = written(tmp_path, {**MANIFEST, "kind": "gru", "tap_period": "7 ms"})
    codes = sorted(item.split()[0] for item in faults(text, "3.0", "custom", path=path))
    assert codes == ["ISL003", "ISL010", "ISL020", "NET007"]


def test_a_class_of_some_joints() -> None:
    """Of two groups in one spec one has the solver's drive; which joints, patterns say."""
    text = NET.split("actuators:")[0].replace("joints: [a]", "joints: [a, b]") + (
        "actuators:\n  legs: {joints: [a, b], level: ideal_pd, kp: 20, kd: 0.5, effort_limit: 9}\n"
    )
    emitted = compiled(text, cls={"b": "implicit"})
    assert {name: cfg["class"] for name, cfg in cfgs(emitted.text).items()} == {
        "legs_a": "IdealPDActuatorCfg",
        "legs_b": "ImplicitActuatorCfg",
    }
    assert emitted.emission.explicit == frozenset("a")
    said = faults(text, cls={"b": "implicit", "c": "auto", "[ab]": "implicit"})
    assert [item.split(":")[0] for item in said] == [
        "ISL002 targets.isaaclab.class.c",
        "ISL002 targets.isaaclab.class.[ab]",
    ]
    assert "b: matched by 'b' too" in said[1]


def test_an_unknown_limit_of_the_solvers_drive_alone() -> None:
    """`a` has the USD's limit, `b` is explicit and must have a number."""
    text = NET.split("actuators:")[0].replace("joints: [a]", "joints: [a, b]") + (
        "actuators:\n  legs: {joints: [a, b], level: ideal_pd, kp: 20, kd: 0.5, effort_limit: unknown}\n"
    )
    (said,) = faults(text, cls={"a": "implicit"})
    assert said.startswith("ISL010 actuators.legs.effort_limit: b: effort_limit is unknown")
