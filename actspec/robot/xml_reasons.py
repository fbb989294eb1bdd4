"""Why expat refuses an XML file, in plain words, and what to do."""

from __future__ import annotations

import re
from xml.parsers import expat

from actspec import files

READ_BY_MUJOCO = " (MuJoCo reads it as it is, other readers of XML do not)"
"""At the end of a help: what such a file lacks is nothing to MuJoCo."""

_TAG_SO_FAR = re.compile(rb"""<[^"'>]*(?:(?:"[^"]*"|'[^']*')[^"'>]*)*""")
_REFERENCE = re.compile(rb"&\w*\Z")
_AFTER_VALUE = re.compile(rb"[\s/>]")

LFS_POINTER = b"version https://git-lfs.github.com/"
"""How a file begins that Git LFS keeps elsewhere."""


def explain(code: int, data: bytes, at: int, inside: tuple[str, int] | None) -> tuple[str, str | None]:
    """Put expat's reason in plain words.

    Args:
        code: expat's error code.
        data: The file.
        at: Offset of the error.
        inside: Innermost open element: tag and line.

    Returns: message and help.
    """
    element = f"<{inside[0]}> (line {inside[1]})" if inside is not None else ""
    text = expat.errors.messages.get(code, "not well-formed XML")
    if text == expat.errors.XML_ERROR_INVALID_TOKEN:
        return _invalid_token(data, at)
    if text == expat.errors.XML_ERROR_SYNTAX:
        if data.startswith(LFS_POINTER):
            return "this is a pointer of Git LFS, and not the file itself", "fetch it: `git lfs pull`"
        return "this is not XML", None
    if text == expat.errors.XML_ERROR_NO_ELEMENTS:
        if not element:
            return "the file has no XML element", None
        return f"the file ends before {element} is closed", f"write </{inside[0] if inside else ''}>"
    if text == expat.errors.XML_ERROR_UNCLOSED_TOKEN:
        return "the file ends inside a tag or comment that starts here", None
    if text == expat.errors.XML_ERROR_UNCLOSED_CDATA_SECTION:
        return "the file ends inside a CDATA section", "write ]]>"
    if text == expat.errors.XML_ERROR_TAG_MISMATCH:
        found = re.compile(rb"[^\s>]*").match(data, at)
        name = found[0].decode("utf-8", "replace") if found else ""
        return f"</{name}> stands where {element} is to be closed", None
    if text == expat.errors.XML_ERROR_DUPLICATE_ATTRIBUTE:
        found = re.compile(rb"[^\s=]*").match(data, at)
        name = found[0].decode("utf-8", "replace") if found else ""
        return f"attribute {name!r} appears twice", "delete one of the two; MuJoCo refuses it too"
    if text == expat.errors.XML_ERROR_JUNK_AFTER_DOC_ELEMENT:
        return "text or an element after the end of the root element", "delete what follows"
    if text == expat.errors.XML_ERROR_UNDEFINED_ENTITY:
        return (
            "a reference to an entity that XML does not know",
            f"write the character itself, or &#NUMBER;{READ_BY_MUJOCO}",
        )
    if text == expat.errors.XML_ERROR_BAD_CHAR_REF:
        return "a reference to a character that XML does not allow", "delete it"
    if text in (expat.errors.XML_ERROR_MISPLACED_XML_PI, expat.errors.XML_ERROR_XML_DECL):
        # MuJoCo 4.0 skips white space before a declaration, as is done here, but refuses one behind a comment.
        return (
            "a malformed XML declaration, or one that is not the first thing in the file",
            'begin the file with <?xml version="1.0"?>, or leave it out',
        )
    return f"not well-formed XML: {text}", None


def _invalid_token(data: bytes, at: int) -> tuple[str, str | None]:
    """Guess at what makes the byte at `at` impossible, from what stands round it."""
    here, before = data[at : at + 1], data[at - 1 : at]
    if here < b" " and here not in (b"\t", b"\n", b"\r"):
        return f"a control character, 0x{here.hex() or '00'}", "delete it"
    if data.rfind(b"<!--", 0, at) > data.rfind(b"-->", 0, at) and data[at - 2 : at] == b"--":
        return "a comment that is never closed", "close it with '-->'"
    if _REFERENCE.search(data[max(at - 40, 0) : at]):
        return "a bare '&'", f"write &amp;{READ_BY_MUJOCO}"
    if data[at - 1 : at + 1] == b"</":
        return "a closing tag whose element is closed already", "delete it"
    if before == b"<":
        return "a '<' that does not begin a tag", "write &lt;"
    tag = data[max(data.rfind(b"<", 0, at), 0) : at]
    so_far = _TAG_SO_FAR.match(tag)
    rest = tag[so_far.end() :] if so_far is not None else b">"
    if here == b"<" and rest[:1] in (b'"', b"'"):
        opens, closes = at - len(rest), data.find(rest[:1], at)
        if closes > 0 and b"\n" not in data[opens:closes] and _AFTER_VALUE.match(data, closes + 1):
            return "'<' inside an attribute value", f"write &lt;{READ_BY_MUJOCO}"
        line = files.place_of(data, opens)[0]
        return f"'<' inside an attribute value that begins in line {line}", "add the missing quote there"
    if not rest and here == b"<":
        return "a tag begins inside another tag", "close the tag before it with '>'"
    if not rest and before in (b'"', b"'"):
        return "no space between two attributes", "put a space between them, or add the missing quote before"
    if not rest and tag.rstrip().endswith(b"="):
        return "an attribute value without quotes", 'write name="value"'
    if not rest and here != b"=" and re.search(rb"\s[^\s=\"'/]+\s*$", tag):
        return "an attribute without a value", 'write name="value"'
    character = data[at : at + 4].decode("utf-8", "ignore")[:1]
    return f"not well-formed XML: {character!r} cannot stand here", None
