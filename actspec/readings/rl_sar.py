"""What rl_sar's policies have from their robot: the keys of the `base.yaml` above a policy's own file that it lacks.

Source: rl_sar, rl_sdk.cpp: ReadYaml takes the key `go2w/robot_lab` of policy/go2w/robot_lab/config.yaml and writes each
figure over that of `go2w` in policy/go2w/base.yaml, which it has read first.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass

import yaml

from actspec.files import FAULTS, read_regular
from actspec.readings.yaml_nodes import Unfit, compose
from actspec.robot.view import ModelFile

_POLICY = re.compile(rb"^([\"']?)([\w.-]+)((?:/[\w.-]+)+)\1[ \t]*:", re.MULTILINE)
"""The key of a policy at the top of its file: its robot's name and the folders below that one's."""


@dataclass(frozen=True, slots=True)
class Base:
    """What the policies of a robot share.

    Attributes:
        file: It.
        block: The robot's mapping in it.
    """

    file: ModelFile
    block: yaml.MappingNode


def base_of(path: str, data: bytes, most: int) -> Base | None:
    """What a policy's file has from its robot's; None where it is none of rl_sar's, or there is no such file.

    Args:
        path: The policy's file.
        data: Its bytes.
        most: Largest size of a file [bytes].
    """
    found = _POLICY.search(data)
    if found is None:
        return None
    robot, below = found[2].decode(), found[3].count(b"/")
    base = os.path.normpath(os.path.join(os.path.dirname(path), *[os.pardir] * below, "base.yaml"))
    try:
        text = read_regular(base, most)
        root = compose(text, base)
    except (*FAULTS, Unfit):
        return None
    for key, block in root.value if isinstance(root, yaml.MappingNode) else ():
        if key.value == robot and isinstance(block, yaml.MappingNode):
            return Base(ModelFile(base, "", text), block)
    return None
