"""The randomisation target: one file a stack, and what each loses.

Ranges are checked here and in `actspec.sample`, not by `validate`: most checks need the nominal values.
"""

from __future__ import annotations

from typing import Any

import actspec
from actspec.diagnostics import Collector, EmitError, nearest, one_line
from actspec.ir import ActuatorSet, JointKind
from actspec.robot.view import RobotView
from actspec.sampling import check_ranges
from actspec.targets.base import Approximation, Emission, EmittedFile, TargetOptions
from actspec.targets.isaaclab.versions import FrictionUnit, isaaclab_dialect
from actspec.targets.mjlab.versions import mjlab_dialect
from actspec.targets.python_text import comment_lines, environment, grouped, identifier
from actspec.targets.randomization.isaaclab import isaaclab_terms
from actspec.targets.randomization.losses import Losses
from actspec.targets.randomization.mjlab import configs_of, mjlab_terms
from actspec.targets.randomization.playground import playground_function
from actspec.targets.randomization.record import record
from actspec.targets.versions import DEFAULT_MUJOCO, DEFAULT_VERSIONS, UnknownVersion, mujoco_dialect
from actspec.units import format_quantity

STACKS = ("isaaclab", "mjlab", "playground", "json")
"""What randomisation can be written for."""


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Write a robot's ranges for every stack that is asked for.

    Args:
        actuators: What is drawn.
        robot: The robot, for its joints' names.
        options: `stacks` (empty: all), `version` (of the one stack that is asked for, else each stack's
            default), `isaac_sim` and `backend`.

    Raises:
        EmitError: a range cannot be drawn from, or a stack or version is not known; with every reason.
    """
    collector = Collector()
    stacks = _stacks(options, collector)
    check_ranges(actuators, collector)
    collector.raise_if_failed(EmitError)
    writer = _Writer(actuators, robot, options, stacks, collector)
    files = [made for stack in stacks if (made := writer.file(stack)) is not None]
    collector.raise_if_failed(EmitError)
    return Emission(tuple(files), tuple(writer.lost), collector.sorted())


def _stacks(options: TargetOptions, collector: Collector) -> tuple[str, ...]:
    for stack in dict.fromkeys(options.stacks):
        if stack not in STACKS:
            guess = nearest(stack, STACKS)
            collector.error(
                "RND011",
                f"no randomisation can be written for '{one_line(stack)}'",
                where=f"targets.{options.name}.for",
                help=(f"did you mean '{guess}'? " if guess else "") + f"known: {', '.join(STACKS)}",
            )
    chosen = tuple(stack for stack in STACKS if stack in options.stacks) if options.stacks else STACKS
    versioned = [stack for stack in chosen if stack != "json"]
    if options.version and len(versioned) != 1:
        collector.error(
            "RND012",
            f"version '{one_line(options.version)}' could be that of {' or '.join(versioned) or 'no stack'}",
            where=f"targets.{options.name}.version",
            span=options.version_span,
            help="write a target for each stack: {target: randomization, for: [isaaclab], version: ...}",
        )
    return chosen


class _Writer:
    def __init__(
        self,
        actuators: ActuatorSet,
        robot: RobotView,
        options: TargetOptions,
        stacks: tuple[str, ...],
        collector: Collector,
    ) -> None:
        self.actuators = actuators
        self.robot = robot
        self.options = options
        self.collector = collector
        self.stem = identifier(actuators.robot)
        moving = (JointKind.HINGE, JointKind.SLIDE)
        self.names = tuple(
            joint.name for joint in robot.joints if joint.kind in moving and joint.mimic is None
        )
        self.lost: list[Approximation] = []

    def file(self, stack: str) -> EmittedFile | None:
        """The file of one stack; None after an error."""
        try:
            made = {
                "isaaclab": self.isaaclab,
                "mjlab": self.mjlab,
                "playground": self.playground,
                "json": self.json,
            }[stack]()
        except UnknownVersion as err:
            self.collector.error(
                "RND013",
                err.message,
                where=f"targets.{self.options.name}.version",
                span=self.options.version_span,
                help=err.help,
            )
            return None
        return made

    def version(self, stack: str) -> str:
        default = {**DEFAULT_VERSIONS, "playground": DEFAULT_MUJOCO}[stack]
        return self.options.version or default

    def isaaclab(self) -> EmittedFile:
        dialect = isaaclab_dialect(self.version("isaaclab"), self.options.isaac_sim, self.options.backend)
        losses = Losses(self.options.name, "isaaclab")
        terms = isaaclab_terms(self.actuators, self.names, dialect, losses, self.collector)
        title = f"Isaac Lab {dialect.text} on Isaac Sim {dialect.sim_text}"
        notes = [
            'Implicit groups are written to the simulator through the CPU: prefer mode="startup" for them.',
            "Text-checked, not run." if dialect.version not in ((2, 2), (2, 3)) else "",
            "Friction stays as it is: it has no known unit here."
            if dialect.friction is not FrictionUnit.EFFORT and dialect.friction is not FrictionUnit.EFFORT_ONE
            else "",
        ]
        module = "isaaclab.utils.configclass" if dialect.version >= (3, 0) else "isaaclab.utils"
        return self.render(
            "isaaclab_events.py.j2", f"{self.stem}_isaaclab_events.py", title, notes, losses,
            terms=terms, configclass=module,
        )  # fmt: skip

    def mjlab(self) -> EmittedFile | None:
        dialect = mjlab_dialect(self.version("mjlab"))
        if dialect.version < (1, 6):
            raise UnknownVersion(
                f"randomisation for mjlab {dialect.text} is not written",
                'write version: "1.6", or leave it out',
            )
        losses = Losses(self.options.name, "mjlab")
        configs = configs_of(self.actuators, self.robot, dialect, self.collector)
        if self.collector.failed:
            return None
        terms = mjlab_terms(self.actuators, configs, _short(self.names), losses)
        notes = []
        if any(term.actuators is not None for term in terms):
            notes = ["actuator_ids count the configs of the articulation that actspec's mjlab target writes:"]
            notes += [f"{index}: {', '.join(config.joints)}" for index, config in enumerate(configs)]
        return self.render(
            "mjlab_events.py.j2", f"{self.stem}_mjlab_events.py", f"mjlab {dialect.text}", notes, losses,
            terms=terms, variable=f"{self.stem.upper()}_EVENTS",
        )  # fmt: skip

    def playground(self) -> EmittedFile:
        dialect = mujoco_dialect(self.version("playground"))
        losses = Losses(self.options.name, "playground")
        function = playground_function(self.actuators, dialect, losses)
        notes = ["For the model that actspec's mujoco target writes; pass it as `randomization_fn`."]
        if function.dcmotor:
            notes.append(
                "The model has <dcmotor> actuators, which MJX runs in its Warp implementation alone."
            )
        return self.render(
            "playground.py.j2", f"{self.stem}_playground_randomize.py", f"MuJoCo Playground, MuJoCo {dialect.text}",
            notes, losses, function=function,
        )  # fmt: skip

    def json(self) -> EmittedFile:
        return EmittedFile(f"{self.stem}_randomization.json", record(self.actuators).encode("utf-8"))

    def render(
        self, template: str, path: str, title: str, notes: list[str], losses: Losses, **values: Any
    ) -> EmittedFile:
        self.lost += losses.items
        lines = [
            f"Written by actspec {actspec.__version__} for {title}. Do not edit: change the spec and compile again.",
            f"spec sha256 {self.actuators.spec_sha256}",
            *(note for note in notes if note),
        ]
        header = [line for text in lines for line in comment_lines(text, hang="  ")]
        said = _losses(losses.items, len(self.actuators.joints))
        if said:
            header += ["#", "# What it cannot do:"]
            header += [line for text in said for line in comment_lines(f"- {text}", hang="  ")]
        text = environment("randomization").get_template(template).render(header=header, **values)
        return EmittedFile(path, text.encode("utf-8"))


def _short(names: tuple[str, ...]) -> dict[str, str]:
    """What mjlab calls each joint: what is behind the last `/`."""
    return {name: name.rsplit("/", 1)[-1] for name in names}


def _losses(items: list[Approximation], joints: int) -> list[str]:
    """One line for the joints that lose the same."""
    found = []
    for _, members in grouped(
        items, lambda x: (x.field, x.asked, x.emitted, x.why, x.max_torque_error, x.unit)
    ):
        first = members[0]
        error = first.max_torque_error
        size = "" if error is None else f", at most {format_quantity(error, first.unit)}"
        field = first.field.partition(".")[2]
        who = "" if len(members) == joints else ": " + ", ".join(member.joint for member in members)
        found.append(f"{field}: {first.asked} -> {first.emitted}{size} ({first.why}){who}")
    return found
