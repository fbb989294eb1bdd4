"""Which options a target gets, and which place in the spec an error about one of them has."""

from __future__ import annotations

import pytest

from actspec.diagnostics import Collector, Span
from actspec.spec.document import document_from_text
from actspec.spec.models import IsaacLabTarget
from actspec.spec.validate import validate
from actspec.targets.base import TargetOptions
from actspec.targets.choose import choose_targets

SPEC = """actspec: 1
robot: {name: leg, model: none, joints: [hip, knee]}
actuators: {legs: {joints: [".*"], level: ideal_pd, kp: 25, kd: 0.5}}
targets:
  lab: {target: isaaclab, version: "2.2", isaac_sim: "5.0"}
  side:
    target: deploy
    joint_order: [knee, hip]
"""


def chosen(*asked: str) -> tuple[TargetOptions, ...]:
    """The targets of SPEC, or those asked for."""
    return choose_targets(
        validate(document_from_text(SPEC, "s.yaml")), asked, None, False, collector=Collector()
    )


def test_every_option_has_its_place() -> None:
    """An option is where its value stands, an entry of a list where it stands; what is not written has no place."""
    lab, side = chosen()
    assert lab.span("version") == Span("s.yaml", 5, 36)
    assert lab.span("isaac_sim") == Span("s.yaml", 5, 54)
    assert lab.span("class") is None
    assert side.span("joint_order") == Span("s.yaml", 8, 18)
    assert side.span("joint_order[1]") == Span("s.yaml", 8, 25)
    assert side.where("joint_order[1]") == "targets.side.joint_order[1]"


def test_a_version_of_the_command_line_has_no_place() -> None:
    """`NAME==VERSION` takes the version's place away, and keeps the other options with theirs."""
    (lab,) = chosen("lab==2.3")
    assert (lab.version, lab.span("version")) == ("2.3", None)
    assert (lab.of(IsaacLabTarget).isaac_sim, lab.span("isaac_sim")) == ("5.0", Span("s.yaml", 5, 54))


def test_a_target_that_the_spec_does_not_name() -> None:
    """A kind of target can be asked for without a line in the spec: its defaults, and no place."""
    (mjlab,) = chosen("mjlab")
    assert (mjlab.name, mjlab.version, mjlab.span("version")) == ("mjlab", "1.6", None)


@pytest.mark.parametrize(
    ("asked", "options", "kept"),
    [
        ("lab==3.0", 'version: "2.3", isaac_sim: "5.1"', (None, None)),
        ("lab==2.2", 'version: "2.3", isaac_sim: "5.0"', ("5.0", None)),
        ("lab==2.2", 'version: "2.3", isaac_sim: "5.1"', (None, None)),
        ("lab==2.3", 'version: "3.0", isaac_sim: "6.0", backend: newton', (None, None)),
        ("lab==3.0", 'version: "3.0", isaac_sim: "6.0", backend: newton', ("6.0", "newton")),
        # No such version: the target says so, and nothing is dropped.
        ("lab==9.9", 'version: "2.3", isaac_sim: "5.1"', ("5.1", None)),
    ],
)
def test_a_version_of_the_command_line_drops_what_does_not_fit(
    asked: str, options: str, kept: tuple[str | None, str | None]
) -> None:
    """The spec's simulator and backend belong to its own version: they go where the asked one has them not."""
    text = SPEC.replace('version: "2.2", isaac_sim: "5.0"', options)
    (lab,) = choose_targets(validate(document_from_text(text, "s.yaml")), (asked,), None, False, Collector())
    given = lab.of(IsaacLabTarget)
    assert (given.isaac_sim, given.backend) == kept
    assert (lab.span("isaac_sim") is None) == (kept[0] is None)


SIBLINGS = """actspec: 1
robot: {name: leg, model: none, joints: [hip, knee]}
actuators: {legs: {joints: [".*"], level: ideal_pd, kp: 25, kd: 0.5}}
targets:
  old: {target: mujoco, version: "3.11"}
  new: {target: mujoco, version: "3.12"}
  lab: {target: isaaclab, class: implicit}
  randomization: {}
"""


@pytest.mark.parametrize(
    ("asked", "beside"),
    [
        ((), [("old", "3.11"), ("new", "3.12"), ("lab", "2.3")]),
        (("randomization",), [("old", "3.11"), ("new", "3.12"), ("lab", "2.3")]),
        (("randomization", "new"), [("new", "3.12"), ("lab", "2.3")]),
        (("new==3.5", "randomization"), [("new", "3.5"), ("lab", "2.3")]),
    ],
    ids=["all", "alone", "with-one", "at-another-version"],
)
def test_randomization_knows_the_simulators_beside_it(
    asked: tuple[str, ...], beside: list[tuple[str, str]]
) -> None:
    """Those that are compiled with it, else those of the spec; other kinds know nothing of each other."""
    spec = validate(document_from_text(SIBLINGS, "s.yaml"))
    found = choose_targets(spec, asked, None, False, Collector())
    (ranges,) = [options for options in found if options.kind == "randomization"]
    assert [(other.name, other.version) for other in ranges.siblings] == beside
    assert all(options.siblings == () for options in found if options is not ranges)
