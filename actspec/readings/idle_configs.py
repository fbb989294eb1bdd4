"""Which robots' configurations of a folder its programs import: what they do not, beside others, nobody runs."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping

from actspec.readings.artifact import FileKind, FileReading

_IMPORTED = re.compile(
    rb"^([ \t]*from[ \t]+[.\w]+[ \t]+import)[ \t]+(?:\((?![^)]*\bas\b)[^)*]*\)|(?!.*\bas\b)[^*(\n]+)",
    re.MULTILINE,
)
"""Names that a program imports; those that it calls by another name count as used."""

_PACKAGE = "__init__.py"

_WORD = re.compile(rb"\w+")

_HANDED_ON = re.compile(
    rb"^[ \t]*from[ \t]+[.\w]+[ \t]+import[ \t]+(?:\([^)*]*\)|[^*(\n]+)|__all__\s*\+?=\s*[\[(][^\])]*[\])]",
    re.MULTILINE,
)
"""What a package's `__init__.py`, or a module that has nothing else, hands on to who imports it: no use of it."""

_SAID = re.compile(
    rb"(^[ \t]*)?(\"\"\"|''').*?\2|([ \t]#[^\n\"']*$|[ \t]{2}#[^\n]*)", re.MULTILINE | re.DOTALL
)
"""What a program of Python only says: with the first group a text that is a statement, with the third a comment behind
one; texts that are none are gone over as a whole."""

_MADE_UP = re.compile(
    rb"(?:^|(?<=:\n)[ \t]+)\w+(?=(?:\.\w+|\[[^\]\n]*\])+[ \t]*=(?!=)|(?:\.\w+){2,}\()"
    rb"|\bin[ \t]+\w+(?=\.actuators\b)"
    rb"|(?<==)[ \t]*\w+(?=\.replace\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\bactuators\s*=)",
    re.MULTILINE,
)
"""The name of what a module sets a part of, goes through the drives of to make a table of action scales, or takes all
but the drives of.

None is a use of it: CFG.actuators["legs"] = ..., if there: CFG.spawn.replace_asset(...), for drive in
CFG.actuators.values(): ..., OTHER_CFG = CFG.replace(actuators={...})
"""


def folders_of(path: str) -> list[bytes]:
    """The names of a file's folders, the closest first."""
    return os.fsencode(os.path.dirname(path)).split(os.sep.encode())[::-1]


def stem_of(path: str) -> bytes:
    """A file's name without its ending."""
    return os.fsencode(os.path.splitext(os.path.basename(path))[0])


def configs_in(reading: FileReading) -> frozenset[bytes]:
    """Constants and classes of a Python file that set up a robot."""
    if reading.kind is not FileKind.CFG:
        return frozenset()
    names = (artifact.config.name for artifact in reading.artifacts if artifact.config is not None)
    return frozenset(name.encode() for name in names if name.isidentifier())


def idle_configs(
    configs: Mapping[str, frozenset[bytes]], programs: Mapping[str, bytes], others: bool
) -> dict[str, frozenset[bytes]]:
    """Path to what nobody imports; `others`: whether a program that is no configuration names a model."""
    if not configs:
        return {}
    every = frozenset().union(*configs.values()) | {stem_of(path) for path in configs}
    # Whole words, each name that is not part of a longer one.
    twins = {stem_of(path) for path in configs if folders_of(path)[0] == stem_of(path)}
    words = [rb"(?<![\w])" + re.escape(name) for name in sorted(every - twins)]
    # Of a module that is called as its package a name in an import is mostly the package's.
    words += [
        b"(?<=" + before + b")" + re.escape(name)
        for name in sorted(twins)
        for before in (re.escape(name) + rb"\.", rb"from \.", b"import ")
    ]
    pattern = re.compile(b"(?:" + b"|".join(words) + rb")(?![\w])")
    counts = {path: Counter(_uses(path, text, path in configs, pattern)) for path, text in programs.items()}
    used: dict[bytes, set[str]] = {}
    for path, count in counts.items():
        for name, times in count.items():
            # Where it is written twice, the second is its use.
            if times > 1 or name not in configs.get(path, ()):
                used.setdefault(name, set()).add(path)
    elsewhere = {
        path: {name for name in names if used.get(name, set()) - {path}} for path, names in configs.items()
    }
    result = {path: configs[path] for path in _copied_aside(configs, programs)}
    for path, names in configs.items():
        if path in result:
            continue
        alone = {name for name in names - elsewhere[path] if path not in used.get(name, ())}
        if not elsewhere[path] and (
            len(alone) < len(names)
            or not (others or any(elsewhere.values()))
            or used.get(stem_of(path), set()) - {path}
            or b"__main__" in programs.get(path, b"")
        ):
            continue
        if alone:
            result[path] = frozenset(alone)
    return result


def _uses(path: str, text: bytes, sets_up: bool, wanted: re.Pattern[bytes]) -> list[bytes]:
    """What is wanted and used in a program, each time; of thousands of programs few speak of any."""
    if not wanted.search(text):
        return []
    if path.endswith(".py"):
        text = _SAID.sub(lambda one: one[0] if one[1] is None is one[3] else b"", text)
    rest = _HANDED_ON.sub(b"", text)
    if os.path.basename(path) == _PACKAGE or not rest.strip():
        return wanted.findall(rest)
    return wanted.findall(_used_imports(_MADE_UP.sub(b"", text) if sets_up else text, wanted))


def _used_imports(text: bytes, wanted: re.Pattern[bytes]) -> bytes:
    """A program without the names that it imports, and without what it imports to use none of them.

    The module stays of what is used: `from robots.leg import`. As it is, where it imports nothing that is wanted: of
    thousands of programs few do.
    """
    if not any(wanted.search(statement[0]) for statement in _IMPORTED.finditer(text)):
        return text
    others = frozenset(_WORD.findall(_IMPORTED.sub(b"", text)))

    def kept(statement: re.Match[bytes]) -> bytes:
        names = _WORD.findall(statement[0][len(statement[1]) :])
        return statement[1] if others.intersection(names) else b""

    return _IMPORTED.sub(kept, text)


def _copied_aside(configs: Collection[str], programs: Mapping[str, bytes]) -> Iterator[str]:
    """Configurations of one file name, of a folder that nothing outside it names, where another's is imported from.

    `from dogs.robots.dog import DOG_CFG` beside `dogs/robots_before/dog.py`: the names inside are the same. Of folders
    with one name too it is the package's: of `dogs/dogs/robots/` where `dogs/robots/` has no `__init__.py`.
    """
    by_module: dict[bytes, list[str]] = {}
    for path in configs:
        by_module.setdefault(stem_of(path), []).append(path)
    for module, paths in by_module.items():
        folders = {path: folders_of(path)[0] for path in paths}
        if len(paths) > 1 and set(folders.values()) != {b""} and len({*folders.values()}) == 1:
            packaged = {
                path for path in paths if os.path.exists(os.path.join(os.path.dirname(path), _PACKAGE))
            }
            plain = re.compile(rb"^[ \t]*(?:from|import)[ \t]+\.?" + re.escape(module) + rb"\b", re.MULTILINE)
            if packaged and not any(map(plain.search, programs.values())):
                yield from (path for path in paths if path not in packaged)
        if len(paths) == 1 or len({*folders.values(), b""}) <= len(paths):
            continue
        named = {
            path: _outside(path, programs, rb"(?<!\w)" + re.escape(folders[path]) + rb"(?!\w)")
            for path in paths
        }
        imported = {
            path: _outside(path, programs, re.escape(folders[path]) + rb"\." + re.escape(module) + rb"(?!\w)")
            for path in paths
        }
        if any(imported.values()):
            yield from (path for path in paths if not named[path])


def _outside(path: str, programs: Mapping[str, bytes], pattern: bytes) -> bool:
    """Whether a program has a text that is in no folder of a file's own."""
    own, wanted = os.path.join(os.path.dirname(path), ""), re.compile(pattern)
    return any(wanted.search(text) for program, text in programs.items() if not program.startswith(own))
