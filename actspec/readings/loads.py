"""What of a program may load a model: the rest of its text names models, too, and runs none."""

from __future__ import annotations

import re
from collections import Counter

_BEHIND = re.compile(rb"[ \t]{2}#[^\n]*|[ \t]#[^\n\"'#]*$", re.MULTILINE)
"""A comment behind a statement."""

_TEXTS = re.compile(rb"(^[ \t]*)?(\"\"\"|''').*?\2", re.MULTILINE | re.DOTALL)
"""Texts of several lines; with the group such as are statements, as docstrings are."""

_FLAT = rb"(?:[^()\n]|\([^()\n]*\))*"
_DEEP = rb"(?:[^()\n]|\((?:[^()\n]|\(" + _FLAT + rb"\))*\))*"
_CALLS = re.compile(
    rb"\b(?:open|parse|ifstream \w+)\(" + _DEEP + rb"\)"
    rb"|(?:\b(?:f?printf?|exists|is_?file|remove|unlink|save\w*|mj_save\w+|write\w*)|\blog(?:ger|ging)?\.\w+)\("
    + _FLAT
    + rb"\)|[\"'][^\"'\n]*[\"']\s?\)?\.(?:read_text|write_text|open|exists|is_file|unlink)\("
    rb"|\braise\b[^\n]*|\bc(?:out|err)\b[^;\n]*"
    rb"|\badd_argument\(\s*[\"'](?!-)[^\"'\n]*[\"']"
    rb"|\bhelp\s?=\s?f?[\"'][^\"'\n]*[\"']|\s(?:-o|--out(?:put)?|>)[ =][ \t]*[^\s\"']+"
)
"""Names that a program opens itself, to write the file or to change its text before a simulator has it, and such as it
only shows, looks for, writes or takes away."""

_HELD = re.compile(rb"^[ \t]*(\w+)[ \t]*=[^=\n][^\n]*", re.MULTILINE)
_OPENED = re.compile(rb"\b(?:open|parse|Path)\((\w+)\b|\b(\w+)\.(?:read_text|write_text|open)\(")
_WORD = re.compile(rb"\w+")
"""A name of a program's own for a path, and its uses that open the file."""


def what_loads(ending: str, text: bytes) -> bytes:
    """A program, without its comments, without what loads no model.

    Args:
        ending: Of its file's name, with the dot.
        text: The program.
    """
    if ending == ".json":
        # A list of what is there, or of what a run wrote.
        return b""
    if ending in (".py", ".ipynb"):
        text = _TEXTS.sub(lambda found: found[0] if found[1] is None else b"", text)
    if ending in (".py", ".ipynb", ".yaml", ".yml", ".sh"):
        text = _BEHIND.sub(b"", text)
    opened = Counter(one or other for one, other in _OPENED.findall(text))
    if opened:
        uses = Counter(_WORD.findall(text))
        uses.subtract(_HELD.findall(text))
        text = _HELD.sub(lambda one: b"" if 0 < uses[one[1]] == opened[one[1]] else one[0], text)
    return _CALLS.sub(b"", text)
