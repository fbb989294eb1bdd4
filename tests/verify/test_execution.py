"""Python files run only where they are what the spec compiles to; what nobody ran and nobody read is reported."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from actspec.verify.agreement import TargetFiles
from actspec.verify.execution import changed, other_rows, withheld
from tests.verify.making import Built, Edit, build, replaced

PYTHON = ("isaaclab", "custom", "mjlab")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The rich spec, compiled."""
    return build(tmp_path_factory.mktemp("rich"))


def spy(marker: Path) -> Edit:
    """A file that leaves a mark when it is executed."""
    return lambda text: f"{text}\nopen({str(marker)!r}, 'w').close()\n"


@pytest.mark.parametrize("name", PYTHON)
def test_edited_file_is_not_executed(name: str, built: Built, tmp_path: Path) -> None:
    """An edited cfg is read and not run, whether its engine is here or not, and that is said with what would run it."""
    marker = tmp_path / "executed"
    agreement = built.verified(name, spy(marker), engines=True, run_edited=False)
    assert not marker.exists()
    (skip,) = [skip for skip in agreement.skipped if skip.what == "torque" and not skip.group]
    file = built.targets[name].files[0]
    assert skip.reason == (
        f"{file} is not what the spec compiles to, and would be executed: only its fields are compared"
    )
    assert skip.help is not None and "--run-edited" in skip.help
    assert not any(row.engine for row in agreement.rows)


@pytest.mark.parametrize("name", PYTHON)
def test_statement_that_no_field_tells(name: str, built: Built, tmp_path: Path) -> None:
    """A statement beside the cfgs is a disagreement at its line, because neither engine nor reader took it."""
    agreement = built.verified(name, spy(tmp_path / "executed"), run_edited=False)
    (row,) = agreement.faults
    assert (row.code, row.quantity) == ("VFY110", "code")
    assert row.place is not None
    line = Path(row.place.path).read_text("utf-8").splitlines()[row.place.line - 1]
    assert line.startswith("open(")


@pytest.mark.parametrize(
    "name, edit",
    [
        ("custom", replaced("self._stall_torque * (-1.0 - speed)", "-self._stall_torque * (1.0 - speed)")),
        ("custom", replaced("encoder_bias: dict[str, float] | float = 0.0", "encoder_bias: float = 0.1")),
        ("mjlab", replaced("    spec.delete(actuator)\n", "    pass\n")),
        ("mjlab", replaced('DRIVEN_JOINTS = (\n  "left_hip",', "DRIVEN_JOINTS = (")),
        ("isaaclab", replaced("from isaaclab.actuators import", "from evil import")),
        ("isaaclab", lambda text: f'{text}\nRICH_ACTUATORS["hips"].stiffness = 3.0\n'),
        ("isaaclab", lambda text: f"{text}\nRICH_ACTUATORS = dict(RICH_ACTUATORS)\n"),
    ],
    ids=["law", "default of a class", "function", "names", "import", "change of a cfg", "second assignment"],
)
def test_code_that_nobody_ran(name: str, edit: Edit, built: Built) -> None:
    """What a class, a function or a later statement says is in no field, and is reported."""
    quantities = {row.quantity for row in built.verified(name, edit, run_edited=False).faults}
    assert "code" in quantities


@pytest.mark.parametrize("name", PYTHON)
def test_remarks_are_no_code(name: str, built: Built) -> None:
    """A remark more changes nothing."""
    assert built.verified(name, lambda text: f"# mine\n{text}\n# ours\n", run_edited=False).faults == ()


def test_what_is_as_compiled_runs(built: Built, tmp_path: Path) -> None:
    """A folder with the same bytes may run, one with others may not; files that are only read are not held back."""
    target = built.targets["isaaclab"]
    copy = tmp_path / "isaaclab"
    copy.mkdir()
    for file in target.files:
        (copy / file).write_bytes(Path(target.folder, file).read_bytes())
    there = replace(target, folder=str(copy))
    assert changed(there) == () and withheld(there, run_edited=False) is None
    (copy / target.files[0]).write_bytes(b"# other\n")
    assert changed(there) == target.files
    assert withheld(there, run_edited=False) is not None and withheld(there, run_edited=True) is None
    model = replace(built.targets["mujoco"], folder=str(copy))
    assert changed(model) == model.files and withheld(model, run_edited=False) is None


def test_another_network(built: Built, tmp_path: Path) -> None:
    """A network beside a cfg is compared byte by byte, and never loaded for that."""
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    for folder, data in ((ours, b"net"), (theirs, b"other")):
        folder.mkdir()
        (folder / "net.pt").write_bytes(data)
    target = TargetFiles(built.targets["isaaclab"].options, str(ours), str(ours), ("cfg.py", "net.pt"), ())
    assert [row.ok for row in other_rows(target)] == [True]
    (row,) = other_rows(replace(target, folder=str(theirs)))
    assert (row.code, row.quantity) == ("VFY110", "file net.pt")
    assert "net.pt is not the file that the spec names" in row.message
