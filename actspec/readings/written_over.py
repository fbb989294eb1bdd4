"""What programs write over of the models and configurations that they load, or take from elsewhere."""

from __future__ import annotations

import re
import sys
from bisect import bisect
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from actspec.simulators.classes import ISAACLAB, MJLAB

_PUT = rb"(?:\[[^=\n]{0,80}\])?\s*=(?!=)"
"""After the name of an array or a mapping, that something is put there; no line is gone through twice."""

_SCALED = rb"[^\n]{0,160}(?:[^\W\d]|\])[ \t]{0,8}\*"
"""The rest of a line that multiplies a figure: a draw about what it was, as of domain randomisation."""

_GROUP = rb"[\w.]+\.actuators\[[^\]\n]+\]"
"""A group of drives that a program takes out of a configuration."""

_CALL = rb"(?:[^()]|\((?:[^()]|\([^()]*\))*\))*"
"""What is inside of the parentheses of a call."""


def _sets(fields: bytes, state: bytes = rb"(?!)") -> re.Pattern[bytes]:
    """A program that sets one of these of an actuator group that it has found in a configuration, or of every one.

    As a task does in its `__post_init__`, by the group's name or by one of its own; what stands at the begin of a
    line a module does to its own, which is read. Or it makes another of the group (`.replace(stiffness=20.0)`), or
    writes it to the simulator: Isaac Lab's own classes do that to `self`, and its events to `asset`.

    Args:
        fields: Their names, without `_sim`.
        state: The name of what it is in Isaac Lab's `write_joint_..._to_sim`.
    """
    field = rb"(?:" + fields + rb")(?:_sim)?"
    item = rb"\." + field + rb"[ \t]*[-+*/]?=(?!=)"
    return re.compile(
        rb"^[ \t]+" + _GROUP + item + rb"|^[ \t]+(?:for[ \t]+(?:\w+[ \t]*,[ \t]*)?(?P<each>\w+)"
        rb"[ \t]+in[ \t]+[\w.]+\.actuators\.(?:values|items)\(\)[ \t]*:|(?P<one>\w+)[ \t]*=[ \t]*"
        + _GROUP
        + rb"[ \t]*$)"
        rb"(?:[^\n]*\n){1,20}?[ \t]+(?:(?P=each)|(?P=one))"
        + item
        + rb"|\bsetattr\(\s*"
        + _GROUP
        + rb"\s*,\s*[\"']"
        + field
        + rb"[\"']"
        rb"|^[ \t]+[^\n#]{0,160}\breplace\([^()]{0,160}\b" + field + rb"[ \t]*=(?!=)"
        rb"|(?<!self)(?<!asset)\.write_joint_(?:" + state + rb")_to_sim\((?!" + _SCALED + rb")",
        re.MULTILINE,
    )


_WRITES: dict[str, re.Pattern[bytes]] = {
    "urdf_effort": re.compile(
        rb"""\bcontrol(?:\.|["']\]\[["'])torque_limits\b"""
        rb"""|\w\[["']effort["']\](?:\.fill\(|(?:\[(?!\s*-?\d)[^\]\n]*\])?\s*=(?!=))"""
    ),
    "angle": re.compile(
        rb"""["']@?angle["'](?:\]\s*=|\s*[:,])\s*["']radian"""
        rb"""|\.compiler\.(?:angle\s*=\s*["']radian|degree\s*=\s*(?:False|0)\b)"""
    ),
    # Not `self.actuators`, as which Isaac Lab's own class has its drives; one group with another figure is `_sets`'.
    "actuators": re.compile(
        rb"\.replace\(" + _CALL + rb"\bactuators\s*=\s*\w+\s*[,)]"
        rb"|^[ \t]+(?:[^\n#]{0,160}\breplace\("
        + _CALL
        + rb"\bactuators\s*=\s*\{[^{}]{0,400}(?:Cfg\(|:\s*\w+\s*[,}])"
        rb"|(?!self\.actuators)[\w.]+\.actuators(?:\[[^\]\n]+\])?\s*=(?!=)(?![^\n]*\breplace\()"
        rb"|del[ \t]+" + _GROUP + rb")|(?<!self)\.actuators\.(?:update|pop)\(",
        re.MULTILINE,
    ),
    "joints": _sets(rb"joint_names_expr|target_names_expr"),
    "gains": re.compile(
        _sets(rb"stiffness|damping", rb"stiffness|damping").pattern
        + rb"|\.set_gains\([^()\n]{0,160}\bk[pd]s\s*=",
        re.MULTILINE,
    ),
    "efforts": re.compile(
        _sets(rb"(?:actuator_|joint_)?effort_limit|saturation_effort", rb"effort_limit").pattern
        + rb"|\bset_joint_effort_target\([^\n]{0,160}\bcl(?:ip|amp)\([^\n]{0,160},\s*-\s*\d",
        re.MULTILINE,
    ),
    "speeds": _sets(rb"(?:actuator_|joint_)?velocity_limit", rb"velocity_limit"),
    "armatures": _sets(rb"armature", rb"armature"),
    "positions": re.compile(
        rb"\bset_(?:joint|dof)_(?:velocity|effort)_targets?(?:_tensor)?\b"
        rb"|\b(?:(?:Joint(?:Velocity|Effort)|NonHolonomic|Ackermann)ActionCfg"
        rb"|(?:Differential|Holonomic|Ackermann)Controller|apply_wheel_actions)\("
        rb"|\bArticulationAction\([^()]{0,400}\bjoint_(?:velocities|efforts)\s*=(?!=|\s*None\b)"
        rb"|\bswitch_(?:control|dof_control)_mode\([^()\n]{0,160}[\"'](?:velocity|effort)[\"']"
        rb"|\bd_gains\b[^*\n]{0,80}\*\s*\(\s*[A-Za-z_][^()\n]{0,160}-\s*self\.dof_vel\b"
    ),
    "lags": re.compile(
        rb"\bsync_actuator_delays\b|\.set_lags\(|\._(?:current_)?lags" + _PUT + rb"|^class[ \t]+DelayBuffer\b"
        rb"|" + _sets(rb"(?:min|max)_delay|delay_(?:min|max)_lag").pattern,
        re.MULTILINE,
    ),
    "drives": re.compile(rb"\.add_(?:actuator|equality|tendon)\(|\bqfrc_applied\b" + _PUT),
    "draws": re.compile(
        rb"^(?:def|class)[ \t]+(?:randomize_(?:actuator_gains|joint_parameters)|pd_gains|effort_limits"
        rb"|joint_(?:damping|armature|friction))\b",
        re.MULTILINE,
    ),
    "classes": re.compile(
        rb"^class[ \t]+(?:" + "|".join(sorted({*ISAACLAB, *MJLAB})).encode() + rb")[ \t]*[(:]", re.MULTILINE
    ),
}
"""What a program writes over a file's figure when it has loaded it.

Forks of legged_gym clip at limits of the configuration in place of the URDF's effort, or put them in its place for all
joints (for one of them by number: a gripper's). What puts actuators that it made
into any configuration of Isaac Lab has their limits from elsewhere. To an MJCF's tree or spec some
give the angle that it lacks, as safety-gymnasium does. Joints get a speed or a torque to follow in place of a position;
lags are set by an event of mjlab at a reset; a spec gets more that drives joints. A folder that has a framework's class
in it, or a function that draws figures, has it as its owner changed it.
"""

_LOADS_FILES = (
    rb"\b(?:from_xml_path|load_model_from_path|mj_loadXML|mj_parseXML|launch_from_path|MjSpec\.from_file"
    rb"|mjcf\.from_(?:path|file))\(|\bMujocoEnv\b"
)
_LOADS_TEXTS = rb"\b(?:from_xml_string|load_model_from_xml|MjSpec\.from_string|mj_parseXMLString)\("
_LOADS = re.compile(_LOADS_FILES + rb"|" + _LOADS_TEXTS)
_OF_FILES, _OF_TEXTS = re.compile(_LOADS_FILES), re.compile(_LOADS_TEXTS)
"""A program that loads an MJCF: as the file stands, or the text that the program has of it."""

_WRITES_TO_MJCFS: dict[str, re.Pattern[bytes]] = {
    "integrator": re.compile(
        rb"""\bopt(?:ion)?\.integrator\s*=(?!=)[^\n]{0,120}(?:\b[23]\b|IMPLICIT)"""
        rb"""|\bintegrator["'\]\\]{0,4}\s*[=,:]\s*["'\\]{1,3}implicit""",
        re.IGNORECASE,
    ),
    **{
        name: re.compile(
            rb"""(?:\bdof_%(field)b|(?:\bj(?:oint|nt)?\w{0,40}|\))\.%(field)b)%(put)b(?!%(scaled)b)"""
            rb"""|(?:\.set\(\s*["']|\breplace\(\s*["'][^"'\n]{0,40})%(field)b(?:["']|=)|props\w{0,20}\[["']%(name)b["']\](?:%(put)b|\.fill\()"""
            % {b"name": name.encode(), b"field": field, b"put": _PUT, b"scaled": _SCALED}
        )
        for name, field in (("damping", b"damping"), ("friction", b"frictionloss"))
    },
    "step": re.compile(
        rb"\bopt(?:ion)?\.timestep\s*=(?!=)|\b(?:dof_armature|body_mass|body_inertia)%(put)b(?!%(scaled)b)"
        % {b"put": _PUT, b"scaled": _SCALED}
    ),
    "gains": re.compile(rb"\bactuator_(?:gain|bias)prm%b(?!%b)" % (_PUT, _SCALED)),
    "range": re.compile(rb"\b(?:jnt_range|jnt_limited|actuator_ctrlrange)" + _PUT),
}
"""What a program writes over of a model that it or another has loaded.

The integrator is an implicit one (mjtIntegrator 2 and 3), to the model, or to an MJCF's tree, spec or text. Damping and
dry friction go to MuJoCo's arrays, a spec or Isaac Gym's properties.
"""

_SPEAKS_OF = {
    "urdf_effort": (b"effort", b"torque_limits"),
    "angle": (b"radian", b".compiler."),
    "actuators": (b"actuators",),
    **dict.fromkeys(("joints", "speeds", "armatures"), (b"actuators", b"_to_sim")),
    "efforts": (b"actuators", b"_to_sim", b"set_joint_effort_target"),
    "positions": (b"elocit", b"ffort", b"olonomic", b"Ackermann", b"Differential", b"wheel", b"d_gains"),
    "lags": (b"sync_actuator_delays", b"lags", b"DelayBuffer", b"_delay", b"_lag"),
    "drives": (b"add_", b"qfrc_applied"),
    "draws": (b"randomize_", b"pd_gains", b"effort_limits", b"joint_"),
    "classes": (b"Cfg",),
    "integrator": (b"integrator",),
    "damping": (b"damping",),
    "friction": (b"friction",),
    "step": (b".timestep", b"dof_armature", b"body_mass", b"body_inertia"),
    "gains": (b"prm", b"actuators", b"_to_sim", b"set_gains"),
    "range": (b"jnt_", b"actuator_ctrlrange"),
}
"""Words that a text has which matches one of these forms: folders have hundreds of megabytes of others, to be passed
over fast."""

_EVENT = re.compile(
    rb"""\.events(?:\.(\w+)|\[["'](\w+)["']\])(?:\s*=\s*None\b|\.params(?:\.update\(|\[["'](?!asset_cfg)\w+["']\]\s*=(?!=)))"""
)
"""An event of Isaac Lab or mjlab that a program takes away, or draws of other figures."""

_BEGINS = re.compile(rb"^(?:class|def)[ \t]+(\w+)", re.MULTILINE)
_TO_SHOW = re.compile(rb"play|eval|test|demo|record", re.IGNORECASE)
"""Names of classes and functions whose settings nobody trains with."""

_SPEAKS_OF_MUJOCO = (b"mj", b"mujoco", b"dm_control", b"robosuite")
_SPEAKS_OF_OTHERS = (
    *(b"isaac", b"bullet", b"drake", b"sapien", b"mani_skill", b"raisim", b"dartpy", b"newton", b"genesis"),
    *(b"brax", b"loadmjcf", b"leggedrobotcfg", b"assetfilename", b"physx", b"gazebo", b"gz", b"ign"),
)
"""Likewise of programs of a simulator, in small letters."""

_RADIANS = re.compile(rb"""<compiler\b[^<>]*\bangle\s*=\s*\\?["']radian""")
_INCLUDES = re.compile(rb"<include\s+file\s*=")
"""A program that has an MJCF of radians as text, and one that includes another in what it has."""

_CLIPPED = (
    rb"(?:ctrl|tau|torques?|effort)(?:(?!ctrl|tau|torque|effort)\w)*(?:\[[^\]\n]*\])?\s*=\s*\w+"
    rb"\.(?:clip|clamp)\("
)
_CLIPS = re.compile(
    _CLIPPED + rb"(?:(?!" + _CLIPPED + rb")[^\n])*,\s*-\s*\d"
    rb"|\bclip_torques\s*=\s*\d"
    rb"|-\s*(?:1(?:\.0?)?\s*\*\s*)?(?:self\.)?_?(?:MAX_TORQUE|max_torque|max_tau|TORQUE_LIMIT|motor_torque_limit)S?s?\b"
)
"""A torque that a program clips at a number of its own before the model's limit can matter.

Of several beginnings on a line the last before the number counts, here as above: a long line is gone through once.
"""

_SAPIEN = re.compile(rb"\b(?:from|import)\s+(?:mani_skill|sapien)")
_FORCES_OF_DRIVES = re.compile(rb"force_limit\s*=(?!=)")
"""A program that gives drives of SAPIEN their largest forces, as ManiSkill's controllers do.

Source: SAPIEN 3, urdf_loader.py: of a joint's limit it takes the range, and no effort.
"""

_KINEMATICS = (
    rb"pinocchio|PyKDL|kdl\w*|urdf_parser_py|urdfpy|yourdfpy|ikpy|pytorch_kinematics|roboticstoolbox|mink|pink|placo"
    rb"|forwardkinematics|curobo"
)
_LIMITS_BY_URDF = re.compile(
    rb"\b(?:isaacgym|isaaclab|isaacsim|omni\.isaac|genesis|raisim\w*|effort_bounds|effortLimit)\b"
    rb"""|\w\[["']effort["']\]"""
)
"""Trainers that take a URDF's effort as the limit of the drive, and programs that optimise within it.

Elsewhere a URDF is mostly there for its links, and the drive's limit is another file's (docs/survey.md: of the efforts
that were not the published ones, readers would have acted on 15 of 18 beside a trainer, and on 4 of 15 without one).
"""


_IMPORTS_OF = rb"\b(?:import|from)[ \t]+(?:[\w.]+(?:[ \t]+as[ \t]+\w+)?[ \t]*,[ \t]*)*"
"""Before the name of a module, in Python."""

_OF_TODAY = re.compile(
    rb"\bimport[ \t][^\n]{0,80}(?<![.\w])mujoco\b|\bfrom[ \t]+mujoco[ \t.]|\bmujoco\.(?:Mj|mj_|mjx|viewer|Renderer)"
    rb"|\bMjSpec\b|\bmj_loadXML\(|mujoco/mujoco\.h|\busing[ \t]+MuJoCo\b|-m[ \t]+mujoco\b|\bgymnasium\.envs\.mujoco\b"
    rb"|(?<![\w/])(?:mjx|mjlab|dm_control|robosuite|mujoco_(?:playground|ros|warp))(?!\w*/)"
)
_OF_OLD = re.compile(rb"\b(?:import|from)[ \t]+(?:mujoco_py|gym\.envs\.mujoco)\b|\bmj_activate\(")
"""Programs of MuJoCo's own bindings, or of what is built on them, and of mujoco_py, which has a MuJoCo of its own; the
word `mujoco` is in an MJCF's text and in the paths of both. Isaac Gym, Bullet and Drake read an MJCF their own way.

Source: MuJoCo's changelog, 2.1: no key is activated any more.
"""

_COMPILES_INSIDE = re.compile(_IMPORTS_OF + rb"(?:genesis|brax)\b")
"""Simulators that have MuJoCo compile an MJCF, take damping, friction and gains of that, and step it their own way.

Source: genesis/utils/mjcf.py and brax/io/mjcf.py, `MjModel.from_xml_string`.
"""

_GAZEBO = re.compile(
    rb"\bgazebo_ros\b|\bros_(?:gz|ign)_|\b(?:gz|ign)[ \t]+(?:sim|gazebo)\b|\bgz[_-]?(?:server|sim)\b"
)
"""Programs that simulate with Gazebo: to it, as to MuJoCo, damping and friction are what the file says, beside a drive
that the effort limits.

Isaac Gym and Isaac Lab take a URDF's damping for the drive's, which is inside of the limit; Bullet takes neither its
friction nor its effort.
"""

_OTHER_PHYSICS = re.compile(
    _IMPORTS_OF
    + rb"(?:isaacgym\w*|isaaclab\w*|isaacsim|omni\.isaac|pybullet\w*|pydrake|sapien|mani_skill\w*|raisim\w*|dartpy"
    rb"|newton)\b|\bloadMJCF\(|\bLeggedRobotCfg\b|\bassetFileName\b|\bphysx[ \t]*:"
)
"""Programs of other simulators that read an MJCF, and configurations of Isaac Gym's; a text names one that it does
without."""

_ATTACHES = re.compile(rb"\.attach(?:_body|_frame|_child)?\(|\bcomposer\.")
_ADDS = re.compile(rb"\.add_(?:body|default|geom|joint)\(")
_ASSEMBLES = re.compile(rb"\bxml_path_completion\(")
"""A program that puts models together before MuJoCo compiles them: what one names may be in another; one that adds
what one lacks; and one of robosuite's kind, which takes the defaults out of every part (models/base.py)."""

_SIMULATORS = (
    rb"isaac\w*|omni\.isaac|ignition|gazebo|gz|ros2?_control|genesis|pydrake|raisim\w*|sapien|mani_?skill\w*|dartpy|webots"
    rb"|newton|brax|playground|vrep|coppelia\w*"
)
"""Other ones than MuJoCo and Bullet."""

_POSES = re.compile(rb"\b(?:mj_forward|mj_kinematics|mj_fwdPosition)\b")
"""MuJoCo computes where the bodies are, and no motion."""

_COMPUTES = re.compile(rb"\b(?:" + _KINEMATICS + rb")\b")
"""Libraries that know where the links are, and of dynamics what a program asks them for."""

_STEPS = re.compile(
    rb"\b(?:mj_step\w*|mjx\w*|mujoco_warp|mjwarp|mjlab|mujoco_py|mujoco[-_]?env|do_simulation|dm_control|pipeline_step|robosuite"
    rb"|physics\.step|sim(?:ulation|ulator)?\.step|pybullet\w*|stepSimulation|mujoco\.viewer\.launch(?:_from_path)?\(|"
    + _SIMULATORS
    + rb")",
    re.IGNORECASE,
)
"""A simulation that goes on: the steps of MuJoCo, what takes them for a program, and other simulators."""

_PLANS = re.compile(rb"^robot_cfg:[ \t]*\n(?:[ \t]*\n)*[ \t]+kinematics:", re.MULTILINE)
"""A robot as cuRobo is given it, in YAML: its links and their spheres, whatever simulator has a USD there too."""

_TOOL = re.compile(rb"\b(?:argparse|ElementTree|minidom|lxml|bs4)\b")
"""Libraries of programs that take files apart, or whose files the user names."""

_IMPORTS = re.compile(rb"^[ \t]*(?:import[ \t]+([^\n#;]+)|from[ \t]+([\w.]+)[ \t]+import)", re.MULTILINE)
_NO_SIMULATORS = frozenset(
    {"PIL", "bs4", "click", "coacd", "cv2", "lxml", "matplotlib", "noise", "numpy", "open3d", "pandas"}
    | {"pymeshlab", "rich", "scipy", "tqdm", "trimesh", "xacro", "yaml"}
)
"""What such a program may import besides the standard library."""

_FORCES = re.compile(rb"effort|torque|\btau\b", re.IGNORECASE)


def poses_alone(programs: Mapping[str, bytes]) -> frozenset[str]:
    """Programs that ask a model where its links are and for nothing else: what drives its joints is nothing to them.

    One that has MuJoCo compute poses counts where no program of the folder steps a simulation: another may step what
    this one loads.
    """
    plans = frozenset(path for path, text in programs.items() if _PLANS.search(text))
    steps = {path for path, text in programs.items() if path not in plans and _STEPS.search(text)}
    return plans | frozenset(
        path
        for path, text in programs.items()
        if path not in steps
        and ((not steps and _POSES.search(text)) or (_COMPUTES.search(text) and not _FORCES.search(text)))
    )


def works_on_files(text: bytes) -> bool:
    """Whether a program is a tool that takes a file apart or hands it on, and imports nothing that simulates."""
    modules = (name for plain, whole in _IMPORTS.findall(text) for name in (whole or plain).split(b","))
    packages = {name.strip().partition(b".")[0].partition(b" ")[0].decode("latin-1") for name in modules}
    return bool(_TOOL.search(text)) and packages <= _NO_SIMULATORS | sys.stdlib_module_names


_MUJOCO, _OLD, _INSIDE, _OTHER = "mujoco", "old", "inside", "other"
GAZEBO = "gazebo"
"""Simulators that a program is of: the MuJoCo of today and that of mujoco_py, `_COMPILES_INSIDE`, `_OTHER_PHYSICS`."""


def simulators_of(text: bytes) -> frozenset[str]:
    """The simulators that a program is of; none: it says nothing of one."""
    lower = text.lower()
    forms: dict[str, re.Pattern[bytes]] = {}
    if any(word in lower for word in _SPEAKS_OF_MUJOCO):
        forms = {_MUJOCO: _OF_TODAY, _OLD: _OF_OLD}
    if any(word in lower for word in _SPEAKS_OF_OTHERS):
        forms |= {_INSIDE: _COMPILES_INSIDE, _OTHER: _OTHER_PHYSICS, GAZEBO: _GAZEBO}
    return frozenset(name for name, form in forms.items() if form.search(text))


@dataclass(frozen=True, slots=True)
class Loader:
    """A program that loads models.

    Attributes:
        simulators: What it is of, as of `simulators_of`.
        reads: Whether it reads a model's text itself and hands that on, with what it puts in place of parts of it.
        attaches: Whether it puts models together.
        adds: Whether it adds to models what they lack.
    """

    simulators: frozenset[str]
    reads: bool
    attaches: bool
    adds: bool

    @classmethod
    def of(cls, text: bytes, simulators: frozenset[str]) -> Loader:
        """By its text."""
        reads = bool(_OF_TEXTS.search(text)) and not _OF_FILES.search(text)
        return cls(simulators, reads, bool(_ATTACHES.search(text)), bool(_ADDS.search(text)))

    def compiles(self, takers: frozenset[str]) -> bool:
        """Whether it has the MuJoCo of today compile models as they stand; see `nothing_to`."""
        if self.reads or self.attaches or self.adds:
            return False
        own = self.whose(takers)
        return _OLD not in own and (_OTHER not in own or bool(own & {_MUJOCO, _INSIDE}))

    def whose(self, takers: frozenset[str]) -> frozenset[str]:
        """The simulators that it is of, or may hand a model to."""
        return self.simulators if self.simulators - {GAZEBO} else takers


def nothing_to(loaders: Collection[Loader], takers: frozenset[str]) -> frozenset[str]:
    """What of a model is nothing to the programs that load it, as `written_over` calls it.

    Args:
        loaders: They; of a folder that has nothing of any simulator MuJoCo alone reads an MJCF.
        takers: Simulators of the programs that may take a model from one that says nothing of a simulator.
    """
    found = set()
    if not any(one.compiles(takers) for one in loaders):
        found.add("compiled")
    if all(one.attaches for one in loaders):
        found.add("step")
    whose = frozenset().union(*(one.whose(takers) for one in loaders))
    if whose & {_OTHER, _INSIDE} and not whose & {_MUJOCO, _OLD, GAZEBO}:
        found.add("step")
        if _INSIDE not in whose:
            found |= {"dynamics", "gains"}
    return frozenset(found)


def _events(text: bytes) -> Iterator[str]:
    """Events that a program sets otherwise, where it trains: `events.NAME`."""
    begins = [*_BEGINS.finditer(text)]
    starts = [one.start() for one in begins]
    for event in _EVENT.finditer(text):
        inside = bisect(starts, event.start())
        if not inside or not _TO_SHOW.search(begins[inside - 1][1]):
            yield f"events.{(event[1] or event[2]).decode()}"


def written_over(texts: Collection[bytes], simulators: frozenset[str]) -> frozenset[str]:
    """What programs write over, of `_WRITES`; of `_WRITES_TO_MJCFS` what each that steps an MJCF does; of URDFs efforts
    that are no drive's limit; whether none steps an MJCF as it stands; whether none takes joints as they are
    (`dynamics` of an MJCF, which MuJoCo alone reads where nobody says a simulator, and `urdf_dynamics`); and the events
    that they set otherwise (`events.NAME`).

    Args:
        texts: The programs.
        simulators: Of all of them.
    """

    def writers(name: str, form: re.Pattern[bytes]) -> Iterator[bytes]:
        words = _SPEAKS_OF[name]
        return (text for text in texts if any(word in text for word in words) and form.search(text))

    found = {name for name, form in _WRITES.items() if any(writers(name, form))}
    loads = [text for text in texts if _LOADS.search(text)]
    # What only looks at a model steps nothing.
    steps = [text for text in loads if _STEPS.search(text)] or loads
    for name, form in _WRITES_TO_MJCFS.items():
        # What loads a model itself writes to that one, and another program's is as it stands.
        writing = [*writers(name, form)]
        if writing and (not all(map(_LOADS.search, writing)) or all(map(form.search, steps))):
            found.add(name)
    found.update(event for text in texts if b".events" in text for event in _events(text))
    if any(_RADIANS.search(text) and _INCLUDES.search(text) for text in texts):
        found.add("angle")
    if any(
        _CLIPS.search(text) or (_SAPIEN.search(text) and _FORCES_OF_DRIVES.search(text)) for text in texts
    ):
        found.add("urdf_effort")
    if not any(map(_LIMITS_BY_URDF.search, texts)):
        found.add("urdf_limit")
    if any(map(_ASSEMBLES.search, texts)):
        # Its base is in radians.
        found |= {"angle", "compiled", "step"}
    if loads and all(map(_ATTACHES.search, loads)):
        found.add("step")
    if not simulators & {_MUJOCO, _OLD}:
        others = simulators & {_OTHER, _INSIDE}
        if others:
            found.add("step")
        if GAZEBO not in simulators:
            found.add("urdf_dynamics")
            if others == {_OTHER} or any(map(_COMPUTES.search, texts)):
                found.add("dynamics")
    return frozenset(found)
