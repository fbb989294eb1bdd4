"""Which targets a compile makes, and whether they lose what the spec accepts."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, SpecError, listed, nearest, one_line
from actspec.simulators import DEFAULT_VERSIONS, UnknownVersion
from actspec.simulators.isaaclab import isaaclab_dialect
from actspec.spec.models import KINDS, IsaacSimTarget
from actspec.spec.plausible import BY_CODE
from actspec.spec.rules.robot import SPEC_ITSELF
from actspec.targets.base import NO_LIMIT, Emission, TargetOptions
from actspec.targets.kit.python_text import grouped
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.ir import ActuatorSet
    from actspec.robot.view import RobotView
    from actspec.spec.validate import Spec

BUILD = "build"
"""Folder below the working directory that compiled files go to."""

Emit = Callable[["ActuatorSet", "RobotView", TargetOptions], Emission]
"""What every kind of target is: `emit(actuators, robot, options)`, what the spec asks for, resolved against the robot,
and how it is to be written. It raises an EmitError with every reason why the target cannot be written."""


def emitter(kind: str) -> Emit:
    """The function that makes a kind of target, from the module `emit` of its folder; imported when it is used."""
    emit: Emit = import_module(f"actspec.targets.{kind}.emit").emit
    return emit


def choose_targets(
    spec: Spec,
    asked: Sequence[str | TargetOptions],
    output: str | None,
    canonical: bool,
    collector: Collector,
) -> tuple[TargetOptions, ...]:
    """Which targets to compile: those of the spec, or those asked for by name or with their options.

    Raises:
        SpecError: a target that is asked for is unknown.
    """
    variant = spec.document.variant
    robot = spec.model.robot.name if variant is None else f"{spec.model.robot.name}-{variant}"
    folder = output if output is not None else os.path.join(BUILD, robot)

    def bare(kind: str) -> TargetOptions:
        version = DEFAULT_VERSIONS.get(kind, "")
        return TargetOptions(kind, kind, version, None, os.path.join(folder, kind), canonical)

    named = {}
    for name, entry in spec.model.targets.items():
        kind = entry.target or name
        own = KINDS[kind]
        named[name] = TargetOptions(
            name=name,
            kind=kind,
            version=entry.version or DEFAULT_VERSIONS.get(kind, ""),
            spans=_spans(spec, name),
            folder=os.path.join(folder, name),
            canonical=canonical,
            given=own.model_construct(**{field: getattr(entry, field) for field in own.model_fields}),
        )
    if not named:
        named["mujoco"] = bare("mujoco")
    chosen: list[TargetOptions] = []
    for text in asked or tuple(named):
        if isinstance(text, TargetOptions):
            chosen.append(text)
            continue
        name, equals, version = text.partition("==")
        if name in named:
            options = named[name]
        elif name in KINDS:
            options = bare(name)
        else:
            known = [*named, *(kind for kind in KINDS if kind not in named)]
            guess = nearest(name, known)
            collector.at("--target").error(
                "CLI001",
                f"no target is named '{one_line(name)}'",
                f"did you mean '{guess}'?" if guess else f"targets of the spec: {', '.join(named)}",
            )
            continue
        if equals:
            options = _at_version(options, version)
        if options not in chosen:
            chosen.append(options)
    collector.raise_if_failed(SpecError)
    return tuple(_beside(options, chosen, named.values()) for options in chosen)


def _at_version(options: TargetOptions, version: str) -> TargetOptions:
    """A target at the command line's version, without what the spec states for another one that does not fit."""
    options = replace(options, version=version, spans=_without(options.spans, "version"))
    given = options.given
    if not isinstance(given, IsaacSimTarget):
        return options
    for _ in ("isaac_sim", "backend"):
        try:
            isaaclab_dialect(version, given.isaac_sim, given.backend)
        except UnknownVersion as err:
            if err.key != "version":
                given = given.model_copy(update={err.key: None})
                options = replace(options, given=given, spans=_without(options.spans, err.key))
    return options


def _without(spans: Mapping[str, Span] | None, option: str) -> dict[str, Span]:
    return {key: span for key, span in (spans or {}).items() if key != option}


def _beside(
    options: TargetOptions, chosen: Sequence[TargetOptions], named: Iterable[TargetOptions]
) -> TargetOptions:
    """A randomization target with the simulators that it is for: those that are compiled, else the spec's."""
    if options.kind != "randomization" or options.siblings:
        return options
    found = []
    for kind in ("mujoco", "isaaclab"):
        found += [o for o in chosen if o.kind == kind] or [o for o in named if o.kind == kind]
    return replace(options, siblings=tuple(found))


def _spans(spec: Spec, name: str) -> dict[str, Span]:
    """Where each option of a target is written, the entries of a list or a mapping one by one too."""
    found = {}
    for key, value in spec.document.data["targets"][name].items():
        found[key] = spec.span("targets", name, key)
        if isinstance(value, list):
            found |= {
                f"{key}[{index}]": spec.span("targets", name, key, index) for index in range(len(value))
            }
        elif isinstance(value, dict):
            found |= {f"{key}[{entry}]": spec.span("targets", name, key, entry) for entry in value}
    return found


LIMIT = "effort_limit"


def warn_unlimited(
    actuators: ActuatorSet,
    targets: Sequence[TargetOptions],
    emissions: Sequence[Emission],
    collector: Collector,
) -> None:
    """Warn where targets are written without a limit that nobody states, and that `accept` does not name.

    Args:
        actuators: The spec, resolved.
        targets: What was compiled.
        emissions: What each made, in the same order.
        collector: Takes the warnings.
    """
    accepted = dict(actuators.accept)
    open_ = [
        (options.name, emission.unlimited)
        for options, emission in zip(targets, emissions, strict=True)
        if emission.unlimited and f"{options.name}.{LIMIT}" not in accepted
    ]
    found = [
        (actuator, tuple(name for name, joints in open_ if actuator.joint in joints))
        for actuator in actuators.joints
    ]
    for (group, span, names), members in grouped(
        [item for item in found if item[1]],
        lambda item: (item[0].group, item[0].effort_limit.span or item[0].span, item[1]),
    ):
        collector.at(f"actuators.{group}.{LIMIT}", span).warning(
            NO_LIMIT,
            f"{listed(actuator.joint for actuator, _ in members)}: {LIMIT} is unknown, and {listed(names)} "
            f"{'gets' if len(names) == 1 else 'get'} a drive of unlimited torque",
            f'state it, or if no limit is meant, `accept: {{{names[0]}.{LIMIT}: "the reason"}}`',
        )


def check_accepted(
    spec: Spec,
    actuators: ActuatorSet,
    targets: Sequence[TargetOptions],
    emissions: Sequence[Emission],
    collector: Collector,
) -> None:
    """Warn where a compiled target has no loss of a name that `accept` has (SPEC164), or a larger one (SPEC165).

    A target that is compiled at another version than the spec's is left out: its losses may be others.

    Args:
        spec: The spec.
        actuators: The spec, resolved: its joints, and what it simplifies itself.
        targets: What was compiled.
        emissions: What each made, in the same order.
        collector: Takes the warnings.
    """
    losses = {
        options.name: emission.approximations
        for options, emission in zip(targets, emissions, strict=True)
        if options.version == _version(spec, options)
    }
    losses[SPEC_ITSELF] = actuators.approximations
    lost = {name: dict.fromkeys(loss.field for loss in some) for name, some in losses.items()}
    for options, emission in zip(targets, emissions, strict=True):
        if emission.unlimited and options.name in lost:
            lost[options.name][LIMIT] = None
    for key, reason in spec.model.accept.items():
        target, _, field = key.partition(".")
        larger = [loss for loss in losses.get(target, ()) if loss.field == field and not loss.within(reason)]
        if larger:
            worst = max(larger, key=lambda loss: loss.max_torque_error or 0.0)
            collector.at(f"accept.{key}", spec.span("accept", key)).warning(
                "SPEC165",
                f"the torque error is up to {format_quantity(worst.max_torque_error, worst.unit, 4)} ({worst.joint}), "
                f"more than this reason says: it is not accepted",
                "look for a number that has changed, or correct the reason",
            )
        if target not in lost or field in lost[target] or (target == SPEC_ITSELF and field in BY_CODE):
            continue
        guess = nearest(field, list(lost[target]))
        if guess is None and target == SPEC_ITSELF:
            codes = {check.name: code for code, check in BY_CODE.items()}
            guess = codes.get(nearest(field.lower(), list(codes)) or "")
        whose = "the spec itself" if target == SPEC_ITSELF else f"the target '{target}'"
        others = f"its losses are {listed(lost[target])}" if lost[target] else "it loses nothing"
        collector.at(f"accept.{key}", spec.document.spans.key(("accept", key))).warning(
            "SPEC164",
            f"{whose} has no approximation of this name: nothing is accepted by it",
            f"did you mean '{target}.{guess}'?" if guess else f"remove it; {others}",
        )


def _version(spec: Spec, options: TargetOptions) -> str:
    entry = spec.model.targets.get(options.name)
    return (entry.version if entry is not None else None) or DEFAULT_VERSIONS.get(options.kind, "")
