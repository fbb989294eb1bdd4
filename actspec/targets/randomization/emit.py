"""The randomisation target: one file a stack, and what each loses.

Ranges are checked here and in `actspec.sample`, not by `validate`: most checks need the nominal values.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from actspec.diagnostics import Collector, EmitError, nearest, one_line
from actspec.ir import ActuatorSet, JointKind, Level
from actspec.robot.view import RobotView
from actspec.sampling import check_ranges
from actspec.simulators import DEFAULT_VERSIONS, UnknownVersion, text_of
from actspec.simulators.mjlab import EVENTS, mjlab_dialect
from actspec.simulators.mujoco import MujocoDialect, mujoco_dialect
from actspec.spec.models import IsaacLabTarget, RandomizationTarget
from actspec.targets.base import Approximation, Emission, EmittedFile, TargetOptions
from actspec.targets.isaaclab import dialect_for
from actspec.targets.isaaclab.randomization import GAINS, isaaclab_terms
from actspec.targets.kit.provenance import written_by
from actspec.targets.kit.python_text import WIDTH, comment_lines, environment, grouped, identifier
from actspec.targets.mjlab.randomization import configs_of, mjlab_terms
from actspec.targets.mjlab.text import WIDTH as MJLAB_WIDTH
from actspec.targets.mujoco.playground import playground_function
from actspec.targets.randomization.losses import Losses
from actspec.targets.randomization.record import record
from actspec.units import format_quantity

STACKS = ("isaaclab", "mjlab", "playground", "json")
"""What randomisation can be written for."""

ADDRESSES = {
    "jnt": ("index", "np.array(joints)"),
    "dof": ("degree of freedom", "np.asarray(model.jnt_dofadr)[joints]"),
    "act": ("actuator", "np.array([target.index(joint) for joint in joints])"),
}
"""What Playground's function looks up of a joint: in words, and as it finds it."""


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Write a robot's ranges for every stack that is asked for.

    Args:
        actuators: What is drawn.
        robot: The robot, for its joints' names.
        options: `for` (nothing: all stacks), `version` (of the one stack that is asked for, else each stack's
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
    writer.tell_empty()
    collector.raise_if_failed(EmitError)
    return Emission(tuple(files), tuple(writer.lost), collector.sorted())


def _stacks(options: TargetOptions, collector: Collector) -> tuple[str, ...]:
    asked = options.of(RandomizationTarget).for_ or ()
    for index, stack in enumerate(asked):
        if stack not in STACKS:
            guess = nearest(stack, STACKS)
            option = f"for[{index}]"
            collector.error(
                "RND011",
                f"no randomisation can be written for '{one_line(stack)}'",
                where=options.where(option),
                span=options.span(option),
                help=(f"did you mean '{guess}'? " if guess else "") + f"known: {', '.join(STACKS)}",
            )
    chosen = tuple(stack for stack in STACKS if stack in asked) if asked else STACKS
    versioned = [stack for stack in chosen if stack != "json"]
    if options.version and len(versioned) != 1:
        collector.error(
            "RND012",
            f"version '{one_line(options.version)}' could be that of {' or '.join(versioned) or 'no stack'}",
            where=options.where("version"),
            span=options.span("version"),
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
        # All that a simulator matches a pattern against: followers and balls too, a floating base not.
        self.names = tuple(joint.name for joint in robot.joints if joint.kind is not JointKind.FREE)
        self.lost: list[Approximation] = []
        self.empty: list[str] = []

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
                where=self.options.where(err.key),
                span=self.options.span(err.key),
                help=err.help,
            )
            return None
        return made

    def version(self, stack: str) -> str:
        return self.options.version or DEFAULT_VERSIONS[stack]

    def isaaclab(self) -> EmittedFile | None:
        dialect = dialect_for(self.options, self.version("isaaclab"))
        losses = Losses(self.options.name, "isaaclab")
        terms = isaaclab_terms(self.actuators, self.names, dialect, losses, self.collector)
        if not terms:
            if not self.collector.failed:
                self.nothing("isaaclab", losses)
            return None
        late = any(term.func == GAINS and term.mode != "startup" for term in terms)
        implicit = any(
            o.kind == "isaaclab" and o.of(IsaacLabTarget).actuator_class == "implicit"
            for o in self.options.siblings
        )
        title = f"Isaac Lab {dialect.text} on Isaac Sim {dialect.sim_text}"
        notes = [
            'Gains of implicit groups are written to the simulator through the CPU: prefer mode="startup".'
            if late and implicit
            else "",
            "Text-checked, not run." if not dialect.executed else "",
            "" if dialect.friction.torque else "Friction stays as it is: it has no known unit here.",
        ]
        module = "isaaclab.utils.configclass" if dialect.row.native else "isaaclab.utils"
        return self.render(
            "isaaclab_events.py.j2", f"{self.stem}_isaaclab_events.py", title, notes, losses,
            terms=terms, configclass=module,
        )  # fmt: skip

    def mjlab(self) -> EmittedFile | None:
        dialect = mjlab_dialect(self.version("mjlab"))
        if dialect.version < EVENTS:
            raise UnknownVersion(
                f"randomisation for mjlab {dialect.text} is not written",
                f'write version: "{text_of(EVENTS)}", or leave it out',
            )
        losses = Losses(self.options.name, "mjlab")
        configs = configs_of(self.actuators, self.robot, dialect, self.collector)
        if self.collector.failed:
            return None
        terms = mjlab_terms(self.actuators, configs, _short(self.names), losses)
        if not terms:
            self.nothing("mjlab", losses)
            return None
        notes = []
        if any(term.actuators is not None for term in terms):
            notes = ["actuator_ids count the configs of the articulation that actspec's mjlab target writes:"]
            notes += [f"{index}: {', '.join(config.joints)}" for index, config in enumerate(configs)]
        return self.render(
            "mjlab_events.py.j2", f"{self.stem}_mjlab_events.py", f"mjlab {dialect.text}", notes, losses,
            width=MJLAB_WIDTH, terms=terms, variable=f"{self.stem.upper()}_EVENTS",
        )  # fmt: skip

    def mujoco(self) -> MujocoDialect | None:
        """MuJoCo of the model that Playground's function is for; None after an error."""
        models = [o for o in self.options.siblings if o.kind == "mujoco"]
        if self.options.version or not models:
            return mujoco_dialect(self.options.version or DEFAULT_VERSIONS["mujoco"])
        dialects = {}
        for model in models:
            # A version that there is not is the MuJoCo target's error.
            with suppress(UnknownVersion):
                dialects[model.name] = mujoco_dialect(model.version)
        words = {dialect.dcmotor for dialect in dialects.values()}
        if len(words) > 1 and any(a.level is Level.DC_MOTOR for a in self.actuators.joints):
            said = " or ".join(f"'{name}' ({dialect.text})" for name, dialect in dialects.items())
            self.collector.error(
                "RND014",
                f"Playground's function could be for the model of {said}, whose motors have their numbers elsewhere",
                where=self.options.where("version"),
                span=self.options.span("version"),
                help="write a target for it: {target: randomization, for: [playground], version: ...}",
            )
            return None
        return next(iter(dialects.values()), mujoco_dialect(DEFAULT_VERSIONS["mujoco"]))

    def nothing(self, stack: str, losses: Losses) -> None:
        """Note that a stack's file would draw nothing, and is not written."""
        self.lost += losses.items
        self.empty.append(stack)

    def tell_empty(self) -> None:
        """Report the stacks without a file."""
        if self.empty:
            stated = any(actuator.randomize for actuator in self.actuators.joints)
            why = "none of the spec's ranges can be drawn there" if stated else "the spec has no `randomize`"
            self.collector.info(
                "RND015",
                f"no file for {', '.join(self.empty)} is written: {why}",
                where=f"targets.{self.options.name}",
                help="state randomize in a group, or leave the stack out of `for`",
            )

    def playground(self) -> EmittedFile | None:
        dialect = self.mujoco()
        if dialect is None:
            return None
        losses = Losses(self.options.name, "playground")
        function = playground_function(self.actuators, self.robot, dialect, losses)
        if not function.joints:
            self.nothing("playground", losses)
            return None
        notes = ["For the model that actspec's mujoco target writes; pass it as `randomization_fn`."]
        if function.dcmotor:
            notes.append(
                "The model has <dcmotor> actuators, which MJX runs in its Warp implementation alone."
            )
        looked_up = ", ".join(ADDRESSES[name][1] for name in function.addresses)
        about = " and ".join(ADDRESSES[name][0] for name in function.addresses).capitalize()
        return self.render(
            "playground.py.j2", f"{self.stem}_playground_randomize.py", f"MuJoCo Playground, MuJoCo {dialect.text}",
            notes, losses, function=function, about=about, looked_up=looked_up,
        )  # fmt: skip

    def json(self) -> EmittedFile:
        return EmittedFile(f"{self.stem}_randomization.json", record(self.actuators).encode("utf-8"))

    def render(
        self,
        template: str,
        path: str,
        title: str,
        notes: list[str],
        losses: Losses,
        *,
        width: int = WIDTH,
        **values: Any,
    ) -> EmittedFile:
        self.lost += losses.items
        lines = [
            written_by(f" for {title}"),
            f"spec sha256 {self.actuators.spec_sha256}",
            *(note for note in notes if note),
        ]
        header = [line for text in lines for line in comment_lines(text, hang="  ", width=width)]
        said = _losses(losses.items, len(self.actuators.joints))
        if said:
            header += ["#", "# What it cannot do:"]
            header += [line for text in said for line in comment_lines(f"- {text}", hang="  ", width=width)]
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
