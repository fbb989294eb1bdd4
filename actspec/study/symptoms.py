"""What people see, what it usually is, and the rule or command that tells: `actspec rule --symptom` and a page."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Cause:
    """One cause.

    Attributes:
        what: In a sentence.
        codes: Rules and findings that tell.
        command: That tells too; "": the audit.
    """

    what: str
    codes: tuple[str, ...] = ()
    command: str = ""


@dataclass(frozen=True, slots=True)
class Symptom:
    """One symptom.

    Attributes:
        name: In the words of who sees it.
        words: By which it is found too.
        causes: The most frequent first.
    """

    name: str
    words: tuple[str, ...]
    causes: tuple[Cause, ...]


SYMPTOMS = (
    Symptom(
        "It jumps in simulation and not on the robot",
        ("jump", "strong", "torque", "weak"),
        (
            Cause("the joint has no limit, or a placeholder such as 1e9", ("LIM101",)),
            Cause(
                "the motor's torque-speed line is missing, so that the full torque is there at any speed",
                ("DGN002",),
                "actspec compare SPEC",
            ),
            Cause("a knee's reduction is left out, or counted twice", ("GEA101",)),
        ),
    ),
    Symptom(
        "Joints are sluggish in one simulator",
        ("sluggish", "slow", "damping", "soft"),
        (
            Cause(
                "damping is counted twice: as kd, as joint damping, at the actuator",
                ("DMP101", "DMP104", "DMP105"),
            ),
            Cause("the armature is too large, or on the wrong side of the gear", ("GEA102",)),
            Cause(
                "friction takes the torque: viscous times speed, or a coefficient read as N*m",
                ("FRC106", "FRC102"),
            ),
            Cause("gains are per degree where they are read per radian, 57.3 times too soft", ("UNT103",)),
        ),
    ),
    Symptom(
        "Joints shake or buzz",
        ("shake", "oscillate", "buzz", "vibrate", "noisy", "unstable"),
        (
            Cause(
                "the step does not carry kd, which is integrated explicitly", ("STB101", "STB102", "CMP001")
            ),
            Cause("the armature is 0 or missing: a light link on a stiff drive", ("GEA104",)),
            Cause("a delay that training did not have", (), "actspec compare SPEC --delay 10ms"),
            Cause("torque faster than the motor", ("DGN004",), "actspec diagnose SPEC LOG"),
        ),
    ),
    Symptom(
        "Fast motions fail and slow ones work",
        ("fast", "run", "sprint", "kick", "speed"),
        (
            Cause("the torque at speed is not there on the robot", ("DGN002",), "actspec compare SPEC"),
            Cause("a speed limit that one file has and the other has not", ("SRC102", "LIM106", "VER104")),
            Cause("the command is faster than the motor", ("DGN005",), "actspec diagnose SPEC LOG"),
        ),
    ),
    Symptom(
        "A policy of Isaac falls over in MuJoCo",
        ("isaac", "mujoco", "sim2sim", "falls", "transfer", "different"),
        (
            Cause(
                "gains, limits or armatures of the two files differ", ("SRC101", "SRC103", "SRC104", "SRC105")
            ),
            Cause("actuators stand in another order than joints", ("ORD101", "ORD102")),
            Cause("friction is a coefficient in one and a torque in the other", ("FRC102",)),
            Cause("step, decimation or integrator differ", ("SRC107",), "actspec verify SPEC"),
        ),
    ),
    Symptom(
        "The robot moves, and with the wrong joints",
        ("order", "permutation", "wrong joint", "mirrored"),
        (
            Cause(
                "the order of the SDK is not that of the model",
                ("ORD101", "ORD102"),
                "actspec audit MODEL DEPLOY",
            ),
            Cause("left and right have other signs or figures", ("SYM101",)),
        ),
    ),
    Symptom(
        "A general actuator behaves oddly",
        ("general", "gainprm", "biasprm", "servo"),
        (
            Cause("its bias has another sign, belongs to another gain, or lacks its biastype", ("SGN102",)),
            Cause("its gain is negative: it pushes away from the target", ("SGN101",)),
            Cause("its command is in degrees, or is a torque", ("UNT101", "UNT102")),
            Cause("its words are those of another release of MuJoCo", ("VER102", "VER105")),
        ),
    ),
    Symptom(
        "There is never any overshoot",
        ("overshoot", "overdamped", "stiff"),
        (
            Cause(
                "damping of model and drive add up to far above critical",
                ("DMP101", "DMP105"),
                "actspec compare SPEC",
            ),
            Cause("the damping ratio has another meaning in this release", ("VER101",)),
        ),
    ),
    Symptom(
        "A step overshoots far more than on the robot",
        ("overshoot", "bounce", "underdamped"),
        (
            Cause("the damping of the URDF was dropped on import", ("DMP106",)),
            Cause("friction is missing in the model", ("FRC105",)),
            Cause("the armature is missing", ("GEA104",)),
        ),
    ),
    Symptom(
        "A joint is dead",
        ("dead", "limp", "no torque", "zero"),
        (
            Cause(
                "its limit is 0, or a pattern of the configuration leaves it out",
                ("LIM101", "CFG101", "CFG102"),
            ),
            Cause("a pattern matches nothing", ("ORD104",)),
            Cause(
                "its actuator's group is switched off: it has no kp in the table",
                (),
                "actspec audit FILES --ledger",
            ),
        ),
    ),
    Symptom(
        "A fit of a log gives nonsense",
        ("sysid", "identification", "fit", "identify"),
        (
            Cause(
                "the log is in degrees, has exchanged joints or a clipped command",
                ("SYS047", "SYS015", "SYS046"),
                "actspec sysid fit SPEC LOG -o R",
            ),
            Cause(
                "the log cannot tell: no torque, no gravity, too slow",
                ("SYS032",),
                "actspec sysid report R -o PAGE",
            ),
        ),
    ),
    Symptom(
        "A sweep is noisy, or tells something else each time",
        ("sysid", "chirp", "sweep", "noise", "bode", "spectrum", "frequency"),
        (
            Cause(
                "the joint moves little more than its encoder's noise",
                ("SYS011", "SYS043"),
                "actspec sysid fit SPEC LOG -o R",
            ),
            Cause(
                "dry friction bends a response that is too small",
                ("SYS052",),
                "actspec sysid fit SPEC LOG -o R --method frequency",
            ),
            Cause(
                "a sweep is too short for its frequencies: a multisine has all of them all the time",
                ("SYS051",),
                "actspec sysid design SPEC -o C --experiment multisine",
            ),
        ),
    ),
    Symptom(
        "Training diverges under domain randomisation",
        ("randomisation", "randomization", "dr", "diverges", "range"),
        (
            Cause("a range leaves the nominal value out, or scales a 0", ("DRN101", "DRN102")),
            Cause("a range reaches below 0, or is inverted", ("DRN106",), "actspec compile SPEC"),
            Cause("friction is drawn with the wrong field", ("DRN104",)),
            Cause("a range is wider than what was identified", ("DRN103",)),
            Cause(
                "at an end of a range the step does not carry the drive: state that end as the value",
                ("STB102",),
                "actspec compile SPEC",
            ),
        ),
    ),
    Symptom(
        "An actuator network does not load",
        ("network", "load", "torchscript", "onnx", "pt"),
        (
            Cause("the file is not what the manifest says", ("NET103", "NET104"), "actspec net inspect FILE"),
            Cause("it is a pickle, which is never read", (), "actspec net inspect FILE"),
        ),
    ),
    Symptom(
        "An actuator network is far too strong or too weak",
        ("network", "scale", "strong", "weak", "sign"),
        (
            Cause(
                "a scale, or the sign of the error, is another one", ("NET102",), "actspec net inspect FILE"
            ),
            Cause("a PD acts in its place, or beside it", ("SPC105",), "actspec audit FILES --ledger"),
            Cause("nothing clamps it at speed", ("NET106",)),
        ),
    ),
    Symptom(
        "An actuator network is bad on some joints",
        ("network", "joints", "rmse", "poor"),
        (
            Cause("these joints hardly move in the logs", (), "actspec net data SPEC LOG --policy POLICY"),
            Cause(
                "the policy goes where the logs did not",
                (),
                "actspec net evaluate SPEC LOG --network NAME.json",
            ),
            Cause("its samples are another time apart than the step", ("NET101",)),
        ),
    ),
    Symptom(
        "A delta action makes it worse, or does nothing",
        ("delta", "asap", "residual"),
        (
            Cause(
                "the limit `max_delta` cuts it, or there is nothing to remove",
                (),
                "actspec delta validate SPEC LOG --network N",
            ),
            Cause(
                "what is wrong is a figure, which is cheaper to set right", (), "actspec diagnose SPEC LOG"
            ),
        ),
    ),
)
"""In the order of the page."""


def symptoms_for(word: str) -> tuple[Symptom, ...]:
    """Those whose name, words or causes have a word in them; of several words those that have all."""
    parts = word.lower().split()
    found = []
    for symptom in SYMPTOMS:
        text = " ".join((symptom.name, *symptom.words, *(cause.what for cause in symptom.causes))).lower()
        if all(part in text for part in parts):
            found.append(symptom)
    return tuple(found)


def page() -> str:
    """The page of all symptoms, as Markdown."""
    lines = [
        "# What you see, and what it usually is",
        "",
        "Each cause names the rule that `actspec audit FILES` reports it with, or the command that tells. Begin with",
        "the audit, of all files of the robot at once: it takes a second and runs all rules.",
        "`actspec rule --symptom WORD` prints the symptoms that a word belongs to, `actspec rule CODE` what a code of",
        "the audit, of `diagnose` or of `compare` means.",
        "",
    ]
    for symptom in SYMPTOMS:
        lines += [f"## {symptom.name}", ""]
        for cause in symptom.causes:
            told = [f"[{code}]({_explained(code)})" for code in cause.codes]
            told += [f"`{cause.command}`"] if cause.command else []
            lines.append(f"- {cause.what[0].upper()}{cause.what[1:]}: {', '.join(told)}")
        lines.append("")
    return "\n".join(lines)


def _explained(code: str) -> str:
    """Where a code is explained, from the page."""
    pages = {"CMP": "compare.md", "DGN": "diagnose.md#messages", "SYS": "sysid.md#messages"}
    return pages.get(code[:3], f"../actspec/audit/rules/{code.lower()}.md")
