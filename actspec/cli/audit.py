"""`actspec audit`: say where robot files disagree with each other and with physics."""

from __future__ import annotations

import argparse
import os

from actspec.audit.read import PendingFiles


def run(arguments: argparse.Namespace) -> int:
    """Audit the files."""
    with begin(arguments) as pending:
        # Rules and reports are imported while the readers import MuJoCo.
        from actspec.cli.audit_report import report_on

        return report_on(arguments, pending)


def begin(arguments: argparse.Namespace) -> PendingFiles:
    """Begin to read the files, each once, the spec too."""
    paths = tuple(dict.fromkeys([*arguments.file, *([arguments.spec] if arguments.spec else [])]))
    # Without threads of numpy's linear algebra this process can be forked; it needs none.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    return PendingFiles(paths, skip_other=arguments.skip_other, jobs=arguments.jobs)
