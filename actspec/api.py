"""What the command line and notebooks both call: load, resolve, compile."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, Diagnostic, EmitError, ResolveError
from actspec.output import Compilation

if TYPE_CHECKING:
    from collections.abc import Callable

    from actspec.ir import ActuatorSet
    from actspec.robot.view import RobotView
    from actspec.spec.validate import Spec
    from actspec.targets.base import TargetOptions
    from actspec.verify.agreement import Agreement


def load(path: str | os.PathLike[str], *, packages: Mapping[str, str] = MappingProxyType({})) -> Spec:
    """Read and validate a spec; needs no robot.

    Args:
        path: Of the spec.
        packages: ROS package to its folder, beside and before those of `robot.packages`; relative to the working one.

    Raises:
        SpecError: with every error of the spec.
    """
    from actspec.spec.validate import load_spec

    spec = load_spec(os.fspath(path))
    return spec.with_packages({name: os.path.abspath(at) for name, at in packages.items()})


def _loaded(spec: Spec | str | os.PathLike[str]) -> Spec:
    """A spec by its path, or itself.

    Raises:
        TypeError: it is none of both.
    """
    from actspec.spec.validate import Spec

    if isinstance(spec, (str, os.PathLike)):
        return load(spec)
    if not isinstance(spec, Spec):
        raise TypeError(f"a spec is its path, or what actspec.load makes of it, got {type(spec).__name__}")
    return spec


def load_robot(spec: Spec) -> RobotView:
    """Read the robot that a spec names.

    Raises:
        RobotError: the model is not there or cannot be read.
    """
    from actspec.robot.load import robot_of

    return robot_of(spec)


def resolve(spec: Spec | str | os.PathLike[str], robot: RobotView | None = None) -> ActuatorSet:
    """Fit a spec to its robot: every joint's actuator in SI units, with origin and source.

    Args:
        spec: A spec, or the path of one.
        robot: The robot; default: the one that the spec names.

    Raises:
        SpecError, RobotError, ResolveError: with every error of the stage.
        TypeError: `spec` is no spec.
    """
    from actspec.resolution import resolve as fit

    loaded = _loaded(spec)
    return fit(loaded, robot if robot is not None else load_robot(loaded))


def compile(
    spec: Spec | str | os.PathLike[str],
    *,
    targets: Sequence[str | TargetOptions] = (),
    output: str | None = None,
    canonical: bool = False,
    partial: bool = False,
) -> Compilation:
    """Compile a spec to its targets, without writing anything (see `actspec.output.write`).

    Args:
        spec: A spec, or the path of one.
        targets: Names of the spec's targets, `KIND==VERSION` such as `mujoco==3.11`, or options; default: all.
        output: Folder to write below; default `build/<robot>`.
        canonical: Write the simulator's own form of the model.
        partial: Leave out targets that cannot be compiled, as long as one can: the errors are in `failures`.

    Raises:
        SpecError, RobotError, ResolveError, EmitError: with every error of the stage.
        TypeError: `spec` is no spec.
    """
    from actspec.audit.rules import check_actuators
    from actspec.robot.load import check_packages
    from actspec.spec.plausible.joints import doubted_drives
    from actspec.targets.choose import check_accepted, choose_targets, emitter, warn_unlimited
    from actspec.targets.kit.network import check_manifests

    loaded = _loaded(spec)
    collector = Collector()
    chosen = choose_targets(loaded, targets, output, canonical, collector)
    robot = load_robot(loaded)
    check_packages(loaded)
    actuators = resolve(loaded, robot)
    for item in actuators.diagnostics:
        collector.add(item)
    if actuators.delta_action is not None:
        from actspec.learn.delta.files import check_named

        check_named(actuators, robot, collector)
    check_manifests(actuators, loaded, collector)
    made, emissions = [], []
    failures: list[tuple[str, Diagnostic]] = []
    explicit: dict[str, frozenset[str]] = {}
    for options in chosen:
        try:
            emission = emitter(options.kind)(actuators, robot, options)
        except EmitError as err:
            failures += [(options.name, _placed(item, loaded, options)) for item in err.diagnostics]
            continue
        made.append(options)
        emissions.append(emission)
        title = "MuJoCo with the Euler integrator" if options.kind == "mujoco" else options.name
        explicit[title] = explicit.get(title, frozenset()) | emission.explicit
        for item in emission.diagnostics:
            collector.add(_placed(item, loaded, options))
    if not (partial and emissions):
        for _, item in failures:
            collector.add(item)
    doubted = doubted_drives(actuators.joints, actuators.diagnostics)
    judged = {title: joints - doubted for title, joints in explicit.items()}
    for item in check_actuators(actuators, judged):
        collector.add(item)
    if any(actuator.network is not None for actuator in actuators.joints):
        from actspec.learn.notes import network_notes
        from actspec.learn.probes import network_doubts

        for item in network_notes(actuators, robot):
            collector.add(item)
        network_doubts(actuators, loaded, collector)
    collector.raise_if_failed(EmitError)
    warn_unlimited(actuators, made, emissions, collector)
    check_accepted(loaded, actuators, made, emissions, collector)
    return Compilation(
        loaded, robot, actuators, tuple(made), tuple(emissions), collector.sorted(), tuple(failures)
    )


def _placed(item: Diagnostic, spec: Spec, options: TargetOptions) -> Diagnostic:
    """What a target says without a place, where the spec has what it is about: its robot, else the target.

    A version of the command line has none.
    """
    if item.span is not None or item.where == options.where("version"):
        return item
    way, data = item.where.split("."), spec.document.data
    if way[0] == "robot":
        return replace(item, span=spec.span(*way))
    if options.name in data.get("targets", {}):
        return replace(item, span=spec.document.spans.key(("targets", options.name)))
    return item


def verify(
    spec: Spec | str | os.PathLike[str],
    *,
    targets: Sequence[str | TargetOptions] = (),
    built: str | os.PathLike[str] | None = None,
    canonical: bool = False,
    engines: bool = True,
    run_edited: bool = False,
    trust: bool = False,
    progress: Callable[[int, int], None] | None = None,
    partial: bool = False,
) -> tuple[Compilation, Agreement]:
    """Show by numbers that every target makes what the spec says: see docs/verify.md.

    Args:
        spec: A spec, or the path of one.
        targets: As in `compile`.
        built: Folder of compiled files to verify, as `compile` writes it below `-o`; default: what it writes today.
        canonical: As in `compile`.
        engines: Run the simulators that are here; files are only read back without.
        run_edited: Let them execute Python files of `built` that are not what the spec compiles to.
        trust: Let them execute TorchScript of networks that actspec did not write.
        progress: Called with how many steps are done, of how many.
        partial: As in `compile`.

    Raises:
        SpecError, RobotError, ResolveError, EmitError: as `compile`.
        VerifyError: a file of `built` is not there.
    """
    import tempfile

    from actspec.verify.run import lay_out, relative, verify

    with tempfile.TemporaryDirectory(prefix="actspec-verify-") as folder:
        compilation = compile(spec, targets=targets, output=folder, canonical=canonical, partial=partial)
        pairs = list(zip(compilation.targets, compilation.emissions, strict=True))
        found = lay_out(pairs, None if built is None else os.fspath(built))
        path = compilation.spec.document.path
        agreement = verify(
            compilation.actuators,
            compilation.robot,
            found,
            spec=path,
            engines=engines,
            run_edited=run_edited,
            trust=trust,
            progress=progress,
        )
        return compilation, relative(agreement, folder)


def sample(
    actuators: ActuatorSet | Spec | str | os.PathLike[str], n: int, *, seed: int, xp: Any = None
) -> dict[str, Any]:
    """Draw the effective actuator values of n randomised robots; see `actspec.sampling.sample`.

    Args:
        actuators: A resolved spec, a spec, or the path of one.
        n: Number of environments, >= 1.
        seed: >= 0.
        xp: `numpy` (default) or `torch`, the module.

    Returns: Field to array of shape (n, joints), in the order of `resolve(...).joints`.

    Raises:
        ValueError: n or seed is out of range.
        SpecError, RobotError, ResolveError: with every error of the stage.
    """
    from actspec.ir import ActuatorSet
    from actspec.sampling import sample as draw

    found = actuators if isinstance(actuators, ActuatorSet) else resolve(actuators)
    return draw(found, n, seed=seed, xp=xp)


__all__ = ["Compilation", "ResolveError", "compile", "load", "load_robot", "resolve", "sample", "verify"]
