"""Text in YAML's double quotes, for what no plain word may hold."""

from __future__ import annotations

_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\r": "\\r", "\t": "\\t"}


def double_quoted(text: str, *, ascii_only: bool = False) -> str:
    """Text as a YAML scalar in double quotes, on one line.

    Args:
        text: Any text.
        ascii_only: Escape every letter beyond ASCII too, not only what cannot be printed.
    """
    kept = (
        character if character.isprintable() and (character.isascii() or not ascii_only) else None
        for character in text
    )
    written = (
        _ESCAPES.get(character) or plain or _escape(character)
        for character, plain in zip(text, kept, strict=True)
    )
    return f'"{"".join(written)}"'


def _escape(character: str) -> str:
    code = ord(character)
    if code < 0x100:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
