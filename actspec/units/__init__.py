"""Units: from what people write to SI floats, and the kind of quantity it is.

Angle is a dimension of its own here (rad is not 1), so `N*m`, `N*m/rad`, `N*m*s/rad` and
`N*m*s` are four different things, and a cycle is another thing than an angle: 30 Hz never
becomes 30 rad/s, nor, unasked, 188.5 rad/s.

Syntax of a unit: names joined by `*` (also a middle dot or a space) and `/`; integer powers
`^2`, `**2` or superscripts; parentheses. Operators apply from left to right, so
`a/b/c` is a/(b*c) and `N*m/rad*s` is N*m*s/rad. A space after a slash (`N*m/rad s`) reads
both ways to people and is refused. `oz`, `lbf`, `kgf` and `gf` are forces, in every place;
`kg` and `g` are masses. `Nm` is N*m.

A prefix is a whole number over a whole number, and pi is counted apart, so that `8 ms` gives
the float nearest to 0.008 and `180 deg` gives pi.
"""

from __future__ import annotations

from actspec.units.kinds import Kind, Parsed, UnitError, format_number, format_quantity
from actspec.units.parse import MAX_LENGTH, convert, parse_quantity, parse_with_unit

__all__ = [
    "MAX_LENGTH",
    "Kind",
    "Parsed",
    "UnitError",
    "convert",
    "format_number",
    "format_quantity",
    "parse_quantity",
    "parse_with_unit",
]
