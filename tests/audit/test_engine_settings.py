"""Settings files: which one counts, what it may say, and what is told when it says something else."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from actspec.audit.finding import Confidence
from actspec.audit.settings import Settings, load_settings
from actspec.cli.main import main
from actspec.diagnostics import AuditError, Severity
from actspec.readings.versions import Versions
from actspec.simulators import isaaclab, mujoco, text_of
from tests.audit.making import rule_of

RULES = (
    rule_of("DMP901", "other-rule", options={"ratio": 0.5, "most": 3.0}),
    rule_of("LIM901", "first-rule"),
)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, some way down a project."""
    inner = tmp_path / "robots" / "leg"
    inner.mkdir(parents=True)
    monkeypatch.chdir(inner)
    return tmp_path


def test_everything_is_read(folder: Path) -> None:
    """Every key of the settings reaches its field; paths are relative to the file."""
    (folder / "actspec.toml").write_text(
        """
        [audit]
        select = ["LIM", "other-rule"]
        ignore = ["LIM901"]
        fail-on = "warning"
        min-confidence = "medium"
        baseline = "ci/known.json"
        per-file-ignores = {"vendor/**" = ["LIM"]}
        severity = {DMP = "info"}
        versions = {mujoco = "3.12", isaac-sim = "5.1", backend = "newton"}
        [audit.rules.DMP901]
        ratio = 1
        """
    )
    assert load_settings(RULES) == Settings(
        select=("LIM", "other-rule"),
        ignore=("LIM901",),
        per_file_ignores=(("vendor/**", ("LIM",)),),
        severity={"DMP": Severity.INFO},
        fail_on=Severity.WARNING,
        min_confidence=Confidence.MEDIUM,
        options={"DMP901": {"ratio": 1.0}},
        versions=Versions(mujoco="3.12", isaac_sim="5.1", backend="newton"),
        baseline=os.path.join("..", "..", "ci", "known.json"),
        folder=os.path.join("..", ".."),
    )


def test_the_nearest_file_counts(folder: Path) -> None:
    """Files are looked for upwards; actspec.toml goes before a pyproject.toml beside it, and silent ones are passed."""
    assert load_settings(RULES) == Settings()
    (folder / "pyproject.toml").write_text("[tool.actspec.audit]\nselect = ['LIM']\n")
    assert load_settings(RULES).select == ("LIM",)
    (folder / "robots" / "pyproject.toml").write_text("[tool.ruff]\nselect = ['X']\n")
    assert load_settings(RULES).select == ("LIM",)
    (folder / "robots" / "actspec.toml").write_text("[audit]\nselect = ['DMP']\n")
    (folder / "robots" / "pyproject.toml").write_text("[tool.actspec.audit]\nselect = ['LIM901']\n")
    assert load_settings(RULES).select == ("DMP",)
    assert load_settings(RULES, config=str(folder / "pyproject.toml")).select == ("LIM",)


def test_of_two_in_one_folder_the_other_is_said(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its `exclude` and `fail-on` do nothing, which is a warning; not where the user named a file, or it is silent."""
    Path("leg.xml").write_text("<mujoco/>")
    (folder / "robots" / "actspec.toml").write_text("[audit]\n")
    other = folder / "robots" / "pyproject.toml"
    said = []
    for text in ("[tool.ruff]\n", "[tool.actspec.audit]\nfail-on = 'warning'\n"):
        other.write_text(text)
        for options in ([], ["--config", os.path.join("..", "actspec.toml")]):
            main(["audit", "leg.xml", *options])
            said.append([line for line in capsys.readouterr().err.splitlines() if "AUD019" in line])
    place = os.path.join("..", "pyproject.toml")
    told = f"{place}: AUD019 [warning]: its [tool.actspec] is not read: actspec.toml beside it goes before it"
    assert said == [[], [], [told], []]


def test_a_wrong_target_is_a_wrong_option(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It stands in no settings file, so it has not the code of one."""
    Path("leg.xml").write_text("<mujoco/>")
    for target in ("isaclab==2.3", "isaaclab==x", "backend==bullet"):
        assert main(["audit", "leg.xml", "-t", target]) == 2
        assert "AUD010 --target" in capsys.readouterr().err


def test_a_fault_is_told_by_the_path_from_here(folder: Path) -> None:
    """The file is two folders up: so it is named, and not by all folders of the machine."""
    (folder / "actspec.toml").write_text("[audit\n")
    with pytest.raises(AuditError) as caught:
        load_settings(RULES)
    (item,) = caught.value.diagnostics
    assert item.span is not None
    assert (item.code, item.span.path) == ("AUD001", os.path.join("..", "..", "actspec.toml"))


def test_never_fails_the_run(folder: Path) -> None:
    """`never` is a severity that no finding has."""
    (folder / "actspec.toml").write_text("[audit]\nfail-on = 'never'\n")
    assert load_settings(RULES).fail_on is None


@pytest.mark.parametrize(
    "text, told",
    [
        ("[audit]\nselct = []", ["AUD002 audit.selct: unknown key|did you mean 'select'?"]),
        ("[audit]\nfail_on = 'error'", ["AUD002 audit.fail_on: unknown key|did you mean 'fail-on'?"]),
        ("[adit]", ["AUD002 adit: unknown key|did you mean 'audit'?"]),
        ("ignore = ['LIM']", ["AUD002 ignore: unknown key|the settings stand below [audit]"]),
        ("audit = 3", ["AUD004 audit: must be a table, got 3|None"]),
        (
            "[audit]\nselect = 'LIM'",
            ["AUD004 audit.select: must be a list of codes or names, got 'LIM'|None"],
        ),
        ("[audit]\nselect = [1]", ["AUD004 audit.select: must be a list of codes or names, got [1]|None"]),
        (
            "[audit]\nignore = ['LIN901']",
            [
                "AUD003 audit.ignore: no rule has the code, the beginning of a code or the name 'LIN901'"
                "|did you mean 'LIM901'?"
            ],
        ),
        (
            "[audit]\nfail-on = 'eror'",
            [
                "AUD004 audit.fail-on: must be one of error, warning, info, never, got 'eror'|did you mean 'error'?"
            ],
        ),
        (
            "[audit.severity]\nLIM = 1",
            ["AUD004 audit.severity.LIM: must be one of error, warning, info, got 1|None"],
        ),
        (
            "[audit.rules.DMP901]\nratoi = 1\nmost = 'x'",
            [
                "AUD002 audit.rules.DMP901.ratoi: unknown key|did you mean 'ratio'?",
                "AUD004 audit.rules.DMP901.most: must be a number, got 'x'|None",
            ],
        ),
        (
            "[audit.rules.DMP901]\nmost = nan",
            ["AUD004 audit.rules.DMP901.most: must be a number, got nan|None"],
        ),
        (
            "[audit.rules.DMP901]\nmost = true",
            ["AUD004 audit.rules.DMP901.most: must be a number, got True|None"],
        ),
        ("[audit.rules.LIM901]\nx = 1", ["AUD002 audit.rules.LIM901: LIM901 has no options|None"]),
        (
            "[audit.rules.DMP902]",
            ["AUD003 audit.rules.DMP902: no rule has this code or name|did you mean 'DMP901'?"],
        ),
        (
            "[audit.versions]\nmujoco = 3.10",
            ['AUD004 audit.versions.mujoco: must be text, got 3.1|write "2.3"'],
        ),
        (
            "[audit.versions]\nisaclab = '2.3'",
            [
                "AUD002 audit.versions.isaclab: 'isaclab' is not a simulator or backend that files can be for"
                "|did you mean 'isaaclab'?"
            ],
        ),
        (
            "[audit.versions]\nmujoco = 'new'",
            ["AUD004 audit.versions.mujoco: must be a version such as 2.3, got 'new'|None"],
        ),
        (
            "[audit.versions]\nbackend = 'bullet'",
            ["AUD004 audit.versions.backend: must be one of physx, ovphysx, newton, got 'bullet'|None"],
        ),
        ("[audit]\nbaseline = ''", ["AUD004 audit.baseline: must be a path, got ''|None"]),
        ("[audit]\nx = [", None),
    ],
    ids=lambda value: value.splitlines()[-1] if isinstance(value, str) else "",
)
def test_what_is_wrong_is_named(text: str, told: list[str] | None, folder: Path) -> None:
    """Every wrong key and value is told at once, by its path, with the nearest right one."""
    (folder / "actspec.toml").write_text(text)
    with pytest.raises(AuditError) as caught:
        load_settings(RULES, config=str(folder / "actspec.toml"))
    items = caught.value.diagnostics
    if told is None:
        assert items[0].message.startswith("this is not TOML: ")
    else:
        assert [f"{item.code} {item.where}: {item.message}|{item.help}" for item in items] == told
    assert all(item.span is not None and item.span.path == str(folder / "actspec.toml") for item in items)


def test_pyproject_names_its_own_path(folder: Path) -> None:
    """In a pyproject.toml the key path begins with `tool.actspec`."""
    (folder / "pyproject.toml").write_text("[tool.actspec.audit]\nselct = []\n[tool.actspec.adit]\n")
    with pytest.raises(AuditError) as caught:
        load_settings(RULES)
    assert [item.where for item in caught.value.diagnostics] == [
        "tool.actspec.audit.selct",
        "tool.actspec.adit",
    ]


@pytest.mark.parametrize(
    "name, data, message",
    [
        ("actspec.toml", b"\xff", "the file is not UTF-8, got the byte 0xff"),
        ("actspec.toml", b"x = " + b"[" * 5000, None),
        ("actspec.toml", b" " * (2 << 20), "the settings cannot be read: 2097152 bytes"),
        ("gone.toml", None, "the settings cannot be read: no such file or directory"),
    ],
    ids=["utf-8", "deep", "large", "missing"],
)
def test_files_that_are_no_settings(name: str, data: bytes | None, message: str | None, folder: Path) -> None:
    """A named file that cannot be read as TOML is refused, never passed over."""
    if data is not None:
        (folder / name).write_bytes(data)
    with pytest.raises(AuditError) as caught:
        load_settings(RULES, config=str(folder / name))
    (item,) = caught.value.diagnostics
    assert item.code == "AUD001"
    assert message is None or item.message == message


def test_a_broken_file_of_somebody_else(folder: Path) -> None:
    """A pyproject.toml on the way that is broken and does not speak of actspec is not our trouble."""
    (folder / "pyproject.toml").write_text("[tool.ruff\n")
    assert load_settings(RULES) == Settings()
    (folder / "pyproject.toml").write_text("[tool.actspec\n")
    with pytest.raises(AuditError) as caught:
        load_settings(RULES)
    (item,) = caught.value.diagnostics
    assert item.span is not None
    assert (item.code, item.span.line) == ("AUD001", 1)


@pytest.mark.parametrize(
    ("version", "said"),
    [
        ("mujoco==99.1", ["actspec knows MuJoCo up to {mujoco}, and takes 99.1 for that"]),
        ("isaaclab==99.0", ["actspec knows Isaac Lab up to {isaaclab}, and takes 99.0 for that"]),
        ("mujoco=={mujoco}.3", []),
        ("mujoco==3.2", []),
        ("isaaclab==3", []),
    ],
)
def test_a_version_that_nobody_knows_yet(
    version: str, said: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It counts as the last known one, which is said; a patch of a known release is known."""
    last = {"mujoco": text_of(max(mujoco.RELEASES)), "isaaclab": text_of(max(isaaclab.RELEASES))}
    (tmp_path / "leg.xml").write_text("<mujoco/>")
    main(["audit", str(tmp_path / "leg.xml"), "-t", version.format(**last)])
    found = [line for line in capsys.readouterr().err.splitlines() if "AUD018" in line]
    name = version.format(**last)
    assert found == [f"AUD018 [warning] {name}: {text.format(**last)}" for text in said]
