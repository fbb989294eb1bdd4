"""Mesh files of a model: where they are, and whether a body's inertia comes from them."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import mujoco

MOST_MESH_BYTES = 256 * 1024 * 1024
"""Chosen: a mesh file above this is not opened for the inertia."""


@dataclass(frozen=True, slots=True)
class MeshDependence:
    """A moving body whose mass comes from mesh files.

    Attributes:
        body: Its name.
        missing: Mesh files that such bodies need and that are not there; empty: all are.
    """

    body: str
    missing: tuple[str, ...]


def mesh_dependence(spec: mujoco.MjSpec) -> MeshDependence | None:
    """Say whether the inertia of a moving body comes from mesh files.

    Args:
        spec: From `open_spec`, not yet compiled.

    Returns: The first such body in the model's order; None when meshes do not matter.
    """
    import mujoco

    meshes = {mesh.name or stem(mesh.file): mesh for mesh in spec.meshes if mesh.file}
    if not meshes:
        return None
    body_name: str | None = None
    missing: dict[str, None] = {}
    stack = [(body, False) for body in reversed(list(spec.worldbody.bodies))]
    while stack:
        body, moving = stack.pop()
        moving = moving or len(body.joints) > 0
        stack.extend((child, moving) for child in reversed(list(body.bodies)))
        if not moving:
            continue
        mode = int(body.compiler.inertiafromgeom)
        if mode == int(mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE):
            continue
        if mode == int(mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO) and body.explicitinertial:
            continue
        groups = body.compiler.inertiagrouprange
        for geom in body.geoms:
            mesh = meshes.get(geom.meshname) if geom.meshname else None
            # NaN mass: not given, so the density decides.
            massless = geom.mass == 0 or (geom.mass != geom.mass and geom.density == 0)
            if mesh is None or massless or not groups[0] <= geom.group <= groups[1]:
                continue
            body_name = body_name if body_name is not None else body.name
            if not usable_file(mesh_path(spec, mesh)):
                missing.setdefault(mesh.file)
    return None if body_name is None else MeshDependence(body_name, tuple(missing))


def mesh_path(spec: mujoco.MjSpec, mesh: Any) -> str:
    """Where MuJoCo looks for a mesh file of a spec that `open_spec` opened."""
    name = base_name(mesh.file) if spec.strippath else mesh.file
    return os.path.join(spec.modelfiledir, mesh.compiler.meshdir, name)


def usable_file(path: str) -> bool:
    """Whether a path is a regular file (no device, no pipe) of a size that can be read."""
    try:
        return os.path.isfile(path) and os.path.getsize(path) <= MOST_MESH_BYTES
    except (OSError, ValueError):
        return False


def base_name(name: str) -> str:
    """The last part of a path, separated by a slash or a backslash."""
    return re.split(r"[/\\]", name)[-1]


def stem(name: str) -> str:
    """The base name without its ending."""
    return os.path.splitext(base_name(name))[0]
