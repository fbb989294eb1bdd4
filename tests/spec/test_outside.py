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
}


@pytest.mark.parametrize(
    "name", ["../out.yaml", "/etc/hostname", "link.yaml", "C:/x", "a\\b", "https://a.org/b"]
)
@pytest.mark.parametrize("key", KEYS)
def test_nothing_outside_is_named(key: str, name: str, tmp_path: Path) -> None:
    """Includes and results are refused in the same words, where the spec names them."""
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


@pytest.mark.parametrize("name", ["CON", "nul", "aux.txt", "COM1", "lpt9.x.y", "r.", ".r", "-r", "a/b"])
def test_names_that_are_no_folders_somewhere(name: str, tmp_path: Path) -> None:
    """A robot's and a target's name are folders: devices of Windows are refused as both."""
    targets = f'targets: {{"{name}": {{target: deploy}}}}\n'
    (tmp_path / "s.yaml").write_text(HEAD % f'"{name}"' + targets + GROUP % ("ideal_pd", ""))
    with pytest.raises(SpecError) as caught:
        load_spec(str(tmp_path / "s.yaml"))
    assert [item.code for item in caught.value.diagnostics] == ["SPEC124", "SPEC161"]


def test_names_that_differ_by_case_alone(tmp_path: Path) -> None:
    """Two targets of one folder are refused; a name that only begins as a device's does not matter."""
    targets = "targets: {deploy: {}, Deploy: {target: deploy}, console: {target: deploy}}\n"
    (tmp_path / "s.yaml").write_text(HEAD % "auxiliary" + targets + GROUP % ("ideal_pd", ""))
    with pytest.raises(SpecError) as caught:
        load_spec(str(tmp_path / "s.yaml"))
    (found,) = caught.value.diagnostics
    assert (found.code, found.where) == ("SPEC161", "targets.Deploy")
