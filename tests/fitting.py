"""Fit a spec's text to a robot's text, all in memory; what the tests of `resolve` begin with."""

from __future__ import annotations

from dataclasses import replace

import pytest

from actspec.diagnostics import ResolveError, SpecError
from actspec.ir import ActuatorSet, JointActuator
from actspec.resolution import resolve
from actspec.robot.load import listed_robot
from actspec.spec.document import document_from_text
from actspec.spec.models import SpecModel
from actspec.spec.results import ResultsFile, validate_results
from actspec.spec.validate import validate
from tests.compiling import view_of

NONE = "name: leg, model: none, joints: [hip, calf, {name: slide, kind: slide}]"
"""A robot without a file: two hinges and a slide."""


def spec_of(groups: str, *, robot: str = NONE, motors: str = "{}", more: str = "") -> str:
    """A spec around its groups in flow style, such as `legs: {joints: [hip], ...}`."""
    return f"actspec: 1\nrobot: {{{robot}}}\nmotors: {motors}\nactuators: {{{groups}}}\n{more}\n"


def model_of(text: str) -> SpecModel:
    """A valid spec's model."""
    return validate(document_from_text(text, "s.yaml")).model


def faults_of(text: str) -> list[str]:
    """What validation says against a spec: `CODE where: message`."""
    with pytest.raises(SpecError) as caught:
        validate(document_from_text(text, "s.yaml"))
    return [f"{d.code} {d.where}: {d.message}" for d in caught.value.diagnostics]


def fit(text: str, model: str | None = None, *, results: str | None = None) -> ActuatorSet:
    """Resolve a spec.

    Args:
        text: The spec; its results are called `r.yaml`.
        model: An MJCF; None: the joints are those that the spec lists.
        results: Joints of the results file, as YAML.
    """
    spec = validate(document_from_text(text, "s.yaml"))
    if results is not None:
        head = "format: actspec-results/1\nrobot: leg\nmethod: rollout\njoints: "
        document = document_from_text(head + results, "r.yaml")
        spec = replace(spec, results={"r.yaml": ResultsFile(validate_results(document), document)})
    return resolve(spec, listed_robot(spec) if model is None else view_of(model))


def joint(
    text: str, name: str = "hip", model: str | None = None, *, results: str | None = None
) -> JointActuator:
    """One joint of a resolved spec."""
    found = fit(text, model, results=results).joint(name)
    assert found is not None
    return found


def refused(text: str, model: str | None = None, *, results: str | None = None) -> list[str]:
    """What `resolve` says against a spec: `CODE where: message`."""
    with pytest.raises(ResolveError) as caught:
        fit(text, model, results=results)
    return [f"{d.code} {d.where}: {d.message}" for d in caught.value.diagnostics]


def drawn_numbers() -> dict[str, str]:
    """`accept` for numbers that a test draws at random: none of them is held to what motors are like."""
    from actspec.spec.plausible import CHECKS

    return {f"spec.{check.code}": "drawn" for check in CHECKS}
