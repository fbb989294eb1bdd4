"""The checks that notice impossible numbers: what each judges and why its bound stands where it does; what one finds.

A bound is told with the extremes of published figures: the specs in robots/ and what `actspec import` writes of 270
files: unitree_mujoco, unitree_ros, unitree_rl_gym, and the wheels playground 0.2.0, gymnasium 1.4.0,
gymnasium-robotics 1.4.2, brax, example-robot-data, mjlab 1.6.0. Of 123 more, of dm_control, metaworld, robosuite and
myosuite, they report one, an arm made up for a test (`benchmarks/plausible.py`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, Diagnostic, Path, Severity, Span, dotted, listed
from actspec.ir import ROUNDED, JointActuator, Origin, Quantity
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.spec.document import Document, SourceMap

_IS_NUMBER = re.compile(r"\s*[-+]?\.?[0-9]")
_OF_SPEC = (Origin.AUTHORED, Origin.IDENTIFIED, Origin.DERIVED)


@dataclass(frozen=True, slots=True)
class Check:
    """One check.

    Attributes:
        code: Its code.
        name: Its name.
        judges: What it reports.
        because: Its bounds, and what published robots have.
    """

    code: str
    name: str
    judges: str
    because: str


CHECKS = (
    Check(
        "SPEC135",
        "continuous-above-peak",
        "Continuous torque above peak torque, or a tiny part of it.",
        "An error above it: the thermal limit is the lower of the two. A warning below a fiftieth of it: published "
        "are 0.1 to 1, and mN*m as N*m are a thousandth.",
    ),
    Check(
        "SPEC180",
        "torque-above-stall",
        "Peak or continuous torque above stall torque, the end of the torque-speed line, or a tiny part of it, or a "
        "stall torque that is just the gear apart from it; a brake torque far from the drive torque.",
        "A peak above the line is a warning from 2 % on and an error from 3 times on; a continuous torque above it is "
        "an error. The largest peak in robots/motors is 1 times the stall torque. A warning for a continuous torque "
        "below 0.004 and a peak below 0.015 of it: windings have 0.02 (EC-i) and 0.05 (AK80-64) and more, and mN*m as "
        "N*m are a thousandth. Stall over peak torque that is the gear to 0.5 %, if it is above 20 or the figure of "
        "the other side has three digits. Of a curve a warning for a brake torque above 3 times the drive torque or "
        "below a third (1.16, Unitree Go2HV, to 1.79, W4010-25).",
    ),
    Check(
        "SPEC181",
        "torque-constant",
        "Torque constant times current far from the torque, or times no-load speed far from the voltage; a speed "
        "constant in its place; a nominal current above the peak current.",
        "N*m/A and V*s/rad are one unit, as N/A and V*s/m. A warning outside of 0.4 to 2.5 times the torque: "
        "amplitudes for effective values, phases for lines, losses and saturation make up to 2. A stall torque that "
        "stands alone is a winding's, unless it is in kgf*cm, to 1 %, what constant, current and effort limit agree "
        "on. Outside of 0.2 to 3 times the voltage: field weakening and the load of the gear. "
        "robots/motors/feetech.yaml has 0.97 of it. From 1.6 times on where currents and voltage say so by one "
        "factor, to 1.15, with which it is the inverse of the number that stands there: Kv in rpm/V; or the root of "
        "three, to 1.06, as of a phase. Of any motor 1 to 1000 V and 5 mA to 2000 A (chosen: from micro motors to "
        "those of vehicles).",
    ),
    Check(
        "SPEC182",
        "gear-below-one",
        "A gear ratio or a reduction below 1, or stages that make one: the output would turn faster than the rotor, "
        "or the joint than the output; one stage of several that does. Teeth that are no whole number; a planetary "
        "stage that nobody can make. A reduction, or a transmission of ratios, that is the motor's own gear again, as "
        "many motors for one joint as there are joints. A gear that dry and viscous friction of its joints contradict. "
        "A motor without a reduction whose joint has more torque, and in the robot's file as much squared more "
        "armature.",
        "A warning; an error below 0.05, as no joint is geared up twenty times. Published: gears of 5 to 345, "
        "reductions to 2.2. One stage below 0.8 of several that reduce together, unless the robot's file has the "
        "torque. A planetary stage above 15: three planets touch each other from 14.9 on (published: 4.5). A reduction "
        "of 5 or more that is the motor's gear ratio to 1 %, and 3 motors or more per joint that are as many as the "
        "joints of the group or the robot, or more than 8 (published: 2), but for a torque that the file has. Where "
        "both frictions are too large by FRC101 and FRC106 (3 times the torque) and of the motor's figures the gear "
        "alone explains it, with its point elsewhere. A torque from 1.2 times on whose square the armature is to 5 %.",
    ),
    Check(
        "SPEC183",
        "beyond-any-motor",
        "Torque or power at the gearbox output beyond any motor of a robot, of the robot's size, or of its own "
        "voltage, gear and peak torque; force behind a transmission; an effort limit without a motor that the joint's "
        "other figures contradict together, or one many times that of every other hinge.",
        "A warning above 100 kN*m (chosen: the strongest arms hold 2300 kg at 3.7 m, 84 kN*m; axes of a KR 210 have "
        "11 kN*m, slews of excavators 400), or 1000 N*m behind more than 1000 turns (gears of large arms have to 350, "
        "and 9 N*m are published behind 1462); above 200 kW (peak torque times no-load speed; chosen, a KR 210 has 24 "
        "kW), or 20 kW where the voltage is below 100 V. A torque that the robot's file agrees with, to a quarter, is "
        "none too large. An error above 1e6 N*m or 1 MW (chosen). Largest published of legged and humanoid robots: "
        "494 N*m (Apollo's hip, playground) and 360 N*m at 20 rad/s, 7.2 kW (H2, unitree_ros). A stall torque beside "
        "a peak torque, or torque constant and peak current, is a winding's, and may be ten times that, or 10 kN*m. "
        "Chosen: 300 kN and 3000 N*m behind a "
        "transmission. Of robots with six hinges or more also the effort limit of a joint with a motor that would "
        "hold the whole robot on a lever of more than 4 m, an error from 40 m (1.55 m, arm Z1), and of a robot of four "
        "joints and 5 kg or more that of a slide which would lift it 75 times over, an error from 750 (21, roller "
        "screws of a leg; 37, three linear axes). Of a joint without a "
        "motor the effort limit, where three of four figures say so: above 9 kW at the velocity limit (8.4, GR1), "
        "above 31000 rad/s^2 of the armature (30000, H1), an error above 4 rad by kp (3.4, but for fingers and one "
        "ankle), the whole robot on a lever of more than 1.8 m (1.7, Aloha; of 6051 published hinges none has two of "
        "these); or above 700 N*m where one of its other figures is of a usual size and impossible beside it; or one "
        "below 5 rad/s^2 of the armature that kp asks for at less than 3.5 mrad. An effort limit above 700 N*m, and no "
        "power of ten, that is 8 times that of every other hinge of the spec and that kp asks for at 3 rad or more (of "
        "355 published robots only placeholders are).",
    ),
    Check(
        "SPEC184",
        "speed-of-side",
        "A no-load speed of an unlikely size for the side that it is stated on, or rpm read as rad/s; a velocity "
        "limit far above it, or beyond any joint where there is none; either of them far from the speed that the "
        "robot's file states; a transmission that is faster than any joint, or a lever arm of "
        "metres; a linear motor of a speed or power that none has; a Stribeck velocity that the joint never reaches.",
        "Behind a gear of 3 or more a rotor below 60 rad/s (or 12 times the gear, if less; 40 rad/s by the speed of "
        "the output), an output above 120 rad/s; a rotor above 8000 rad/s, or 150000 rpm below 1 mN*m (micro motors "
        "are sold with 120000); behind a screw, a pinion or a lever a slide above 30 m/s and a hinge above 120 rad/s "
        "(chosen: belts reach 10 m/s; a screw above 5, as fast ones reach 2.5), "
        "as a motor that travels, or one of 200 kW (20 kW below 100 V); a lever arm "
        "above 3 m (chosen: large excavators have 1); a joint, behind reduction and transmission, above 1000 rad/s "
        "divided by the root of its torque in N*m (3000 without a gear, of a wheel, or where constant and voltage make "
        "the speed or, without a constant, the power is no more than 100 A of the voltage; hobby motors have 1081 and"
        " 1185); a velocity limit above 3 times the motor's speed at the joint, "
        "and where none is known of a hinge above 200 rad/s or that 1000 rad/s, of a slide above 30 m/s; where the "
        "robot's file has it too, from 3 times that. Published: rotors of 180 (Go2) to 2044 rad/s (STS3215), outputs "
        "to 40 rad/s, speed times root of torque to 560 (shoulder of the Qinglong, which has 110 rad/s; ankle of the "
        "H2 100.7), velocity limits to 1 times the speed. From 5 times above or below the file's limit on, where a "
        "slip in one figure makes them agree to a quarter (by a factor of 2 from 30 times above on), and a limit "
        "above 30 times it in any case; where no slip does, a motor that is 5 times slower than every joint of a "
        "group has it, as a slower joint is often chosen; 0, powers of ten and figures of one digit are placeholders. "
        "Of a motor whose gear is not stated, below 700 N*m, a no-load speed below 0.02 rad/s, or below 0.3 where the "
        "error at which kp asks for the effort limit takes more than 1.5 s at it (legs: 0.1 s) or the motor has 8.4 V "
        "and 10 N*m at most (servos); not where the robot's file or the motor's inertia has it (2 ms to that speed; "
        "published: 5). Of a servo of 14.8 V with a stated gear one of 0.03 to 0.3 to which its torque turns its rotor "
        "in 0.5 ms. A velocity limit in deg/s or rpm below 1 rad/s whose number other hinges have in rad/s, or the "
        "joint's motor to 1 %; one of three digits also to a quarter, where all others are in rad/s and 5 times it. "
        "A stated Stribeck velocity from the motor's no-load speed, else the velocity limit, on (published: to 1 "
        "rad/s).",
    ),
    Check(
        "SPEC185",
        "rotor-inertia",
        "A rotor that its own torque would turn too slowly or too fast: inertia in another unit or on the other side.",
        "Torque over inertia at the rotor from 1500 to 5e6 rad/s^2 (from 2500 by a peak torque behind a gear of "
        "3, from 500 by a continuous torque that stands alone; to 1e6 by a peak of 1 N*m or more, to 5e7 below 1 "
        "mN*m), at an output without a stated gear from 1 to 1e6; the peak torque counts where it is stated, or else "
        "that of the peak current. A direct drive that reaches its speed in 0.1 s is not too heavy "
        "(hub motors of wheels: 0.03 s). Also a rotor that takes more "
        "than 0.5 s to its own speed without load (0.005 to 0.052 s; 1 s by a continuous torque that stands "
        "alone; 5 s without a gear above 1000 rad/s, where it is a spindle, chosen). A warning outside, an error "
        "outside of a hundred times that. Published: 29400 (Unitree 4010) to 125000 (7520) at the rotor, 1451 "
        "by the continuous torque (maxon EC 90 flat), 114 (STS3215) to 8640 at the output.",
    ),
    Check(
        "SPEC186",
        "time-scale",
        "A time step, control period, delay, cutoff or bandwidth that is no robot's: seconds for milliseconds, a rate "
        "in Hz as `decimation`; draws more often than commands.",
        "Steps of 20 us to 40 ms (published: 0.1 to 33 ms), control periods to 0.5 s, delays of 20 us to 0.25 s "
        "(published: to 12.5 ms; 0 is none), also drawn ones, cutoffs of 0.2 Hz to 5 kHz, bandwidths of 2 Hz to 20 "
        "kHz: a warning outside, an error from ten times on, but for a delay of nearly none. Where joints or groups "
        "are called like those of legs also policies below 10 Hz, and below 20 Hz where `decimation` is a usual rate "
        "that the step gives with a whole number of steps (published: 20 to 200 Hz; arms have 3 Hz and more). "
        "`every` that ends below the control period; 0 is at each command.",
    ),
    Check(
        "SPEC187",
        "limit-of-motor",
        "An effort limit far from what the motor gives at the joint, or above the end of its torque-speed line; or a "
        "torque far from the limit of the robot's file.",
        "A warning above 3 times its peak torque, or the largest of its torques where none is stated, an error above "
        "30 times, and above 1.25 times the end of the torque-speed line at level dc_motor (chosen: a gear's "
        "efficiency of 0.8 in one of the two makes so much), twice the end at others; a warning below an eighth of "
        "the least of peak and continuous torque, or a fiftieth of a stall torque that stands alone and of what it "
        "gives behind a transmission, and where it is peak or continuous torque at the rotor to the digit. Published:"
        " 0.59 (STS3215) to 1.003 (Spot's hips). A torque against the robot's file as SPEC184, or with a line of "
        "another motor exchanged where both are more than 1.25 times off and agree to 1.05 then; of one motor stall "
        "torque and no-load speed, where the limit is the number of the speed and the line begins below it. An effort"
        " limit from 5 times above the file's on where it has no source and no motor's torque is known, from 30 times"
        " on in any case; below it only what is a power of ten off or, by the gear ratio, the rotor's, to 2 %: less "
        "is often right. Where no slip explains a motor's torque, it is told if it is 5 times off for every joint of "
        "a group, and those are given it. Behind a lead or radius, force and speed that are both off by the same "
        "factor of 1.5 or more, one above and one below, are the length's. 0, powers of ten and one figure for all "
        "joints are placeholders of a file.",
    ),
    Check(
        "SPEC188",
        "range",
        "A range of randomisation that nobody draws from: a factor in per cent, values as factors, three times a "
        "motor's torque, an encoder's error in degrees, values far from the nominal one or below 0, dry friction up to "
        "the effort limit; such an error as the nominal one; a standard deviation many times its value.",
        "A warning for a factor above 10 (published: 3, on kd), or above 3 on strength and effort limit (1.25), for "
        "factors above 3 that are values with the nominal one between them, for "
        "offsets that bring a number without a sign below 0 where no target draws them (else they are RND004), for "
        "values that are all above ten times the nominal "
        "one or below a tenth of it, for dry friction that can be drawn (by scale, add or abs) at the effort limit of "
        "a hinge, for an encoder that is off by more than 0.25 rad or 0.1 m (0.02 rad), and for a stated standard "
        "deviation above ten times its value (chosen: of what a fit hardly sees it is 1 to 3).",
    ),
    Check(
        "SPEC189",
        "efficiency",
        "A gearbox that passes on less than a tenth of the torque.",
        "A warning below 0.1: lead screws and worm gears have 0.2 to 0.4.",
    ),
    Check(
        "FRC101",
        "friction-not-below-effort",
        "Dry friction, also break-away friction, that takes half of the effort limit or more.",
        "A warning from 0.5 on, an error from 2 times on; of break-away friction below the limit only where it is 5 "
        "times the kinetic one (chosen: it is 1.1 to 3 times). Published: to 0.36 (head of the TIAGo), and two robots "
        "whose URDF is wrong: Allegro (12 of 15 N*m in a finger), TALOS (1 of 1 N*m in the gripper). Of frictions "
        "that one number of their motor explains, that number.",
    ),
    Check(
        "FRC106",
        "viscous-takes-the-limit",
        "Viscous friction that takes half of the effort limit at the motor's no-load speed, or, at another level than "
        "`dc_motor`, three times the limit there or all of it at a stated velocity limit; of the motor's peak torque, "
        "where that is more.",
        "Without a peak torque the stall torque is what the drive gives, below ten times its other torques. A warning "
        "from 0.5 times the limit on where the torque-speed line acts. Published: to 0.43 (ANYmal D, PACE). Elsewhere "
        "from 3 times on, as a joint may never come near that speed (a sound belt takes 1.24), and from 1 times on at "
        "a velocity limit that the spec states, but for powers of ten and for friction that the robot's file has as "
        "well: limits of published URDFs are often placeholders, of 100 or 1e4 rad/s, and make up to 3333 times.",
    ),
    Check(
        "SPEC190",
        "pose-outside-the-range",
        "A default position outside of the joint's range, also the 0 of a joint that `default_pose` leaves out, or "
        "beyond a full turn where it has none; a command range many times as wide, in another unit, outside of the "
        "joint's range or without its default position; a range of `robot.joints` in degrees or mm, or in rad as "
        "degrees.",
        "A warning from 0.05 rad (5 mm) beyond an end on, an error from the width of the range, or pi, beyond it. "
        "Published: to 0.02 rad beyond (calf of the B2). Of a joint that is left out only where `default_pose` has "
        "others, and positions are commanded. Two that are each inside of the other's range are told as exchanged. "
        "A range of position commands above 12 times the joint's own "
        "(chosen: degrees are 57 times, mm 1000), or its own in degrees; powers of ten for both ends are "
        "placeholders. Also one that is 0.05 rad (5 mm) from the joint's range, or from a default position inside of "
        "that (of 4549 published servos one by 0.016 rad, and one of 1942 with a position by 0.012). Of a hinge "
        "without a range: more than 12 turns that are one at most in degrees. Of a range of `robot.joints` more than "
        "4 turns that are one at most in degrees, and more than 20 m (chosen); one in deg whose ends are both a "
        "multiple of pi/12, to 0.002. Of speeds and torques a range above 12 times what the joint has, or 5 times "
        "where rpm or deg/s bring it below that (chosen).",
    ),
    Check(
        "SPEC191",
        "armature",
        "An armature that is not the motor's inertia at the joint, or far from the links, the torque or the other "
        "joints of its group.",
        "Outside of 0.3 to 3 times what rotor inertia and gears give; of an identified one, which holds what the "
        "motor's figures lack, of 0.1 to 10 times (fitted to a Go2: 2.8 to 5.7); above 300 times where no model has "
        "the links, as what is coupled to the rotor may be meant. Without those: effort limit, or the motor's peak "
        "torque (as FRC106), over armature below 5 (unless the motor's speed is reached in 0.2 s) or, but of a motor "
        "that travels, above 3e5 rad/s^2 (where the links are not known 3e6 below 20 N*m; published of 20 N*m and "
        "more: to 2e4); from 50 times the links' inertia (2e-3 kg*m^2 or more) on where it is below 30, too, from 300 "
        "times on in any case (1000 where it follows from rotor and gear: a bare flange of a KR 210 has 507), or from "
        "ten times above or below three or more other joints of its group, which are alike, on. Also one that the "
        "motor's torque turns in more than 0.5 s to its speed (rotors: to 0.052 s), where it is ten times the links' "
        "inertia or, of unknown links, kp swings it alone below 6 rad/s. What is just rotor inertia times gear squared "
        "is the motor's matter (SPEC185), and judged by the 300 or 1000 times alone: an exoskeleton's wearer is in no "
        "model. Published: 10 (fingers of the H1) to 30000 rad/s^2, and 124 times the links at 150 rad/s^2 "
        "(gymnasium's ant).",
    ),
    Check(
        "SPEC192",
        "gains",
        "kp and kd exchanged, or given per degree, per mm or times 57.3, by each other, the effort limit, natural "
        "frequency and damping ratio, a viscous friction by the last; a kd alone by effort limit, "
        "dry friction and the joint's speed; both gains 0.",
        "kd over kp above 1 s (published: 0.0071 to 0.25 s); a natural frequency outside of 0.15 to 100 Hz, a damping "
        "ratio outside of 0.015 to 60 or a part of the effort limit outside of 0.001 to 5 that a gain is derived "
        "from. Of joints with a motor also kd over kp below 0.5 ms (0.3 ms without friction), a kp that needs an "
        "error of more than 50 rad for the effort limit (2.2 rad), or of less than 0.015 rad with kd over kp below 2 "
        "ms (an so101 with 998 N*m/rad); and, by the inertia of links and armature at the reference pose: below 6 "
        "rad/s where the limit needs an error of more than 10 rad, or dry friction holds one of 0.1 rad and viscous "
        "friction is above kd, or below 1 rad/s, or below 15 rad/s where a rotor behind its gear is 10 times the links "
        "and the limit needs more than 4 rad, from 6 rad/s on unless the robot's file has the limit (published: 6.2 "
        "rad/s and up; an error of 25 rad at most, at 16 rad/s); above 150 rad/s where it needs less than 0.06 rad, of "
        "1e-3 kg*m^2 or "
        "more (95 rad/s; 203 at 0.1 rad), but to 500 rad/s where both gains have two digits and damp it with 0.5 to 3 "
        "(machines); a damping ratio below 0.015 with friction (0.064) or above 60 (12). Servos "
        "without a motor are often a simulator's own: Isaac Lab's G1 has arms of 1482 rad/s. Of them only the 0.015 "
        "rad are noticed, with kd over kp below 0.1 ms (0.4 ms, an so101 with 1600 N*m/rad), but for powers of ten "
        "and what the robot's file has as well. Of joints of 10 N*m or more, with a motor or without: a kp that needs "
        "less than 0.03 rad for the effort limit with kd and friction over kp below 0.8 ms (1.9 ms, a Talos), and one "
        "that needs 0.3 rad or more with kd over kp below 1 ms, and below 5 ms with friction (7.1 ms, an ANYmal D). "
        "Without a motor an error of more than 50 rad or 10 m is noticed where dry friction is stated (25 rad, an "
        "ankle), else of 1000 rad or 200 m (250 rad, a gripper's finger), but for limits of 100, 1000 and so on; where "
        "dry friction is stated, also more than 10 rad below 10 rad/s and 5 rad below 5 (22 rad at 13 rad/s, a YAM's "
        "wrist; 1.6 below 6). Of a slide with a range also an error of more than 25 times that with a motor or below "
        "6 rad/s (17, fingers of an X5), else 150 times (60, fingers of a Panda). Where nobody states the armature of "
        "a motor, nothing is told that an armature would explain which it turns to its speed in 0.052 s; of "
        "slides also 0.1 mm with kd over kp below 0.1 ms. Powers of ten as kp or kd are placeholders of a rigid joint "
        "where neither motor nor dry friction is stated. Where both gains are 57.3 times numbers of two digits, the "
        "150 rad/s are noticed without a motor, too. A kd without kp, or whose kp is unknown, that asks for the "
        "effort limit at less than 0.01 rad/s or 1 mm/s (0.07 rad/s); for a command of a speed also one that gives "
        "less than the joint's dry friction, or a thousandth of the effort limit, at the fastest speed; and of a "
        "position, of joints of 10 N*m or more, below 1e-4 s/rad of the limit (6.7e-3). An error of more than pi or 1 "
        "m that a kp is derived from.",
    ),
    Check(
        "SPEC193",
        "action-scale",
        "An action scale of which one unit reaches beyond every limit, or does not overcome dry friction.",
        "A command of a position: more than twice the joint's range, and kp times it more than twice the effort limit "
        "(published: 0.84 and 0.75 times). Of a speed: ten times the fastest that the joint turns. Of a torque: ten "
        "times the effort limit. A warning; an error from twenty times that. A warning also where kp times the scale "
        "is below the joint's own dry friction: policies give about one unit.",
    ),
    Check(
        "SPEC194",
        "not-of-its-source",
        "A gain, limit, armature or friction that names the robot's file as its source, which says another number.",
        "A warning from 5 times above or below what the file says on (chosen: a smaller difference may be a number "
        "that was tuned). A source is the robot's file if its `page` has the name of `robot.model`, as `actspec "
        "import` writes it.",
    ),
    Check(
        "SPEC195",
        "jacobian",
        "A linkage's table of which a row does not fit the others, a pose far outside of the joint's range, or a "
        "limit by a linkage that is far off the robot's file.",
        "Of four rows or more: a pose that is out of the order of all others and in it by another unit, sign or power "
        "of ten; a Jacobian of another sign than all others, or a power of ten off (to a factor of 1.6) what the rows "
        "beside it make on a straight line. A pose from 0.3 rad and from a quarter of the range beyond an end on. A "
        "limit from 5 times on where it is a power of ten off or another linkage of the motor agrees with the file "
        "(to a quarter), from 30 times above in any case (Spot's table: 1.0).",
    ),
    Check(
        "NET017",
        "network-manifest",
        "A number of a network's manifest that its joints contradict: samples seconds apart, training data in degrees "
        "or with torques that no joint gives, a scale of 0.",
        "A tap period above 0.5 s, as of control periods (known networks: 5 to 20 ms). Of the training data, by its "
        "0.999 quantile: position errors above 3 times the widest range of the joints and above a full turn, of "
        "slides 12 times the range; velocities above 10 times the fastest speed. Torques of the validation above 10 "
        "times the largest of the joints' (chosen: degrees are 57 times, mN*m 1000). A negative scale may be right: a "
        "network that was trained on measured - target needs it.",
    ),
    Check(
        "NET018",
        "network-weights",
        "A network whose weights contradict its manifest or its joints: a torque away from the target, velocities and "
        "errors exchanged, a torque that no joint gives, or hardly any.",
        "`compile`, `verify` and `net inspect --spec` run it at rest. A torque away from the target, near 0 and over "
        "3 rad. A velocity that is driven on by more than 0.01 s times the stiffness (drives damp by 0.0071 to 0.25 "
        "s). Damping above 1 s times the stiffness, as SPEC192. An error or velocity of the training data, by its "
        "0.999 quantile, that gives more than 10 times the largest torque of the joints; without a stated range an "
        "error of 3 rad, or of the joints' range if less, that gives more than 1000 times. Less than a hundredth of "
        "the least effort limit up to 3 rad (chosen: dry friction alone is that, mN*m as N*m are a thousandth); "
        "powers of ten in the robot's file are placeholders.",
    ),
)
"""Every check, in the order in which they are explained."""

BY_CODE: Mapping[str, Check] = {check.code: check for check in CHECKS}


@dataclass(frozen=True, slots=True)
class Doubt:
    """A number that can hardly be right.

    Attributes:
        code: Of its check.
        message: What it implies.
        where: Dotted path of the number.
        span: Where it is written.
        help: What was probably meant.
        judged: Where the other numbers are written that were judged with it.
        error: Nothing could be right.
        blamed: Where other numbers are written that are wrong as well, by the same mistake.
    """

    code: str
    message: str
    where: str
    span: Span | None
    help: str | None = None
    judged: tuple[Span | None, ...] = ()
    error: bool = False
    blamed: tuple[Span | None, ...] = ()

    @property
    def diagnostic(self) -> Diagnostic:
        """What is reported of it."""
        severity = Severity.ERROR if self.error else Severity.WARNING
        return Diagnostic(self.code, severity, self.message, self.where, self.span, self.help)


@dataclass(frozen=True, slots=True)
class Found:
    """A doubt about one joint.

    Attributes:
        doubt: The doubt.
        joint: Name of the joint.
        size: How far the number is from its bound.
        derived: One of the numbers follows from others, such as the motor's.
    """

    doubt: Doubt
    joint: str
    size: float
    derived: bool = False


def is_stated(quantity: Quantity | None) -> bool:
    """Whether the spec has the number, or what it follows from."""
    return (
        quantity is not None
        and quantity.value is not None
        and quantity.span is not None
        and quantity.origin in _OF_SPEC
    )


def found_at(
    joint: JointActuator,
    code: str,
    where: str,
    size: float,
    message: str,
    help: str | None,
    number: Quantity,
    *others: Quantity | None,
    error: bool = False,
) -> Found:
    """A doubt about a number at a joint.

    Args:
        joint: The joint.
        code: Of the check.
        where: Dotted path of the number.
        size: How far it is from its bound.
        message: What it implies.
        help: What was probably meant.
        number: The number; it is told where it is written.
        others: What was judged with it.
        error: Nothing could be right.
    """
    known = [other for other in others if other is not None]
    judged = tuple(other.span for other in known)
    derived = any(item.origin is Origin.DERIVED for item in (number, *known))
    return Found(Doubt(code, message, where, number.span, help, judged, error), joint.joint, size, derived)


def in_file(*quantities: Quantity) -> Quantity | None:
    """Of a quantity and of what it was stated in place of: the one that the robot's file has."""
    return next((one for one in quantities if one.origin is Origin.MODEL), None)


def is_files(quantity: Quantity) -> bool:
    """Whether the robot's file says a number as well."""
    said = in_file(*quantity.lost)
    return (
        said is not None
        and said.value is not None
        and math.isclose(said.value, quantity.require(), rel_tol=0.01)
    )


def shown(quantity: Quantity, digits: int = 4) -> str:
    """A number with its unit, as a message has it."""
    return format_quantity(quantity.value, quantity.unit, digits)


def by_number(found: Iterable[Found]) -> Iterator[Doubt]:
    """One doubt for each number: that of its worst joint, with the names of all."""
    numbers: dict[tuple[str, Span | None], list[Found]] = {}
    for one in found:
        numbers.setdefault((one.doubt.code, one.doubt.span), []).append(one)
    for members in numbers.values():
        worst = max(members, key=lambda one: (one.doubt.error, one.size))
        names = dict.fromkeys((worst.joint, *(one.joint for one in members)))
        yield replace(worst.doubt, message=f"{listed(names, 3)}: {worst.doubt.message}")


def at(
    spans: SourceMap,
    code: str,
    message: str,
    path: Path,
    help: str | None = None,
    *others: Path,
    error: bool = False,
) -> Doubt:
    """A doubt about the number at `path`, judged with those at `others`."""
    judged = tuple(spans.value(other) for other in others)
    return Doubt(code, message, dotted(path), spans.value(path), help, judged, error)


_BOUND = re.compile(r"\b(?:up to|at most) ([0-9]+(?:\.[0-9]+)?) ?([A-Za-z%][\w*·/^]*)")


@dataclass(frozen=True, slots=True)
class Kept:
    """What the author of a spec is sure of.

    Attributes:
        codes: Of the checks whose findings `accept` keeps, with the reason.
        sure: Where the numbers with `sure: true` are written.
        numbers: Where numbers are written.
        paths: Paths of the numbers with `sure: true`.
    """

    codes: Mapping[str, str] = field(default_factory=dict)
    sure: frozenset[Span] = frozenset()
    numbers: frozenset[Span] = frozenset()
    paths: frozenset[Path] = frozenset()

    def has(self, doubt: Doubt) -> bool:
        """Whether the author is sure of what a doubt blames, whichever numbers it was judged with.

        A word, such as `side`, has no `sure`: any number that was judged with it keeps it.
        """
        blamed = (doubt.span,) if doubt.span in self.numbers else (doubt.span, *doubt.judged)
        reason = self.codes.get(doubt.code)
        taken = reason is not None and _is_within(doubt.message, reason)
        return taken or not self.sure.isdisjoint(blamed)


def _is_within(message: str, reason: str) -> bool:
    """Whether what a check found is no more than a bound of the reason, as in "up to 300 rad/s".

    The first figure of the message in the bound's unit is the one that was found; one in no such unit is not bounded.
    """
    for size, unit in _BOUND.findall(reason):
        written = re.escape(unit.replace("·", "*"))
        found = re.search(rf"(?<![\w.])([0-9]+(?:\.[0-9]+)?(?:e[+-]?[0-9]+)?) {written}(?![\w*/^])", message)
        if found is not None and float(found[1]) > ROUNDED * float(size):
            return False
    return True


def kept_of(document: Document, accept: Mapping[str, str]) -> Kept:
    """What a spec keeps by `sure` and `accept`.

    Args:
        document: The spec.
        accept: Its `accept`; `spec.CODE` keeps what a check finds, up to a bound that the reason states.
    """
    codes = {code: accept[f"spec.{code}"] for code in BY_CODE if f"spec.{code}" in accept}
    written = list(_numbers(document.data))
    spans = document.spans
    return Kept(
        codes,
        frozenset(spans.value(path) for path, sure in written if sure),
        frozenset(spans.value(path) for path, _ in written),
        frozenset(path for path, sure in written if sure),
    )


def tell(doubts: Iterable[Doubt], kept: Kept, collector: Collector) -> None:
    """Report doubts, but for those of numbers that the author is sure of.

    Args:
        doubts: What the checks found.
        kept: What the author is sure of.
        collector: Takes the rest; a number has each code once, whichever of its joints and aliases they are about.
    """
    reported = {(item.code, item.span) for item in collector}
    for doubt in doubts:
        if (doubt.code, doubt.span) in reported or kept.has(doubt):
            continue
        if doubt.span is not None:
            reported.add((doubt.code, doubt.span))
        collector.add(doubt.diagnostic)


def _numbers(node: Any, path: Path = ()) -> Iterator[tuple[Path, bool]]:
    """Where numbers are written, and whether the author is sure of each."""
    if isinstance(node, dict):
        if "value" in node:
            yield path, node.get("sure") is True
        for key, value in node.items():
            yield from _numbers(value, (*path, key))
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from _numbers(value, (*path, index))
    elif (isinstance(node, (int, float)) and not isinstance(node, bool)) or (
        isinstance(node, str) and _IS_NUMBER.match(node)
    ):
        yield path, False
