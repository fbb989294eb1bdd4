"""The manifest of a delta action, which a spec names: what its network takes and gives, and where it comes from.

JSON or YAML, read as strictly as a spec.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from actspec.spec.network import NetworkFiles, Sha256
from actspec.spec.results import FitFile
from actspec.spec.values import Strict

Column = Annotated[str, Field(min_length=3, max_length=300)]


class DeltaValidation(Strict):
    """What the network takes away of the errors on rows that it was not trained on."""

    position: Annotated[float, Field(le=1.0)]
    """1 - RMS corrected / RMS uncorrected, of the next row's positions [-]."""
    velocity: Annotated[float, Field(le=1.0)]
    """Likewise of its velocities [-]."""
    rows: Annotated[int, Field(ge=1)]
    """How many."""
    logs: tuple[str, ...] = ()
    """Recordings, by path."""


class DeltaManifest(Strict):
    """What a delta action takes and gives: delta = max_delta * tanh(f(state, command)).

    The files take rows of the columns `inputs` as a log has them, in rad, rad/s, m and s, and give rows of `outputs`,
    limited, in rad.
    """

    format: Literal["actspec-delta/1"]
    """Format of this file."""
    inputs: Annotated[tuple[Column, ...], Field(min_length=2, max_length=4000)]
    """Columns of the state, as `JOINT.position`, `JOINT.velocity`, `JOINT.last_command` (that of the row before) and
    `base.SIGNAL.COMPONENT`, then the `outputs`: the commands, before correction."""
    outputs: Annotated[tuple[Column, ...], Field(min_length=1, max_length=1000)]
    """Columns that are corrected, `JOINT.command`."""
    max_delta: Annotated[float, Field(gt=0.0, le=10.0)]
    """Largest correction [rad, of slides m]."""
    period: Annotated[float, Field(gt=0.0, le=10.0)]
    """Time between two commands [s]."""
    files: NetworkFiles
    """The network, beside the manifest."""
    per: Literal["joint", "robot"] | None = None
    """Whether one network serves every joint by its own columns, or one the whole robot."""
    action_scale: dict[str, float] = Field(default_factory=dict)
    """Joint to its command [rad] per unit of a policy's action, where the spec states one."""
    default_position: dict[str, float] = Field(default_factory=dict)
    """Joint to its command at action 0 [rad], likewise."""
    model: Sha256 | None = None
    """Hash of the compiled dynamics that it corrects."""
    logs: tuple[FitFile, ...] = ()
    """Recordings that it was trained on."""
    validation: DeltaValidation | None = None
    """How well it does on rows that it was not trained on."""
    note: str | None = None
    """Remark."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names, in the order of the outputs."""
        return tuple(name.rpartition(".")[0] for name in self.outputs)

    @property
    def state(self) -> tuple[str, ...]:
        """Columns of the state: the inputs without the commands."""
        return self.inputs[: -len(self.outputs)]

    @property
    def measured(self) -> tuple[str, ...]:
        """Columns of the state without the last commands: what a simulator tells."""
        return tuple(name for name in self.state if not name.endswith(".last_command"))
