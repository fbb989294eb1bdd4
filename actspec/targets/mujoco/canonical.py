"""MuJoCo's own form of a model: one flat MJCF from a URDF, or from an MJCF with `--canonical`."""

from __future__ import annotations

import os
from collections.abc import Sequence

from actspec.diagnostics import Collector, Span
from actspec.robot.view import ModelFile, ModelFormat, RobotView


def canonical_files(robot: RobotView, collector: Collector) -> RobotView:
    """The same robot as one MJCF in MuJoCo's own form, read again.

    From 3.16 on MuJoCo saves what the author wrote, to the last digit; before, it saves the compiled
    model with six digits, which is reported.

    Raises:
        RobotError: MuJoCo cannot open or compile the model.
    """
    from actspec.robot.mjspec import compile_spec, mesh_dependence, open_spec, quiet
    from actspec.robot.read_mjcf import read_mjcf
    from actspec.robot.read_urdf import open_urdf

    files: Sequence[ModelFile] = robot.files
    if robot.format is ModelFormat.URDF:
        spec, files = open_urdf(files)
    else:
        spec = open_spec(files, format=robot.format)
    exact = hasattr(spec.compiler, "savecanonical")
    if exact:
        spec.compiler.savecompiled = False
        spec.compiler.savecanonical = False
    else:
        collector.warning(
            "MJC014",
            "this MuJoCo saves numbers with six digits; 3.16 and later keep them all",
            span=Span(robot.path),
            help="pip install --upgrade mujoco",
        )
        meshes = mesh_dependence(spec)
        if meshes is not None:
            spec = open_spec(files, format=robot.format, real_assets=True)
    compile_spec(spec, files)
    with quiet():
        text = spec.to_xml()
    path = f"{os.path.splitext(robot.path)[0]}.xml"
    main = ModelFile(path, "", text.encode("utf-8"))
    view = read_mjcf((main,), inertia=False)
    if robot.format is ModelFormat.URDF:
        collector.info(
            "MJC015",
            "the URDF is written as an MJCF: its base is fixed to the world, as MuJoCo reads it, and its velocity "
            "limits have no place there",
            span=Span(robot.path),
        )
    return view
