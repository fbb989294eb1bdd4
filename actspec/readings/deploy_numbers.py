"""Figures of a deploy file that are meant for numbers and are none: text, `.nan`, a joint without one."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

import yaml

from actspec.diagnostics import Collector, listed, shortened
from actspec.joints import SIDE_WORDS
from actspec.readings.deploy_keys import is_of_another
from actspec.readings.yaml_nodes import node_span, number_of

NO_NUMBER = "DEPLOY003"
"""Code of a value that is no number and stands where one is meant."""

_FIGURE = re.compile(r"\s*[-+]?\.?\d")
"""How a text begins that is meant for a number: `0,5`, `25 N*m/rad`, `4O0`, `1e5`."""

_YAML = "tag:yaml.org,2002:"


LEAST_JOINTS = 3
"""Chosen: entries of a list without names from which on it is one of joints; two may be the ends of a range."""


_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")

_LIMBS = SIDE_WORDS.union(
    ("front", "fore", "rear", "hind", "back", "middle"),
    ("leg", "arm", "hand", "finger", "head", "neck", "torso", "waist", "wheel"),
)
"""Words of a side, an end or a limb, in lower case. Chosen: as in joints' names, of one limb; `legs` is of several."""


def is_meant_for_one(node: yaml.Node) -> bool:
    """Whether a value is a number, or was meant for one: text that begins with a figure, `.nan`, `.inf`."""
    if not isinstance(node, yaml.ScalarNode):
        return False
    figure = node.tag == f"{_YAML}str" and _FIGURE.match(node.value) is not None
    return figure or node.tag in (f"{_YAML}int", f"{_YAML}float")


def is_empty(node: yaml.Node) -> bool:
    """Whether nothing stands behind a key, not even `null`."""
    return isinstance(node, yaml.ScalarNode) and node.tag == f"{_YAML}null" and node.value == ""


def is_per_joint(node: yaml.Node | None) -> bool:
    """Whether a value can be gains of several joints: a single number (a velocity controller's Kp) cannot."""
    if isinstance(node, yaml.SequenceNode):
        return bool(node.value) and all(isinstance(item, yaml.ScalarNode) for item in node.value)
    return isinstance(node, yaml.MappingNode) and bool(node.value)


def no_number(key: str, values: Sequence[tuple[str, yaml.Node]], out: Collector) -> None:
    """Say which figures of a key are no numbers; `null` and `unknown` are nobody's figure, nor are words among words.

    Args:
        key: As it stands in the file.
        values: Joint, or `it`, to its value.
        out: Is told.
    """
    odd = [(joint, node) for joint, node in values if number_of(node) is None and not _is_left_open(node)]
    figures = [one for one in odd if is_meant_for_one(one[1]) or is_empty(one[1])]
    drawn = any(is_of_another(joint) and "_" not in joint for joint, _ in values)
    if drawn or len(values) - len(odd) + len(figures) < len(odd) - len(figures):
        # What may be drawn, and words with a number among them, are no gains by joint: `kp: {mode: rel, scale: 0.8}`,
        # Isaac Gym's `stiffness: {range: [0.5, 1.5], operation: scaling, schedule_steps: 3000}`.
        odd = figures
    for joint, node in odd:
        out.warning(
            NO_NUMBER, f"{joint} has {_what(node)}: it is not judged", where=key, span=node_span(node)
        )


def by_side(values: Sequence[tuple[str, yaml.Node]], joints: Collection[str] = ()) -> str:
    """What a gain has in place of figures of joints, with why that is not read: `kp: {left: [...], right: [...]}`.

    Args:
        values: Of the key, by word.
        joints: Names of the file's list.

    Returns: Empty where most of its values are no lists and mappings of numbers below words of sides or limbs: a mode,
        a pose or a kind of limit has figures of all joints.
    """
    limbs = _LIMBS.union(*map(_words, joints))
    below = [
        (word, node)
        for word, node in values
        if word not in joints
        and not is_of_another(word)
        and (own := _words(word))
        and own <= limbs
        and _are_numbers(node)
    ]
    if 2 * len(below) <= len(values):
        return ""
    words = listed(shortened(word) for word, _ in below)
    kinds = sorted({"list" if isinstance(node, yaml.SequenceNode) else "mapping" for _, node in below})
    if len(below) == 1:
        return f"a {kinds[0]} below {words}: which joints it is of is not read"
    return f"{' and '.join(f'{kind}s' for kind in kinds)} below {words}: which joints they are of is not read"


def _words(name: str) -> set[str]:
    """The words of a name in lower case, without the s of several."""
    words = (word.lower() for word in _WORD.findall(name))
    return {word[:-1] if len(word) > 3 and word.endswith("s") else word for word in words}


def _are_numbers(node: yaml.Node) -> bool:
    """Whether a list or mapping has figures that may be of joints, as those of a range or of a schedule are not."""
    if isinstance(node, yaml.SequenceNode):
        return len(node.value) >= LEAST_JOINTS and all(number_of(item) is not None for item in node.value)
    pairs = node.value if isinstance(node, yaml.MappingNode) else []
    return len(pairs) > 1 and all(
        number_of(value) is not None and not is_of_another(str(word.value)) for word, value in pairs
    )


def _is_left_open(node: yaml.Node) -> bool:
    """Whether somebody says that there is no figure: a word for it, and not nothing at all."""
    if not isinstance(node, yaml.ScalarNode):
        return False
    return node.value == "unknown" or (node.tag == f"{_YAML}null" and not is_empty(node))


def _what(node: yaml.Node) -> str:
    if not isinstance(node, yaml.ScalarNode):
        return "a list, which is no number as YAML reads it"
    if node.tag == f"{_YAML}null":
        return "no value"
    if node.tag == f"{_YAML}float":
        return f"{shortened(node.value)}, which is no finite number"
    quote = node.style if node.style in ("'", '"') else ""
    # `1e5` without a dot is text to YAML 1.1.
    return f"{quote}{shortened(node.value)}{quote}, which is no number as YAML reads it"
