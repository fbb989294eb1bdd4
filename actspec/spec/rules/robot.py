"""Rules of `robot`, `sources`, `targets` and `accept`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from actspec.diagnostics import Path, did_you_mean, many, nearest
from actspec.ir import whole_steps
from actspec.patterns import PatternError, compile_pattern
from actspec.spec.document import Breaches
from actspec.spec.fields import CONTROL_PERIOD, STEP
from actspec.spec.models import KINDS, AnyTarget, Robot, SpecModel, Target, Timing
from actspec.spec.values import SpecValue
from actspec.units import format_number, format_quantity


def check_robot(robot: Robot, breaches: Breaches) -> None:
    """Name, joints and patterns of `robot`."""
    if robot.model != "none" and robot.joints:
        breaches.error("SPEC120", "`joints` are listed only where `model: none`", ("robot", "joints"))
    if robot.model == "none" and not robot.joints:
        breaches.error(
            "SPEC120",
            "a robot without a model needs its joints",
            ("robot", "model"),
            "write `joints: [name, ...]`, or name a model",
        )
    if not is_folder_name(robot.name):
        breaches.error(
            "SPEC124",
            f"the name {robot.name!r} cannot be a folder's name",
            ("robot", "name"),
            FOLDER_HELP,
        )
    names = [joint if isinstance(joint, str) else joint.name for joint in robot.joints]
    for index, name in enumerate(names):
        if name in names[:index]:
            breaches.error("SPEC121", f"the joint '{name}' is listed twice", ("robot", "joints", index))
    for index, pattern in enumerate(robot.unmanaged):
        check_pattern(pattern, ("robot", "unmanaged", index), breaches)
    for pattern in robot.default_pose:
        check_pattern(pattern, ("robot", "default_pose", pattern), breaches, key=True)


def check_timing(timing: Timing, breaches: Breaches) -> None:
    """The control period is said once, and is a whole number of physics steps."""
    path = ("timing", "control_dt")
    if timing.decimation is not None and timing.control_dt is not None:
        breaches.error(
            "SPEC125",
            "decimation and control_dt are both given",
            path,
            "keep decimation where the time of one physics step is known, else control_dt",
        )
    elif timing.physics_dt is not None and timing.control_dt is not None:
        found = _uneven(timing.control_dt, timing.physics_dt)
        if found is not None:
            breaches.error("SPEC126", found[0], path, found[1])


def _uneven(control: SpecValue, step: SpecValue) -> tuple[str, str] | None:
    """What is wrong with a control period that is no whole number of steps, and what to write; None: it is one."""
    if not control.value or not step.value or whole_steps(control.value, step.value) is not None:
        return None
    if not STEP[0] <= step.value <= STEP[1] or not CONTROL_PERIOD[0] <= control.value <= CONTROL_PERIOD[1]:
        # One of them is a slip, which is told (SPEC186).
        return None
    count = control.value / step.value
    if count < 1.0:
        help = f"write {step.written} or a multiple of it"
        if whole_steps(step.value, control.value) is not None:
            help = f"are the two exchanged? Else {help}"
        return f"{control.written} is less than one physics step of {step.written}", help
    most = math.ceil(count)
    low, high = (
        f"{format_quantity(1e3 * part * step.value, 'ms')} ({many(part, 'step')})"
        for part in (most - 1, most)
    )
    shown = format_number(round(count, 3))
    return (
        f"{control.written} is {shown} physics steps of {step.written}: simulators take whole ones",
        f"write {low} or {high}, or a physics_dt that divides it",
    )


def check_references(data: Any, model: SpecModel, breaches: Breaches) -> None:
    """Every motor and source that is named is in its section; a name that is in none is told once.

    Args:
        data: The document.
        model: What it says.
        breaches: Takes what is wrong.
    """
    known: Mapping[str, Mapping[str, object]] = {"motors": model.motors, "sources": model.sources}
    nouns = {"sources": ("SPEC123", "source"), "motors": ("SPEC141", "motor")}
    missing: dict[tuple[str, str], list[Path]] = {}
    sources = (("sources", key, path) for path, key in _source_keys(data))
    for section, name, path in (*sources, *_named_in(model)):
        out = breaches.left_out.intersection(((section,), (section, name), path[:1], path[:2]))
        if name not in known[section] and not out:
            missing.setdefault((section, name), []).append(path)
    for (section, name), paths in missing.items():
        code, noun = nouns[section]
        # `ec45` is short for `ec45_csf17`, and to the letter not near it.
        longer = [other for other in known[section] if name in other]
        meant = f"did you mean '{longer[0]}'?" if len(longer) == 1 and name else f"add it to `{section}`"
        help = did_you_mean(name, sorted(known[section]), meant)
        more = f", here and at {many(len(paths) - 1, 'more place')}" if len(paths) > 1 else ""
        breaches.error(code, f"no {noun} is named '{name}'{more}", paths[0], help)


def _named_in(model: SpecModel) -> Iterator[tuple[str, str, Path]]:
    """Section, name and place of the motors and sources that groups and linkages name."""
    for name, group in model.actuators.items():
        path: Path = ("actuators", name)
        overrides = [((*path, "overrides", key), held) for key, held in group.overrides.items()]
        for place, fields in ((path, group), *overrides):
            if fields.motor is not None:
                yield "motors", fields.motor, (*place, "motor")
    for name, linkage in model.linkages.items():
        for index, motor in enumerate(linkage.motors):
            yield "motors", motor, ("linkages", name, "motors", index)
        if linkage.source is not None:
            yield "sources", linkage.source, ("linkages", name, "source")


def _source_keys(node: Any, path: Path = ()) -> Iterator[tuple[Path, str]]:
    """Every `source:` that stands beside a `value:`."""
    if isinstance(node, Mapping):
        if "value" in node and isinstance(node.get("source"), str):
            yield (*path, "source"), node["source"]
        for key, value in node.items():
            yield from _source_keys(value, (*path, key))
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from _source_keys(value, (*path, index))


def check_pattern(pattern: str, path: Path, breaches: Breaches, *, key: bool = False) -> None:
    """A joint pattern can be matched."""
    try:
        compile_pattern(pattern)
    except PatternError as err:
        breaches.error("SPEC122", err.message, path, err.help, key=key)


FOLDER_HELP = (
    "use letters, digits, '-', '_' and '.', no '.' at the end, and no device of Windows (CON, NUL, COM1)"
)


def is_folder_name(name: str) -> bool:
    """Whether a name is safe as a folder on every system and as part of an identifier."""
    return (
        name.isascii()
        and all(c.isalnum() or c in "-_." for c in name)
        and name[:1] not in ("", ".", "-")
        and name[-1] != "."
        and not _RESERVED.fullmatch(name.partition(".")[0])
    )


_RESERVED = re.compile(r"CON|PRN|AUX|NUL|CONIN|CONOUT|(?:COM|LPT)[0-9]", re.IGNORECASE)
"""Devices of Windows, whatever ending stands behind them."""


_CHECK = re.compile(r"SPEC[0-9]+")
SPEC_ITSELF = "spec"
"""What stands for a target in keys of `accept` about what the spec itself approximates, for every target."""


def check_targets(targets: Mapping[str, Target], breaches: Breaches) -> None:
    """Every target is of a kind that there is and has that kind's options, and its name can be a folder's."""
    for name, target in targets.items():
        kind = target.target or name
        if kind not in KINDS:
            guess = nearest(kind, list(KINDS))
            breaches.error(
                "SPEC160",
                f"no target is named '{kind}'",
                ("targets", name, "target") if target.target else ("targets", name),
                (f"did you mean '{guess}'? " if guess else "") + f"known targets: {', '.join(KINDS)}",
                key=target.target is None,
            )
        else:
            _check_options(name, kind, target, breaches)
        if not is_folder_name(name) or name == SPEC_ITSELF:
            breaches.error(
                "SPEC161",
                f"the name '{name}' cannot be a folder's name"
                if name != SPEC_ITSELF
                else f"the name '{name}' stands for the spec itself in `accept`",
                ("targets", name),
                FOLDER_HELP if name != SPEC_ITSELF else "choose another name",
                key=True,
            )
    _check_distinct("targets", targets, breaches)


def check_variants(variants: Iterable[str], own: str | None, breaches: Breaches) -> None:
    """The name of a variant can end that of a folder, and is not that of the spec itself.

    Args:
        variants: Their names.
        own: What the spec itself is called; None: nothing, or it is one of them.
        breaches: Takes what is wrong.
    """
    for name in variants:
        if name.endswith("."):
            message = f"the name '{name}' cannot end a folder's name"
            breaches.error("SPEC161", message, ("variants", name), FOLDER_HELP, key=True)
        if name == own:
            message = f"'{name}' is the spec itself, by `variant`"
            breaches.error("SPEC161", message, ("variants", name), "rename one of the two", key=True)
    _check_distinct("variants", variants, breaches)


def _check_distinct(section: str, names: Iterable[str], breaches: Breaches) -> None:
    """Names of folders differ by more than case."""
    folders: dict[str, str] = {}
    for name in names:
        first = folders.setdefault(name.casefold(), name)
        if first != name:
            message = f"the name '{name}' and '{first}' are one folder where case is not told apart"
            breaches.error("SPEC161", message, (section, name), "choose another name", key=True)


def _check_options(name: str, kind: str, target: Target, breaches: Breaches) -> None:
    """A target's options are those of its kind: another kind's would do nothing."""
    own = _options(KINDS[kind])
    for option in target.model_dump(by_alias=True, exclude_none=True):
        if option == "target" or option in own:
            continue
        kinds = [other for other, options in KINDS.items() if option in _options(options)]
        breaches.error(
            "SPEC163",
            f"a target of kind {kind} has no option `{option}`",
            ("targets", name, option),
            f"`{option}` is for {', '.join(kinds)}; {kind} has {', '.join(own) or 'none'}",
            key=True,
        )


def _options(options: type[AnyTarget]) -> list[str]:
    """The keys of a kind of target, but for `target` itself."""
    keys = [field.alias or name for name, field in options.model_fields.items()]
    return [key for key in keys if key != "target"]


def check_accept(accept: Mapping[str, str], targets: Mapping[str, Target], breaches: Breaches) -> None:
    """Every accepted approximation is of a target of the spec, and says why it is accepted."""
    # Without targets the spec compiles to MuJoCo.
    names = tuple(targets) or ("mujoco",)
    for entry, reason in accept.items():
        target_name, dot, _ = entry.partition(".")
        if not dot or target_name not in (*names, SPEC_ITSELF):
            check = _CHECK.fullmatch(entry)
            breaches.error(
                "SPEC162",
                f"'{entry}' names no target of this spec",
                ("accept", entry),
                f"write `{SPEC_ITSELF}.{entry}`"
                if check
                else f"write TARGET.FIELD; targets: {', '.join(names)}",
                key=True,
            )
        if not reason.strip():
            breaches.error(
                "SPEC162",
                "what is accepted needs its reason",
                ("accept", entry),
                "say in a sentence why the number is right all the same"
                if target_name == SPEC_ITSELF
                else "say in a sentence why the loss does not matter here",
            )
