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
    """Moving bodies whose mass comes from mesh files.

    Attributes:
        body: Name of the first.
        bodies: The bodies, in the model's order; they live as long as their spec.
        missing: Mesh files that they need and that are not there; empty: all are.
        total: Whether the file scales all masses to a total, so that every body depends on them.
    """

    body: str
    bodies: tuple[mujoco.MjsBody, ...]
    missing: tuple[str, ...]
    total: bool

    @property
    def reason(self) -> str:
        """Why the inertia is unknown where a mesh file is missing."""
        return f"the mass of body {self.body!r} comes from mesh files that are not there"


def mesh_dependence(spec: mujoco.MjSpec) -> MeshDependence | None:
    """Say whether the inertia of a moving body comes from mesh files.

    Args:
        spec: From `open_spec`, not yet compiled.

    Returns: Such bodies; None when meshes do not matter.
    """
    import mujoco

    meshes = {mesh.name or stem(mesh.file): mesh for mesh in spec.meshes if mesh.file}
    if not meshes:
        return None
    bodies = []
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
        weighed = False
        for geom in body.geoms:
            mesh = meshes.get(geom.meshname) if geom.meshname else None
            # NaN mass: not given, so the density decides.
            massless = geom.mass == 0 or (geom.mass != geom.mass and geom.density == 0)
            if mesh is None or massless or not groups[0] <= geom.group <= groups[1]:
                continue
            weighed = True
            if not usable_file(mesh_path(spec, mesh)):
                missing.setdefault(mesh.file)
        if weighed:
            bodies.append(body)
    if not bodies:
        return None
    return MeshDependence(bodies[0].name, tuple(bodies), tuple(missing), spec.compiler.settotalmass > 0.0)


def give_placeholder_masses(meshes: MeshDependence) -> None:
    """Give the bodies of a spec that is to be compiled without their meshes 1 kg and 1 kg*m^2.

    The stand-ins weigh tons, and what does not depend on them would lose digits beside them.
    """
    for body in meshes.bodies:
        if not body.explicitinertial:
            body.mass, body.inertia, body.ipos, body.explicitinertial = 1.0, (1.0, 1.0, 1.0), (0, 0, 0), True


def unknown_inertia(model: mujoco.MjModel, meshes: MeshDependence | None) -> frozenset[int]:
    """Degrees of freedom whose inertia, with the others held or free, depends on mesh files that are not there.

    They are in one kinematic tree with a body that takes its mass from a mesh: the mass matrix has no other
    coupling, unless a tendon with armature couples trees.

    Args:
        model: Compiled, with stand-ins.
        meshes: Of its spec; None: no mass comes from meshes.
    """
    if meshes is None or not meshes.missing:
        return frozenset()
    trees = model.dof_treeid.tolist()
    if meshes.total or model.tendon_armature.any():
        return frozenset(range(model.nv))
    shaken = {model.body_treeid[body.id] for body in meshes.bodies}
    return frozenset(dof for dof, tree in enumerate(trees) if tree in shaken)


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
