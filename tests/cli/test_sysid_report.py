"""`actspec sysid report`: a results file beside its logs, as one page that needs nothing else."""

from __future__ import annotations

import hashlib
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import yaml

from actspec.cli.main import main
from actspec.logs import write_log
from tests.sysid.test_fit import MODEL, SPEC, TRUE, logged

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow

UNITS = {
    "kp": "N*m/rad", "kd": "N*m*s/rad", "armature": "kg*m^2", "friction.coulomb": "N*m",
    "friction.viscous": "N*m*s/rad", "delay": "s", "encoder_bias": "rad",
}  # fmt: skip
BAD = "<script>alert(1)</script>\"' & <b>"


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The log of the virtual joint, of 2 s."""
    from dataclasses import replace

    path = tmp_path_factory.mktemp("log") / "hip.csv"
    write_log(replace(logged(gravity=True, rows=1000), path=str(path)))
    return path.read_bytes()


@pytest.fixture
def bench(tmp_path: Path, log: bytes, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with robot, spec, log and the results of a fit that found the truth, two figures apart."""
    (tmp_path / "bench.xml").write_text(MODEL.replace("AXIS", "0 1 0"))
    (tmp_path / "spec.yaml").write_text(SPEC)
    (tmp_path / "hip.csv").write_bytes(log)
    (tmp_path / "r.yaml").write_text(yaml.safe_dump(results(tmp_path), sort_keys=False))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def results(folder: Path) -> dict[str, object]:
    """As `fit` writes them; viscous friction is at its bound, the armature is not told."""
    joint: dict[str, object] = {"friction": {}}
    for field, value in TRUE.items():
        if field in ("armature", "friction.viscous"):
            continue
        section, _, key = field.rpartition(".")
        holder = joint[section] if section else joint
        assert isinstance(holder, dict)
        holder[key] = {"value": value, "unit": UNITS[field], "std": value / 100.0}
    joint |= {
        "bounds_hit": ["friction.viscous"],
        "unidentifiable": ["armature"],
        "reasons": {"armature": "because delay does nearly the same in this log"},
        "correlation": [["kp", "delay", -0.75]],
    }
    return {
        "format": "actspec-results/1",
        "robot": "bench",
        "method": "rollout",
        "spec": {"path": "spec.yaml", "sha256": _hash(folder / "spec.yaml")},
        "data": [{"path": "hip.csv", "sha256": _hash(folder / "hip.csv")}],
        "joints": {"hip": joint},
    }


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


class Page(HTMLParser):
    """What a browser would make of it: elements that must be closed are, and what would be fetched or run."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.fetched: list[str] = []
        self.text = ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            if name in ("src", "srcset", "data", "action") or name.startswith("on"):
                self.fetched.append(f"{name}={value}")
            if name in ("href", "xlink:href") and not (value or "").startswith("#"):
                self.fetched.append(f"{name}={value}")
            assert name != "style" or value is None or "url" not in value
        if tag not in ("meta", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "style" not in self.open:
            self.text += data


def report(*more: str) -> int:
    """Run the command."""
    return main(["sysid", "report", "r.yaml", "-o", "r.html", *more])


def page_of(folder: Path) -> Page:
    """The page, with nothing in it that would be fetched."""
    text = (folder / "r.html").read_text(encoding="utf-8")
    found = Page(text)
    assert found.fetched == []
    assert "script" not in found.tags and "link" not in found.tags and "img" not in found.tags
    assert not re.search(r"@import|url\(|https?://", text)
    return found


def test_one_page_with_all_of_it(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Figures, intervals, what is not told and what would, pictures, files and commands; within 200 kB."""
    assert report() == 0, capsys.readouterr()
    page = page_of(bench)
    text = " ".join(page.text.split())
    assert "bench: 5 figures identified, 2 not told" in text
    # kp 32 of 40 is 20 % less; 32 +- 1.96 * 0.32 is 31.37 to 32.63.
    assert "-20 %, outside" in text and "31.37 to 32.63" in text
    assert "not told: because delay does nearly the same in this log" in text
    assert "--experiment chirp --joint hip" in text and "--experiment friction --joint hip" in text
    for title in (
        "Worst stretch: position", "Typical stretch", "Worst stretch: torque", "Residuals by size", "Bode: gain",
        "Coherence", "Friction over speed",
    ):  # fmt: skip
        assert title in text
    assert "-0.75" in text
    assert _hash(bench / "hip.csv") in text
    assert "actspec sysid fit spec.yaml hip.csv -o r.yaml" in text
    assert (bench / "r.html").stat().st_size < 200_000


def test_an_uneven_interval_is_drawn_as_the_file_has_it(bench: Path) -> None:
    """kp 32 of 31 to 34, where its standard deviation alone would give 30 to 34; two joints have a table of both."""
    given = results(bench)
    joint = given["joints"]["hip"]  # type: ignore[index]
    joint["kp"]["std"], joint["intervals"] = 1.02, {"kp": [31.0, 34.0]}
    given["joints"]["knee"] = {"kp": joint["kp"]}  # type: ignore[index]
    (bench / "r.yaml").write_text(yaml.safe_dump(given, sort_keys=False))
    assert report() == 1
    text = " ".join(page_of(bench).text.split())
    assert "31.0 to 34.0" in text and "32.0 +2.0 −1.0" in text and "32.0 ± 2.0" in text


def test_methods_that_fit_no_motion(bench: Path) -> None:
    """Steps leave the spec's joint, with nothing of the results; constant speeds come with a rollout of their own."""
    given = results(bench)
    loop = {"natural_frequency": {"value": 4.0, "unit": "Hz"}, "damping_ratio": {"value": 0.4, "unit": "1"}}
    given |= {"method": "step", "joints": {"hip": {"diagnostics": loop}}}
    (bench / "r.yaml").write_text(yaml.safe_dump(given))
    assert report() == 0
    text = " ".join(page_of(bench).text.split())
    assert "Simulated is the spec's joint: this method fits no motion." in text
    assert "This method tells no figure of the spec" in text and "Intervals of 95 %" not in text
    # The spec's kp is 40, the joint's 32: only the rollout moves as the joint did.
    assert "log less spec" in text
    dry = {"coulomb": {"value": TRUE["friction.coulomb"], "unit": "N*m", "std": 0.001}}
    given |= {"method": "friction", "joints": {"hip": {"friction": dry}}}
    (bench / "r.yaml").write_text(yaml.safe_dump(given))
    assert report("--force") == 0
    text = " ".join(page_of(bench).text.split())
    assert "Friction over speed" in text and "log less fit" in text
    noise = re.search(r"Root mean square \S+ rad, (\S+) times the noise", text)
    assert noise is not None and float(noise[1]) < 1.5


def test_the_fitted_joint_moves_as_the_true_one(bench: Path) -> None:
    """With the true figures what is left is the noise of 0.5 mrad; with a kp of 5 % more it is not."""
    from actspec import api
    from actspec.diagnostics import Collector
    from actspec.logs import load_log
    from actspec.spec.results import Results
    from actspec.sysid.replay import replay

    spec = api.load("spec.yaml")
    robot = api.load_robot(spec)
    given = results(bench)
    joint = given["joints"]["hip"]  # type: ignore[index]
    joint["friction"]["viscous"] = {"value": TRUE["friction.viscous"], "unit": "N*m*s/rad"}
    joint["bounds_hit"] = []

    def left() -> tuple[float, float]:
        out = Collector()
        actuators = api.resolve(spec, robot)
        (one,) = replay(actuators, robot, [load_log("hip.csv")], Results.model_validate(given), out)["hip"]
        assert not out.failed
        return float(np.sqrt(np.nanmean(one.residual("position") ** 2))), one.figures["armature"]

    # The armature is not told: it is found on the way.
    size, armature = left()
    assert size == pytest.approx(5e-4, rel=0.05)
    assert armature == pytest.approx(TRUE["armature"], rel=0.02)
    joint["unidentifiable"] = []
    joint["armature"] = {"value": TRUE["armature"], "unit": "kg*m^2"}
    joint["kp"]["value"] *= 1.05
    assert left()[0] > 1.2 * size


def test_torques_of_a_delay_of_whole_rows(bench: Path) -> None:
    """4 ms are two rows, and a fit may find 3.98: torques tell the command three rows before, not two, and what is left
    of them is their noise, 2 % of their size."""
    from dataclasses import replace as changed

    from actspec import api
    from actspec.diagnostics import Collector
    from actspec.spec.results import Results
    from actspec.sysid.replay import replay

    log = logged(gravity=True, rows=1000, true={**TRUE, "delay": 0.004})
    given = results(bench)
    joint = given["joints"]["hip"]  # type: ignore[index]
    joint["friction"]["viscous"] = {"value": TRUE["friction.viscous"], "unit": "N*m*s/rad"}
    joint["armature"] = {"value": TRUE["armature"], "unit": "kg*m^2"}
    joint["delay"] = {"value": 0.00398, "unit": "s"}
    joint["bounds_hit"] = joint["unidentifiable"] = []
    spec = api.load("spec.yaml")
    robot, out = api.load_robot(spec), Collector()
    log = changed(log, path="hip.csv")
    (one,) = replay(api.resolve(spec, robot), robot, [log], Results.model_validate(given), out)["hip"]
    torque = log.joints["hip"].torque
    assert torque is not None
    noise = 0.02 * float(np.sqrt(np.mean(torque**2)))
    assert float(np.sqrt(np.nanmean(one.residual("torque") ** 2))) == pytest.approx(noise, rel=0.1)


def test_gains_of_a_log(bench: Path) -> None:
    """Two logs of one joint, one made with half the spec's kp: half of the kp that was found, and the kd that was."""
    from dataclasses import replace as changed

    from actspec import api
    from actspec.logs import Sidecar, load_log
    from actspec.spec.results import Results
    from actspec.sysid.replay import _figures

    one = load_log("hip.csv")
    stated = {"gains": {"hi.*": {"kp": 20.0, "kd": 0.6}}}
    other = changed(one, sidecar=Sidecar.model_validate(stated))
    actuators = api.resolve("spec.yaml")
    result = Results.model_validate(results(bench)).joints["hip"]
    # The spec has kp 40 and kd 0.6; found were 32 and 0.9.
    found = [_figures(actuators, "hip", result, log, [one, other]) for log in (one, other)]
    assert [(values["kp"], values["kd"]) for values in found] == [(32.0, 0.9), (16.0, 0.9)]
    # Not found: as stated beside the log, else the spec's.
    bare = result.model_copy(update={"kp": None, "kd": None})
    found = [_figures(actuators, "hip", bare, log, [one, other]) for log in (one, other)]
    assert [(values["kp"], values["kd"]) for values in found] == [(40.0, 0.6), (20.0, 0.6)]


def test_names_are_text(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A joint, a robot, a reason, a combination and a log whose names are markup."""
    given = results(bench)
    joint = given["joints"].pop("hip")  # type: ignore[attr-defined]
    joint["reasons"]["armature"] = BAD
    joint["combinations"] = {BAD: {"value": 1.0, "std": 0.1, "unit": BAD}}
    joint["diagnostics"] = {BAD: {"value": 1.0, "unit": BAD}}
    given["joints"] = {BAD: joint, BAD + "2": joint}
    given["note"] = BAD
    given["robot"] = "x" + BAD
    given["data"] = [{"path": BAD + ".csv", "sha256": "0" * 64}]
    given.pop("spec")
    (bench / "r.yaml").write_text(yaml.safe_dump(given, sort_keys=False))
    assert report() == 1
    page = page_of(bench)
    assert "b" not in page.tags
    assert page.text.count("alert(1)") > 10
    capsys.readouterr()


def test_what_is_missing_is_reported(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without the log, without the spec: the page with what there is, and exit code 1."""
    (bench / "hip.csv").rename(bench / "moved.csv")
    assert report() == 1
    assert "SYS060" in capsys.readouterr().err
    text = page_of(bench).text
    assert (
        "the log 'hip.csv' is not there" in text and "31.37 to 32.63" in text and "Worst stretch" not in text
    )
    (bench / "spec.yaml").rename(bench / "s.yaml")
    assert report("--log", "moved.csv", "--force") == 1
    assert "SYS062" in capsys.readouterr().err
    (bench / "s.yaml").write_text(SPEC.replace("kd: 0.6", "kd: 0.7"))
    assert report("--log", "moved.csv", "--spec", "s.yaml", "--force") == 0
    assert "SYS063" in capsys.readouterr().err
    text = page_of(bench).text
    assert "Worst stretch" in text and "changed since the fit" in text
    # Without the model there is no joint to simulate.
    (bench / "bench.xml").unlink()
    assert report("--log", "moved.csv", "--spec", "s.yaml", "--force") == 1
    assert "31.37 to 32.63" in page_of(bench).text


def test_figures_of_another_tool(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Their source is no log and is not read; any log may be held against them."""
    given = results(bench)
    given |= {"method": "bam", "commit": "abc"}
    given.pop("spec")
    given["data"] = [{"path": "params.json", "sha256": "0" * 64}]
    given["joints"]["hip"]["left_out"] = {"q_offset": "it is no encoder bias"}  # type: ignore[index]
    (bench / "r.yaml").write_text(yaml.safe_dump(given))
    (bench / "params.json").write_text("{}")
    assert report() == 0
    text = page_of(bench).text
    assert "it is no encoder bias" in text and "sysid fit" not in text
    assert report("--log", "hip.csv", "--spec", "spec.yaml", "--force") == 0
    assert "Worst stretch" in page_of(bench).text
    capsys.readouterr()


def test_another_log_is_an_error(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Both hashes are named, and nothing is written; named by the results or by an option."""
    right = _hash(bench / "hip.csv")
    with (bench / "hip.csv").open("a") as stream:
        stream.write("\n")
    wrong = _hash(bench / "hip.csv")
    for more in ([], ["--log", "hip.csv"]):
        assert report(*more) == 2
        err = capsys.readouterr().err
        assert "SYS061" in err and right in err and wrong in err
    assert not (bench / "r.html").exists()


@pytest.mark.parametrize("path", ["../secret.csv", "/etc/hostname", "a/../../secret.csv", "link.csv", "\0"])
def test_results_do_not_choose_what_is_read(
    path: str, bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A log outside of the folders is not opened, and its hash is not told."""
    home = bench / "home"
    home.mkdir()
    (bench / "secret.csv").write_text("time [s]\n")
    (home / "link.csv").symlink_to(bench / "secret.csv")
    given = results(bench)
    given["data"] = [{"path": path, "sha256": "0" * 64}]
    given["spec"] = {"path": "../spec.yaml", "sha256": "0" * 64}
    (home / "r.yaml").write_text(yaml.safe_dump(given))
    monkeypatch.chdir(home)
    code = report()
    err = capsys.readouterr().err
    if path == "\0":
        assert code in (1, 2)
    else:
        assert code == 1
        assert err.count("lies outside of this folder and the results file's") == 2
    assert _hash(bench / "secret.csv") not in err


def test_files_that_are_there_stay(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Another file is replaced by --force alone, what is read never; a file in place of a folder is reported."""
    (bench / "r.html").write_text("mine")
    assert report() == 2
    assert "--force" in capsys.readouterr().err
    assert (bench / "r.html").read_text() == "mine"
    before = (bench / "r.yaml").read_bytes()
    assert main(["sysid", "report", "r.yaml", "-o", "r.yaml", "--force"]) == 2
    assert (bench / "r.yaml").read_bytes() == before
    assert main(["sysid", "report", "r.yaml", "-o", "spec.yaml/r.html"]) == 2
    assert "spec.yaml/r.html: OUT00" in capsys.readouterr().err


def test_a_spec_of_another_robot(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No page of one robot's figures in the other's model."""
    (bench / "other.yaml").write_text(SPEC.replace("name: bench", "name: leg"))
    assert report("--spec", "other.yaml") == 2
    assert "the spec is of the robot 'leg', the results are of 'bench'" in capsys.readouterr().err
