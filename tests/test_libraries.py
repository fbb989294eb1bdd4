"""What to type where a library is missing."""

from __future__ import annotations

from importlib import metadata

import pytest

from actspec.libraries import extra_line


def test_an_extra_where_actspec_is_installed_and_where_it_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """No index has actspec: pip finds an extra by its name only where it is installed, else in the clone."""
    assert extra_line("sysid") == "pip install 'actspec[sysid]'"

    def none(name: str) -> str:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "version", none)
    assert extra_line("sysid") == "pip install '.[sysid]' in the clone of actspec"
