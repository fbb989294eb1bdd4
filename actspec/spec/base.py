"""What the models of the spec language share: their base, and kinds of number that several have."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from actspec.spec.values import Number, SpecValue
from actspec.units import Kind


class Strict(BaseModel):
    """Base of all models: frozen, unknown keys refused, built when the first file is read.

    `use_attribute_docstrings` is off because it parses the source at every start; `descriptions`
    does so when somebody asks.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


Name = Annotated[str, Field(min_length=1, max_length=200)]
Inertia = Annotated[SpecValue, Number(Kind.INERTIA, at_least=0.0)]
Ratio = Annotated[SpecValue, Number(Kind.RATIO, above=0.0)]
Factor = Annotated[SpecValue, Number(Kind.RATIO, above=0.0, unknown=False)]
Efficiency = Annotated[SpecValue, Number(Kind.RATIO, above=0.0, at_most=1.0)]
