"""Which model level a robot needs: from what is to be done with it, what can be measured, and what logs show."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

LADDER = ("ideal_pd", "dc_motor", "actuator_net", "delta_action")
"""Levels, from the simplest."""
TASKS = ("walk", "run", "jump", "extreme")
CARRIES = 0.8
"""Score on the robot over that in simulation from which on the level is kept. Chosen: seeds differ by a fifth."""


@dataclass(frozen=True, slots=True)
class Answers:
    """What a user says; None: not said.

    Attributes:
        task: Of `TASKS`.
        robot: Whether there is one.
        torque_sensor: Whether it measures torque.
        transfer: Score on the robot over that in simulation.
    """

    task: str | None = None
    robot: bool | None = None
    torque_sensor: bool | None = None
    transfer: float | None = None


@dataclass(frozen=True, slots=True)
class LevelChoice:
    """A level.

    Attributes:
        current: The spec's; of several groups the highest.
        recommended: What answers and findings lead to.
        why: The steps that lead there, and what answers that were not given would decide.
    """

    current: str
    recommended: str
    why: tuple[str, ...]


def choose_level(current: str, answers: Answers, codes: Collection[str]) -> LevelChoice:
    """The level for what is to be done.

    Args:
        current: The spec's level.
        answers: Of the user.
        codes: Findings of a diagnosis.
    """
    why: list[str] = []
    if answers.robot is False:
        return LevelChoice(current, "ideal_pd", ("there is no robot to be like: PD and limits are enough",))
    if answers.robot is None:
        why.append("--robot is not given: without a robot ideal_pd is enough")
    level = _for_task(current, answers, why)
    if answers.transfer is not None:
        if answers.transfer >= CARRIES:
            level = current
            why.append(
                f"the policy carries over ({answers.transfer:g} of its score, {CARRIES:g} is enough): the level is kept"
            )
        else:
            level = LADDER[max(LADDER.index(level), min(LADDER.index(current) + 1, len(LADDER) - 1))]
            why.append(
                f"the policy does not carry over ({answers.transfer:g} of its score): one level up from {current}"
            )
    if "DGN002" in codes and LADDER.index(level) < LADDER.index("dc_motor"):
        level = "dc_motor"
        why.append("torque beyond the motor's line (DGN002): at least dc_motor")
    return LevelChoice(current, level, tuple(why))


def _for_task(current: str, answers: Answers, why: list[str]) -> str:
    """By task and sensor; the spec's level where they are not known."""
    hard = answers.task in ("jump", "extreme")
    if answers.task is None:
        why.append("--task is not given: jump and extreme need a learned level, run at least dc_motor")
    if answers.torque_sensor is None:
        why.append(
            "--torque-sensor is not given: with one a network can be trained, without one a delta action"
        )
    if answers.task is None or answers.torque_sensor is None:
        level = current
        if answers.task == "run" and LADDER.index(level) < LADDER.index("dc_motor"):
            why.append("running meets the torque-speed line: at least dc_motor")
            level = "dc_motor"
        return level
    if answers.torque_sensor:
        why.append(
            f"task {answers.task} with a torque sensor: "
            + ("an actuator network" if hard else "the motor's line")
        )
        return "actuator_net" if hard else "dc_motor"
    if hard:
        why.append(f"task {answers.task} without a torque sensor: a delta action")
        return "delta_action"
    if answers.task == "run":
        why.append("running meets the torque-speed line: dc_motor")
        return "dc_motor"
    why.append("walking without a torque sensor: PD and limits")
    return "ideal_pd"
