"""Codes of what a verification finds wrong; docs/verify.md has a paragraph on each."""

from __future__ import annotations

TITLES = {
    "VFY100": "the torque is another one",
    "VFY101": "damping is counted twice",
    "VFY102": "friction is in another unit, or in another field",
    "VFY103": "a gear is left out, or taken to the wrong power",
    "VFY104": "a limit is lost",
    "VFY105": "degrees, rpm or rad/s in place of the spec's unit",
    "VFY106": "the sign is wrong",
    "VFY107": "the armature is another one",
    "VFY108": "the delay is another one",
    "VFY109": "a joint is missing, or has another joint's numbers",
    "VFY110": "a field is another one",
    "VFY111": "the file cannot be read, or its simulator refuses it",
    "VFY112": "the response over time is another one",
    "VFY113": "the time step is too coarse for the drive, or the simulation diverges",
}
"""Code to what it means. A code is never used for anything else."""
