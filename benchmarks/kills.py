"""Kill -9 at random moments of the commands that write, and what the next run makes of what is left.

    python benchmarks/kills.py --kills 250 --seed 1

Each run is a process of its own, forked from one that has everything imported. Most kills are timed by what the run has
written: behind the n-th change of the disk that Python's audit events tell, of which three in four lie between the
first file that is put in place and the last. One in five comes from outside, at a random moment after the first
change. It is the command or its watcher that is killed. Then the same command runs again, or one with the older
spec, without --force. A file that was there has to be whole at any time, and in the end the folder is
compared byte for byte with that of runs that nobody killed. Exit code 1: something was torn, missing or left.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from actspec import guest
from actspec.cli.main import main as command

ROOT = Path(__file__).resolve().parents[1]

Run = tuple[str, ...]
Tree = Mapping[str, bytes]

_CHANGES = (
    "os.rename",
    "os.remove",
    "os.link",
    "os.mkdir",
    "os.rmdir",
    "os.chmod",
    "os.chown",
    "os.truncate",
)
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT


@dataclass(frozen=True)
class Case:
    """A command that writes.

    Attributes:
        name: For the table.
        run: Its arguments.
        older: The run whose outputs it writes over, and to which one may go back; None: it writes new files.
    """

    name: str
    run: Run
    older: Run | None = None


CASES = (
    Case("compile, new", ("compile", "plain.yaml", "-o", "out")),
    Case(
        "compile, over older",
        ("compile", "plain.yaml", "-o", "out"),
        ("compile", "plain.yaml#soft", "-o", "out"),
    ),
    Case(
        "audit --fix", ("audit", "legs_cfg.py", "arms_cfg.py", "hands_cfg.py", "--fix", "-t", "isaaclab==2.3")
    ),
    Case("lock", ("lock", "plain.yaml", "biped.urdf"), ("lock", "biped.urdf")),
    Case("import", ("import", "biped.urdf", "biped_cfg.py", "-o", "new/new.yaml")),
    Case(
        "audit --write-baseline",
        ("audit", "biped_cfg.py", "biped_deploy.yaml", "--write-baseline", "base.json"),
        ("audit", "biped_deploy.yaml", "--write-baseline", "base.json"),
    ),
)

_ORDER = CASES[:3] * 2 + CASES
"""Those that put several files in place have most of the moments."""

_FIXABLE = """\
from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets.articulation import ArticulationCfg

NAME_CFG = ArticulationCfg(
    actuators={
        "all": IdealPDActuatorCfg(
            joint_names_expr=[".*"], stiffness=25.0, damping=0.5, actuator_effort_limit=23.7, joint_velocity_limit=5.0
        )
    }
)
"""


def sound(folder: Path) -> None:
    """Put the files that commands read into an empty folder."""
    shutil.copytree(ROOT / "tests" / "fuzz" / "scene", folder, dirs_exist_ok=True)
    shutil.copytree(ROOT / "docs" / "example", folder, dirs_exist_ok=True)
    for name in ("legs", "arms", "hands"):
        (folder / f"{name}_cfg.py").write_text(_FIXABLE.replace("NAME", name.upper()))


def tree(folder: Path) -> dict[str, bytes]:
    """Every file with its bytes, every folder with none."""
    return {
        path.relative_to(folder).as_posix(): b"" if path.is_dir() else path.read_bytes()
        for path in sorted(folder.rglob("*"))
    }


@dataclass(slots=True)
class Hook:
    """Writes changes of a folder down, and ends a process behind one of them.

    Attributes:
        folder: Whose changes count; "": nobody looks.
        log: Where a byte a change is written: `r` for a file that is put in place, `c` for another.
        at: Behind which change, from 0; -1: none.
        watcher: Whether the parent is killed, whose end is the command's.
        due: The next event is behind it.
    """

    folder: str = ""
    log: int = -1
    at: int = -1
    watcher: bool = False
    due: bool = False

    def __call__(self, event: str, arguments: tuple[object, ...]) -> None:
        """As `sys.addaudithook` calls it."""
        if not self.folder:
            return
        if self.due:
            self.due = False
            os.kill(os.getppid() if self.watcher else os.getpid(), signal.SIGKILL)
        flags = arguments[2] if event == "open" else None
        if event not in _CHANGES and not (isinstance(flags, int) and flags & _WRITES):
            return
        path = arguments[0]
        if not isinstance(path, str) or not os.path.realpath(path).startswith(self.folder + os.sep):
            return
        placed = event == "os.rename" and not os.path.basename(str(arguments[1])).startswith(".")
        os.write(self.log, b"r" if placed else b"c")
        self.at -= 1
        self.due = self.at == -1


HOOK = Hook()


def execute(
    run: Run, folder: Path, *, at: int = -1, watcher: bool = False, wait: float | None = None
) -> tuple[int, bytes]:
    """Run a command in a process of its own.

    Args:
        folder: The working folder.
        at: As `Hook.at`.
        watcher: As `Hook.watcher`.
        wait: Seconds from the first change to a kill from outside; None: no such kill.

    Returns: Exit code, -9 after a kill; and the changes, as `Hook.log`.
    """
    ours, log = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(ours)
        os.setpgid(0, 0)
        os.chdir(folder)
        sys.stdout = sys.stderr = open(os.devnull, "w")  # noqa: SIM115 - as long as the process is there
        HOOK.folder, HOOK.log, HOOK.at, HOOK.watcher = str(folder), log, at, watcher
        os._exit(guest.watch(lambda: command(run), lambda _: 2))
    os.close(log)
    changes = b""
    with open(ours, "rb", buffering=0) as stream:
        while part := stream.read(1 if wait is not None and not changes else 4096):
            if wait is not None and not changes:
                time.sleep(wait)
                os.kill(child, signal.SIGKILL)
            changes += part
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), changes


def judged(
    case: Case, choice: random.Random, work: Path, alone: Mapping[tuple[str, Run], tuple[int, Tree, bytes]]
) -> tuple[str, list[str]]:
    """One kill and the run after it.

    Returns: Where it struck, and what is wrong.
    """
    folder = work / "folder"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    sound(folder)
    if case.older is not None:
        execute(case.older, folder)
    before = tree(folder)
    _, after, changes = alone[case.name, case.run]
    watcher = choice.random() < 0.5
    if choice.random() < 0.2:
        _, seen = execute(case.run, folder, wait=choice.expovariate(1 / 0.003))
    else:
        first, last = changes.index(b"r"), changes.rindex(b"r")
        many = first < last and choice.random() < 0.75
        at = choice.randrange(first, last) if many else choice.randrange(len(changes))
        _, seen = execute(case.run, folder, at=at, watcher=watcher)
    placed, all_placed = seen.count(b"r"), changes.count(b"r")
    struck = "before the first" if not placed else "behind the last" if placed == all_placed else "between"
    faults = []
    left = tree(folder)
    for name, data in before.items():
        if name not in left:
            faults.append(f"{name} is missing after the kill")
        elif left[name] not in (data, after.get(name)):
            faults.append(f"{name} is torn after the kill")
    faults += [
        f"{name} is torn after the kill"
        for name, data in left.items()
        if name not in before and not os.path.basename(name).startswith(".") and data != after.get(name)
    ]
    back = case.older is not None and choice.random() < 0.3
    again = case.older if back and case.older is not None else case.run
    code, expected, _ = alone[case.name, again]
    got, _ = execute(again, folder)
    done = tree(folder)
    if got != code:
        faults.append(f"the next run, `actspec {' '.join(again)}`, ends with {got}, not {code}")
    # Going back leaves the files that the older run does not write.
    names = {*expected, *(done if not back else ())}
    faults += [
        f"{name} is {'left' if name not in expected else 'missing' if name not in done else 'not as it should be'}"
        for name in sorted(names)
        if done.get(name) != expected.get(name)
    ]
    faults += [f"{name} is left" for name in done if back and os.path.basename(name).startswith(".")]
    return struck, faults


def main() -> int:
    """Kill, count and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--kills", type=int, default=250)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", help="where folders are made; default: that of temporary files")
    arguments = parser.parse_args()
    sys.addaudithook(HOOK)
    counts: Counter[tuple[str, str]] = Counter()
    bad = 0
    with tempfile.TemporaryDirectory(dir=arguments.folder) as parent:
        work = Path(os.path.realpath(parent))
        alone: dict[tuple[str, Run], tuple[int, Tree, bytes]] = {}
        for case in CASES:
            folder = work / "alone"
            for run in (case.older, case.run):
                if run is None:
                    continue
                shutil.rmtree(folder, ignore_errors=True)
                folder.mkdir()
                sound(folder)
                os.chdir(folder)
                _warmed(run)
                shutil.rmtree(folder)
                folder.mkdir()
                sound(folder)
                if case.older is not None and run is case.run:
                    execute(case.older, folder)
                code, changes = execute(run, folder)
                alone[case.name, run] = code, tree(folder), changes
        for number in range(arguments.kills):
            case = _ORDER[number % len(_ORDER)]
            choice = random.Random(f"{arguments.seed}/{number}")
            struck, faults = judged(case, choice, work, alone)
            counts[case.name, struck] += 1
            bad += bool(faults)
            for fault in faults:
                print(f"{number} ({case.name}, {struck}): {fault}", flush=True)
    words = ("before the first", "between", "behind the last")
    print(f"| killed | {' | '.join(words)} |\n|---|{'---:|' * len(words)}")
    for case in CASES:
        print(f"| {case.name} | {' | '.join(str(counts[case.name, word]) for word in words)} |")
    print(f"{arguments.kills} kills, {bad} with something torn, missing or left")
    return bad > 0


def _warmed(run: Run) -> None:
    """Import here what the command imports."""
    out, err = sys.stdout, sys.stderr
    with open(os.devnull, "w") as nowhere:
        sys.stdout = sys.stderr = nowhere
        try:
            command(run)
        finally:
            sys.stdout, sys.stderr = out, err


if __name__ == "__main__":
    sys.exit(main())
