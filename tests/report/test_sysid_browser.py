"""The page of a fit in a real browser: Debian's Chromium, where it is installed."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.logs import Log, Sidecar
from actspec.report.sysid_page import Identified, render
from actspec.spec.results import Results
from tests.audit.report.test_browser import CHROMIUM, looked
from tests.report.test_sysid_pictures import multisine, replay

pytest.importorskip("scipy")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")]

BAD = "<script>window.hit=1</script>\"'"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a page of two joints, with hostile names."""
    path = tmp_path_factory.mktemp("page")
    number = {"value": 25.0, "unit": "N*m/rad", "std": 0.1}
    joint = {
        "kp": number,
        "unidentifiable": ["armature"],
        "reasons": {"armature": BAD},
        "correlation": [["kp", "delay", 0.9]],
        "diagnostics": {BAD: {"value": 1.0, "unit": "1"}},
    }
    given = {
        "format": "actspec-results/1",
        "robot": BAD,
        "method": "rollout",
        "joints": {BAD: joint, "hip": joint},
    }
    command = multisine()
    one = replay(command, 0.9 * command, 0.8 * command)
    log = Log(BAD, "0" * 64, one.recording.time, {}, Sidecar())
    shown = Identified(
        "r.yaml", Results.model_validate(given), "0" * 64, None, None, {"hip": [one]}, [log], ()
    )
    (path / "report.html").write_text(render(shown), encoding="utf-8")
    return path


def test_a_phone_shows_all_of_it(folder: Path) -> None:
    """Nothing sticks out of the screen, links lead to their joint, and no script of a stranger has run."""
    found = looked(folder)
    assert found["wide"] == [] and found["over"] == 0
    assert found["hit"] and "<script>" in found["title"]
    assert len(found["links"]) == 2 and all(there for _, there in found["links"])


def test_dark_where_the_reader_wants_it(folder: Path) -> None:
    """Near black on a dark system; Blink's number for dark is 0."""
    found = looked(folder, "--blink-settings=preferredColorScheme=0", width=1200)
    assert found["ground"] == "rgb(13, 17, 23)"
