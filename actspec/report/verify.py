"""What `actspec verify` prints: a row for each target and distinct actuator, what is wrong, what was not run."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence

from actspec.diagnostics import Severity, Span, listed, many, one_line
from actspec.output import Compilation
from actspec.report.compile import worst_error
from actspec.report.tables import escaped, markdown_table, table
from actspec.report.terminal import style_of
from actspec.simulate.excitation import COURSES as NETWORK
from actspec.simulate.experiment import COURSES
from actspec.units import format_number, format_quantity
from actspec.verify.agreement import Agreement, At, Row, Skip
from actspec.verify.response import SOFT

_RESPONSES = ("target", "group", "joints", "response", "error", "allowed", "at")
_HISTORIES = {"torque": "held command", "torque.step": "step", "torque.ramp": "ramp", NETWORK: "course"}

_ROUNDING = 1e-4
"""Torque error that is rounding [N*m or N]. Chosen: engines in single precision are 1e-5 N*m off, and ours 1e-14."""

Cells = tuple[str, ...]


def text(compilation: Compilation, agreement: Agreement) -> Iterator[str]:
    """Lines for a terminal."""
    actuators = compilation.actuators
    yield f"{actuators.robot}: {many(len(actuators.joints), 'joint')}, {compilation.spec.document.path}"
    heads = ("target", "group", "joints", "engine", "torque error", "allowed", "at", "fields")
    yield from table([heads, *_cells(compilation, agreement)])
    moved = list(_response_cells(compilation, agreement))
    if moved:
        yield ""
        yield from table([_RESPONSES, *moved])
    for row in agreement.faults:
        yield _fault(row)
    marked = list(_marked(agreement))
    if marked:
        yield ""
        open_ = {loss.key for loss in compilation.unaccepted}
        keys = [key for row in agreement.rows for key in row.approximations]
        taken = open_.isdisjoint((*keys, *(loss.key for loss in agreement.approximations)))
        how = ", as the spec accepts" if taken else " (see --strict and `accept`)"
        yield f"  known approximations{how}"
        yield from table(marked, indent="    ", headings=0)
    if any(SOFT in row.approximations for row in agreement.rows):
        yield ""
        yield f"  {SOFT}: dry friction in MuJoCo is a soft constraint, which creeps; no key of `accept`"
    missed = list(_missed(agreement.skipped))
    if missed:
        yield ""
        yield from table([("not run", "because", ""), *missed])
    yield ""
    yield _summary(compilation, agreement)


def markdown(compilation: Compilation, agreement: Agreement) -> Iterator[str]:
    """Lines for a page or a pull request."""
    yield f"### {one_line(compilation.actuators.robot)}"
    yield ""
    heads = (
        "target",
        "group",
        "joints",
        "engine",
        "torque error",
        "allowed",
        "at",
        "fields",
        "approximations",
    )
    losses = dict(_marked(agreement))
    lines = [(*cells, losses.get(cells[0].split(" ")[0], "")) for cells in _cells(compilation, agreement)]
    moved = list(_response_cells(compilation, agreement))
    for rows in ([heads, *lines], [_RESPONSES, *moved] if moved else []):
        if rows:
            yield from markdown_table([[escaped(cell) for cell in row] for row in rows])
            yield ""
    for row in agreement.faults:
        yield f"- {_fault(row)}"
    for target, reason, help in _missed(agreement.skipped):
        yield f"- {target}: not run: {reason}{f' ({help})' if help else ''}"
    yield ""
    yield _summary(compilation, agreement)


def github(compilation: Compilation, agreement: Agreement, *, built: bool, strict: bool) -> Iterator[str]:
    """Workflow commands of GitHub Actions, for annotations of a pull request.

    Args:
        compilation: The spec, compiled.
        agreement: What was found.
        built: Whether the files lie in the repository; else a fault is reported at the spec.
        strict: Whether an approximation that the spec does not accept is a fault.
    """
    from actspec.report.github import command

    spec = Span(compilation.spec.document.path)
    for row in agreement.faults:
        place = row.place if built else None
        yield command(Severity.ERROR, f"{row.code} {row.target}", place or spec, _said(row))
    for loss in compilation.unaccepted if strict else ():
        text = one_line(f"{loss.joint} {loss.field}: {loss.asked} becomes {loss.emitted}: {loss.why}")
        yield command(Severity.ERROR, f"{loss.key} is not accepted", spec, text)
    for target, reason, help in _missed(agreement.skipped):
        yield command(
            Severity.INFO, f"{target} not run", spec, one_line(f"{reason}{f' ({help})' if help else ''}")
        )
    for _, item in compilation.failures:
        if item.severity is Severity.ERROR:
            yield command(item.severity, item.code, item.span or spec, one_line(item.message))
    verdict = Severity.INFO if agreement.ok and not compilation.failures else Severity.ERROR
    yield command(verdict, one_line(compilation.actuators.robot), spec, _summary(compilation, agreement))


def _cells(compilation: Compilation, agreement: Agreement) -> Iterator[Cells]:
    """One line for each target and actuator with numbers of its own."""
    for options in compilation.targets:
        mine = [row for row in agreement.rows if row.target == options.name]
        label = options.title
        torques = [row for row in mine if row.quantity in _HISTORIES]
        fields = [row for row in mine if row.quantity not in _HISTORIES and row.quantity not in COURSES]
        if not torques:
            groups = dict.fromkeys(row.group for row in fields if row.group)
            joints = len(compilation.actuators.joints)
            reader = next((row.engine for row in fields if row.engine), "-")
            yield label, listed(groups, most=3), str(joints), reader, "-", "-", "-", _agreed(fields)
            continue
        for index, shared in enumerate(_by_actuator(torques)):
            worst = max(shared, key=lambda row: (not row.ok, _share(row)))
            own = [row for row in fields if row.group == worst.group]
            first = index == 0
            others = [row for row in fields if not row.group] if first else []
            shown = {row.group for rows in _by_actuator(torques)[:index] for row in rows}
            yield (
                label if first else "",
                worst.group,
                str(worst.joints),
                (worst.engine or "-") if first else "",
                _amount(worst.max_error, worst.unit),
                _amount(worst.tolerance, worst.unit) + (" ~" if worst.approximations else ""),
                _where(worst),
                _agreed([*own, *others]) if worst.group not in shown else "",
            )


def _response_cells(compilation: Compilation, agreement: Agreement) -> Iterator[Cells]:
    """One line for each target and group: the response that is nearest to what is allowed, or beyond."""
    for options in compilation.targets:
        mine = [row for row in agreement.rows if row.target == options.name and row.quantity in COURSES]
        for index, group in enumerate(dict.fromkeys(row.group for row in mine)):
            shared = [row for row in mine if row.group == group]
            worst = max(shared, key=lambda row: (not row.ok, _share(row)))
            joints = sum(row.joints for row in shared if row.quantity == worst.quantity)
            yield (
                options.title if index == 0 else "",
                group,
                str(joints),
                worst.quantity,
                _amount(worst.max_error, worst.unit),
                _amount(worst.tolerance, worst.unit) + (" ~" if worst.approximations else ""),
                _where(worst),
            )


def _by_actuator(rows: Sequence[Row]) -> list[list[Row]]:
    """Rows of one engine, those of one actuator together: they follow each other, each history once or twice."""
    found: list[list[Row]] = []
    for row in rows:
        last = found[-1] if found else []
        before = last[-1] if last else None
        # Of a network there is one row, or two: of joints that agree, and of others.
        again = before is not None and (before.quantity, before.group, before.ok) == (
            row.quantity,
            row.group,
            not row.ok,
        )
        if before is None or (row.quantity in ("torque", NETWORK) and not again):
            found.append([row])
        else:
            last.append(row)
    return found


def _share(row: Row) -> float:
    if row.max_error is None:
        return float("inf")
    return row.max_error / row.tolerance if row.tolerance else float(row.max_error > 0.0)


def _amount(value: float | None, unit: str) -> str:
    if value is None:
        return "none"
    return "any" if value == float("inf") else format_quantity(value, unit, 2)


def _where(row: Row) -> str:
    at = row.at
    if at is None:
        return row.joint
    if row.quantity in COURSES:
        return f"{row.joint}: {_state(at, row.unit)}"
    return f"{row.joint}: {_HISTORIES[row.quantity]}, {_state(at, row.unit)}"


def _state(at: At, unit: str) -> str:
    angle, torque = ("m", "N") if unit in ("N", "m") else ("rad", "N*m")
    speed = f"velocity {format_quantity(at.velocity, f'{angle}/s', 3)}"
    if at.time is not None and at.torque is not None:
        sign = "+" if at.torque > 0.0 else ""
        return f"at {format_quantity(at.time, 's', 3)}, {speed}, torque {sign}{format_quantity(at.torque, torque, 2)}"
    asked = f"command {format_number(at.command, 3)}"
    parts = [asked if at.error is None else f"error {format_quantity(at.error, angle, 3)}", speed]
    return ", ".join([*parts, *([f"step {at.step}"] if at.step else [])])


def _agreed(fields: Sequence[Row]) -> str:
    """How many fields agree: `18`, or `17 of 18`."""
    right = sum(row.ok for row in fields)
    return str(right) if right == len(fields) else f"{right} of {len(fields)}"


def _fault(row: Row) -> str:
    place = f"{row.place}: " if row.place is not None else ""
    code = style_of(sys.stdout).severity(row.code or "", Severity.ERROR)
    return one_line(place) + f"{code} {row.target} {_said(row)}"


def _said(row: Row) -> str:
    """The joints and what is wrong with them."""
    more = f" and {row.joints - 1} more" if row.joint and row.joints > 1 else ""
    who = f"{row.joint}{more}: " if row.joint else ""
    where = ""
    if row.at is not None:
        what = _HISTORIES.get(row.quantity, row.quantity)
        where = (
            f" ({what}, {_state(row.at, row.unit)}; {format_quantity(row.tolerance, row.unit, 2)} allowed)"
        )
    return one_line(f"{who}{row.message}{where}")


def _marked(agreement: Agreement) -> Iterator[tuple[str, str]]:
    """Each target with its approximations: those of what was compared, then those in which nothing differs."""
    found: dict[str, dict[str, None]] = {}
    keys = [(row.target, key) for row in agreement.rows for key in row.approximations if key != SOFT]
    for target, key in (*keys, *((loss.target, loss.key) for loss in agreement.approximations)):
        found.setdefault(target, {})[key.removeprefix(f"{target}.")] = None
    for target, names in found.items():
        yield target, listed(names, most=12)


def _missed(skipped: Sequence[Skip]) -> Iterator[tuple[str, str, str]]:
    for skip in skipped:
        group = f" {skip.group}" if skip.group else ""
        what = "" if skip.what == "torque" else f", {skip.what}"
        yield f"{skip.target}{group}{what}", skip.reason, skip.help or ""


def _summary(compilation: Compilation, agreement: Agreement) -> str:
    faults = agreement.faults
    bad = list(dict.fromkeys(row.target for row in faults))
    if not faults:
        verdict = _verdict(compilation, agreement)
    else:
        verdict = f"{many(len(faults), 'disagreement')} in {listed(bad)}"
    asked = {row.target for row in agreement.rows if row.quantity in _HISTORIES}
    # Of the other targets it is said that they were read back.
    for what in dict.fromkeys(skip.what for skip in agreement.skipped if skip.target in asked):
        missed = [skip for skip in agreement.skipped if skip.target in asked and skip.what == what]
        where = listed(dict.fromkeys(f"{skip.target} {skip.group}".rstrip() for skip in missed), 3)
        verdict += f"; not run in full: {what} of {one_line(where)}"
    if compilation.failures:
        verdict += (
            f"; {listed(dict.fromkeys(name for name, _ in compilation.failures))} could not be compiled"
        )
    engines = (
        f"the torque of {len(asked)} of {len(compilation.targets)} was computed by the simulator's own code"
    )
    own = compilation.actuators.approximations
    if own:
        # The law is that of the resolved spec, which has them already.
        worst = worst_error(own)
        fields = listed(dict.fromkeys(loss.field for loss in own))
        verdict += (
            f"; the spec itself approximates {fields}{f' ({worst})' if worst else ''}, alike in every target"
        )
    return f"{verdict}; {engines}"


def _verdict(compilation: Compilation, agreement: Agreement) -> str:
    """How many targets agree, how many do within what they are known to lose, and how many were only read back."""
    every = dict.fromkeys(row.target for row in agreement.rows)
    run = {row.target for row in agreement.rows if row.quantity in _HISTORIES}
    marked = [row for row in agreement.rows if set(row.approximations) - {SOFT}]
    losing = {row.target for row in marked} | {loss.target for loss in agreement.approximations}
    same = [name for name in every if name in run and name not in losing]
    within = [name for name in every if name in run and name in losing]
    read = [name for name in every if name not in run and name not in losing]
    bounded = [name for name in every if name not in run and name in losing]
    first = next(group for group in (same, within, read, bounded) if group or group is bounded)

    def count(group: list[str], one: str, more: str) -> str:
        alone = len(group) == 1
        return f"{many(len(group), 'target') if group is first else len(group)} {one if alone else more}"

    parts = []
    if same:
        parts.append(count(same, "agrees", "agree") + " with the spec")
    if within:
        how = count(within, "agrees", "agree") if within is first else str(len(within))
        size = _measured(row for row in marked if row.target in within) or _bound(agreement, within)
        parts.append(f"{how} within {_word(compilation, agreement, marked, within)} approximations{size}")
    if read:
        parts.append(f"{count(read, 'was', 'were')} read back and not run ({listed(read)})")
    if bounded:
        how = f"{count(bounded, 'was', 'were')} read back and not run ({listed(bounded)})"
        word = _word(compilation, agreement, marked, bounded)
        parts.append(f"{how} within {word} approximations{_bound(agreement, bounded)}")
    return ", ".join(parts)


def _word(
    compilation: Compilation, agreement: Agreement, marked: Sequence[Row], targets: Sequence[str]
) -> str:
    """`accepted`, or `known` where the spec does not accept all that these targets lose."""
    lost = {key for row in marked if row.target in targets for key in row.approximations}
    lost |= {loss.key for loss in agreement.approximations if loss.target in targets}
    return "known" if lost & {loss.key for loss in compilation.unaccepted} else "accepted"


def _measured(rows: Iterable[Row]) -> str:
    """The largest torque error that was found in these rows; "" where there is none but rounding."""
    torques = [row for row in rows if row.quantity in _HISTORIES and row.max_error is not None]
    worst = max(torques, key=lambda row: row.max_error or 0.0, default=None)
    if worst is None or (worst.max_error or 0.0) <= _ROUNDING:
        return ""
    size = f"largest {_amount(worst.max_error, worst.unit)}"
    usual = max((row.usual_error for row in torques if row.usual_error is not None), default=None)
    if usual is not None:
        amount = _amount(usual, worst.unit) if usual > _ROUNDING else "none"
        size += f", {amount} inside the ranges of command and speed"
    return f" ({size})"


def _bound(agreement: Agreement, targets: Sequence[str]) -> str:
    """The largest torque error that these targets may have by what they are known to lose; "" where none has a size."""
    bound = worst_error(loss for loss in agreement.approximations if loss.target in targets)
    return f" ({bound}, as `compile` has it)" if bound else ""
