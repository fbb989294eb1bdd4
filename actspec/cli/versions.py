"""`--target NAME==VERSION` of the commands that read robot files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from actspec.audit.settings import read_versions
from actspec.diagnostics import AuditError, Collector
from actspec.readings.versions import Versions


def named_versions(targets: Sequence[str], out: Collector) -> Versions:
    """The versions that a user names.

    Args:
        targets: `NAME==VERSION`.
        out: Gets what is wrong with them.
    """
    given: dict[str, str] = {}
    for target in targets:
        name, equals, version = target.partition("==")
        if not equals:
            out.error(
                "AUD010",
                f"must be NAME==VERSION, got {target!r}",
                where="--target",
                help="isaaclab==2.3, say",
            )
        elif given.setdefault(name, version) != version:
            out.error("AUD010", f"two versions of {name}: {given[name]} and {version}", where="--target")
    return read_versions(given, "--target", None, out)


def configured(targets: Sequence[str]) -> Versions:
    """The versions of the settings file with those that a user names in their place.

    Raises: AuditError: either is wrong.
    """
    from actspec.audit.rules.registry import all_rules
    from actspec.audit.settings import load_settings

    out = Collector()
    named = named_versions(targets, out)
    out.raise_if_failed(AuditError)
    return over(load_settings(all_rules()).versions, named)


def over(under: Versions, above: Versions) -> Versions:
    """Versions with others in their place where those say something."""
    given = {name: getattr(above, name) for name in Versions.__dataclass_fields__}
    return replace(under, **{name: value for name, value in given.items() if value is not None})
