"""Paths and texts: the functions and methods of Python's own that a configuration builds file names with."""

from __future__ import annotations

from collections.abc import Sequence

from actspec.diagnostics import Span
from actspec.readings.python.arithmetic import bounded, text_of
from actspec.readings.python.values import MAX_TEXT, Data, PathText, Seq, Unknown, Value, reason_of


def path_call(name: str, args: Sequence[Value]) -> Data | None:
    """`Path(...)` and the functions of `os.path`; None for any other."""
    texts = [text_of(arg.data) for arg in args]
    reason = next((reason_of(arg.data) for arg in args if reason_of(arg.data)), None)
    if name in ("pathlib.Path", "pathlib.PurePath", "os.path.join") and texts:
        parts = [text for text in texts if text is not None]
        if len(parts) < len(texts):
            return Unknown(reason or "a path of what is no text")
        text = parts[0]
        for part in parts[1:]:
            text = part if part.startswith("/") else f"{text.rstrip('/')}/{part}" if text else part
    elif name in ("os.path.abspath", "os.path.realpath", "os.path.normpath", "os.fspath") and len(texts) == 1:
        if texts[0] is None:
            return Unknown(reason or "a path of what is no text")
        text = texts[0]
    elif name == "os.path.dirname" and len(texts) == 1:
        if texts[0] is None:
            return Unknown(reason or "a path of what is no text")
        text = _parent(texts[0])
    else:
        return None
    if len(text) > MAX_TEXT:
        return Unknown("a path that is too long")
    return Unknown(reason, text) if reason is not None else PathText(text)


def _parent(text: str) -> str:
    return text.rstrip("/").rpartition("/")[0] or "."


def path_attribute(path: str, name: str) -> Data | None:
    """An attribute of a `pathlib.Path`; None where it has none that is folded."""
    if name == "parent":
        return PathText(_parent(path))
    if name == "name":
        return path.rpartition("/")[2]
    if name == "stem":
        return path.rpartition("/")[2].rpartition(".")[0] or path.rpartition("/")[2]
    if name == "parents":
        found = []
        for _ in range(8):
            path = _parent(path)
            found.append(Value(PathText(path), Span("")))
        return Seq(found, "tuple")
    return None


def text_method(text: str, name: str, args: Sequence[Value]) -> Data:
    """A method of a text."""
    if isinstance(text, PathText) and name in ("resolve", "absolute", "expanduser", "as_posix"):
        return str(text) if name == "as_posix" else text
    plain = [arg.data for arg in args]
    reason = next((r for r in map(reason_of, plain) if r), None)
    if reason is not None:
        return Unknown(reason)
    if name in ("lower", "upper", "strip", "title") and not plain:
        return str(getattr(text, name)())
    texts = [one for one in plain if isinstance(one, str)]
    if len(texts) == len(plain):
        if name in ("startswith", "endswith") and len(texts) == 1:
            return text.startswith(texts[0]) if name == "startswith" else text.endswith(texts[0])
        if name == "replace" and len(texts) == 2 and (text.count(texts[0]) + 1) * len(texts[1]) <= MAX_TEXT:
            return bounded(text.replace(texts[0], texts[1]))
    if name == "join" and len(plain) == 1 and isinstance(plain[0], Seq):
        parts = [one.data for one in plain[0].items]
        words = [part for part in parts if isinstance(part, str)]
        if len(words) == len(parts) and sum(map(len, words)) + len(text) * len(words) <= MAX_TEXT:
            return text.join(words)
    return Unknown(f"calls .{name}() of a text, which is not folded")
