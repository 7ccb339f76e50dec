"""Supports of an elastic body: items of an `Elasticity` problem."""

from dataclasses import dataclass

import numpy as np

from flangeway.checks import are_finite, check_finite, is_finite
from flangeway.errors import InputError, short
from flangeway.geometry.arrays import Point
from flangeway.problems.prescribed import Scalar, check_scalar, check_vector
from flangeway.types import Floats


def _check_place(owner: str, where: str | Point) -> None:
    if not isinstance(where, str) and not are_finite(where, 2):
        raise InputError(f"{owner} at {short(where)}", "the name of an edge set, or a point (x, y)", "correct it")


def axes(angle: float) -> Floats:
    """Directions of the first and second axis of a frame turned counter-clockwise, the rows of (2, 2)."""
    turn = angle / (np.pi / 2.0)
    if turn == round(turn):  # quarter turns without round-off, so that unknowns stay apart
        angle_cos, angle_sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(turn) % 4]
    else:
        angle_cos, angle_sin = np.cos(angle), np.sin(angle)
    return np.array([[angle_cos, angle_sin], [-angle_sin, angle_cos]])


@dataclass(frozen=True)
class PrescribedDisplacement:
    """Displacements given on named edges or at a point, each component on its own.

    Parameters
    ----------
    where
        Name of an edge set, or a point of the mesh.
    x, y
        Displacement along each axis: a number, a function of points (n, 2) with values (n,), or None for free.
    angle
        Angle in radians from the x axis of space to the x axis of this support, counter-clockwise.

    """

    where: str | Point
    x: Scalar | None = None
    y: Scalar | None = None
    angle: float = 0.0

    def __post_init__(self) -> None:
        owner = f"PrescribedDisplacement({short(self.where)})"
        _check_place(owner, self.where)
        check_finite(owner, "angle", self.angle, "a finite angle in radians", "correct it")
        for name, value in (("x", self.x), ("y", self.y)):
            if value is not None:
                check_scalar(f"{owner}: {name}", value)
        if self.x is None and self.y is None:
            raise InputError(f"{owner} without x and y", "at least one of them", "give x=0.0 or y=0.0, or leave it out")


def fixed(where: str | Point) -> PrescribedDisplacement:
    """Support that holds both components of named edges, or of a point, at zero."""
    return PrescribedDisplacement(where, x=0.0, y=0.0)


@dataclass(frozen=True)
class Spring:
    """Elastic support on named edges or at a point, fixed at its other end.

    Parameters
    ----------
    where
        Name of an edge set, or a point of the mesh.
    x, y
        Stiffness along each axis, 0 for none: pressure per displacement on edges, force per displacement at a point
        (in a body of revolution, of the whole circle).
    angle
        Angle in radians from the x axis of space to the x axis of this support, counter-clockwise.

    """

    where: str | Point
    x: float = 0.0
    y: float = 0.0
    angle: float = 0.0

    def __post_init__(self) -> None:
        owner = f"Spring({short(self.where)})"
        _check_place(owner, self.where)
        check_finite(owner, "angle", self.angle, "a finite angle in radians", "correct it")
        if not all(is_finite(k) and k >= 0.0 for k in (self.x, self.y)) or self.x == self.y == 0.0:
            raise InputError(
                f"{owner}: stiffnesses x={self.x}, y={self.y}",
                "numbers >= 0, and one of them positive",
                "give the stiffness along each axis; to hold a component take PrescribedDisplacement",
            )


@dataclass(frozen=True)
class RigidHandle:
    """Named edges that move as a rigid line: each of three motions is prescribed, or free under a force.

    Parameters
    ----------
    edges
        Name of an edge set.
    x, y
        Translation of the pivot, or None for free.
    rotation
        Rotation in radians, counter-clockwise and small, or None for free.
    force
        Applied force x, y; only along free translations.
    moment
        Applied moment about the pivot, counter-clockwise; only on a free rotation.
    pivot
        Point that the motion and the moment refer to; None is the middle of the edges' bounding box.

    """

    edges: str
    x: float | None = None
    y: float | None = None
    rotation: float | None = None
    force: Point = (0.0, 0.0)
    moment: float = 0.0
    pivot: Point | None = None

    def __post_init__(self) -> None:
        owner = f"RigidHandle({short(self.edges)})"
        for name, value in (("x", self.x), ("y", self.y), ("rotation", self.rotation), ("moment", self.moment)):
            if value is not None:
                check_scalar(f"{owner}: {name}", value)
        check_vector(f"{owner}: force", self.force)
        if self.pivot is not None:
            check_vector(f"{owner}: pivot", self.pivot)
        actions = zip(("force x", "force y", "moment"), (*self.force, self.moment), strict=True)
        for name, motion, (action, load) in zip(("x", "y", "rotation"), self.prescribed, actions, strict=True):
            if motion is not None and load != 0.0:
                raise InputError(
                    f"{owner}: {name}={motion} and {action} = {load}",
                    "a motion, or a force on a free motion",
                    f"leave {name}=None to apply the {action}",
                )

    @property
    def prescribed(self) -> tuple[float | None, float | None, float | None]:
        """Translations x, y and rotation, None where free."""
        return self.x, self.y, self.rotation


Support = PrescribedDisplacement | Spring | RigidHandle
