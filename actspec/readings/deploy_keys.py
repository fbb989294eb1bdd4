"""Keys of a deploy file: those of figures by joint and of names, an author's own for gains (`kp_walk` beside `kd_walk`,
`motor_kp`, `Kp`), and those of standing up."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import yaml

from actspec.diagnostics import Collector
from actspec.joints import WORD
from actspec.readings.deploy_steps import nearest
from actspec.readings.yaml_nodes import node_span, number_of

PER_JOINT = {
    "kp": ("kp", "kps", "stiffness", "p_gains", "kp_gains", "joint_kp", "joint_stiffness", "rl_kp"),
    "kd": ("kd", "kds", "damping", "d_gains", "kd_gains", "joint_kd", "joint_damping", "rl_kd"),
    "effort_limit": (
        "effort_limit",
        "effort_limits",
        "torque_limit",
        "torque_limits",
        "tau_limit",
        "dof_effort_limit_list",
    ),
    "velocity_limit": ("velocity_limit", "velocity_limits", "dof_vel_limit_list"),
    "armature": ("armature", "dof_armature_list"),
    "frictionloss": ("friction_coulomb", "frictionloss", "dof_joint_friction_list"),
    "joint_damping": ("friction_viscous",),
    "default_position": (
        "default_position",
        "default_joint_pos",
        "default_joint_angles",
        "default_dof_pos",
        "default_angles",
        "default_pos",
    ),
    "action_scale": ("action_scale", "action_scales"),
}
"""Field to the keys that people use for it. Source: unitree_rl_gym, unitree_rl_lab, rl_sar, ASAP, OpenHomie deploy
files, and what actspec writes."""

GAIN_KEYS = (*PER_JOINT["kp"], *PER_JOINT["kd"])
"""Every known key of gains that joints run a policy with."""

NAMES = (
    "joint_names",
    "dof_names",
    "joint_order",
    "policy_joint_names",
    "actuated_joint_names",
    "joint_controller_names",
    "joints",
)
"""Keys of the list that names the joints."""

STANDING_UP = "DEPLOY009"
"""Code of gains that are of standing up alone."""

STANDING = ("fixed_kp", "fixed_kd")
"""Keys of the gains with which the robot gets up and lies down, and never runs its policy. Source: rl_sar, rl_sdk.cpp:
Interpolate takes them as it is told, RLControl and ComputeTorques take rl_kp and rl_kd always."""

_LIKE = re.compile(r"(?:(?P<before>\w+)_)?(?P<gain>k[pd])s?(?:_(?P<after>\w+))?", re.IGNORECASE)

# fmt: off
_OTHER = frozenset((
    "range", "ranges", "limit", "limits", "scale", "scales", "factor", "factors", "min", "max", "low", "lower", "high",
    "upper", "std", "noise", "ratio", "weight", "weights", "rand", "randomization", "error", "mult", "multiplier",
    "cartesian", "cart", "task", "foot", "feet", "body", "com", "base", "ori", "orient", "orientation", "rot", "lin",
    "ang", "contact", "force", "torque", "vel", "velocity",
))
# fmt: on
"""Words of a key whose numbers are no gains of joints' positions: of what may be drawn, of a foot, of the body."""

LEAST = 7
"""Chosen: entries of lists of kp and kd from which on they are told to be of joints though no list of as many names is
in the file: fewer are of a leg, of a foot, of a pose in space."""

_MATRIX = 36
"""Entries of a matrix of stiffness in space."""

_SPACES = frozenset(("cartesian", "admittance", "compliance"))
"""Words of a block, or of a controller's type, whose stiffness is of a pose in space. An impedance is of joints as
often, `task` is IsaacGymEnvs' word for everything, `cart` a pole's."""

_OF_A_POSE = (3, 6, _MATRIX)
"""Entries of a stiffness in space."""

_AXES = "selected_axes"
"""What stands beside an admittance's stiffness. Source: ros2_controllers, admittance_controller_parameters.yaml."""

_TENSORS = ("torch.tensor", "torch.Tensor", "torch.FloatTensor", "torch.as_tensor")
"""What Hydra makes of a list, its `data`, and is still that list."""


@dataclass(frozen=True, slots=True)
class OwnGains:
    """A kp and a kd of joints that stand beside each other under keys of an author's own.

    Attributes:
        name: What their keys call them, `walk`; empty for `Kp` and `Kd`.
        kp: Key of the one, as written.
        kd: Key of the other.
        node: The kp.
        named: Whether a list of as many names of joints, or one with the names of these mappings, is in the file.
    """

    name: str
    kp: str
    kd: str
    node: yaml.Node
    named: bool


def gain_of(key: str) -> tuple[str, str] | None:
    """`kp` or `kd`, and what an author's own key calls it: `kp` and `walk` of `kp_walk`; None of any other key."""
    parts = _LIKE.fullmatch(key)
    if parts is None or key in ("kp", "kps", "kd", "kds", *STANDING):
        return None
    name = "_".join(part for part in (parts["before"], parts["after"]) if part).lower()
    return None if is_of_another(name) else (parts["gain"].lower(), name)


def is_of_another(name: str) -> bool:
    """Whether the numbers of a key are no gains of joints' positions, by its words."""
    return not _OTHER.isdisjoint(name.lower().split("_"))


def speaks_of_space(name: str) -> bool:
    """Whether a block's key, or a controller's type, says that its stiffness is of a pose in space, and not of joints:
    `admittance`, `cartesian_compliance_controller/CartesianComplianceController`."""
    words = {word.lower() for word in WORD.findall(name)}
    return not words.isdisjoint(_SPACES) and words.isdisjoint(("joint", "joints"))


def is_in_space(block: Mapping[str, yaml.Node], *, below: bool) -> bool:
    """Whether the gains of a block are of a pose in space: as many as its axes, where its controller's type, what
    stands beside them or a key above them says so.

    Args:
        block: A mapping.
        below: Whether a key above it, or the type of a controller that it is of, speaks of space.
    """
    gains = [block[key] for key in GAIN_KEYS if key in block]
    # A list of names in the block itself is of its gains; a controller in space names the joints that it moves.
    told = below and not any(key in block for key in NAMES)
    told = told or type_of_space(block) or _AXES in block
    lists = [node.value for node in gains if isinstance(node, yaml.SequenceNode)]
    return told and len(lists) == len(gains) > 0 and all(len(own) in _OF_A_POSE for own in lists)


def type_of_space(block: Mapping[str, yaml.Node]) -> bool:
    """Whether a block is of a controller whose `type` speaks of space."""
    return speaks_of_space(str(getattr(block.get("type"), "value", "")))


def as_figures(
    node: yaml.Node, mapping: Callable[[yaml.MappingNode], Mapping[str, yaml.Node]]
) -> yaml.Node | None:
    """What stands for the figures of a key: of a tensor that Hydra makes its list, and none of any other object of its
    making, whose keys are no joints.

    Args:
        node: What stands below a key of figures.
        mapping: A mapping's own and merged keys.
    """
    own = mapping(node) if isinstance(node, yaml.MappingNode) else {}
    if "_target_" not in own:
        return in_a_row(node, mapping)
    data = own.get("data")
    made = getattr(own["_target_"], "value", "")
    return data if made in _TENSORS and isinstance(data, yaml.SequenceNode) else None


def by_figure(
    node: yaml.Node | None,
    mapping: Callable[[yaml.MappingNode], Mapping[str, yaml.Node]],
) -> tuple[dict[str, yaml.Node], yaml.SequenceNode | None]:
    """Figures that stand joint by joint, each as one mapping of joints to it: `joints: {hip: {kp: 20, kd: 1}}`, or
    `joints: [{name: hip, kp: 20, kd: 1}]`; and the names that such a list has, whose joints with two places are left
    out.

    Args:
        node: What stands below `joints`.
        mapping: A mapping's own and merged keys.

    Returns: Empty where it has no several joints of which most have both.
    """
    names: list[yaml.Node] = []
    items: list[tuple[str, yaml.Node]] = []
    if isinstance(node, yaml.MappingNode):
        items = [*mapping(node).items()]
    elif isinstance(node, yaml.SequenceNode):
        for item in node.value:
            own = mapping(item) if isinstance(item, yaml.MappingNode) else {}
            name = next((own[key] for key in ("name", "joint") if key in own), None)
            if isinstance(name, yaml.ScalarNode):
                names.append(name)
                items.append((str(name.value), item))
    blocks = [(joint, mapping(below)) for joint, below in items if isinstance(below, yaml.MappingNode)]
    having = {
        joint
        for joint, own in blocks
        if all(not own.keys().isdisjoint(PER_JOINT[field]) for field in ("kp", "kd"))
    }
    count = Counter(joint for joint, _ in items)
    if node is None or len(having) < 2 or 2 * len(having) <= len(count):
        return {}, None
    their = frozenset(names)
    found: dict[str, list[tuple[yaml.Node, yaml.Node]]] = {}
    for joint, own in blocks:
        for key, figure in own.items():
            if count[joint] == 1 and figure not in their:
                found.setdefault(key, []).append((yaml.ScalarNode("tag:yaml.org,2002:str", joint), figure))
    whole: dict[str, yaml.Node] = {
        key: yaml.MappingNode("tag:yaml.org,2002:map", of_joints, node.start_mark, node.end_mark)
        for key, of_joints in found.items()
    }
    return whole, yaml.SequenceNode(node.tag, names, node.start_mark, node.end_mark)


def in_a_row(
    node: yaml.Node, mapping: Callable[[yaml.MappingNode], Mapping[str, yaml.Node]], first: int = 0
) -> yaml.Node:
    """Figures by the numbers of joints, `kp: {0: 20, 1: 40}`, as the list that they are; any other node as it is.

    Args:
        node: What stands below a key of figures.
        mapping: A mapping's own and merged keys.
        first: The first number. From 1 on joints may be called 1, 2, 3.
    """
    own = mapping(node) if isinstance(node, yaml.MappingNode) else {}
    return _row(node, own, first) if len(own) > 1 else node


def names_in_a_row(
    node: yaml.Node,
    mapping: Callable[[yaml.MappingNode], Mapping[str, yaml.Node]],
    beside: Iterable[yaml.Node] = (),
) -> yaml.Node:
    """Names by the numbers of joints, from 0 or 1 on, as the list that they are; any other node as it is.

    Args:
        node: What stands below a key of names.
        mapping: A mapping's keys.
        beside: What stands below the keys beside it: where figures are numbered from elsewhere on, which is whose is
            open.
    """
    own = mapping(node) if isinstance(node, yaml.MappingNode) else {}
    # One that stands twice, or a key that is no number, leaves open which is meant.
    whole = bool(own) and len(own) == len(node.value)
    if not (whole and all(value.tag == "tag:yaml.org,2002:str" for value in own.values())):
        return node
    others = (mapping(one).keys() for one in beside if isinstance(one, yaml.MappingNode))
    starts = {"0" in keys for keys in others if keys and all(map(str.isdecimal, keys))}
    return _row(node, own, int("0" not in own)) if starts <= {"0" in own} else node


def _row(node: yaml.Node, own: Mapping[str, yaml.Node], first: int) -> yaml.Node:
    numbers = [str(number) for number in range(first, first + len(own))]
    if own.keys() != set(numbers):
        return node
    return yaml.SequenceNode(node.tag, [own[number] for number in numbers], node.start_mark, node.end_mark)


_INTERVAL = re.compile(r"_(?:bounds?|ranges?|limits?|intervals?|min|max|low|high)$", re.IGNORECASE)
"""The end of a key of gains between which somebody looks for them."""


def own_gains(
    block: Mapping[str, yaml.Node],
    names: Collection[frozenset[str]],
    mapping: Callable[[yaml.MappingNode], Mapping[str, yaml.Node]],
) -> list[OwnGains]:
    """Every kp and kd of joints of a mapping under keys of an author's own, in its order.

    Args:
        block: The mapping.
        names: What `joint_lists` has of the file.
        mapping: A mapping's own and merged keys.
    """
    keys: dict[str, dict[str, str]] = {}
    for key in block:
        found = gain_of(key)
        if found is not None and not _INTERVAL.search(key):
            keys.setdefault(found[1], {}).setdefault(found[0], key)
    gains = []
    for name, own in keys.items():
        if len(own) < 2:
            continue
        kp, kd = (block[own[gain]] for gain in ("kp", "kd"))
        if isinstance(kp, yaml.SequenceNode) and isinstance(kd, yaml.SequenceNode):
            count = len(kp.value)
            numbers = all(number_of(item) is not None for item in (*kp.value, *kd.value))
            named = any(len(each) == count for each in names)
            told = named or (count >= LEAST and count != _MATRIX)
            if numbers and count == len(kd.value) and told:
                gains.append(OwnGains(name, own["kp"], own["kd"], kp, named))
        elif isinstance(kp, yaml.MappingNode) and isinstance(kd, yaml.MappingNode):
            values = {**mapping(kp), **mapping(kd)}
            if any(set(values) <= each for each in names):
                gains.append(OwnGains(name, own["kp"], own["kd"], kp, True))
    return gains


def joint_lists(blocks: Iterator[Mapping[str, yaml.Node]]) -> set[frozenset[str]]:
    """The lists of names that a file has under keys that speak of joints, `joint_names_mujoco` too, each name once."""
    found = set()
    for block in blocks:
        for key, node in block.items():
            if not isinstance(node, yaml.SequenceNode) or not re.search("joint|dof", key, re.IGNORECASE):
                continue
            texts = [item.value for item in node.value if item.tag == "tag:yaml.org,2002:str"]
            if len(node.value) == len(set(texts)) > 1:
                found.add(frozenset(texts))
    return found


def standing_up(
    scopes: Sequence[Mapping[str, yaml.Node]],
    out: Collector,
) -> bool:
    """Whether a block's only gains are of standing up, which are compared with nothing; that is said.

    Args:
        scopes: Mappings in which they may stand, the nearest first.
        out: Is told.
    """
    found = nearest(scopes, STANDING)
    if found is None or nearest(scopes, GAIN_KEYS) is not None:
        return False
    out.info(
        STANDING_UP,
        "these are the gains of getting up and lying down (rl_sar), and those of the policy (rl_kp, rl_kd) are not "
        "here: they are compared with nothing",
        where=found[0],
        span=node_span(found[1]),
    )
    return True
