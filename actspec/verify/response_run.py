"""Ask engines for time responses, and compare them with the law's."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

from actspec.ir import ActuatorSet
from actspec.verify.agreement import Row, Skip
from actspec.verify.engines.question import EngineMissing, EngineRefused
from actspec.verify.response import Friction, Plan, Responded, plan
from actspec.verify.response_rows import (
    broken_response,
    expected,
    kept_friction,
    reference,
    response_rows,
    response_skips,
)
from actspec.verify.target import Target
from actspec.verify.torque import Laws

Ask = Callable[[Plan, Friction], Responded]
"""An engine's `respond`, which knows its files."""


def responses(
    targets: Sequence[Target], actuators: ActuatorSet, laws: Laws, asks: Mapping[str, Ask]
) -> tuple[dict[str, list[Row]], list[Skip]]:
    """Rows by target, and what could not be asked.

    Args:
        targets: All of them.
        actuators: What the spec asks for.
        laws: Of its joints.
        asks: Target to its engine, for those that there are.
    """
    from actspec.processes import cores

    asked = [target for target in targets if target.name in asks]
    if not asked or not laws.laws:
        return {}, []
    told = plan(actuators, laws.laws)
    if not told.joints:
        return {}, [skip for target in asked for skip in response_skips(target, told)]
    wanted = {target.name: expected(target, told) for target in asked}
    with ThreadPoolExecutor(max_workers=cores()) as pool:
        futures = {
            target.name: pool.submit(_answer, asks[target.name], told, kept_friction(wanted[target.name]))
            for target in asked
        }
        # Here, while the engines run in processes of their own.
        moved = reference(told, wanted.values())
        answers = {name: future.result() for name, future in futures.items()}
    rows: dict[str, list[Row]] = {}
    skipped: list[Skip] = []
    for target in asked:
        answer = answers[target.name]
        skipped += response_skips(target, told, answer if isinstance(answer, Responded) else None)
        if isinstance(answer, Responded):
            found = response_rows(target, actuators, told, wanted[target.name], moved, answer)
            rows[target.name] = list(found)
        elif isinstance(answer, EngineMissing):
            skipped.append(Skip(target.name, "", "responses", answer.reason, answer.help, answer.setup))
        else:
            rows[target.name] = [broken_response(target, answer)]
    return rows, skipped


def _answer(ask: Ask, told: Plan, friction: Friction) -> Responded | EngineMissing | EngineRefused:
    try:
        return ask(told, friction)
    except (EngineMissing, EngineRefused) as err:
        return err
