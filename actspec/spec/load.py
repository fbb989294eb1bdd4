"""Load a spec with everything that it names, but the robot: YAML, includes, identification results."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, SpecError
from actspec.spec.document import load_document
from actspec.spec.validate import Spec, validate

if TYPE_CHECKING:
    from actspec.spec.results import Results


def load_spec(path: str) -> Spec:
    """Read and validate a spec and the results files that it names.

    Raises:
        SpecError: with every error of the spec, or of all of its results files.

    Results of another robot are a warning in `Spec.diagnostics`.
    """
    spec = validate(load_document(path))
    folder = os.path.dirname(os.path.abspath(path))
    collector = Collector()
    results: dict[str, Results] = {}
    for name, group in spec.model.actuators.items():
        named = group.identified
        if named is None or named in results:
            continue
        where = f"actuators.{name}.identified"
        full = os.path.realpath(os.path.join(folder, named))
        if os.path.commonpath([full, os.path.realpath(folder)]) != os.path.realpath(folder):
            collector.error(
                "SPEC170",
                f"'{named}' is outside the spec's folder",
                where=where,
                span=spec.span("actuators", name, "identified"),
                help="keep results files below the folder of the spec",
            )
            continue
        # Most specs name no results, and the models take time to build.
        from actspec.spec.results import validate_results

        try:
            found = validate_results(load_document(os.path.join(os.path.dirname(path), named)))
        except SpecError as err:
            for item in err.diagnostics:
                if item.span is None or not item.span.line:
                    # About the file as a whole: the place to change is the line that names it.
                    place = spec.span("actuators", name, "identified")
                    item = replace(item, where=where, span=place)
                collector.add(item)
            continue
        results[named] = found
        if found.robot != spec.model.robot.name:
            collector.warning(
                "RES012",
                f"'{named}' has the results of the robot '{found.robot}', the spec is for '{spec.model.robot.name}'",
                where=where,
                span=spec.span("actuators", name, "identified"),
                help="name this robot's results, or correct `robot` in one of the two files",
            )
    collector.raise_if_failed(SpecError)
    return replace(spec, results=results, diagnostics=(*spec.diagnostics, *collector.sorted()))
