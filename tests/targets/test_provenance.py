"""The sources in the head of what each target writes."""

from __future__ import annotations

import pytest

from actspec.ir import ActuatorSet
from actspec.resolution import resolve
from actspec.robot.view import RobotView
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import TargetOptions
from actspec.targets.choose import emitter
from actspec.targets.kit.provenance import known_quantities, source_lines
from tests.compiling import spec_text, view_of

MODEL = "<mujoco><worldbody><body><joint name='hip'/><geom size='0.1'/></body></worldbody></mujoco>"

SOURCES = """sources:
  manual: {title: A manual, url: https://example.org, page: 3, commit: "0012"}
  paper: {title: A paper}
  rates: {title: Rates}
  unused: {title: Nobody, commit: "9999"}
"""

LEG = """  leg:
    joints: [hip]
    level: ideal_pd
    kp: {value: 25 N*m/rad, source: manual}
    kd: {value: 0.5 N*m*s/rad, source: paper}
    effort_limit: 24 N*m
"""


def fitted() -> tuple[ActuatorSet, RobotView]:
    """A joint whose numbers cite two of three sources."""
    timing = "{physics_dt: {value: 5 ms, source: rates}}"
    spec = validate(document_from_text(spec_text(LEG, timing=timing) + SOURCES, "spec.yaml"))
    view = view_of(MODEL)
    return resolve(spec, view), view


def test_a_source_on_one_line() -> None:
    """Title, address, page and commit, of the sources that are cited, in the spec's order."""
    actuators, _ = fitted()
    assert list(source_lines(actuators, known_quantities(actuators))) == [
        "manual: A manual, https://example.org, 3, commit 0012",
        "paper: A paper",
    ]


@pytest.mark.parametrize("kind", ["mujoco", "isaaclab", "mjlab", "deploy"])
def test_the_commit_is_in_every_head(kind: str) -> None:
    """Whatever file a number ends up in, the commit that it was read at stands in its head."""
    actuators, view = fitted()
    version = {"mujoco": "3.12", "isaaclab": "2.3", "mjlab": "1.6"}.get(kind, "")
    emission = emitter(kind)(actuators, view, TargetOptions(kind, kind, version, None, "out"))
    text = emission.files[0].data.decode("utf-8")
    assert "manual: A manual, https://example.org, 3, commit 0012\n" in text
    assert "9999" not in text


@pytest.mark.parametrize("kind", ["mujoco", "deploy"])
def test_the_step_s_source_is_told(kind: str) -> None:
    """A file that says where its time step comes from says what that source is."""
    actuators, view = fitted()
    version = "3.12" if kind == "mujoco" else ""
    emission = emitter(kind)(actuators, view, TargetOptions(kind, kind, version, None, "out"))
    assert "rates: Rates\n" in emission.files[0].data.decode("utf-8")
