"""Templates of models: what another program fills in before a simulator reads it."""

from __future__ import annotations

import re

from actspec.diagnostics import Span, shortened
from actspec.files import place_of
from actspec.readings.artifact import without_comments
from actspec.robot.view import ModelFile
from actspec.robot.xml_tree import XmlDocument

_PLACEHOLDER = re.compile(
    r"\{[^{}]+\}|\b__\w+?__\b|@[a-zA-Z_]\w*|@\([^()]+\)|%\(\w+\)|%\w+%|%[sdf]\b|\$[a-zA-Z_]\w*|\$\(\w[^()]*\)|#\w+#|<\w+>"
    r"|/\*\s*\w+\s*\*/"
)
"""As `str.format`, `string.Template`, Jinja, EmPy, CMake, plain substitution and the snippets of editors have it."""
_STATEMENT = re.compile(rb"\{\{[^{}<>]+\}\}|\{%[^{}]+%\}|^[ \t]*@(?:\[(?:for|if)\b|\{)[^\n]*", re.MULTILINE)
"""Of Jinja or EmPy, which may leave no XML."""
_REFUSED = re.compile(
    r"(?:format in attribute|keyword:|must be a number, got|no (?:file|folder)|^type) '([^']*)'"
)
"""What a refused value is, or the attribute that has it; of MuJoCo, and of our own readers."""


def placeholder(reason: str, at: Span | None, document: XmlDocument | None = None) -> str | None:
    """The value that a refusal is about, where it has yet to be filled in; None: that is not what is wrong.

    Args:
        reason: Why the file is refused.
        at: Where.
        document: The file; None: it could not be put together, and the reason has the value.
    """
    found = _REFUSED.search(reason)
    if found is None:
        return None
    if _PLACEHOLDER.search(found[1]):
        return repr(shortened(found[1]))
    if document is None or at is None:
        return None
    for element in document.walk():
        value, place = element.get(found[1], ""), document.span(element)
        if (place.path, place.line) == (at.path, at.line) and value and _PLACEHOLDER.search(value):
            return f'{shortened(found[1])}="{shortened(value)}"'
    return None


def statement(file: ModelFile) -> tuple[str, Span] | None:
    """The first statement of Jinja or EmPy in a file that is no XML, and its place; None: there is none."""
    found = _STATEMENT.search(without_comments(file.data))
    if found is None:
        return None
    place = Span(file.path, *place_of(file.data, file.data.index(found[0])))
    return repr(shortened(found[0].decode("utf-8", "replace"))), place
