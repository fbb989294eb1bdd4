"""Which joints are the left and right of one, by the words of their names."""

from __future__ import annotations

import re
from collections.abc import Collection
from functools import lru_cache

_SIDES = (
    ("left", "right"), ("l", "r"), ("fl", "fr"), ("rl", "rr"), ("hl", "hr"), ("bl", "br"), ("ml", "mr"),
    ("lf", "rf"), ("lh", "rh"), ("lb", "rb"), ("lm", "rm"),
)  # fmt: skip
"""Words for the sides, in lower case. Chosen: from the joint names in the surveyed repositories."""

_RIGHT = {
    form(left): form(right) for left, right in _SIDES for form in (str.lower, str.upper, str.capitalize)
}

SIDE_WORDS = frozenset(word for sides in _SIDES for word in sides)

WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+|[^A-Za-z0-9]+")


def other_side(name: str, names: Collection[str]) -> str | None:
    """Which of the names is the other side's of a joint, if one is."""
    right = (other for other in mirrors(name) if other in names)
    return next(right, next((other for other in names if name in mirrors(other)), None))


@lru_cache(maxsize=4096)
def mirrors(name: str) -> tuple[str, ...]:
    """What a left joint's name may be on the right: one of its words changed, or all of them."""
    words = WORD.findall(name)
    at = [index for index, word in enumerate(words) if word in _RIGHT]
    return tuple(
        "".join(_RIGHT[word] if index in chosen else word for index, word in enumerate(words))
        for chosen in (*([index] for index in at), at)
        if chosen
    )
