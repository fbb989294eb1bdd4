"""`actspec sysid import`: results of other identification tools as results files."""

from __future__ import annotations

import argparse

from actspec.cli.options import add_force, describe, quantity_needed
from actspec.cli.recordings import warned
from actspec.diagnostics import Collector
from actspec.logs import LogError
from actspec.report.terminal import print_diagnostics, print_lines
from actspec.units import Kind

LONGEST_STEP = 0.1
"""Of a physics step [s]. Chosen: no simulator takes a longer one, and `2.5 s` for `2.5 ms` makes a delay of 5 s."""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the options and what the help says."""
    describe(
        command,
        "Make a results file of what another tool found: Rhoban's BAM (parameter JSON), PACE (its mean, as text), "
        "MuJoCo's sysid (params_x_hat.yaml), or a line k v + b of friction over speed. What it has that a results file "
        "has not is listed there with the reason.",
        "actspec sysid import m1.json --from bam --joint hip knee --robot leg -o results/leg.yaml",
        "0 written; 1 written, something was left out; 2 nothing was written",
    )
    command.add_argument("file", metavar="FILE", help="file of the other tool")
    command.add_argument(
        "--from", required=True, choices=("bam", "pace", "mujoco-sysid", "line"), dest="tool", help="tool"
    )
    command.add_argument(
        "--joint", nargs="+", default=[], metavar="JOINT", help="joints, in the file's order"
    )
    command.add_argument("--robot", required=True, metavar="NAME", help="the robot, as the spec calls it")
    command.add_argument(
        "-o", "--output", required=True, metavar="RESULTS", help="results file to write (YAML)"
    )
    command.add_argument(
        "--layout", default="", metavar="B,...", help="pace: armature,viscous,friction,bias,delay"
    )
    command.add_argument(
        "--step", metavar="TIME", help="pace, mujoco-sysid: physics step of the fit, e.g. '2.5 ms'"
    )
    command.add_argument("--commit", default="", metavar="COMMIT", help="pace, bam: version of the tool")
    command.add_argument(
        "--map",
        action="append",
        default=[],
        metavar="NAME=JOINT.FIELD",
        help="mujoco-sysid: what a parameter is; field: armature, friction.viscous, friction.coulomb, kp, kd",
    )
    command.add_argument(
        "--linear", action="store_true", help="mujoco-sysid: the joints are slides, in m and N"
    )
    add_force(command)


def run(arguments: argparse.Namespace) -> int:
    """Read, and write the results file."""
    from actspec.logs import check_results_path
    from actspec.output import write_text
    from actspec.owned import check_free
    from actspec.report.foreign import imported_lines
    from actspec.spec.document import document_from_text
    from actspec.spec.results import validate_results
    from actspec.sysid.foreign import foreign_text, read_foreign
    from actspec.sysid.foreign.figures import Options

    check_results_path(arguments.output)
    check_free(arguments.output, [arguments.file], arguments.force)
    options = Options(
        joints=tuple(arguments.joint),
        layout=tuple(block.strip() for block in arguments.layout.split(",") if block.strip()),
        step=None
        if arguments.step is None
        else quantity_needed(arguments.step, Kind.TIME, "--step", "SYS042", most=LONGEST_STEP),
        commit=arguments.commit,
        names=_mapped(arguments.map),
        linear=arguments.linear,
    )
    collector = Collector()
    found = read_foreign(arguments.tool, arguments.file, options, collector)
    text = foreign_text(found, arguments.robot)
    validate_results(document_from_text(text, arguments.output))
    write_text(arguments.output, text, force=arguments.force)
    print_diagnostics(collector.sorted())
    print_lines([*imported_lines(found), f"wrote {arguments.output}"])
    return warned(collector)


def _mapped(texts: list[str]) -> dict[str, tuple[str, str]]:
    """`NAME=JOINT.FIELD` of `--map`."""
    from actspec.sysid.foreign.mujoco_params import MAPPED

    found = {}
    for text in texts:
        name, _, meant = text.rpartition("=")
        field = next((field for field in MAPPED if meant.endswith(f".{field}")), None)
        if not name or field is None or name in found or len(meant) == len(field) + 1:
            help = f"write NAME=JOINT.FIELD, each name once; fields: {', '.join(MAPPED)}"
            raise LogError.of(
                "SYS071", f"'{text}' maps no parameter to a joint's field", where="--map", help=help
            )
        found[name] = (meant.removesuffix(f".{field}"), field)
    return found
