"""Ranges as the function that MuJoCo Playground randomizes a model with, those that the MuJoCo target's model holds."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from actspec.ir import JointActuator, Level, Randomization
from actspec.readings.joint import read_joint
from actspec.resolution.quantities import finite_limit
from actspec.sampling import FACTORS, drawn_ends, nominal_of, own_ranges
from actspec.simulators import UnknownVersion
from actspec.simulators.mujoco import DcMotorDialect, MujocoDialect, mujoco_dialect
from actspec.targets.base import EmittedFile
from actspec.targets.kit.draws import factor_lost, lost
from actspec.targets.kit.events import StackWriter
from actspec.targets.kit.python_text import WIDTH, grouped, py
from actspec.targets.mujoco.drive import Form, form_of

_REASONS = {
    "friction.static": "MuJoCo's frictionloss is one number for sticking and sliding",
    "friction.stribeck_velocity": "MuJoCo has no Stribeck friction",
    "delay": "a delay is a fixed number of steps of the model",
}


@dataclass(frozen=True, slots=True)
class DrawnJoint:
    """A joint of the MuJoCo target's model whose numbers are drawn.

    Attributes:
        actuator: What the spec asks for.
        form: The drive's element.
        limited: Whether the drive has a force limit.
        capped: Whether the joint has a force range of its own too.
        ranges: Field to its range, those that the model can hold.
    """

    actuator: JointActuator
    form: Form
    limited: bool
    capped: bool
    ranges: dict[str, Randomization]


def drawn_joint(actuator: JointActuator, stack: StackWriter, dialect: MujocoDialect) -> DrawnJoint:
    """What is drawn of a joint, with what cannot be; the robot's own numbers where the spec has none."""
    joint = stack.robot.joint(actuator.joint)
    limited, coulomb = actuator.effort_limit.known, actuator.friction_coulomb.value
    # A network's motor takes no limit of the file's own servo.
    if joint is not None and not limited and actuator.level is not Level.ACTUATOR_NET:
        limited = finite_limit(read_joint(stack.robot, joint.name).drive_limit) is not None
    if coulomb is None:
        coulomb = 0.0 if joint is None else joint.frictionloss
    form = form_of(actuator, dialect)
    capped = joint is not None and joint.effort_range is not None
    return DrawnJoint(actuator, form, limited, capped, _kept(stack, actuator, form, limited, coulomb))


def _kept(
    stack: StackWriter, actuator: JointActuator, form: Form, limited: bool, frictionloss: float
) -> dict[str, Randomization]:
    """The ranges that the model can hold; the others are reported."""
    losses, draws = stack.losses, stack.draws[actuator.joint]
    kept = {}
    for field, entry in own_ranges(actuator).items():
        draw = draws.get(field)
        reason = _REASONS.get(field)
        if field == "encoder_bias" and form is not Form.POSITION:
            reason = f"a <{form.value}> has no constant force to shift its position with"
        if actuator.level is Level.ACTUATOR_NET and field in ("kp", "kd", "gains"):
            reason = "the network has no gains"
        if field == "effort_limit" and not limited:
            reason = (
                "effort_limit is unknown, so the model's drive has no limit, and a drawn one does not act"
            )
        # Of a position or velocity drive there is no line to scale: that loss is the MuJoCo target's.
        if field == "strength" and form is Form.MOTOR and limited:
            why = "the torque comes from outside of the model: only its limit follows"
            losses.entry(actuator, entry, "a factor on the limit", why, factor_lost(actuator, entry))
        elif field == "strength" and form is Form.MOTOR:
            reason = "the torque comes from outside of the model, which does not limit it"
        if reason is not None:
            if draw is not None:
                losses.dropped(draw, reason)
            else:
                losses.entry(actuator, entry, "none", reason)
            continue
        if field == "friction.coulomb" and draw is not None and frictionloss == 0.0:
            losses.entry(
                actuator,
                entry,
                "without effect in MJX's JAX implementation",
                "it has friction at those joints alone whose frictionloss is not 0 when the model is put on the "
                "device; its Warp implementation applies it",
                lost(draw),
            )
        if field == "encoder_bias" and draw is not None:
            losses.entry(
                actuator,
                entry,
                "the drive's torque is shifted, the observation is not",
                "a model holds no encoder: add the bias to the observed joint positions too",
            )
        if entry.when != "startup":
            why = "Playground randomizes a model once"
            losses.entry(actuator, entry, "drawn at startup", why, more=f", drawn at {entry.when}")
        kept[field] = entry
    return kept


def _raises_limit(joint: DrawnJoint) -> bool:
    """Whether a limit can be drawn above the nominal."""
    for field in ("effort_limit", "strength"):
        if field in joint.ranges:
            entry = joint.ranges[field]
            nominal = nominal_of(joint.actuator, field) if field == "effort_limit" else 1.0
            neutral = {"scale": 1.0, "add": 0.0, "abs": nominal}[entry.operation]
            if neutral is None or drawn_ends(entry)[1] > neutral:
                return True
    return False


BODY = 8
"""Columns before a line of the body."""

ORDER = ("kp", "kd", "effort_limit", "armature", "friction.coulomb", "friction.viscous", "encoder_bias",
         "gains", "strength")  # fmt: skip

VARIABLE = {
    "kp": "kp",
    "kd": "kd",
    "effort_limit": "limit",
    "armature": "armature",
    "friction.coulomb": "frictionloss",
    "friction.viscous": "damping",
    "encoder_bias": "bias",
}

MODEL_FIELD = {
    "armature": "dof_armature",
    "friction.coulomb": "dof_frictionloss",
    "friction.viscous": "dof_damping",
}


ADDRESSES = {
    "jnt": ("index", "np.array(joints)"),
    "dof": ("degree of freedom", "np.asarray(model.jnt_dofadr)[joints]"),
    "act": ("actuator", "np.array([target.index(joint) for joint in joints])"),
}
"""What the function looks up of a joint: in words, and as it finds it."""


def write(stack: StackWriter) -> EmittedFile | None:
    """The module with the robot's function; None: it would draw nothing, or an error."""
    dialect = _model_dialect(stack)
    if dialect is None:
        return None
    joints = [drawn_joint(actuator, stack, dialect) for actuator in stack.actuators.joints]
    drawn = [joint for joint in joints if joint.ranges]
    if not drawn:
        return None
    function = Function(dialect, drawn)
    warp = "The model has <dcmotor> actuators, which MJX runs in its Warp implementation alone."
    return stack.file(
        "playground.py.j2",
        "playground_randomize.py",
        f"MuJoCo Playground, MuJoCo {dialect.text}",
        [
            "For the model that actspec's mujoco target writes; pass it as `randomization_fn`.",
            warp if function.forms[Form.DCMOTOR] else "",
        ],
        function=function,
        about=" and ".join(ADDRESSES[name][0] for name in function.addresses).capitalize(),
        looked_up=", ".join(ADDRESSES[name][1] for name in function.addresses),
    )


def _model_dialect(stack: StackWriter) -> MujocoDialect | None:
    """MuJoCo of the model that the function is for; None after an error."""
    models = [o for o in stack.options.siblings if o.kind == "mujoco"]
    default = mujoco_dialect(stack.version("mujoco"))
    if stack.options.version or not models:
        return default
    dialects = {}
    for model in models:
        # A version that there is not is the MuJoCo target's error.
        with suppress(UnknownVersion):
            dialects[model.name] = mujoco_dialect(model.version)
    words = {dialect.dcmotor for dialect in dialects.values()}
    if len(words) > 1 and any(a.level is Level.DC_MOTOR for a in stack.actuators.joints):
        said = " or ".join(f"'{name}' ({dialect.text})" for name, dialect in dialects.items())
        stack.options.at("version", stack.collector).error(
            "RND014",
            f"Playground's function could be for the model of {said}, whose motors keep their numbers in other fields",
            "write a target for it: {target: randomization, for: [playground], version: ...}",
        )
        return None
    return next(iter(dialects.values()), default)


class Function:
    """The emitted function: it reads the nominals, draws, and writes back.

    Attributes:
        joints: Joints that are drawn, in the robot's order.
        forms: Element to the places of its joints among them.
        fields: Fields of the spec that are drawn.
        addresses: What is looked up of the joints, `jnt`, `dof` and `act`.
        sets: Places of joints to the name of their set.
        keys: What shares a random key, to its number.
        lines: Lines of the body.
        written: Fields of the model that it writes, each a variable of the same name.
    """

    def __init__(self, dialect: MujocoDialect, drawn: Sequence[DrawnJoint]) -> None:
        self.dialect = dialect
        self.actuators = tuple(joint.actuator for joint in drawn)
        self.joints = tuple(actuator.joint for actuator in self.actuators)
        self.forms = {form: self._indices(a.actuator for a in drawn if a.form is form) for form in Form}
        self.fields = fields = {field for joint in drawn for field in joint.ranges}
        self.lines: list[str] = []
        self.written: list[str] = []
        self.sets: dict[tuple[int, ...], str] = {}
        self.keys: dict[tuple[str, str, str], int] = {}
        gains = bool(fields & {"kp", "kd", "gains", "strength", "encoder_bias"})
        limit = any(joint.limited and joint.ranges.keys() & {"effort_limit", "strength"} for joint in drawn)
        widened = any(joint.limited and joint.capped and _raises_limit(joint) for joint in drawn)
        entries = {
            field: [(joint.actuator, joint.ranges[field]) for joint in drawn if field in joint.ranges]
            for field in ORDER
        }
        self._read(gains, limit, {VARIABLE[field] for field in VARIABLE if self._replaces(entries[field])})
        for field in ORDER:
            self._draw(field, entries[field])
        self._store(gains, limit, widened)
        used = {"jnt": widened, "dof": bool(fields & MODEL_FIELD.keys()), "act": gains or limit}
        self.addresses = tuple(name for name, needed in used.items() if needed)

    @property
    def definitions(self) -> list[str]:
        """Definitions of the sets of joints, as lines."""
        return [line for places, name in self.sets.items() for line in _array(name, "np.array", places, "")]

    def _indices(self, some: Iterable[JointActuator]) -> tuple[int, ...]:
        wanted = {actuator.joint for actuator in some}
        return tuple(i for i, joint in enumerate(self.joints) if joint in wanted)

    def _set(self, indices: tuple[int, ...]) -> str:
        """Index expression of some joints: a name, or all of them."""
        if indices == tuple(range(len(self.joints))):
            return ":"
        return self.sets.setdefault(indices, f"SET_{len(self.sets) + 1}")

    def _act(self, indices: tuple[int, ...]) -> str:
        chosen = self._set(indices)
        return "act" if chosen == ":" else f"act[{chosen}]"

    def _part(self, name: str, indices: tuple[int, ...]) -> str:
        chosen = self._set(indices)
        return name if chosen == ":" else f"{name}[{chosen}]"

    def _read(self, gains: bool, limit: bool, replaced: set[str]) -> None:
        """Read the nominals, but those of `replaced` variables, which a draw replaces at all joints."""
        fields, forms = self.fields, self.forms
        for field, name in MODEL_FIELD.items():
            if field in fields and VARIABLE[field] not in replaced:
                self.lines.append(f"{VARIABLE[field]} = model.{name}[dof]")
        if gains:
            driven = [indices for form, indices in forms.items() if indices and form is not Form.MOTOR]
            whole = len(driven) == 1 and self._set(driven[0]) == ":" and not forms[Form.VELOCITY]
            if not whole:
                self.lines += ["kp = jnp.zeros(len(JOINTS))", "kd = jnp.zeros(len(JOINTS))"]
            for form, indices in forms.items():
                if not indices or form is Form.MOTOR:
                    continue
                chosen, act = self._set(indices), self._act(indices)
                if form is Form.DCMOTOR:
                    # Resistance and torque constant, in front of the controller's gains.
                    voltage = self.dialect.dcmotor is DcMotorDialect.VOLTAGE
                    if voltage or "strength" in fields:
                        self.lines.append(f"resistance = model.actuator_gainprm[{act}, 0]")
                    if voltage:
                        self.lines.append(f"constant = model.actuator_gainprm[{act}, 1]")
                    kp, kd = f"model.actuator_gainprm[{act}, 4]", f"model.actuator_gainprm[{act}, 6]"
                    if voltage:
                        kp = f"{kp} * constant / resistance"
                        kd = f"({kd} + constant) * constant / resistance"
                elif form is Form.POSITION:
                    kp, kd = f"model.actuator_gainprm[{act}, 0]", f"-model.actuator_biasprm[{act}, 2]"
                else:
                    kp, kd = "", f"model.actuator_gainprm[{act}, 0]"
                for name, text in (("kp", kp), ("kd", kd)):
                    if text and not (whole and name in replaced):
                        self.lines.append(
                            f"{name} = {text}" if whole else f"{name} = {name}.at[{chosen}].set({text})"
                        )
        if limit and "limit" not in replaced:
            self.lines.append("limit = model.actuator_forcerange[act, 1]")
        if "encoder_bias" in fields and "bias" not in replaced:
            self.lines += _nominal(
                "bias", [nominal_of(a, "encoder_bias") or 0.0 for a in self.actuators], "JOINTS"
            )
        if "strength" in fields:
            self.lines.append("strength = jnp.ones(len(JOINTS))")

    def _replaces(self, entries: Sequence[tuple[JointActuator, Randomization]]) -> bool:
        """Whether one draw gives every joint a value of its own."""
        kinds = {(e.operation, e.low, e.high, e.distribution, e.per) for _, e in entries}
        return len(entries) == len(self.joints) and len(kinds) == 1 and kinds.pop()[::4] == ("abs", "joint")

    def _draw(self, field: str, entries: Sequence[tuple[JointActuator, Randomization]]) -> None:
        def numbers(item: tuple[JointActuator, Randomization]) -> tuple[object, ...]:
            actuator, entry = item
            share = {"joint": None, "group": actuator.group, "env": ""}[entry.per]
            return (entry.operation, entry.low, entry.high, entry.distribution, entry.per, share)

        for key, members in grouped(entries, numbers):
            share = key[-1]
            indices = self._indices(actuator for actuator, _ in members)
            entry = members[0][1]
            # What shares a draw shares its key, whatever its range; joints on their own have one a set.
            scope = str(share) if share is not None else f"{entry.low!r} {entry.high!r} {indices}"
            number = self.keys.setdefault((field, entry.per, scope), len(self.keys))
            shape = "()" if share is not None else f"({len(indices)},)"
            drawn = _expression(entry, f"keys[{number}]", shape)
            chosen = self._set(indices)
            if field == "strength":
                self._times("strength", chosen, drawn)
                continue
            if field == "gains":
                self.lines.append(f"factor = {drawn}")
                for part in FACTORS["gains"]:
                    self._times(VARIABLE[part], chosen, "factor")
                continue
            name = VARIABLE[field]
            if self._replaces(entries):
                self.lines.append(f"{name} = {drawn}")
            elif chosen == ":" and entry.operation != "abs":
                sign = "*" if entry.operation == "scale" else "+"
                self.lines.append(f"{name} = {name} {sign} {_term(drawn)}")
            else:
                verb = {"scale": "multiply", "add": "add", "abs": "set"}[entry.operation]
                self.lines.append(f"{name} = {name}.at[{chosen}].{verb}({drawn})")
            if entry.distribution == "gaussian" and field != "encoder_bias":
                self.lines.append(f"{name} = jnp.maximum({name}, 0.0)")

    def _times(self, name: str, chosen: str, factor: str) -> None:
        product = f"{name} * {_term(factor)}" if chosen == ":" else f"{name}.at[{chosen}].multiply({factor})"
        self.lines.append(f"{name} = {product}")

    def _store(self, gains: bool, limit: bool, widened: bool) -> None:
        written, strength = self.written, "strength" in self.fields
        for field, name in MODEL_FIELD.items():
            if field in self.fields:
                self.lines.append(f"{name} = model.{name}.at[dof].set({VARIABLE[field]})")
                written.append(name)
        if gains and any(indices for form, indices in self.forms.items() if form is not Form.MOTOR):
            self._store_gains()
        if limit:
            both = "jnp.stack([-limit, limit], axis=-1)"
            self.lines += ["limit = limit * strength"] if strength else []
            self.lines.append(f"actuator_forcerange = model.actuator_forcerange.at[act].set({both})")
            written.append("actuator_forcerange")
        if widened:
            self.lines += [
                "# A joint's own force range would cap the limits that are raised.",
                "own = model.jnt_actfrcrange[jnt]",
                "own = jnp.stack([jnp.minimum(own[:, 0], -limit), jnp.maximum(own[:, 1], limit)], axis=-1)",
                "jnt_actfrcrange = model.jnt_actfrcrange.at[jnt].set(own)",
            ]
            written.append("jnt_actfrcrange")

    def _store_gains(self) -> None:
        fields, forms, lines = self.fields, self.forms, self.lines
        strong = "strength" in fields
        lines.append("actuator_gainprm = model.actuator_gainprm")
        affine = [form for form in (Form.POSITION, Form.VELOCITY) if forms[form]]
        if strong and affine:
            indices = tuple(sorted(i for form in affine for i in forms[form]))
            for name in ("kp", "kd"):
                self._times(name, self._set(indices), self._part("strength", indices))
        if affine:
            lines.append("actuator_biasprm = model.actuator_biasprm")
        for form in affine:
            act, kp, kd = (self._act(forms[form]), *(self._part(n, forms[form]) for n in ("kp", "kd")))
            if form is Form.POSITION:
                lines.append(f"actuator_gainprm = actuator_gainprm.at[{act}, 0].set({kp})")
                lines.append(f"actuator_biasprm = actuator_biasprm.at[{act}, 1].set(-{kp})")
                drawn = "encoder_bias" in fields
                nominals = [nominal_of(self.actuators[i], "encoder_bias") or 0.0 for i in forms[form]]
                if drawn or any(nominals):
                    bias = self._part("bias", forms[form]) if drawn else "bias"
                    if not drawn:
                        lines += _nominal("bias", nominals, self._part("JOINTS", forms[form]))
                    lines.append(f"actuator_biasprm = actuator_biasprm.at[{act}, 0].set(-{kp} * {bias})")
            else:
                lines.append(f"actuator_gainprm = actuator_gainprm.at[{act}, 0].set({kd})")
            lines.append(f"actuator_biasprm = actuator_biasprm.at[{act}, 2].set(-{kd})")
        indices = forms[Form.DCMOTOR]
        if indices:
            act, kp, kd = (self._act(indices), *(self._part(n, indices) for n in ("kp", "kd")))
            strength = self._part("strength", indices)
            if strong:
                # At a constant K the stall torque, and with it the whole line, goes with 1/R.
                lines.append(f"actuator_gainprm = actuator_gainprm.at[{act}, 0].set(resistance / {strength})")
            if self.dialect.dcmotor is DcMotorDialect.VOLTAGE:
                kp, kd = f"{kp} * resistance / constant", f"{kd} * resistance / constant - constant"
            elif strong:
                kp, kd = f"{kp} * {strength}", f"{kd} * {strength}"
            lines.append(f"actuator_gainprm = actuator_gainprm.at[{act}, 4].set({kp})")
            lines.append(f"actuator_gainprm = actuator_gainprm.at[{act}, 6].set({kd})")
        self.written += ["actuator_gainprm", *(["actuator_biasprm"] if affine else [])]


def _nominal(name: str, values: Sequence[float], joints: str) -> list[str]:
    """Lines that set a variable to numbers of the spec; equal ones as one number."""
    if len(set(values)) > 1:
        return _array(name, "jnp.array", values, " " * BODY)
    size = f"len({joints})" if joints == "JOINTS" else f"{len(values)}"
    return [f"{name} = jnp.full({size}, {py(values[0])})" if values[0] else f"{name} = jnp.zeros({size})"]


def _array(name: str, maker: str, values: Sequence[float], indent: str) -> list[str]:
    """`name = maker([...])` as lines, broken between entries where it is too long."""
    one = f"{name} = {maker}({py(list(values))})"
    if len(indent) + len(one) <= WIDTH:
        return [one]
    rows = textwrap.wrap(f"{', '.join(map(py, values))},", WIDTH - len(indent) - 8, break_on_hyphens=False)
    return [f"{name} = {maker}(", "    [", *(f"        {row}" for row in rows), "    ]", ")"]


def _term(text: str) -> str:
    """A drawn number as a factor or summand: a sum stands in brackets."""
    return f"({text})" if " + " in text.split("(")[0] else text


def _expression(entry: Randomization, key: str, shape: str) -> str:
    low, high = py(entry.low), py(entry.high)
    if entry.distribution == "gaussian":
        text = f"{low} + {high} * jax.random.normal({key}, {shape})"
        # A factor below 0 turns a torque round.
        return f"jnp.maximum({text}, 0.0)" if entry.field in FACTORS else text
    if entry.distribution == "log_uniform":
        return f"jnp.exp(jax.random.uniform({key}, {shape}, minval=jnp.log({low}), maxval=jnp.log({high})))"
    return f"jax.random.uniform({key}, {shape}, minval={low}, maxval={high})"
