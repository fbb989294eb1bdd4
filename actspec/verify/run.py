"""Verify targets: read their files back, ask their engines, and say what agrees.

Checks are functions that take the verified targets and give rows; another one is added in `verify`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from importlib import import_module

from actspec.diagnostics import Collector, Diagnostic, RobotError, Span
from actspec.ir import ActuatorSet
from actspec.readings.compare import Figure
from actspec.robot.view import RobotView
from actspec.simulate.excitation import HeldMotions
from actspec.targets.base import Emission, TargetOptions
from actspec.verify.agreement import Agreement, Row, Skip, TargetFiles, VerifyError
from actspec.verify.engines.asking import EngineAnswer, EngineMissing, EngineRefused, Question, answered
from actspec.verify.execution import (
    CONSENT,
    EXECUTED,
    code_rows,
    other_rows,
    runnable,
    withheld,
)
from actspec.verify.fields import broken, engine_rows, field_rows, without_repeats
from actspec.verify.joint_laws import JointLaws, law_skips, laws_of, motions_of
from actspec.verify.layout import order_rows
from actspec.verify.networks import network_rows
from actspec.verify.readback import Asked, FileFigures, read_back, read_overlay, spec_figures
from actspec.verify.response import responses
from actspec.verify.torque import torque_rows

ENGINES = {
    "mujoco": "actspec.verify.engines.mujoco",
    "isaaclab": "actspec.verify.engines.frameworks",
    "mjlab": "actspec.verify.engines.frameworks",
    "newton": "actspec.verify.engines.frameworks",
}
"""Kind of target to the module whose `ask` runs its engine; the other kinds have none."""

NO_ENGINE = {
    "urdf": "a URDF describes joints, and no drive that could give a torque",
    "deploy": "the file is read by the robot's own software",
    "randomization": "ranges have no torque",
}
"""Why a kind has none."""

READ = ("mujoco", "isaaclab", "mjlab", "deploy", "urdf")
"""Kinds whose main file the audit's readers read back joint by joint; Newton's has a reader of its own."""

EngineReply = EngineAnswer | EngineMissing | EngineRefused
"""What came of asking an engine."""


def verify(
    actuators: ActuatorSet,
    robot: RobotView,
    targets: Sequence[TargetFiles],
    *,
    spec: str,
    engines: bool = True,
    run_edited: bool = False,
    trust: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Agreement:
    """Verify targets against the spec that they are compiled from.

    Args:
        actuators: What the spec asks for, resolved.
        robot: Its robot.
        targets: Their files, which are there.
        spec: Path of the spec, for places.
        engines: Ask the engines too; files are only read back without.
        run_edited: Let simulators execute Python files that are not what the spec compiles to.
        trust: Let them execute TorchScript that actspec did not write.
        progress: Called with how many steps are done, of how many.
    """
    from actspec.verify.ranges import range_rows

    done = 0

    def step() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done, len(targets) + 2)

    readings, unread = _read(targets, actuators, robot)
    step()
    asked = spec_figures(actuators, spec)
    rows: list[Row] = []
    skipped: list[Skip] = []
    replies: Mapping[str, EngineReply] = {}
    moved: Mapping[str, list[Row]] = {}
    laws = laws_of(actuators) if engines else JointLaws((), {}, {}, {})
    given: dict[str, tuple[JointLaws, HeldMotions]] = {}
    if laws.joints:
        both = laws, motions_of(laws, actuators.physics_dt.require())
        for target in targets:
            mine = runnable(target, laws, run_edited=run_edited, trust=trust)
            alone = mine is not laws
            given[target.name] = (mine, motions_of(mine, actuators.physics_dt.require())) if alone else both
        refused = {
            target.name: EngineMissing(reason, CONSENT)
            for target in targets
            if (reason := withheld(target, run_edited=run_edited)) is not None
        }
        asked_of = [t for t in targets if t.name not in refused and given[t.name][0].joints]
        questions = _questions(asked_of, readings, actuators, robot, given, run_edited=run_edited)
        replies = {**refused, **_ask(questions, given, step)}
        asks = {
            name: partial(import_module(ENGINES[questions[name].options.kind]).respond, questions[name])
            for name, answer in replies.items()
            if isinstance(answer, EngineAnswer)
        }
        moved, skipped = responses(targets, actuators, laws, asks)
        step()
    for target in targets:
        fresh, built = readings.get(target.name, (None, None))
        if engines:
            mine, moves = given.get(target.name, (laws, {}))
            found, missed = _torques(target, actuators, asked, mine, moves, replies.get(target.name), fresh)
            rows += [*found, *moved.get(target.name, ())]
            skipped += missed
        if engines and target.options.kind == "urdf" and fresh is not None and built is not None:
            found, missed = _read_again(target, actuators, asked, fresh, built)
            rows += found
            skipped += missed
        if fresh is not None and built is not None:
            fields = list(field_rows(target, actuators, asked, fresh, built))
            if target.options.kind == "deploy" and built.reason is None:
                orders = list(order_rows(target))
                if not all(row.ok for row in orders):
                    # Every list has another joint's numbers then, and it is said once.
                    fields = [row for row in fields if row.code != "VFY109" or row.quantity == "joint"]
                fields += orders
            rows += fields
        elif target.options.kind == "randomization":
            rows += range_rows(target, actuators, robot)
        if not isinstance(replies.get(target.name), EngineAnswer):
            rows += code_rows(target)
        rows += other_rows(target)
    skipped += [Skip(name, "", "fields", one.message, one.help, True) for name, one in unread.items()]
    if unread and not rows:
        # Nothing is compared at all, which is no agreement.
        raise VerifyError([replace(one, where=f"targets.{name}", span=None) for name, one in unread.items()])
    losses = tuple(loss for target in targets for loss in target.losses)
    files = {target.name: Span(target.path(target.files[0])) for target in targets}
    rows = [row if row.ok or row.place else replace(row, place=files[row.target]) for row in rows]
    return Agreement(without_repeats(rows), tuple(skipped), losses)


def lay_out(emitted: Sequence[tuple[TargetOptions, Emission]], built: str | None) -> tuple[TargetFiles, ...]:
    """Write what was compiled to the targets' folders, and say which files are verified.

    Args:
        emitted: Each target with what was made for it.
        built: Folder with the files to verify, each target's below its name, or one target's own; None: those
            that are written.

    Raises: VerifyError: a file is not there.
    """
    collector = Collector()
    found = []
    for options, emission in emitted:
        for written in emission.files:
            path = os.path.join(options.folder, written.path)
            os.makedirs(os.path.dirname(path), exist_ok=True)
            with open(path, "wb") as stream:
                stream.write(written.data)
        files = tuple(file.path for file in emission.files)
        folder = options.folder
        if built is not None:
            folder = os.path.join(built, options.name)
            if len(emitted) == 1 and not os.path.isdir(folder):
                folder = built
            for file in files:
                path = os.path.join(folder, file)
                if not os.path.isfile(path):
                    collector.at(f"targets.{options.name}", Span(path)).error(
                        "VFY001",
                        "there is no such file, and the spec compiles to it",
                        f"write it with `actspec compile -o {built}`, or leave the target out with --target",
                    )
        found.append(TargetFiles(options, folder, options.folder, files, emission.approximations))
    collector.raise_if_failed(VerifyError)
    return tuple(found)


def relative(agreement: Agreement, folder: str) -> Agreement:
    """The same with paths below a folder that is about to go written from there.

    Args:
        agreement: Of `verify`.
        folder: The folder that `compile` was given.
    """
    start = folder + os.sep

    def shown(row: Row) -> Row:
        place = row.place
        if place is not None:
            place = replace(place, path=place.path.removeprefix(start))
        return replace(row, place=place, message=row.message.replace(start, ""))

    return replace(agreement, rows=tuple(map(shown, agreement.rows)))


def _read(
    targets: Sequence[TargetFiles], actuators: ActuatorSet, robot: RobotView
) -> tuple[dict[str, tuple[FileFigures, FileFigures]], dict[str, Diagnostic]]:
    """What actspec writes for each target, and what is verified, read back; why nobody here can read a target's."""
    chosen = [target for target in targets if target.options.kind in READ]
    asked = []
    for target in chosen:
        asked += [
            Asked(os.path.join(folder, target.files[0]), target.options)
            for folder in (target.fresh, target.folder)
        ]
    found = read_back(asked, actuators, robot)
    readings = {target.name: (found[2 * i], found[2 * i + 1]) for i, target in enumerate(chosen)}
    unread: dict[str, Diagnostic] = {}
    for target in (target for target in targets if target.options.kind == "newton"):
        ours, theirs = (os.path.join(folder, target.files[0]) for folder in (target.fresh, target.folder))
        try:
            fresh = read_overlay(ours, target.options, actuators, robot)
            built = fresh if ours == theirs else read_overlay(theirs, target.options, actuators, robot)
        except RobotError as err:
            unread[target.name] = err.diagnostics[0]
        else:
            readings[target.name] = (fresh, built)
    return readings, unread


def _questions(
    targets: Sequence[TargetFiles],
    readings: Mapping[str, tuple[FileFigures, FileFigures]],
    actuators: ActuatorSet,
    robot: RobotView,
    given: Mapping[str, tuple[JointLaws, HeldMotions]],
    *,
    run_edited: bool,
) -> dict[str, Question]:
    """What is asked of each target that has an engine."""
    found = {}
    for target in targets:
        if target.options.kind in ENGINES:
            refusal = readings[target.name][1].refusal if target.name in readings else None
            # Equal to the file that is verified, and nobody has changed it since, or put anything beside it.
            ours = target.options.kind in EXECUTED and not run_edited
            folder = target.fresh if ours else target.folder
            known = replace(actuators, joints=given[target.name][0].joints)
            found[target.name] = Question(target.options, folder, target.files, known, robot, refusal)
    return found


def _ask(
    questions: Mapping[str, Question],
    given: Mapping[str, tuple[JointLaws, HeldMotions]],
    step: Callable[[], None],
) -> dict[str, EngineReply]:
    """Ask the engines, each in a process of its own, as many at once as there are cores."""
    from actspec.processes import cores

    found: dict[str, EngineReply] = {}
    with ThreadPoolExecutor(max_workers=cores()) as pool:
        futures = {
            name: pool.submit(
                answered, import_module(ENGINES[question.options.kind]).ask, question, given[name][1]
            )
            for name, question in questions.items()
        }
        for name, future in futures.items():
            found[name] = future.result()
            step()
    return found


def _read_again(
    target: TargetFiles,
    actuators: ActuatorSet,
    asked: Mapping[str, Mapping[str, Figure]],
    fresh: FileFigures,
    built: FileFigures,
) -> tuple[list[Row], list[Skip]]:
    """Rows and skips of a reader that is not ours."""
    from actspec.verify.engines.yourdfpy import urdf_rows

    if built.reason is not None:
        return [], []
    reply = answered(urdf_rows, target, actuators, asked, fresh)
    if isinstance(reply, EngineMissing):
        return [], [reply.skip(target.name, "fields")]
    if isinstance(reply, EngineRefused):
        return [broken(target, f"yourdfpy does not take the file: {reply}", "yourdfpy")], []
    return reply, []


def _torques(
    target: TargetFiles,
    actuators: ActuatorSet,
    asked: Mapping[str, Mapping[str, Figure]],
    laws: JointLaws,
    moves: HeldMotions,
    reply: EngineReply | None,
    fresh: FileFigures | None,
) -> tuple[list[Row], list[Skip]]:
    """Rows and skips of one target's engine."""
    kind = target.options.kind
    if kind not in ENGINES:
        return [], [Skip(target.name, "", "torque", NO_ENGINE.get(kind, "actspec knows no engine for it"))]
    skipped = list(law_skips(target, laws))
    if reply is None:
        return [], skipped
    if isinstance(reply, EngineMissing):
        return [], [*skipped, reply.skip(target.name, "torque")]
    if isinstance(reply, EngineRefused):
        return [broken(target, f"its simulator refuses the file: {reply}", kind)], skipped
    rows = list(torque_rows(target, actuators, laws, moves, reply))
    rows += network_rows(target, actuators, laws, moves, reply)
    written = fresh or FileFigures(target.path(target.files[0]))
    rows += engine_rows(target, actuators, asked, written, reply.figures, reply.engine)
    return rows, skipped
