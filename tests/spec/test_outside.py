"""What a spec names stays in its folder, and what is made of it has a name that every system takes."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.diagnostics import SpecError
from actspec.spec.validate import load_spec

HEAD = "actspec: 1\nrobot: {name: %s, model: none, joints: [a]}\n"
GROUP = "actuators:\n  g: {joints: [a], level: %s, kp: 1, kd: 1, effort_limit: 5 N*m%s}\n"
KEYS = {
    "include": ("include: [%s]\n", GROUP % ("ideal_pd", "")),
    "identified": ("", GROUP % ("ideal_pd", ", identified: %s")),
    "network.file": ("", GROUP % ("actuator_net", ", network: {file: %s}")),
    "network.manifest": ("", GROUP % ("actuator_net", ", network: {manifest: %s}")),
    "delta_action.manifest": ("delta_action: {manifest: %s}\n", GROUP % ("ideal_pd", "")),
}


@pytest.mark.parametrize(
    "name", ["../out.yaml", "/etc/hostname", "link.yaml", "C:/x", "a\\b", "https://a.org/b", "b/Torch.PY."]
)
@pytest.mark.parametrize("key", KEYS)
def test_nothing_outside_is_named(key: str, name: str, tmp_path: Path) -> None:
    """Includes, results and networks are refused in the same words, where the spec names them."""
    folder = tmp_path / "spec"
    folder.mkdir()
    (tmp_path / "out.yaml").write_text("motors: {}\n")
    (folder / "link.yaml").symlink_to(tmp_path / "out.yaml")
    top, group = KEYS[key]
    text = HEAD % "r" + (top % name if top else "") + (group if top else group % name)
    (folder / "s.yaml").write_text(text)
    with pytest.raises(SpecError) as caught:
        load_spec(str(folder / "s.yaml"))
    (found,) = caught.value.diagnostics
    assert found.code == "SPEC013"
    assert found.message.startswith(f"'{name}' ")
    assert found.where.startswith(key) or found.where.endswith(key)
    assert found.span is not None
    line = text.splitlines()[found.span.line - 1]
    assert line[found.span.column - 1 :].startswith(name)


@pytest.mark.parametrize("key", ["network.file", "network.manifest", "delta_action.manifest"])
def test_nothing_outside_lies_beside_a_manifest(key: str, tmp_path: Path) -> None:
    """What a manifest names, and the manifest of a file without one, are no links out of the tree either."""
    (tmp_path / "nets").mkdir()
    (tmp_path / "spec").mkdir()
    (tmp_path / "spec/nets").mkdir()
    out = tmp_path / "nets/out"
    out.write_text("{}")
    named = "legs.pt" if key == "network.file" else "legs.json"
    beside = "legs.json" if key == "network.file" else "legs.onnx"
    text = '{"format": "actspec-network/1", "files": {"onnx": {"path": "legs.onnx"}}}'
    (tmp_path / "spec/nets" / named).write_text(text)
    top, group = KEYS[key]
    spec = tmp_path / "spec/s.yaml"
    spec.write_text(HEAD % "r" + (top % f"nets/{named}" + group if top else group % f"nets/{named}"))
    load_spec(str(spec))
    (tmp_path / "spec/nets" / beside).symlink_to(out)
    with pytest.raises(SpecError) as caught:
        load_spec(str(spec))
    (found,) = caught.value.diagnostics
    assert found.message == f"'nets/{beside}' leaves the folder of the spec by a symbolic link"
    assert (found.code, found.where) == ("SPEC013", key if top else f"actuators.g.{key}")
    assert found.span is not None and found.span.line > 2


@pytest.mark.parametrize("name", ["CON", "nul", "aux.txt", "COM1", "lpt9.x.y", "r.", ".r", "-r", "a/b"])
def test_names_that_are_no_folders_somewhere(name: str, tmp_path: Path) -> None:
    """A robot's and a target's name are folders: devices of Windows are refused as both."""
    targets = f'targets: {{"{name}": {{target: deploy}}}}\n'
    (tmp_path / "s.yaml").write_text(HEAD % f'"{name}"' + targets + GROUP % ("ideal_pd", ""))
    with pytest.raises(SpecError) as caught:
        load_spec(str(tmp_path / "s.yaml"))
    assert [item.code for item in caught.value.diagnostics] == ["SPEC124", "SPEC161"]


def test_names_that_differ_by_case_alone(tmp_path: Path) -> None:
    """Two targets or variants of one folder are refused; a name that only begins as a device's does not matter."""
    targets = "targets: {deploy: {}, Deploy: {target: deploy}, console: {target: deploy}}\n"
    targets += "variants: {soft: {}, Soft: {}, aux: {}, b.: {}}\n"
    (tmp_path / "s.yaml").write_text(HEAD % "auxiliary" + targets + GROUP % ("ideal_pd", ""))
    with pytest.raises(SpecError) as caught:
        load_spec(str(tmp_path / "s.yaml"))
    found = {(item.code, item.where) for item in caught.value.diagnostics}
    assert found == {("SPEC161", name) for name in ("targets.Deploy", "variants.Soft", "variants.b.")}
