"""The head that actspec writes over a configuration: which versions it was compiled for."""

from __future__ import annotations

import re
from collections.abc import Mapping

_HEAD = re.compile(
    r"# Written by actspec \S+ for Isaac Lab (?P<isaaclab>\d+(?:\.\d+)*) on Isaac Sim (?P<isaac_sim>\d+(?:\.\d+)*) ?"
    r"(?:\((?P<backend>PhysX|OVPhysX|Newton)\))?\. "
)
"""Source: `actspec.targets.isaaclab.text`, and without the backend `actspec.targets.randomization`;
`tests/audit/test_head.py` holds them to each other."""


def written_for(data: bytes) -> Mapping[str, str]:
    """Versions by the names of `actspec.audit.case.Versions`' fields; empty without such a head.

    Args:
        data: The file.
    """
    found = _HEAD.match(data[:400].decode("utf-8", "replace"))
    return {name: text.lower() for name, text in found.groupdict().items() if text} if found else {}
