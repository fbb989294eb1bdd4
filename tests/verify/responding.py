"""A compiled spec whose law has been computed, for engines to be asked for responses again and again."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from actspec.ir import ActuatorSet
from actspec.verify.agreement import Row
from actspec.verify.engines.question import Question
from actspec.verify.response import Plan, Responded, plan
from actspec.verify.response_reference import Lane, Moved
from actspec.verify.response_rows import Expected, expected, kept_friction, reference, response_rows
from actspec.verify.run import ENGINES
from actspec.verify.torque import laws_of
from tests.verify.making import Built, Edit, build


@dataclass(frozen=True)
class Bench:
    """A spec with what its law makes of every course.

    Attributes:
        built: The spec, compiled.
        told: What its joints are told.
        wanted: Target to what is expected of it.
        moved: What the laws make of it.
    """

    built: Built
    told: Plan
    wanted: dict[str, tuple[Expected, ...]]
    moved: dict[tuple[int, Lane], Moved]

    @classmethod
    def of(cls, folder: Path, spec: str, *names: str) -> Bench:
        """Of a spec and some of its targets."""
        built = build(folder, spec)
        actuators = built.compilation.actuators
        told = plan(actuators, laws_of(actuators).laws)
        wanted = {name: expected(built.targets[name], told) for name in names}
        return cls(built, told, wanted, reference(told, wanted.values()))

    @property
    def actuators(self) -> ActuatorSet:
        """What the spec asks for."""
        return self.built.compilation.actuators

    def asked(self, name: str, edit: Edit | None = None) -> Responded:
        """What an engine makes of a target's main file, edited."""
        target = self.built.targets[name]
        folder = target.folder
        if edit is not None:
            folder = str(self.built.folder / "edited")
            shutil.rmtree(folder, ignore_errors=True)
            shutil.copytree(target.folder, folder)
            path = Path(folder, target.files[0])
            path.write_text(edit(path.read_text("utf-8")), "utf-8")
        robot = self.built.compilation.robot
        question = Question(target.options, folder, target.files, self.actuators, robot)
        engine = import_module(ENGINES[target.options.kind])
        found: Responded = engine.respond(question, self.told, kept_friction(self.wanted[name]))
        return found

    def rows(self, name: str, edit: Edit | None = None) -> list[Row]:
        """Rows of a target, its main file edited."""
        answer = self.asked(name, edit)
        assert answer.errors == {}
        target, wanted = self.built.targets[name], self.wanted[name]
        return list(response_rows(target, self.actuators, self.told, wanted, self.moved, answer))
