"""What people write around a number that is no part of it: a remark, a deviation, a range, a comment."""

from __future__ import annotations

import re

from actspec.diagnostics import shortened
from actspec.units import MAX_LENGTH, Kind, UnitError, format_number, parse_quantity
from actspec.units.reader import BadUnit, read_unit

UNKNOWN = "unknown"

_NUMBER = r"[-+]?(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][-+]?\d+)?"
_UNIT = r"[^\d\s.+±-]*"
_NOTHING = re.compile(
    r"unknown|n\.?/?a\.?|tb[acd]|none|nil|nan|-+|—|–|\?+|not (?:available|stated|specified|known)", re.I
)
"""Words for a figure that nobody states."""
_DEVIATION = re.compile(rf"({_NUMBER})\s*({_UNIT})\s*(?:\+\s*/?\s*-|±)\s*({_NUMBER})\s*(\S.*|)")
_RANGE = re.compile(rf"({_NUMBER})\s*({_UNIT})\s*(?:\.\.+|…|-|–|—|~|to\b)\s*({_NUMBER})\s*(\S.*|)")
_THOUSANDS = re.compile(r"([-+]?[1-9]\d{0,2}(?:['\u2019_ ]\d{3})+)(?!\d)(.*)")
_COMMENT = re.compile(r"(.*?\S)\s*(//|#|;|/\*)\s*(.*)")
_BEFORE = re.compile(r"([^\d]*[^\d\s.+−-][^\d]*?)\s*([-+]?\.?\d.*)")
_REMARK = re.compile(r"[(@]?\s*[A-Za-z\d][\w .,:/()-]*")
_QUALIFIERS = re.compile(
    r"[ad]c|rms|pea?k|max(imum)?|min(imum)?|nom(inal)?|rated|typ(ical)?|cont(inuous)?|approx", re.I
)
"""Words that say of a figure which one it is, and are no source."""


def explained(given: str, kind: Kind, words: tuple[str, ...], inside: bool) -> tuple[str, str] | None:
    """Message and help for a text that is no quantity because of what stands around one; None: it is another text.

    Args:
        given: As written.
        kind: What it must be.
        words: Those that the field takes in place of a number.
        inside: Whether it is the `value` of a mapping already.
    """
    text = given.strip()
    if len(text) > MAX_LENGTH:
        return None
    if UNKNOWN in words and _NOTHING.fullmatch(text):
        return f"`{text}` is no number", f"for a figure that nobody states write `{UNKNOWN}`"
    return (
        _deviation(text, kind, inside)
        or _range(text, kind, inside)
        or _marks(text, kind)
        or _words_before(text, kind, inside)
        or _words_behind(text, kind, inside)
    )


def fits(text: str | float, kind: Kind) -> bool:
    """Whether a text or number is a quantity of a kind."""
    try:
        parse_quantity(text, kind)
    except UnitError:
        return False
    return True


def _with(value: str, key: str, text: str, inside: bool) -> str:
    """What to write: a value with another key beside it."""
    quoted = text.replace('"', "'")
    pair = f"value: {value}, {key}: " + (f'"{quoted}"' if key == "note" else text)
    return f"write `{pair}`" if inside else f"write `{{{pair}}}`"


def _deviation(text: str, kind: Kind, inside: bool) -> tuple[str, str] | None:
    """`3 +- 0.2 N*m`."""
    match = _DEVIATION.fullmatch(text)
    if match is None:
        return None
    first, own, second, last = match.groups()
    if last == "%" and own:
        second, last = format_number(float(first) * float(second) / 100.0), own
    value, std = f"{first} {own or last}".strip(), f"{second} {last or own}".strip()
    if not fits(value, kind) or not fits(std, kind):
        return None
    help = f"{_with(value, 'std', std, inside)}, if that is one standard deviation"
    return f"`{shortened(text)}` is a number and its deviation", help


def _range(text: str, kind: Kind, inside: bool) -> tuple[str, str] | None:
    """`10..12 A`."""
    match = _RANGE.fullmatch(text)
    if match is None:
        return None
    first, own, second, last = match.groups()
    low, high = f"{first} {own or last}".strip(), f"{second} {last or own}".strip()
    if not fits(low, kind) or not fits(high, kind):
        return None
    help = f"{_with(low, 'note', shortened(text), inside)}, with the one of the two that holds"
    return f"`{shortened(text)}` is a range, and one number is needed", help


def _marks(text: str, kind: Kind) -> tuple[str, str] | None:
    """`5'000 N/m`, `51#harmonic`, `51 // harmonic`."""
    thousands = _THOUSANDS.fullmatch(text)
    if thousands is not None:
        meant = re.sub(r"\D", "", thousands[1]) + thousands[2]
        if fits(meant, kind):
            return (
                f"`{shortened(text)}` has a mark inside a number",
                f"thousands have no mark: write `{meant}`",
            )
    comment = _COMMENT.fullmatch(text)
    if comment is not None and fits(comment[1], kind):
        remark = comment[3].removesuffix("*/").strip()
        rest = f" # {shortened(remark)}" if remark else ""
        return (
            f"`{shortened(text)}`: what stands behind {comment[1]} is no unit",
            f"a comment begins with a space and `#`: write `{comment[1]}{rest}`",
        )
    return None


def _words_before(text: str, kind: Kind, inside: bool) -> tuple[str, str] | None:
    """`~370 rpm`, `> 60 Hz`, `about 60 Hz`."""
    match = _BEFORE.fullmatch(text)
    if match is None or not fits(match[2], kind):
        return None
    message = f"`{shortened(match[1].strip())}` before {match[2]} is no part of a number"
    if match[1].strip() in ("=", ":", "=="):
        return message, f"write `{match[2]}`"
    return message, _with(match[2], "note", shortened(text), inside)


def _words_behind(text: str, kind: Kind, inside: bool) -> tuple[str, str] | None:
    """`25 N*m/rad manual`, `24 V DC`, `9 N*m @ 24 V`."""
    words = text.split()
    for count in range(len(words) - 1, 0, -1):
        number, rest = " ".join(words[:count]), " ".join(words[count:])
        if not fits(number, kind):
            continue
        if kind is not Kind.RATIO and re.fullmatch(_NUMBER, number):
            # What stands behind a bare number is meant as its unit.
            return None
        if _REMARK.fullmatch(rest) is None or _is_unit(words[count]):
            return None
        remark = rest.strip("()")
        alone = count == len(words) - 1 and remark == rest and rest[0] != "@"
        named = alone and _QUALIFIERS.fullmatch(rest) is None
        key = "source" if named else "note"
        return f"`{shortened(rest)}` behind {number} is no unit", _with(number, key, remark, inside)
    return None


def _is_unit(text: str) -> bool:
    try:
        read_unit(text)
    except BadUnit:
        return False
    return True
