"""An assembled mechanism in MuJoCo's language (MJCF), and as tables of bodies and joints, for a check elsewhere.

Bodies, joints and linear springs are said exactly. MuJoCo's contacts are soft constraints of another law, so that the
contacts here, and all else that it cannot have, stand in words in a comment.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..elements import BallContact
from ..errors import InputError
from ..fields import Part
from ..files import user_path, write
from .body_tree import BodyTree, Triple, number_text, tree_of, triple
from .formats import csv_text

# MuJoCo takes no body that moves without a mass; this one changes nothing.
NO_MASS = 1e-12  # kg


def mjcf(design: Part, scenario: Part | None = None) -> str:
    """Return a mechanism with its start as MuJoCo's MJCF, without contacts: these stand in words in a comment.

    **Arguments:**

    - ``design``: whose bodies are rigid, and joined as a tree by `Revolute`, `Universal` and `Prismatic` joints.
    - ``scenario`` (default: the mechanism's own): its start is the key frame "start".

    **Returns:** the text of an XML file.

    **Raises:** `InputError` for what MJCF cannot say: bodies that bend, loops of joints, other joints.

    **Example:**

    >>> text = jb.mjcf(jb.docking3d(), jb.Scenario3D())
    >>> [line.strip() for line in text.splitlines() if '<body name="probe"' in line]
    ['<body name="probe" pos="0.1899891304347826 0 0">']
    """
    tree = tree_of(design, scenario)
    lines = ["<mujoco>", *_comment(tree), '  <compiler angle="radian" boundmass="0" boundinertia="0"/>']
    lines += ['  <option gravity="0 0 0"><flag contact="disable"/></option>', "  <worldbody>"]
    for root in tree.roots:
        lines += _body(tree, root, 2)
    at, rates = _start(tree)
    key = f'    <key name="start" qpos="{number_text(at)}" qvel="{number_text(rates)}"/>'
    return "\n".join([*lines, "  </worldbody>", "  <keyframe>", key, "  </keyframe>", "</mujoco>", ""])


def export_mjcf(design: Part, scenario: Part | None, file: str | Path, *, overwrite: bool = False) -> None:
    """Write `mjcf` to a file, and beside it tables of the bodies and the joints, as URDF has them.

    **Arguments:**

    - ``design``, ``scenario``: as of `mjcf`.
    - ``file``: "docking.xml", say; the tables are docking.bodies.csv and docking.joints.csv.
    - ``overwrite``: whether to replace files that are there.

    **Raises:** `InputError` as `mjcf`, and for a file that is there.

    **Example:**

    >>> import tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     jb.export_mjcf(jb.table2(), None, pathlib.Path(folder) / "docking.xml")
    ...     sorted(file.name for file in pathlib.Path(folder).iterdir())
    ['docking.bodies.csv', 'docking.joints.csv', 'docking.xml']
    """
    target, tree = user_path(file), tree_of(design, scenario)
    texts = {
        target: mjcf(design, scenario),
        target.with_suffix(".bodies.csv"): _bodies_table(tree),
        target.with_suffix(".joints.csv"): _joints_table(tree),
    }
    for place in texts:
        if place.exists() and not overwrite:
            raise InputError(f"{place} exists; overwrite=True replaces it")
    for place, text in texts.items():
        write(place, text, overwrite)


def _comment(tree: BodyTree) -> list[str]:
    bodies = ", ".join(f"{k} {name}" for k, name in enumerate(tree.names))
    head = f"Written by jaxbuffer. Bodies: {bodies}. SI units. Not said below, since MJCF has nothing of the kind:"
    # Two hyphens would end a comment.
    return ["  <!--", *(f"    {line.replace('--', '- -')}" for line in (head, *tree.words)), "  -->"]


def _body(tree: BodyTree, body: int, depth: int) -> Iterator[str]:
    """Yield the lines of a body and of all that hangs on it."""
    pad, link, name = "  " * depth, tree.links.get(body), tree.names[body]
    yield f'{pad}<body name="{name}" pos="{number_text((0.0, 0.0, 0.0) if link is None else link.place)}">'
    if link is None:
        yield from (f"{pad}  {line}" for line in _free(tree, name))
    else:
        for k, joint in enumerate(link.joints, 1):
            stiffness, damping, slack = joint.spring
            place = f'pos="{number_text(joint.point)}" axis="{number_text(joint.axis)}"'
            spring = f'stiffness="{stiffness!r}" damping="{damping!r}" springref="{slack!r}"'
            yield f'{pad}  <joint name="{name} {k}" type="{joint.kind}" {place} {spring}/>'
    mass, inertia = _inertial(tree, body)
    yield f'{pad}  <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{number_text(inertia)}"/>'
    for ball in _spinning(tree, body):
        about, kind = [float(ball.spin_inertias[0])] * 3, 'type="ball"' if tree.space else 'type="hinge" axis="0 0 1"'
        yield f'{pad}  <body name="{ball.name}" pos="{number_text(triple(ball.point))}">'
        yield f'{pad}    <joint name="{ball.name}" {kind}/>'
        yield f'{pad}    <inertial pos="0 0 0" mass="{NO_MASS!r}" diaginertia="{number_text(about)}"/>'
        yield f"{pad}  </body>"
    for child, of in tree.links.items():
        if of.parent == body:
            yield from _body(tree, child, depth + 1)
    yield f"{pad}</body>"


def _free(tree: BodyTree, name: str) -> list[str]:
    """Return the joints of a body that hangs on none."""
    if tree.space:
        return [f'<freejoint name="{name}"/>']
    axes = {"x": ("slide", "1 0 0"), "y": ("slide", "0 1 0"), "turn": ("hinge", "0 0 1")}
    return [f'<joint name="{name} {axis}" type="{kind}" axis="{of}"/>' for axis, (kind, of) in axes.items()]


def _inertial(tree: BodyTree, body: int) -> tuple[float, Triple]:
    """Return mass and moments of inertia; in the plane the one about its normal stands for all."""
    it = tree.mechanism.system.bodies[body]
    inertia: Any = it.inertia
    return float(it.mass), triple(inertia if tree.space else (inertia,) * 3)


def _spinning(tree: BodyTree, body: int) -> list[BallContact]:
    return [it for it in tree.mechanism.all_of(BallContact) if it.body == body and it.spin_inertias]


def _start(tree: BodyTree) -> tuple[list[float], list[float]]:
    """Return the positions and velocities at t = 0, in MuJoCo's order."""
    at, rates = list[float](), list[float]()

    def visit(body: int) -> None:
        frame: Any = tree.kin.frame(body)  # of the plane or of space
        if (link := tree.links.get(body)) is not None:
            at.extend(joint.at for joint in link.joints)
            rates.extend(joint.rate for joint in link.joints)
        elif tree.space:
            # MuJoCo's spins are in the body's axes.
            at.extend(map(float, (*frame.origin, *frame.quaternion)))
            rates.extend(map(float, (*frame.velocity, *frame.in_axes(frame.spin))))
        else:
            at.extend(map(float, (*frame.origin, frame.angle)))
            rates.extend(map(float, (*frame.velocity, frame.spin)))
        for _ in _spinning(tree, body):
            # A ball begins without a spin of its own against the body that it sits in.
            at.extend([1.0, 0.0, 0.0, 0.0] if tree.space else [0.0])
            rates.extend([0.0] * (3 if tree.space else 1))
        for child, of in tree.links.items():
            if of.parent == body:
                visit(child)

    for root in tree.roots:
        visit(root)
    return at, rates


def _bodies_table(tree: BodyTree) -> str:
    """Return masses, moments of inertia and places at t = 0, a row a body."""
    axes = "xyz"[: tree.mechanism.system.basis.dimensions]
    header = ["body", "mass [kg]", *(f"inertia {it} [kg m²]" for it in "xyz"), *(f"{it} [m]" for it in axes)]
    places = np.asarray(tree.kin.poses())[:, : len(axes)].tolist()
    rows = []
    for k, (name, place) in enumerate(zip(tree.names, places, strict=True)):
        mass, inertia = _inertial(tree, k)
        rows.append([name, mass, *inertia, *place])
    return csv_text(header, rows)


def _joints_table(tree: BodyTree) -> str:
    """Return the hinges and slides: the child's place in its parent at zero, point and axis in the child, spring."""
    header = ["parent", "child", "type", *(f"{what} {it}" for what in ("origin", "point", "axis") for it in "xyz")]
    header = [it if it.startswith(("parent", "child", "type", "axis")) else f"{it} [m]" for it in header]
    rows = [
        [tree.names[link.parent], tree.names[child], it.kind, *link.place, *it.point, *it.axis, *it.spring]
        for child, link in tree.links.items()
        for it in link.joints
    ]
    return csv_text([*header, "stiffness [N/m, N m/rad]", "damping [N s/m, N m s/rad]", "slack at [m, rad]"], rows)
