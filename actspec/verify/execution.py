"""What a simulator would execute of a target's files, and what of them no reader sees.

Isaac Lab and mjlab execute a cfg. What actspec has just written may run; a file that somebody edited is a stranger's
program, and runs with his consent alone.
"""

from __future__ import annotations

import ast
import os
from collections import Counter
from collections.abc import Iterator

from actspec.diagnostics import Span, one_line
from actspec.files import FAULTS, read_regular
from actspec.verify.agreement import Row, TargetFiles
from actspec.verify.joint_laws import JointLaws

EXECUTED = ("isaaclab", "mjlab")
"""Kinds of target whose main file is Python that their simulator executes."""

CONSENT = "look at it, then --run-edited"
"""What makes an edited file run."""

MOST_BYTES = 64 << 20
"""Chosen: the largest file that is compiled is a network of that size, see `actspec.targets.kit.network`."""

_READ = (".xml", ".urdf", ".py", ".yaml", ".json", ".usda")
"""Ends of files that are compared by what they say."""


def changed(target: TargetFiles) -> tuple[str, ...]:
    """Files whose bytes are not those that the spec compiles to now."""
    if target.folder == target.fresh:
        return ()
    return tuple(file for file in target.files if not _same(target, file))


def withheld(target: TargetFiles, *, run_edited: bool) -> str | None:
    """Why a simulator must not execute a target's files; None: it may.

    Args:
        target: The target.
        run_edited: Whether the user wants edited files executed.
    """
    edited = changed(target) if target.options.kind in EXECUTED and not run_edited else ()
    if not edited:
        return None
    return (
        f"{edited[0]} is not what the spec compiles to, and would be executed: only its fields are compared"
    )


TRUST = "--trust runs it, if you know who made it"


def runnable(target: TargetFiles, laws: JointLaws, *, run_edited: bool, trust: bool) -> JointLaws:
    """The laws without networks whose program a simulator must not execute.

    Args:
        target: The target.
        laws: Of its joints.
        run_edited: Whether the user wants edited files executed.
        trust: Whether he wants TorchScript executed that is not actspec's own.
    """
    if trust or not laws.networks or target.options.kind not in EXECUTED:
        return laws
    from actspec.learn.files import torchscript_bytes
    from actspec.learn.torchscript import same_program

    folder = target.folder if run_edited else target.fresh
    # Joints of a group share them.
    known = {id(drive.network.layers): drive.network.layers for drive in laws.networks.values()}
    for file in _programs(target):
        try:
            data = read_regular(os.path.join(folder, file), MOST_BYTES)
            if any(same_program(data, torchscript_bytes(layers)) for layers in known.values()):
                continue
            why = f"{file} is TorchScript, a program, and not the one that actspec writes of its ONNX file"
        except FAULTS:
            why = f"{file} cannot be read"
        except ImportError:
            why = f"whether {file}, a program, is actspec's own is not known without torch"
        return laws.without_networks(one_line(why), TRUST)
    return laws


def _programs(target: TargetFiles) -> list[str]:
    """Files that are no text: networks."""
    return [file for file in target.files[1:] if not file.endswith(_READ)]


def code_rows(target: TargetFiles) -> Iterator[Row]:
    """Rows of statements of a Python file that nobody executed, other than the assignments that readers understand."""
    file = target.files[0]
    if target.options.kind not in EXECUTED or file not in changed(target):
        return
    try:
        ours, theirs = (
            _statements(read_regular(os.path.join(folder, file), MOST_BYTES))
            for folder in (target.fresh, target.folder)
        )
    except (*FAULTS, SyntaxError, RecursionError, MemoryError):
        # The reader of its fields says so.
        return
    more, less = Counter(text for text, _ in theirs), Counter(text for text, _ in ours)
    extra, lacking = more - less, less - more
    for text, line in theirs:
        if extra[text]:
            extra[text] -= 1
            yield _code_row(target, file, line, "the statement is not what actspec writes")
    if not more - less:
        for text, _ in ours:
            if lacking[text]:
                lacking[text] -= 1
                yield _code_row(target, file, 0, "a statement that actspec writes is missing")


def other_rows(target: TargetFiles) -> Iterator[Row]:
    """Rows of files that are no text, networks, which are right as they were named in the spec alone."""
    for file in _programs(target):
        if target.folder == target.fresh or _same(target, file):
            yield target.right(f"file {file}")
        else:
            what = one_line(f"{file} is not the file that the spec names")
            yield target.fault(f"file {file}", "VFY110", what, place=Span(target.path(file)))


def _same(target: TargetFiles, file: str) -> bool:
    try:
        ours, theirs = (
            read_regular(os.path.join(folder, file), MOST_BYTES) for folder in (target.fresh, target.folder)
        )
    except FAULTS:
        return False
    return ours == theirs


def _code_row(target: TargetFiles, file: str, line: int, what: str) -> Row:
    message = f"{what}; it was not executed, and no field shows what it does"
    return target.fault("code", "VFY110", message, place=Span(target.path(file), line))


def _statements(data: bytes) -> list[tuple[str, int]]:
    """A module's statements and their lines, without texts; of the first cfg or table of a name only that name."""
    found = []
    assigned: set[str] = set()
    for node in ast.parse(data).body:
        text = ast.dump(node)
        name = _assigned(node)
        if name is not None and name not in assigned:
            assigned.add(name)
            text = f"{name} ="
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        found.append((text, node.lineno))
    return found


def _assigned(node: ast.stmt) -> str | None:
    """The name that a cfg or a table is given; None where a statement is anything else."""
    if isinstance(node, ast.Assign) and len(node.targets) == 1:
        target = node.targets[0]
    elif isinstance(node, ast.AnnAssign):
        target = node.target
    else:
        return None
    if isinstance(target, ast.Name) and isinstance(node.value, ast.Call | ast.Dict):
        return target.id
    return None
