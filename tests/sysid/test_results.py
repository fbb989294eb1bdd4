"""What a results file holds of a fit."""

from __future__ import annotations

from actspec.joints import JointKind
from actspec.spec.document import document_from_text
from actspec.spec.results import validate_results
from actspec.sysid.identified import Identification, Indicator, JointFit, Parameter, State
from actspec.sysid.results import results_text


def test_diagnostics_are_written_beside_the_figures() -> None:
    """With its standard deviation where it is known, and without the key where it is not."""
    bias = Parameter("encoder_bias", State.UNIDENTIFIABLE, None, None, None, None, "rad")
    read = (Indicator("torque_scale", 1.05, 0.002, "1"), Indicator("rise_time", 0.031, None, "s"))
    joint = JointFit("hip", JointKind.HINGE, (bias,), (), (), 1e-3, None, 1.0, 1.0, read)
    text = results_text(Identification("bench", "rollout", (joint,), (), 0.0), [])
    found = validate_results(document_from_text(text, "r.yaml")).joints["hip"].diagnostics
    assert {name: (d.value, d.std, d.unit) for name, d in found.items()} == {
        "torque_scale": (1.05, 0.002, "1"),
        "rise_time": (0.031, None, "s"),
    }


def test_both_ends_of_an_interval_are_written() -> None:
    """Uneven ones too; a figure that is held or not told has none, and the file passes its own check."""
    parameters = (
        Parameter("kp", State.HELD, 25.0, None, None, None, "N*m/rad"),
        Parameter("friction.viscous", State.IDENTIFIED, 0.01, 0.0102, 0.0, 0.03, "N*m*s/rad"),
        Parameter("encoder_bias", State.UNIDENTIFIABLE, None, None, None, None, "rad"),
    )
    joint = JointFit("hip", JointKind.HINGE, parameters, (), (), 1e-3, None, 1.0, 1.0)
    text = results_text(Identification("bench", "rollout", (joint,), (), 0.0), [])
    found = validate_results(document_from_text(text, "r.yaml")).joints["hip"]
    assert found.intervals == {"friction.viscous": (0.0, 0.03)}
