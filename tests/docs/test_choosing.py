"""The picture of docs/choosing.md gives the levels that `diagnose` gives."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from actspec.study.level import LADDER, TASKS, Answers, choose_level

PICTURE = Path(__file__).parents[2] / "docs" / "choosing.svg"
LEAVES = [g.attrib for g in ElementTree.parse(PICTURE).iter() if "data-level" in g.attrib]
YES = {"yes": True, "no": False, None: None}


@pytest.mark.parametrize("leaf", LEAVES, ids=lambda leaf: " ".join(leaf.values()))
@pytest.mark.parametrize("current", LADDER[:3])
def test_a_leaf_is_what_the_answers_lead_to(leaf: dict[str, str], current: str) -> None:
    """The answers on the way to a leaf lead to its level, from any level of a spec."""
    up = LADDER[LADDER.index(current) + 1]
    for task in leaf.get("data-task", "").split() or [None]:
        answers = Answers(
            task=task,
            robot=YES[leaf.get("data-robot", "yes")],
            torque_sensor=YES[leaf.get("data-torque-sensor")],
            transfer=float(leaf["data-transfer"]) if "data-transfer" in leaf else None,
        )
        codes = leaf.get("data-findings", "").split()
        level = choose_level(current, answers, codes).recommended
        shown = {"current": current, "up": up}.get(leaf["data-level"], leaf["data-level"])
        assert level == (max(shown, current, key=LADDER.index) if codes else shown)


def test_every_task_and_sensor_has_its_leaf() -> None:
    """Nothing that can be answered is missing in the picture."""
    told = {
        (task, leaf["data-torque-sensor"]) for leaf in LEAVES for task in leaf.get("data-task", "").split()
    }
    assert told == {(task, sensor) for task in TASKS for sensor in ("yes", "no")}
