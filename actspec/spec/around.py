"""What people write around a number that is no part of it: a remark, a deviation, a range, a comment, a calculation."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from actspec.diagnostics import shortened
from actspec.units import MAX_LENGTH, Kind, UnitError, format_number, parse_quantity
from actspec.units.reader import BadUnit, in_ascii, read_unit

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
_TEN = re.compile(rf"({_NUMBER})\s*(?:[eE]\s*|[*x]\s*10\s*(?=[-+]))([-+]?\d+)(?!\d)(.*)")
"""`6.4 e-5`, and `6.4 x 10-5` as it comes out of a PDF."""
_PI = r"(?:(?:np|numpy|math)\.|M_)?(?:pi|π)(?![A-Za-z])"
_FACTOR = rf"(?:{_NUMBER}|{_PI})(?:\s*(?:\^|\*\*)\s*\(?[-+]?\d\d?\)?)?"
_TIMES = r"\s*[*/]\s*|\s*x\s*(?=10\s*[\^*])"
_PRODUCT = re.compile(rf"([-+]?)\s*({_FACTOR}(?:(?:{_TIMES}|\s*(?={_PI})){_FACTOR})*)\s*(.*)", re.IGNORECASE)
"""`-pi/2 rad`, `2 pi rad`, `6.4*10^-5 kg*m^2`."""
_PARTS = re.compile(rf"({_TIMES}|)\s*({_NUMBER}|{_PI})(?:\s*(?:\^|\*\*)\s*\(?([-+]?\d+)\)?)?", re.IGNORECASE)
_OTHER_ANGLES = re.compile("deg|rev|turn|rpm")
_COMMENT = re.compile(r"(.*?\S)\s*(//|#|;|/\*)\s*(.*)")
_BEFORE = re.compile(r"([^\d]*[^\d\s.+−-][^\d]*?)\s*([-+]?\.?\d.*)")
_OPERATOR = re.compile(rf"[*/^(]\s*$|{_PI}", re.IGNORECASE)
"""What makes a factor of the words before a number: without them it is another number."""
_FACTOR_BEHIND = re.compile(r"x\s*\d", re.IGNORECASE)
_REMARK = re.compile(r"[(@]?\s*[A-Za-z\d][\w .,:/()-]*")
_QUALIFIERS = re.compile(
    r"[ad]c|rms|pea?k|max(imum)?|min(imum)?|nom(inal)?|rated|typ(ical)?|cont(inuous)?|stall|approx", re.I
)
"""Words that say of a figure which one it is, and are no source."""
_PEAK, _CONTINUOUS = (
    re.compile(r"pea?k|max(imum)?", re.I),
    re.compile(r"nom(inal)?|rated|cont(inuous)?", re.I),
)
"""Which of a motor's currents one is."""
_ALTERNATING = re.compile(r"\(?(rms|eff|pk|p-?p)\)?", re.I)


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
        _calculation(text, kind)
        or _deviation(text, kind, inside)
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


def _calculation(text: str, kind: Kind) -> tuple[str, str] | None:
    """`pi/2 rad`, `0.5*pi`, `6.4*10^-5 kg*m^2`; of sums and brackets nothing is said."""
    match = _PRODUCT.fullmatch(in_ascii(text))
    if match is None:
        return None
    value, parts = (-1.0 if match[1] == "-" else 1.0), list(_PARTS.finditer(match[2]))
    turned = any("p" in part[2].lower() or "π" in part[2] for part in parts)
    if (len(parts) == 1 and not turned and parts[0][3] is None) or _either_way(parts):
        return None
    try:
        for sign, factor, power in (part.groups() for part in parts):
            number = math.pi if factor[-1] in "iIπ" else float(factor)
            number **= int(power or 1)
            value = value / number if sign.strip() == "/" else value * number
    except (OverflowError, ZeroDivisionError):
        return None
    # An angle is all that pi alone can be.
    unit = match[3] or (
        kind.rotary_unit if turned and kind in (Kind.POSITION, Kind.ANGLE, Kind.SPEED) else ""
    )
    # Of pi degrees or turns the one or the other is wrong.
    odd = turned and _OTHER_ANGLES.search(unit)
    help = None if odd else _meant(f"{format_number(value)} {unit}".strip(), kind)
    if help is not None and kind is Kind.RATIO and len(parts) > 1 and 0.0 < value < 1.0 and not match[3]:
        # As of `1:20`.
        help += f", or `{format_number(1.0 / value)}` for a gearbox that reduces the speed so"
    return None if help is None else (f"`{shortened(text)}` is to be worked out: a number is needed", help)


def _meant(text: str, kind: Kind) -> str | None:
    """The help that has a quantity, its unit put right where that is told; None: it is none."""
    try:
        parse_quantity(text, kind)
    except UnitError as err:
        return err.help if (err.help or "").startswith("did you mean `" + text.split()[0]) else None
    return f"write `{text}`"


def _either_way(parts: Sequence[re.Match[str]]) -> bool:
    """Whether a factor without its sign stands behind a division: `1/2pi`."""
    divided = False
    for part in parts[1:]:
        divided |= part[1].strip() == "/"
        if divided and not part[1]:
            return True
    return False


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
    ten = _TEN.fullmatch(in_ascii(text))
    help = None if ten is None else _meant(f"{ten[1]}e{ten[2]}{ten[3]}", kind)
    if help is not None:
        return f"`{shortened(text)}` has a power of ten that is not read as one", help
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
    if match is None or not fits(match[2], kind) or _OPERATOR.search(match[1]):
        return None
    message = f"`{shortened(match[1].strip())}` before {match[2]} is no part of a number"
    if match[1].strip() in ("=", ":", "=="):
        return message, f"write `{match[2]}`"
    return message, _with(match[2], "note", shortened(text), inside)


def _words_behind(text: str, kind: Kind, inside: bool) -> tuple[str, str] | None:
    """`25 N*m/rad manual`, `24 V DC`, `9 N*m @ 24 V`."""
    words = text.split()
    for count in range(len(words) - 1, 0, -1):
        number, rest = " ".join(words[:count]).rstrip(","), " ".join(words[count:])
        if not fits(number, kind):
            continue
        if kind is not Kind.RATIO and re.fullmatch(_NUMBER, number):
            # What stands behind a bare number is meant as its unit.
            return None
        if _REMARK.fullmatch(rest) is None or _is_unit(words[count]) or _FACTOR_BEHIND.match(rest):
            return None
        if kind in (Kind.CURRENT, Kind.TORQUE_CONSTANT) and _ALTERNATING.fullmatch(rest):
            # Another number, not a remark: the reader of units has both.
            return None
        remark = rest[1:-1] if rest[0] + rest[-1] == "()" else rest
        message = f"`{shortened(rest)}` behind {number} is no unit"
        if kind is Kind.CURRENT and (help := _which_current(number, remark.removesuffix("."))):
            return message, help
        alone = count == len(words) - 1 and remark == rest and rest[0] != "@"
        named = alone and _QUALIFIERS.fullmatch(rest.removesuffix(".")) is None
        key = "source" if named else "note"
        return message, _with(number, key, remark, inside)
    return None


def _which_current(number: str, word: str) -> str | None:
    """The key that is meant by a word behind a motor's current; a peak may be the amplitude of a sine as well."""
    if _CONTINUOUS.fullmatch(word):
        return f"write `nominal_current: {number}`"
    if not _PEAK.fullmatch(word):
        return None
    if word[0] in "mM":
        return f"write `peak_current: {number}`"
    rms = f"{format_number(parse_quantity(number, Kind.CURRENT).value / math.sqrt(2.0))} A"
    sine = f"if it is the amplitude of a sine, `{rms}` beside a torque constant per A rms"
    return f"write `peak_current: {number}`; {sine}"


def _is_unit(text: str) -> bool:
    try:
        read_unit(text)
    except BadUnit:
        return False
    return True
