"""What the files and folders of artifacts call their robots, and whether that tells two robots apart."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Sequence
from functools import lru_cache

from actspec.files import in_common
from actspec.readings.artifact import Artifact, Framework

_OF_A_POLICY = re.compile(
    r".*/(?:robots/(?P<robot>[^/]+)/config/policy/(?:[^/]+/)*|logs/[^/]+/(?P<task>[^/]+)/[^/]+/)params"
)
"""Folders of one policy, whose robot is told further up. Source: unitree_rl_lab, deploy/robots/*/src/State_RLBase.cpp,
which loads `policy_dir / "params" / "deploy.yaml"`; their config/config.yaml: `policy_dir: config/policy/velocity`,
or `../../../logs/rsl_rl/unitree_b2_velocity`, below which is a folder for each training."""

_FOLDERS = 3
"""Folders above a file whose names tell robots of one family apart. Chosen: `anymal_b_description/urdf/anymal.urdf`."""

# fmt: off
_GENERIC = frozenset((
    "dof",
    "robot", "robots", "scene", "model", "mujoco", "mjcf", "urdf", "usd", "xml", "xmls", "cfg",
    "config", "configs", "description", "rev", "flat", "rough", "terrain", "env", "task", "train",
    "play", "deploy", "actuator", "actuators", "articulation", "articulations", "constants",
    "joint", "joints", "minimal", "main", "base", "hand", "hands", "handless", "with", "custom",
    "copy", "new", "old", "test", "mjx", "feetonly", "position", "torque", "motor", "velocity",
    "unitree", "asset", "assets", "source", "the", "and", "of", "my", "models", "resources", "data", "src",
))

KINDS = frozenset((
    "humanoid", "humanoids", "biped", "bipedal", "quadruped", "quadrupeds", "quadrupedal", "hexapod", "legged",
    "wheeled", "wheel", "leg", "legs", "dog", "arm", "arms", "gripper", "manipulator", "mobile", "procedural",
    "generated", "walker", "pendulum", "cartpole",
))
# fmt: on
"""Words that say nothing about which robot it is (the first), and what kind of robot it is. Chosen: from the names in
the surveyed repositories."""

_NUMBERED = re.compile(r"(?!(?:v|ver|rev|run|exp|seed|scene|task|copy|test)\d)([a-z]+)\d")
"""Letters before the first digit of a word, which are a family's; not of versions and runs."""

_LIKE_A_ROBOT = re.compile(r"(?!v\d)[a-z]{1,2}\d")
"""How many robots are called: `a1`, `go2`, `h1`, `x30`; what a policy does is no such word. Chosen: longer words with a
number, `walk2`, may be any."""

_WORD = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+[0-9]*|[A-Z]+[0-9]*|[0-9]+[a-z]*")


def agreement(named: str, path: str) -> int:
    """How many names of two paths agree from the end on: of `d1/urdf/robot.urdf` and `d2/urdf/robot.usd` two."""
    here, there = (os.path.splitext(each.replace("\\", "/"))[0].split("/")[::-1] for each in (named, path))
    return in_common(here, there)


def stem_of(path: str) -> str:
    """The name of a file without its ending."""
    return os.path.splitext(os.path.basename(path))[0]


def distinctive(artifact: Artifact) -> frozenset[str]:
    """What the artifact is called, in words that tell robots apart: `go2`, `h1_2`, `anymal_c`."""
    own, folder = names_of(artifact)
    return own or folder


def names_of(artifact: Artifact) -> tuple[frozenset[str], frozenset[str]]:
    """Telling words of the artifact's own name, and of its folder, or of the robot's one above a policy's."""
    stem = stem_of(artifact.path)
    above = os.path.dirname(os.path.abspath(artifact.path)).replace(os.sep, "/")
    deep = _OF_A_POLICY.fullmatch(above)
    folder = telling((deep["robot"] or deep["task"]) if deep else "") or telling(os.path.basename(above))
    own = telling(artifact.name)
    if artifact.config is None or artifact.config.framework is Framework.DEPLOY:
        own |= telling(stem)
    own = own or telling(stem) or _included(artifact)
    inside = _of_its_joints(artifact)
    # The more exact name counts: a scene called `h1` with `h1_2.xml` is an H1-2.
    own = frozenset(word for word in own if not any(i != word and i.startswith(word) for i in inside))
    return own | inside, folder


def words_of(artifact: Artifact, named: str) -> frozenset[str]:
    """Telling words of what an artifact and a path are called, with those of a folder where these tell but its kind.

    Args:
        artifact: A robot or its configuration.
        named: Path of its file from the folder that somebody named, or of the asset that it names; "" without one.
    """
    named = named.replace("\\", "/")
    own, folder = names_of(artifact)
    own |= telling(stem_of(named))
    if own - KINDS:
        return own
    folders = map(telling, reversed(named.split("/")[:-1]))
    return own | next(filter(None, folders), folder)


def _included(artifact: Artifact) -> frozenset[str]:
    """Telling words of the files that a model includes: a scene is of the robot in it."""
    files = () if artifact.robot is None else artifact.robot.files[1:]
    return frozenset(word for file in files for word in telling(stem_of(file.path)))


def _of_its_joints(artifact: Artifact) -> frozenset[str]:
    """Telling words of the included file that all joints of a model are in: `stairs.xml` with `go2.xml` is a Go2.

    An arm with a gripper of another file is none.
    """
    paths = {joint.span.path for joint in artifact.robot.joints} if artifact.robot is not None else set()
    return telling(stem_of(paths.pop())) if len(paths) == 1 and artifact.path not in paths else frozenset()


@lru_cache(maxsize=1024)  # a folder's files share most of it
def telling(text: str) -> frozenset[str]:
    """Words of a name that tell robots apart."""
    return frozenset(_words(text))


def _words(text: str) -> Iterable[str]:
    joined: list[str] = []
    for found in _WORD.findall(text.replace("MuJoCo", "mujoco")):
        word = found.lower()
        # `h1_2` and `anymal_c`: one letter or digit belongs to the word before it.
        if len(word) == 1 and joined and joined[-1] not in _GENERIC:
            joined[-1] += f"_{word}"
        else:
            joined.append(word)
    return [
        word
        for word in joined
        if word not in _GENERIC and len(word) > 1 and not re.fullmatch(r"[0-9]+(?:dof|kg|hz)?(?:_\d)?", word)
    ]


def shared_words(one: frozenset[str], other: frozenset[str]) -> frozenset[str]:
    """The words by which two names are of one robot: of its kind where neither has any other."""
    common = one & other
    return common - KINDS or (common if one <= KINDS and other <= KINDS else frozenset())


def say_nothing(one: frozenset[str], other: frozenset[str]) -> bool:
    """Whether names tell neither that it is one robot nor that it is two."""
    return not shared_words(one, other) and (not one or not other or bool(one & other))


def home_of(path: str) -> str:
    """The folder of a file, without those that only say what kind of files are in them."""
    parts = os.path.dirname(os.path.abspath(path)).split(os.sep)
    while len(parts) > 1 and not telling(parts[-1]):
        parts.pop()
    return os.sep.join(parts)


def names_agree(one: frozenset[str], other: frozenset[str]) -> bool:
    """Whether names may be of one robot: they share a word, and no sign tells models of one family apart.

    Signs are a letter or digit of its own (`anymal_b`, `anymal_c`) and a number in a word (`gr1t1`, `gr2t2`, `kr16`,
    `kr120`), unless one begins as the other does (`gr2t2`, `gr2t2d`) or it is a version's (`v2`).
    """
    return bool(shared_words(one, other)) and not _has_signs(one, other)


def _has_signs(one: frozenset[str], other: frozenset[str]) -> bool:
    """Whether signs tell models of one family apart."""
    apart = one - other, other - one
    signs = [{word.rpartition("_")[0] for word in mine if "_" in word} for mine in apart]
    numbered = any(_is_another_number(mine, its) for mine in apart[0] for its in apart[1])
    return bool(signs[0] & signs[1]) or numbered


def are_two(one: Sequence[frozenset[str]], other: Sequence[frozenset[str]]) -> bool:
    """Whether names of two artifacts, or else of their folders, are of one family's robots, or like `a1` and `go2`."""
    mine, its = (
        next(filter(None, (frozenset(filter(_LIKE_A_ROBOT.match, words)) for words in each)), frozenset())
        for each in (one, other)
    )
    alike = any(a.startswith(b) or b.startswith(a) for a in mine for b in its)
    return _has_signs(one[0], other[0]) or (bool(mine and its) and not alike)


def _is_another_number(one: str, other: str) -> bool:
    """Whether two words are one family's with different numbers."""
    stems = [_NUMBERED.match(word) for word in (one, other)]
    same = stems[0] is not None and stems[1] is not None and stems[0][1] == stems[1][1]
    return same and not one.startswith(other) and not other.startswith(one)


def told_apart(one: str, other: str, shared: frozenset[str]) -> bool:
    """Whether folders tell apart what the files call alike: `anymal_b_description`, `anymal_c_description`."""
    signs = [
        {
            word
            for name in os.path.dirname(os.path.abspath(path)).split(os.sep)[-_FOLDERS:]
            for word in telling(name)
            if word.rpartition("_")[0] in shared
        }
        for path in (one, other)
    ]
    return bool(signs[0] and signs[1]) and not signs[0] & signs[1]
