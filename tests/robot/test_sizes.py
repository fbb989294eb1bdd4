"""Sizes that a text states: refused at the element beyond a limit, before MuJoCo makes gigabytes of them."""

from __future__ import annotations

import time

import pytest

from actspec.diagnostics import RobotError
from actspec.robot.read_mjcf import read_mjcf
from actspec.robot.sizes import COPIES, _made
from actspec.robot.view import ModelFile
from actspec.robot.xml import parse_document

ROBOT = '<worldbody><body name="b"><joint name="j"/><geom size=".1"/></body>%s</worldbody>'

BEYOND = {
    "keyframes": ('<size nkey="2000000000"/>', "", "copies"),
    "numbers": ('<size nuser_jnt="2000000000"/>', "", "numbers of the user"),
    "numbers, each joint": ('<size nuser_jnt="3000000"/>', "", "numbers of the user"),
    "user data": ('<size nuserdata="100000000"/>', "", "numbers of the user"),
    "height field": (
        '<asset><hfield name="h" nrow="30000" ncol="30000" size="1 1 1 1"/></asset>',
        "",
        "cells",
    ),
    "cube": ('<asset><texture name="t" builtin="flat" width="8000" height="8000"/></asset>', "", "cells"),
    "mesh": ('<asset><mesh name="m" builtin="cone" params="1e8 .1"/></asset>', "", "divisions of a mesh"),
    "lengths": ('<compiler><lengthrange timestep="1e-9"/></compiler>', "", "steps"),
    "points": ("", '<flexcomp name="f" type="grid" count="500 500 400" spacing="1 1 1"/>', "copies"),
    # 32^3 - 30^3 + 1 = 32768 - 27000 + 1 = 5769 points.
    "points of a shell": ("", '<flexcomp name="f" type="box" count="32 32 32" spacing="1 1 1"/>', "copies"),
    "points of no end": (
        "",
        f'<flexcomp name="f" type="box" count="{"9" * 200} {"9" * 200} 9" spacing="1 1 1"/>',
        "copies",
    ),
    "points of few bodies": (
        "",
        '<flexcomp name="f" dof="trilinear" count="40 40 40" spacing="1 1 1"/>',
        "50000 points",
    ),
    "copies": ("", '<replicate count="10001"><geom size=".1"/></replicate>', "copies"),
    "sensor": ("", '</worldbody><sensor><user dim="100000000"/></sensor><worldbody>', "numbers of the user"),
    "together": ("", '<replicate count="6000"><geom size=".1"/></replicate>' * 2, "copies"),
}


def view(head: str, body: str) -> object:
    """A model of one joint."""
    text = f"<mujoco>{head}\n{ROBOT % body}</mujoco>"
    return read_mjcf((ModelFile("m.xml", "", text.encode()),))


@pytest.mark.parametrize("name", BEYOND)
def test_beyond_a_limit(name: str) -> None:
    """One error, at the element, and MuJoCo has not begun."""
    head, body, budget = BEYOND[name]
    begin = time.process_time()
    with pytest.raises(RobotError) as caught:
        view(head, body)
    assert time.process_time() - begin < 2.0
    (said,) = caught.value.diagnostics
    assert said.code == "ROBOT110" and said.span is not None
    assert said.span.line == (1 if head else 2) and said.span.column > 1
    assert budget in said.message and "makes more than" in said.message


def test_sizes_in_use_are_read() -> None:
    """Stated sizes that models have: a terrain, a sky of 512, a cloth, a hundred keyframes."""
    head = (
        '<size nkey="100" nuser_jnt="4" memory="100M"/><asset><hfield name="h" nrow="512" ncol="512" '
        'size="1 1 1 1"/><texture type="skybox" builtin="gradient" width="512" height="3072"/></asset>'
    )
    assert view(head, '<replicate count="100" offset="1 0 0"><geom size=".1"/></replicate>')


@pytest.mark.parametrize(
    ("kind", "count", "dim", "bodies"),
    [
        ("grid", "3 4 5", 3, 60),
        # 3 4 5 has 1 x 2 x 3 inside; 60 - 6 + 1 = 55. 20^3 - 18^3 + 1 = 2169, of a sample of MuJoCo.
        ("box", "3 4 5", 3, 55),
        ("box", "20 20 20", 3, 2169),
        ("cylinder", "5 6 7", 3, 151),
        ("ellipsoid", "6 6 6", 3, 153),
        ("square", "5 6 1", 2, 30),
        ("disc", "5 6 1", 2, 30),
        ("circle", "8 30 30", 1, 7),
        ('direct" point="0 0 0 1 0 0 0 1 0" element="0 1 2', "90 90 90", 2, 0),
        ('grid" dof="trilinear', "20 20 20", 3, 0),
        ('grid" rigid="true', "20 20 20", 3, 0),
        ('circle" origin="0 0 0', " ", 1, 0),
    ],
)
def test_bodies_of_a_flex(kind: str, count: str, dim: int, bodies: int) -> None:
    """As many as MuJoCo makes: one a point, of what the type makes of the count."""
    text = (
        f'<mujoco><option integrator="Euler"/><worldbody><flexcomp name="f" type="{kind}" count="{count}" dim="{dim}" '
        'spacing=".1 .1 .1" radius=".01"/></worldbody></mujoco>'
    )
    document = parse_document((ModelFile("m.xml", "", text.encode()),))
    made = [
        amount
        for element in document.walk()
        for budget, _, amount in _made(element, 1.0, 1)
        if budget is COPIES
    ]
    assert sum(made) == bodies
    if bodies:
        mujoco = pytest.importorskip("mujoco")
        assert mujoco.MjModel.from_xml_string(text).nbody == 1 + bodies
