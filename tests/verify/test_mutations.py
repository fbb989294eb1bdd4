"""Any number of a compiled file that is changed a little, turned, zeroed or swapped is found by the fields alone."""

from __future__ import annotations

import io
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from actspec.verify.run import verify
from tests.verify.making import SPEC, Built, build

NUMBER = re.compile(r"(?<![\w.])-?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?![\w.])")

NEWTON = '  newton: {version: "1.8", joint_paths: {".*": "joints/{joint}"}}\n'


@dataclass(frozen=True)
class Mutation:
    """One number that is another one.

    Attributes:
        file: In which file.
        name: What is done, at which line.
        text: The file afterwards.
    """

    file: str
    name: str
    text: str


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The rich spec, for Newton too."""
    return build(tmp_path_factory.mktemp("rich"), SPEC + NEWTON)


def blank(pattern: str, text: str) -> str:
    """Spaces in place of what is no number, or a number of nobody's."""
    return re.sub(pattern, lambda found: " " * len(found[0]), text, flags=re.DOTALL)


def places(file: str, text: str) -> list[tuple[int, int]]:
    """Where a file has numbers that say something of a managed joint."""
    if file.endswith(".py"):
        starts = [0]
        for line in text.splitlines(keepends=True):
            starts.append(starts[-1] + len(line))
        tokens = tokenize.generate_tokens(io.StringIO(text).readline)
        return [
            (starts[t.start[0] - 1] + t.start[1], starts[t.end[0] - 1] + t.end[1])
            for t in tokens
            if t.type == tokenize.NUMBER
        ]
    if file.endswith(".xml"):
        text = blank(r"<!--.*?-->", text)
        # not shapes, nor the joint that the spec leaves alone, nor places, names, or an axis, whose length is nothing
        text = blank(
            r"<(geom|body)[^>]*>|<joint name=\"gripper\"[^>]*>|<motor[^>]*>|(pos|name|axis)=\"[^\"]*\"", text
        )
        # a range of controls that limits nothing: viewers have sliders of that length
        text = blank(r"ctrllimited=\"false\" ctrlrange=\"[^\"]*\"", text)
        # of a saturation the first number alone is one here; MuJoCo 4.0 reads no second
        text = blank(r"(?<=saturation=\")[^\"]*\"", text)
    elif file.endswith((".yaml", ".usda")):
        text = blank(r"#[^\n]*|\"[^\"\n]*\"", text)
    else:
        text = blank(r"\"(unit|tool|spec_sha256|format)\": \"[^\"]*\"|\"joint\": \"[^\"]*\"", text)
    return [found.span() for found in NUMBER.finditer(text)]


def mutations(file: str, text: str) -> Iterator[Mutation]:
    """Every number: 1 % more or less; and turned, 0 (or 1) or its neighbour's, each of three numbers in turn."""
    spots = places(file, text)
    for index, (start, end) in enumerate(spots):
        old = text[start:end]
        value, whole = float(old), re.fullmatch(r"-?\d+", old) is not None
        changed = {"x 0.99": value * 0.99} if index % 2 else {"x 1.01": value * 1.01}
        changed |= [{"turned": -value}, {"zero": 0.0}, {}][index % 3]
        for name, new in ({"one": 1.0} if value == 0.0 else changed).items():
            shown = repr(int(new)) if whole and new.is_integer() else repr(new)
            line = text.count("\n", 0, start) + 1
            # Newton's steps are whole numbers, and USD cuts a fraction off.
            if float(shown) != value and not (file.endswith(".usda") and whole and int(new) == value):
                yield Mutation(file, f"{file}:{line} {old} {name}", text[:start] + shown + text[end:])
        if index % 3 == 2 and index + 1 < len(spots):
            first, last = spots[index + 1]
            other = text[first:last]
            if float(other) != value:
                swapped = text[:start] + other + text[end:first] + old + text[last:]
                yield Mutation(file, f"{file} {old} and {other}", swapped)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["mujoco", "isaaclab", "custom", "implicit", "il45", "mjlab", "newton", "deploy", "randomization"]
)
def test_every_number_counts(name: str, built: Built, tmp_path: Path) -> None:
    """Each such file disagrees with the spec."""
    if name == "newton":
        pytest.importorskip("pxr", reason="usd-core is not installed")
    target = built.targets[name]
    texts = {file: Path(target.folder, file).read_text("utf-8") for file in target.files}
    chosen = [one for file, text in texts.items() for one in mutations(file, text)]
    assert len(chosen) > 30
    edited = []
    for index, one in enumerate(chosen):
        folder = tmp_path / str(index)
        folder.mkdir()
        for file, text in texts.items():
            (folder / file).write_text(one.text if file == one.file else text, "utf-8")
        edited.append(replace(target, options=replace(target.options, name=str(index)), folder=str(folder)))
    done = built.compilation
    agreement = verify(done.actuators, done.robot, edited, spec="spec.yaml", engines=False)
    found = {row.target for row in agreement.faults}
    assert [one.name for index, one in enumerate(chosen) if str(index) not in found] == []
