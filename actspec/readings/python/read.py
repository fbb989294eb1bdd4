"""Reads configuration `.py` of Isaac Lab, mjlab and legged_gym by its syntax; nothing is imported or executed.

Values are folded: arithmetic, constants, imports from files beside it, copies. What cannot be folded
is in the configuration with its reason, and never guessed.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, Span
from actspec.readings.artifact import (
    ActuatorGroup,
    Artifact,
    FileKind,
    FileReading,
    RandomizedRange,
    RobotConfig,
    Setting,
)
from actspec.readings.networks import with_networks
from actspec.readings.python import isaaclab, legged_gym, mjlab
from actspec.readings.python.settings import JOINTS, NOTHING, UNFOLDED, fields_of, has_joints, setting
from actspec.readings.python.source import Library, Source, UnreadableError, definitions, open_library
from actspec.readings.python.unapplied import Assigned, sorted_out
from actspec.readings.python.unrolled import SCALE, Unrolling, filled
from actspec.readings.python.values import (
    MAX_STEPS,
    Cls,
    Data,
    Func,
    Module,
    Obj,
    Scope,
    Seq,
    Table,
    Value,
)
from actspec.readings.versions import step_of, written_for
from actspec.robot.view import ModelFile

MAX_CONFIGS = 200
"""Configurations of one file. Chosen: the fullest file of Isaac Lab has 10."""


def read_python(path: str, named: tuple[str, ...] = ()) -> FileReading:
    """Read the robot configurations of a Python file.

    Args:
        path: The file as the user named it.
        named: Files of one robot, of which the others may define what this one imports from a package.

    Returns: One artifact a robot or environment, in the order of the file; a reason when it cannot be read.
    """
    library = open_library(path)
    library.named = tuple(file for file in named if file != path)
    try:
        source = library.open(path)
        interpreter = Unrolling(library)
        module = interpreter.load(source)
        reader = _Reader(interpreter, source, module)
        configs = list(reader.configs())
    except UnreadableError as err:
        refused = Span(path, *err.at) if err.at[0] else None
        file = ModelFile(path, "", err.data)
        return FileReading(path, FileKind.CFG, str(err), files=(file,) * bool(err.data), refused=refused)
    except (RecursionError, MemoryError):
        deep = "its expressions are nested too deep to fold"
        return FileReading(path, FileKind.CFG, deep, files=_files(library))
    said = Collector()
    if interpreter.budget.left < 0:
        said.warning(
            UNFOLDED, f"only part of it is folded: it takes more than {MAX_STEPS} steps", span=Span(path)
        )
    if reader.found > MAX_CONFIGS:
        message = f"only the first {MAX_CONFIGS} of its {reader.found} configurations are read"
        said.warning(UNFOLDED, message, span=Span(path))
    reason = None
    if not configs:
        reason, help, span = _nothing_in(source)
        said.error(NOTHING, reason, span=span, help=help)
    files = _files(library)
    return FileReading(
        path,
        FileKind.CFG,
        reason,
        tuple(_artifact(path, config, {one.path: one.data for one in files}) for config in configs),
        files,
        tuple(said),
    )


def _nothing_in(source: Source) -> tuple[str, str, Span]:
    """Why a file has no configuration, what to name in its place, and where that is seen."""
    # Of the thousands of files in a folder few have a word of it.
    named = any(name.encode() in source.data for name in JOINTS)
    waiting: list[tuple[ast.AST, str]] = [(source.tree, "")] if named else []
    while waiting:
        node, inside = waiting.pop()
        if isinstance(node, ast.Call) and any(keyword.arg in JOINTS for keyword in node.keywords):
            where = f"in {inside}, which is not run" if inside else "in no robot's configuration that is read"
            help = (
                "a robot's cfg is read where a name of the file, or of a class in it, has it: write it there"
            )
            return f"its actuators stand {where}", help, source.span(node)
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            inside = f"the function {node.name}()"
        waiting += [(inner, inside) for inner in ast.iter_child_nodes(node)][::-1]
    help = "name the robot's configuration; it finds its base itself"
    return "no actuators of Isaac Lab, mjlab or legged_gym in it", help, Span(source.path)


def _files(library: Library) -> tuple[ModelFile, ...]:
    """What was read, the named file first."""
    return tuple(ModelFile(one.path, one.include, one.data) for one in library.sources.values() if one)


def _artifact(path: str, config: RobotConfig, data: Mapping[str, bytes]) -> Artifact:
    """A configuration with its networks and what it was written for, if that is one thing for all of its groups."""
    parts: tuple[ActuatorGroup | RandomizedRange, ...] = config.groups or config.randomize
    heads = [written_for(data.get(part.span.path, b"")) for part in parts]
    if heads and all(head == heads[0] for head in heads):
        config = replace(config, written_for=heads[0])
    if config.groups and "physics_dt" not in config.settings:
        config = replace(config, settings={**config.settings, **_step(config, data)})
    return Artifact(path, FileKind.CFG, config.name, config=with_networks(config))


def _step(config: RobotConfig, data: Mapping[str, bytes]) -> dict[str, Setting]:
    """The physics step that all files of the groups were written for; empty where one of them does not say."""
    files = dict.fromkeys(group.span.path for group in config.groups)
    steps = {path: step_of(data.get(path, b"")) for path in files}
    path, first = next(iter(steps.items()))
    if first is None or any(step is None or step[0] != first[0] for step in steps.values()):
        return {}
    return {"physics_dt": Setting(first[0], Span(path, first[1], 1))}


class _Reader:
    """Finds the configurations among the names of one module."""

    def __init__(self, interpreter: Unrolling, source: Source, module: Value) -> None:
        assert isinstance(module.data, Module)
        self.interpreter = interpreter
        self.source = source
        self.places = definitions(source.tree.body)
        self.scope: Scope = module.data.scope
        self.used: set[Span] = set()
        self.names: dict[int, str] = {}
        self.entities: dict[int, list[Value]] = {}
        self.found = 0
        self.assigned: dict[str, list[Assigned]] = {}
        self.beside: list[tuple[str, str, Value]] = []
        self.scales: dict[str, Setting] = {}
        self.only = ""

    def configs(self) -> Iterator[RobotConfig]:
        """Every configuration once, in the order of the file."""
        found: list[RobotConfig] = []
        own = list(self._own())
        # Those of functions are under their names already, which counts.
        self.assigned[""] = list(self.interpreter.unapplied.found)
        self.names = self._object_names()
        for _, value, _ in own:
            if mjlab.is_entity(value):
                self.entities.setdefault(id(fields_of(value)["articulation"].data), []).append(value)
        # Robots first: what they use is not loose.
        for name, value, span in own:
            found.extend(self._constant(name, value, span))
        for name, value, span in own:
            if isinstance(value.data, Cls):
                found.extend(self._class(name, value.data, span))
        for name, value, span in own:
            found.extend(self._loose(name, value, span))
        inside = {one for config in found if not _is_ranges(config) for one in config.randomize}
        constants = {name for name, value, _ in own if self.scope.names.get(name) is value}
        functions = {name for name, _, _ in own} - constants
        constants.difference_update(name for name, value, _ in own if isinstance(value.data, Cls))
        self.found = len(found)
        self.beside = self._beside()
        self.scales = {
            name.removesuffix(SCALE): setting(value)
            for name, value in filled(self.interpreter, self.scope).items()
        }
        drives = [config.name for config in found if config.groups]
        self.only = drives[0] if len(set(drives)) == 1 else ""
        seen: list[object] = []
        kept: list[RobotConfig] = []
        # `BIPED_CFG = make_cfg()` is the robot BIPED, not one more that is called as the function is.
        public = {name for name in constants if not name.startswith("_")}
        stated = [_content(config) for config in found if config.name in public]
        for config in sorted(found, key=lambda one: (one.span.line, one.span.column))[:MAX_CONFIGS]:
            content = _content(config)
            if config.name in functions and content in stated:
                continue
            # A task's variants for playing differ in nothing that is read here; its events are in the task.
            repeated = _is_ranges(config) and inside.issuperset(config.randomize)
            if config.name in constants or (content not in seen and not repeated):
                seen.append(content)
                kept.append(replace(self._scaled(config), by_call=config.name in functions))
        yield from self._with_assigned(kept)

    def _with_assigned(self, configs: Sequence[RobotConfig]) -> Iterator[RobotConfig]:
        """With what is assigned to robots that are not read; the first one has what belongs to no other."""
        own = {config.name: self.assigned.get(config.name, []) for config in configs}
        known = {(one.target, one.span) for assigned in own.values() for one in assigned}
        rest = []
        for name, assigned in self.assigned.items():
            for one in assigned:
                if (one.target, one.span) not in known:
                    known.add((one.target, one.span))
                    rest.append((name, one))
        for config in configs:
            parts = [("", own[config.name])]
            if config is configs[0]:
                parts += [(f"{name}: " if name else "", [one]) for name, one in rest]
            entries = dict(config.entries)
            others: dict[str, Setting] = {}
            for prefix, assigned in parts:
                numbers, values = sorted_out(assigned, config, prefix)
                entries.update(numbers)
                others.update(values)
            yield replace(config, entries=entries, others=others)

    def _made(self, name: str, function: Value, span: Span) -> Value:
        """What a call without arguments gives; what it assigns to robots that are not read is the name's."""
        found = self.interpreter.unapplied.found
        before = len(found)
        value = self.interpreter.call(function, [], {}, span)
        self.assigned.setdefault(name, []).extend(found[before:])
        return value

    def _scaled(self, config: RobotConfig) -> RobotConfig:
        """With the action scale and pose that stand beside a robot: `G1_ACTION_SCALE` beside `G1_ARTICULATION`."""
        settings = dict(config.settings)
        for prefix, name, value in self.beside:
            if config.name.startswith(f"{prefix}_") and name not in settings:
                settings[name] = setting(value)
        own = [one for name, one in self.scales.items() if config.name.startswith(f"{name}_")]
        if not own and config.name == self.only:
            own = list(self.scales.values())
        stated = settings.get("action_scale")
        open = stated is None or (stated.unknown is not None and stated.looped is None)
        looped = {"action_scale": own[0]} if len(own) == 1 and config.groups and open else {}
        return replace(config, settings=settings, looped=looped)

    def _beside(self) -> list[tuple[str, str, Value]]:
        """Prefix, setting and value of the constants that belong to a robot by their name."""
        found = []
        for ending, name in ((SCALE, "action_scale"), ("_JOINT_POS", "default_position")):
            for constant, value in self.scope.names.items():
                if constant.endswith(ending):
                    value = self.interpreter.resolved(value, self.scope)
                    found.append((constant.removesuffix(ending), name, value))
        return found[:MAX_CONFIGS]

    def _own(self) -> Iterator[tuple[str, Value, Span]]:
        """What this file defines: constants, classes, and what its functions make without arguments."""
        made: list[tuple[str, Value, Span]] = []
        for name, lazy in list(self.scope.names.items()):
            if name not in self.places:
                continue
            span = self.source.span(self.places[name])
            value = self.interpreter.resolved(lazy, self.scope)
            if isinstance(value.data, Func):
                if not name.startswith("_") and _makes_cfg(value.data) and _needs_nothing(value.data):
                    made.append((name, self._made(name, value, span), span))
            elif _interesting(value.data):
                yield name, value, span
        yield from made

    def _constant(self, name: str, value: Value, span: Span) -> Iterator[RobotConfig]:
        data = value.data
        if isinstance(data, Cls):
            return
        if mjlab.is_articulation(value) or mjlab.is_entity(value):
            yield from self._articulation(name, value)
        elif mjlab.is_environment(value):
            yield mjlab.environment(name, value, span, self._call, self.names)
        elif mjlab.is_events(value):
            yield mjlab.events(name, value, span)
        elif isaaclab.is_robot(value) or isaaclab.is_group_dict(value):
            actuators = fields_of(value).get("actuators", value) if isinstance(data, Obj) else value
            self._use(actuators)
            yield isaaclab.robot(name, value, span)
        elif isaaclab.is_environment(value):
            yield isaaclab.environment(name, value, span)

    def _articulation(self, name: str, value: Value) -> Iterator[RobotConfig]:
        articulation = fields_of(value)["articulation"] if mjlab.is_entity(value) else value
        assert isinstance(articulation.data, Obj)
        if articulation.data.span in self.used:
            return
        self.used.add(articulation.data.span)
        self._use(fields_of(articulation).get("actuators"))
        users = self.entities.get(id(articulation.data), [value] if mjlab.is_entity(value) else [])
        name = self.names.get(id(articulation.data), name)
        yield mjlab.articulation(
            name, articulation, users[0] if len(users) == 1 else None, self._call, self.names
        )

    def _loose(self, name: str, value: Value, span: Span) -> Iterator[RobotConfig]:
        """Actuator cfgs that no robot of this file uses."""
        data = value.data
        if isinstance(data, Obj) and data.span not in self.used and has_joints(data):
            if mjlab.is_group(value):
                yield mjlab.articulation(name, value, None, self._call, self.names)
            elif isaaclab.is_group(value):
                yield isaaclab.robot(name, value, span)

    def _class(self, name: str, cls: Cls, span: Span) -> Iterator[RobotConfig]:
        if legged_gym.is_robot(cls, self._get):
            yield legged_gym.robot(cls, self._get)
            return
        if isinstance(self.interpreter.member(cls, "__init__"), Func):
            # A cfg has fields; what computes something when it is made is no cfg.
            return
        value = self._made(name, Value(cls, span), span)
        own = list(self._constant(name, value, span))
        if not own and isaaclab.is_events(value):
            own.append(isaaclab.events(name, value, span))
        yield from own
        if not own:
            # A class that is no cfg is a scope as the file is: a scene, or a robot with what else belongs to it.
            for field, one in fields_of(value).items():
                place = self.places.get(f"{name}.{field}")
                if place is not None:
                    yield from self._constant(f"{name}.{field}", one, self.source.span(place))

    def _use(self, actuators: Value | None) -> None:
        data = actuators.data if actuators is not None else None
        inner = (
            data.items if isinstance(data, Seq) else data.items.values() if isinstance(data, Table) else ()
        )
        self.used.update(one.data.span for one in inner if isinstance(one.data, Obj))

    def _call(self, function: Value) -> Value:
        return self.interpreter.call(function, [], {}, function.span)

    def _get(self, cls: Cls, name: str) -> Value | None:
        found = self.interpreter.member(cls, name)
        # What a class that is not read has is nobody's statement here.
        return found if isinstance(found, Value) else None

    def _object_names(self) -> dict[int, str]:
        """Names of objects by identity, those of this file first."""
        names: dict[int, str] = {}
        scopes = [self.scope]
        for module in self.interpreter.modules.values():
            if isinstance(module.data, Module) and module.data.scope is not self.scope:
                scopes.append(module.data.scope)
        for scope in scopes:
            for name, value in scope.names.items():
                if isinstance(value, Value) and isinstance(value.data, Obj):
                    names.setdefault(id(value.data), name)
        return names


def _is_ranges(config: RobotConfig) -> bool:
    """Whether a configuration has ranges alone, as a class of events."""
    return not (config.groups or config.settings or config.actions)


def _content(config: RobotConfig) -> tuple[object, ...]:
    """What a configuration says, whatever it is called."""
    return config.framework, config.groups, config.settings, config.randomize, config.actions


def _interesting(data: Data) -> bool:
    return isinstance(data, (Obj, Cls, Table))


def _needs_nothing(function: Func) -> bool:
    spec = function.node.args
    names = [arg.arg for arg in (*spec.posonlyargs, *spec.args, *spec.kwonlyargs)]
    return all(name in function.defaults for name in names)


def _makes_cfg(function: Func) -> bool:
    """Whether a function speaks of a cfg at all; others are not worth following."""
    for node in ast.walk(function.node):
        name = node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""
        if name.endswith(("Cfg", "_cfg", "_CFG")):
            return True
    return False
