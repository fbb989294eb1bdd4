"""What the terms of an environment's actions make of an action at one joint: scale, zero and ends of its command.

Source: Isaac Lab 2.2.0 and 2.3.2, isaaclab/envs/mdp/actions/joint_actions.py; mjlab 1.6.0,
mjlab/envs/mdp/actions/actions.py: scale 1 and offset 0 for a joint that no key of a dict is for. Measured in
tests/frameworks/test_actions.py.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from actspec.patterns import PatternError, compile_pattern
from actspec.readings.artifact import ActionTerm, Framework, RobotConfig, Setting
from actspec.readings.dict_keys import Found, may_match, meets, of_one_key, plain_name, settled, value_of
from actspec.readings.joint_names import matching

SCALE = "action_scale"

_WORDS = {"position": "a position", "velocity": "a speed", "effort": "a torque"}

_NO_CLIP = {"position": 100.0, "velocity": 100.0, "effort": 1e9}
"""Ends of a command from which on a clip clips nothing, by what it is [SI]. Chosen: tasks of legged robots write
(-100, 100) for none; of a torque what is no limit of a drive either."""


def command_of(control: str, figures: Mapping[str, Found]) -> str:
    """What a drive's command is: without stiffness it follows a speed, without gains it is a torque.

    Args:
        control: What its class is, in the ledger's words.
        figures: Its gains.
    """
    if control in ("velocity", "motor"):
        return "velocity" if control == "velocity" else "effort"
    kp, kd = figures.get("kp"), figures.get("kd")
    if kp is None or kp.value != 0.0 or control == "network":
        return "position"
    return "effort" if kd is not None and kd.value == 0.0 else "velocity"


def acted(
    config: RobotConfig, joint: str, pattern: str, named: Sequence[str] | None, command: str
) -> dict[str, Found]:
    """What an environment's action terms say of a joint; empty where no term is for it.

    Args:
        config: With its terms.
        joint: The joint; the pattern itself where no joint is known.
        pattern: What selects it.
        named: All joints of the robot; None: they are not known.
        command: What the joint's command is: `position`, `velocity` or `effort`.

    Returns: `action_scale`; `action_zero`, the position at zero action, where that is not the default position;
        `clip_low` and `clip_high`, the ends of the command, where the term has any: infinite where it has one alone.
    """
    term, why = _term_of(config, joint, pattern, named)
    if term is None:
        return {}
    if not why and term.command is None:
        why = term.why
    called = term.cls or f"actions.{term.name}"
    if not why and term.command != command:
        its = _WORDS[term.command or ""]
        size = "" if term.scale is None or term.scale.number is None else f", {term.scale.number:g} x action"
        why = f"{called} commands {its}{size}, and the joint's command is {_WORDS[command]}"
    if why:
        return {SCALE: Found(None, term.place, why=why)}
    found: dict[str, Found] = {}
    zero = None
    if term.zero is not None:
        zero = _value(config.framework, term.zero, joint, pattern, named, 0.0)
    if zero is not None and command == "position":
        found["action_zero"] = zero
    elif zero is not None and zero.value != 0.0:
        size = "an offset that is not known" if zero.value is None else f"an offset of {zero.value:g}"
        return {SCALE: Found(None, term.place, why=f"{called} adds {size} to the command")}
    scale, beside = term.scale, config.settings.get(SCALE)
    if scale is not None and scale.unknown is not None and beside is not None and beside.unknown is not None:
        # The constant beside the robot, which the term names: it says more of why.
        scale = beside
    if scale is not None:
        found[SCALE] = _value(config.framework, scale, joint, pattern, named, 1.0)
    if term.clip is not None:
        found |= _ends(config.framework, term.clip, joint, command)
    return found


def _term_of(
    config: RobotConfig, joint: str, pattern: str, named: Sequence[str] | None
) -> tuple[ActionTerm | None, str]:
    """The term that is for a joint, and why nothing is known of it where that is not certain; None: no term is."""
    known = named is not None or plain_name(config.framework, pattern) is not None
    sure: list[ActionTerm] = []
    perhaps: list[ActionTerm] = []
    for term in config.actions:
        covers = [one for one in term.joints or () if _covers(config.framework, one, joint, known)]
        if covers:
            sure.append(term)
        elif any(_may_cover(config.framework, one, joint, known) for one in term.joints or ()):
            perhaps.append(term)
    loose = [term for term in config.actions if term.joints is None]
    if not sure and not perhaps and len(loose) == 1:
        # The base that has its joints is not read: those that no other term is for.
        return loose[0], ""
    every = [*sure, *perhaps, *(() if sure else loose)]
    if not every:
        return None, ""
    names = " and ".join(f"actions.{term.name}" for term in every[:2])
    if not perhaps and len(sure) > 1:
        return sure[0], f"{names} are both for the joint"
    if len(sure) == 1 and len(every) == 1:
        return sure[0], ""
    are = "are" if len(every) > 1 else "is"
    return every[0], f"which joints {names} {are} for is not known"


def _covers(framework: Framework, one: str, joint: str, known: bool) -> bool:
    """Whether a term's pattern is for a joint; for all that a pattern in its place stands for."""
    return bool(matching(framework, one, (joint,))) if known else one in (joint, ".*")


def _may_cover(framework: Framework, one: str, joint: str, known: bool) -> bool:
    """Whether a term's pattern that is not known to be for a joint may be."""
    return _is_refused(one) if known else may_match(framework, one, joint)


def _is_refused(pattern: str) -> bool:
    """Whether a pattern is not matched here, and may select anything."""
    try:
        compile_pattern(pattern)
    except PatternError:
        return True
    return False


def _value(
    framework: Framework,
    setting: Setting,
    joint: str,
    pattern: str,
    named: Sequence[str] | None,
    silent: float,
) -> Found:
    """A setting's value for a joint; `silent` for one that no key of a dict is for."""
    if isinstance(setting.value, Mapping) and setting.unknown is None:
        if named is None and plain_name(framework, pattern) is None:
            return value_of(framework, setting, joint, pattern, named) or Found(None, setting.span)
        if not any(meets(framework, SCALE, key, joint) for key in setting.value):
            refused = next((key for key in setting.value if _is_refused(key)), None)
            why = None if refused is None else f"whether the key '{refused}' is for the joint is not known"
            return Found(None if why else silent, setting.span, why=why)
        setting = settled(framework, SCALE, setting, joint)
    found = value_of(framework, setting, joint, pattern, named)
    return found or Found(None, setting.span, why="it is no number")


def _ends(framework: Framework, clip: Setting, joint: str, command: str) -> dict[str, Found]:
    """The ends of a joint's command, infinite where one is none; none where they clip nothing.

    `clip_low` alone, with the reason, where they are not known.
    """
    low, high, why = 0.0, 0.0, clip.unknown
    if why is None and not isinstance(clip.value, Mapping):
        why = "it is no dict of (low, high) by joint"
    elif why is None and isinstance(clip.value, Mapping):
        if not any(meets(framework, SCALE, key, joint) for key in clip.value):
            return {}
        clip = of_one_key(framework, SCALE, clip, joint)
        match clip.value:
            case (int() | float() as low, int() | float() as high):
                why = None if low < high else f"its ends are {low:g} and {high:g}"
            case _:
                why = clip.unknown or "it is no pair of numbers"
    if why is not None:
        return {"clip_low": Found(None, clip.span, why=why)}
    if min(-low, high) >= _NO_CLIP[command]:
        return {}
    return {"clip_low": Found(float(low), clip.span), "clip_high": Found(float(high), clip.span)}
