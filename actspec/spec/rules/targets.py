"""Rules of `targets` and `accept`."""

from __future__ import annotations

from collections.abc import Mapping

from actspec.diagnostics import nearest
from actspec.spec.models import Target
from actspec.spec.rules.breaches import Breaches, is_folder_name

TARGETS = ("mujoco", "isaaclab", "mjlab", "deploy", "randomization", "urdf", "newton")
"""Kinds of target that the spec language knows."""

OPTIONS = {
    "version": ("mujoco", "isaaclab", "mjlab", "randomization", "newton"),
    "isaac_sim": ("isaaclab", "randomization"),
    "backend": ("isaaclab", "randomization"),
    "class": ("isaaclab",),
    "for": ("randomization",),
    "joint_order": ("deploy",),
    "root": ("newton",),
    "joint_paths": ("newton",),
}
"""Key of a target to the kinds of target that have it."""


SPEC_ITSELF = "spec"
"""What stands for a target in keys of `accept` about what the spec itself approximates, for every target."""


def check_targets(targets: Mapping[str, Target], breaches: Breaches) -> None:
    """Every target is of a kind that there is and has that kind's options, and its name can be a folder's."""
    for name, target in targets.items():
        kind = target.target or name
        if kind not in TARGETS:
            guess = nearest(kind, TARGETS)
            breaches.error(
                "SPEC160",
                f"no target is named '{kind}'",
                ("targets", name, "target") if target.target else ("targets", name),
                (f"did you mean '{guess}'? " if guess else "") + f"known targets: {', '.join(TARGETS)}",
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
                "use letters, digits, '-', '_' and '.'" if name != SPEC_ITSELF else "choose another name",
                key=True,
            )


def _check_options(name: str, kind: str, target: Target, breaches: Breaches) -> None:
    """A target's options are those of its kind: another kind's would do nothing."""
    stated = target.model_dump(by_alias=True, exclude_none=True)
    for option, kinds in OPTIONS.items():
        if option not in stated or kind in kinds:
            continue
        own = [other for other, of in OPTIONS.items() if kind in of]
        breaches.error(
            "SPEC163",
            f"a target of kind {kind} has no option `{option}`",
            ("targets", name, option),
            f"`{option}` is for {', '.join(kinds)}; {kind} has {', '.join(own) or 'none'}",
            key=True,
        )


def check_accept(accept: Mapping[str, str], targets: Mapping[str, Target], breaches: Breaches) -> None:
    """Every accepted approximation is of a target of the spec, and says why it is accepted."""
    # Without targets the spec compiles to MuJoCo.
    names = tuple(targets) or ("mujoco",)
    for entry, reason in accept.items():
        target_name, dot, _ = entry.partition(".")
        if not dot or target_name not in (*names, SPEC_ITSELF):
            breaches.error(
                "SPEC162",
                f"'{entry}' names no target of this spec",
                ("accept", entry),
                f"write TARGET.FIELD; targets: {', '.join(names)}",
                key=True,
            )
        if not reason.strip():
            breaches.error(
                "SPEC162",
                "an accepted approximation needs its reason",
                ("accept", entry),
                "say in a sentence why the loss does not matter here",
            )
