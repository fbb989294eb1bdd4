"""Each promise of README.md and SECURITY.md with its guard taken out: the test that it names has to fail.

    python benchmarks/guards.py
    python benchmarks/guards.py --only "no entity"

A guard is taken out by an edit of one line in a copy of the checkout, in which the named test runs before and after.
Prints a table. Exit code 1: a test that fails before, or does not fail without its guard.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Guard:
    """A guard.

    Attributes:
        promise: What it keeps, in few words.
        file: Below `actspec`.
        there: A text that is in the file once.
        without: What stands in its place when the guard is gone.
        test: Below `tests`.
    """

    promise: str
    file: str
    there: str
    without: str
    test: str


GUARDS = (
    Guard(
        "MuJoCo: the torque is the law",
        "targets/mujoco/actuator_xml.py",
        "nominal = (VOLTAGE, drive.line.stall_torque,",
        "nominal = (VOLTAGE, drive.line.stall_torque * (1 + 1e-8),",
        "agree/test_mujoco_target.py::test_a1_is_the_law",
    ),
    Guard(
        "Isaac Lab, mjlab, Newton: the same law",
        "targets/isaaclab/fields.py",
        "total = damping.value + value",
        "total = damping.value",
        "frameworks/test_isaaclab.py::test_one_damping_field_takes_the_sum",
    ),
    Guard(
        "an approximation is as large as it says",
        "targets/kit/sizes.py",
        "difference = np.abs(law.torque(command, q, speeds) - emitted(command, q, speeds))",
        "difference = np.abs(law.torque(command, q, speeds) - emitted(command, q, speeds)) / 2",
        "agree/test_mujoco_target.py::test_static_loss_is_what_is_measured",
    ),
    Guard(
        "nothing else in a MuJoCo model changes",
        "targets/mujoco/emit.py",
        "    if strayed:",
        "    if not strayed:",
        "targets/mujoco/test_faults.py::test_mjc090_stops_the_compile",
    ),
    Guard(
        "untouched lines stay byte for byte",
        "robot/xml_edit.py",
        "data = _File(file.data, own).edited()",
        'data = _File(file.data, own).edited().replace(b"\\r\\n", b"\\n")',
        "targets/mujoco/test_text.py::test_crlf_stays_crlf",
    ),
    Guard(
        "damping, friction, limits arrive once",
        "targets/mujoco/check.py",
        "    readings = read_joints(written)\n    for actuator in actuators.joints:\n        reading =",
        "    readings = read_joints(written)\n    for actuator in ():\n        reading =",
        "targets/mujoco/test_faults.py::test_a_plan_that_counts_damping_twice_stops_the_compile",
    ),
    Guard(
        "the same input, the same bytes",
        "output.py",
        '        "format": MANIFEST_FORMAT,\n',
        '        "format": MANIFEST_FORMAT,\n        "made": os.urandom(8).hex(),\n',
        "golden/test_golden.py::test_compiling_twice_gives_the_same_bytes",
    ),
    Guard(
        "a kill between two files is finished",
        "placing.py",
        "if new in left and _signs(target) == was:",
        "if new in left and not left:",
        "test_placing.py::test_a_kill_between_the_moves",
    ),
    Guard(
        "all files of a run or none",
        "placing.py",
        "moved.callback(_take_back, move)",
        "pass",
        "test_placing.py::test_moves_are_taken_back",
    ),
    Guard(
        "what actspec did not write stays",
        "output.py",
        "    if not force:\n        for file in files:",
        "    if force:\n        for file in files:",
        "cli/test_compile.py::test_an_edited_output_is_not_replaced",
    ),
    Guard(
        "no configuration is executed",
        "readings/python/source.py",
        "            tree = ast.parse(text)\n",
        '            tree = ast.parse(text)\n            exec(text, {"DCMotorCfg": dict})\n',
        "readings/test_python_hostile.py::test_nothing_is_executed",
    ),
    Guard(
        "no entity of XML",
        "robot/xml_tree.py",
        "parser.StartDoctypeDeclHandler = doctype",
        "pass",
        "robot/test_xml.py::test_what_is_refused",
    ),
    Guard(
        "YAML is bounded",
        "spec/yaml_tree.py",
        "if self.aliases > MAX_ALIASES:",
        "if self.aliases > 10**9:",
        "spec/test_document.py::test_aliases_are_counted",
    ),
    Guard(
        "what a spec names lies below its folder",
        "spec/document.py",
        "if os.path.commonpath([root, real]) != root:",
        "if not root:",
        "spec/test_document.py::test_an_include_stays_in_the_folder",
    ),
    Guard(
        "a name is data in what is written",
        "targets/kit/python_text.py",
        "literal = repr(text)",
        "literal = f\"'{text}'\"",
        "targets/test_python_text.py::test_text_comes_back",
    ),
    Guard(
        "sizes are judged before MuJoCo makes them",
        "robot/sizes.py",
        "if spent[budget] > budget.most:",
        "if spent[budget] > 1e99:",
        "robot/test_sizes.py::test_beyond_a_limit[copies]",
    ),
    Guard(
        "MuJoCo's crash ends in words",
        "guest.py",
        'if not (sys.platform.startswith("linux") and hasattr(os, "pidfd_open")):',
        "if True:",
        "cli/test_guest.py::test_a_crash",
    ),
    Guard(
        "a stage stops at its limit",
        "diagnostics.py",
        "if self._errors == MOST_ERRORS:",
        "if self._errors < 0:",
        "cli/test_bounded.py::test_a_collector_stops",
    ),
    Guard(
        "what is printed is printable",
        "cli/streams.py",
        "        if not text.isprintable():",
        "        if not text:",
        "cli/test_streams.py::test_control_characters_are_escaped",
    ),
)


def passes(copy: Path, test: str) -> tuple[bool, str]:
    """Whether a test passes in a copy, and what pytest says last."""
    env = {**os.environ, "PYTHONPATH": str(copy), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", f"tests/{test}"],
        cwd=copy,
        env=env,
        capture_output=True,
        text=True,
    )
    return done.returncode == 0, (done.stdout.strip().splitlines() or [done.stderr[-200:]])[-1]


def main() -> int:
    """Take each out, and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--only", action="append", help="begin of a promise; may be repeated")
    arguments = parser.parse_args()
    bad = False
    print("| promise | guard in | test | with it | without |\n|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "actspec"
        ignored = shutil.ignore_patterns(".git", "__pycache__", ".*_cache", ".hypothesis", ".venv", "build")
        shutil.copytree(ROOT, copy, ignore=ignored)
        for guard in GUARDS:
            if arguments.only and not guard.promise.startswith(tuple(arguments.only)):
                continue
            path = copy / "actspec" / guard.file
            sound = path.read_text("utf-8")
            if sound.count(guard.there) != 1:
                sys.exit(f"{guard.promise}: {guard.file} has {sound.count(guard.there)} of {guard.there!r}")
            before, said = passes(copy, guard.test)
            path.write_text(sound.replace(guard.there, guard.without), "utf-8")
            after, _ = passes(copy, guard.test)
            path.write_text(sound, "utf-8")
            words = ("passes" if before and "passed" in said else said, "passes" if after else "fails")
            bad |= words != ("passes", "fails")
            print(f"| {guard.promise} | `{guard.file}` | `{guard.test}` | {' | '.join(words)} |", flush=True)
    return bad


if __name__ == "__main__":
    sys.exit(main())
