"""What a URDF says of who drives its joints: transmissions, ros2_control's interfaces and plugins of Gazebo."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from actspec.audit.case import Case
from actspec.audit.rules.joints import partner_rows
from actspec.diagnostics import Span
from actspec.fields import GRAVITY, LONGEST_LEVER
from actspec.readings.artifact import Artifact, FileKind
from actspec.readings.ledger import LedgerRow
from actspec.robot.xml import parse_document
from actspec.robot.xml_tree import NUMBER, Element, as_unicode

_OF_DRIVES = (b"<transmission", b"<ros2_control", b"<plugin")

_DRIVE = re.compile("drive", re.IGNORECASE)
"""Plugins of Gazebo that turn wheels: `libgazebo_ros_diff_drive.so`, `libgazebo_ros_skid_steer_drive.so`."""

_TORQUE = re.compile("(?:max_?)?(?:wheel_?)?torque", re.IGNORECASE)
"""What these hold their wheels' speeds with at most: `torque`, `wheelTorque`, `max_wheel_torque`.

Source: gazebo_ros_pkgs, gazebo_ros_diff_drive.cpp: it is the joint's `fmax`; a URDF's effort clips what SetForce is
given, and these do not call it.
"""

_COMMENT = re.compile("<!--.*?-->", re.DOTALL)


@dataclass(frozen=True, slots=True)
class WheelDrive:
    """What a plugin of Gazebo drives a wheel with.

    Attributes:
        most: The largest torque [N*m].
        plugin: The plugin's file, as written.
        place: Where the torque is.
    """

    most: float
    plugin: str
    place: Span


@dataclass(frozen=True, slots=True)
class _Drives:
    """What a URDF says.

    Attributes:
        driven: Joints that have a transmission, or an interface that takes commands.
        mentioned: Names in plugins, which may drive them too.
        wheels: Joints that a plugin drives with a torque of its own.
    """

    driven: frozenset[str] = frozenset()
    mentioned: frozenset[str] = frozenset()
    wheels: tuple[tuple[str, WheelDrive], ...] = ()


def wheel_drive(case: Case, row: LedgerRow) -> WheelDrive | None:
    """What a plugin of a URDF drives a joint with; None: none does, or with more than any robot of its mass has."""
    wheels = case.once_of(_drives, row.artifact).wheels
    drive = next((found for name, found in wheels if name == row.joint), None)
    robot = case.artifacts[row.artifact].robot
    mass = None if robot is None else robot.mass
    return drive if drive and mass and 0.0 < drive.most <= LONGEST_LEVER * mass * GRAVITY else None


def is_left_undriven(case: Case, row: LedgerRow) -> bool:
    """Whether a URDF says which of its joints are driven, and not this one, which nothing else of its robot drives."""
    drives = case.once_of(_drives, row.artifact)
    if row.joint in drives.driven | drives.mentioned or drives.driven.isdisjoint(
        case.joints_by_artifact.get(row.artifact, {})
    ):
        return False
    return all(
        case.artifacts[other.artifact].kind is FileKind.URDF
        or (case.artifacts[other.artifact].kind is FileKind.MJCF and other.control == "none")
        for other in partner_rows(case, row)
    )


def _drives(artifact: Artifact) -> _Drives:
    """What an artifact says; nothing, where it is no URDF."""
    robot = artifact.robot
    if artifact.kind is not FileKind.URDF or robot is None:
        return _Drives()
    if not any(word in file.data for file in robot.files for word in _OF_DRIVES):
        return _Drives()
    document = parse_document(robot.files)
    plugins = [
        part for section in document.sections("gazebo") for part in section.children if part.tag == "plugin"
    ]
    wheels = []
    for plugin in plugins:
        named = plugin.get("filename") or ""
        torques = [part for part in plugin.children if _TORQUE.fullmatch(part.tag)]
        if _DRIVE.search(named) and len(torques) == 1 and NUMBER.fullmatch(text := _text(torques[0])):
            found = WheelDrive(float(text), named, document.span(torques[0]))
            wheels += [(_text(part), found) for part in plugin.children if part is not torques[0]]
    return _Drives(
        frozenset(
            name
            for section in document.root.children
            for part in _driven(section)
            if (name := part.get("name"))
        ),
        frozenset(_text(part) for plugin in plugins for part in _below(plugin)),
        tuple(wheels),
    )


def _driven(section: Element) -> Iterator[Element]:
    """Joints of a transmission, and those of ros2_control that take commands."""
    for part in section.children:
        takes = any(each.tag == "command_interface" for each in part.children)
        if part.tag == "joint" and (
            section.tag == "transmission" or (section.tag == "ros2_control" and takes)
        ):
            yield part


def _below(element: Element) -> Iterator[Element]:
    for part in element.children:
        yield part
        yield from _below(part)


def _text(element: Element) -> str:
    """What stands between an element's tags."""
    between = "" if element.self_closing else element.text[element.open_end : element.close]
    return as_unicode(_COMMENT.sub("", between)).strip()
