"""Static agreement of a deploy file's maps between joint orders."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import Any

from actspec.diagnostics import one_line
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.verify.agreement import Row
from actspec.verify.target import Target

MAPS = ("order", "index")
"""Blocks of the file whose entries are lists over the joints."""

MOST_BYTES = 8 << 20
"""Chosen: as the audit's reader, which has taken the file before."""


def order_rows(target: Target) -> Iterator[Row]:
    """Rows of each order and each map between two, held to what actspec writes."""
    ours, theirs = (
        _blocks(os.path.join(folder, target.files[0])) for folder in (target.fresh, target.folder)
    )
    for name in dict.fromkeys((*ours, *theirs)):
        asked, got = ours.get(name), theirs.get(name)
        same = asked == got
        message = "" if same else one_line(f"{name} is another one: {_difference(asked, got)}")
        yield Row(
            *(target.name, "", "", len(asked or ()), name, "", 0.0 if same else None, 0.0, same),
            code=None if same else "VFY109",
            message=message,
        )


def _blocks(path: str) -> dict[str, list[Any]]:
    """Lists of the blocks, by `order.isaac`; those that cannot be read are missing."""
    import yaml

    try:
        data = yaml.load(read_regular(path, MOST_BYTES), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    except (OSError, ValueError, NotRegular, TooLarge, yaml.YAMLError, RecursionError):
        return {}
    if not isinstance(data, Mapping):
        return {}
    return {
        f"{block}.{name}": value
        for block in MAPS
        if isinstance(data.get(block), Mapping)
        for name, value in data[block].items()
        if isinstance(value, list)
    }


def _difference(asked: list[Any] | None, got: list[Any] | None) -> str:
    """The first entry that differs."""
    if asked is None or got is None:
        return "it is missing" if got is None else "actspec writes none"
    if len(asked) != len(got):
        return f"it has {len(got)} entries, and should have {len(asked)}"
    place, (want, have) = next(
        (i, pair) for i, pair in enumerate(zip(asked, got, strict=True)) if pair[0] != pair[1]
    )
    return f"entry {place} is {have!s:.60}, and should be {want!s:.60}"
