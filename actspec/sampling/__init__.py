"""Domain randomisation: what the ranges of a spec mean, whether they make sense, and draws from them.

Order of combination, the same in `sample` and in every target:

1. each field's own range: nominal × factor (`scale`), nominal + offset (`add`) or the drawn value (`abs`);
2. `gains`: one factor on kp and kd;
3. `strength`: one factor on the torque, so on kp, kd and effort_limit together;
4. nothing but `encoder_bias` goes below 0, and kinetic friction not above static friction.

The draws of two fields are independent; `per` says which joints share one draw of a field.
"""

from __future__ import annotations

from actspec.sampling.draw import sample
from actspec.sampling.ranges import (
    FACTORS,
    FIELDS,
    check_ranges,
    drawn_ends,
    nominal_of,
    own_ranges,
    quantity_of,
    unit_of,
)

__all__ = [
    "FACTORS",
    "FIELDS",
    "check_ranges",
    "drawn_ends",
    "nominal_of",
    "own_ranges",
    "quantity_of",
    "sample",
    "unit_of",
]
