"""Joint patterns: regular expressions of strangers, matched as Isaac Lab and mjlab do (`re.fullmatch`).

A pattern goes to the targets as text, and they hand it to Python's `re`, which has no time limit.
So it is not enough that a pattern is answered fast here: it must be cheap in `re` itself. The
pattern is parsed first, what can explode is refused, and the steps that `re` may take on
the longest name are bounded before the match starts.
"""

from __future__ import annotations

from actspec.patterns.pattern import (
    MAX_NAME,
    MAX_PATTERN,
    MAX_REPEAT,
    MAX_STEPS,
    NoExpression,
    Pattern,
    PatternError,
    compile_pattern,
    covering_pattern,
    match_names,
    written_out,
)
from actspec.patterns.selection import (
    Matches,
    PatternProblem,
    apart,
    is_slip,
    recased,
    resolve_patterns,
    suggest_pattern,
)

__all__ = [
    "MAX_NAME",
    "MAX_PATTERN",
    "MAX_REPEAT",
    "MAX_STEPS",
    "Matches",
    "NoExpression",
    "Pattern",
    "PatternError",
    "PatternProblem",
    "apart",
    "compile_pattern",
    "covering_pattern",
    "is_slip",
    "match_names",
    "recased",
    "resolve_patterns",
    "suggest_pattern",
    "written_out",
]
