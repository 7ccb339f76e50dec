"""The contact patch test (Moherdaui 2021, 6.2.1, Figures 64 and 70 to 75): a uniform pressure between two boxes.

The source gives one number, the uniform stress of (6.1). It shows the errors of its node-to-segment results in pictures
and in words: never exact, larger for triangles than for polygons, smaller on finer meshes. The boxes' height of 1
follows from (6.1); width, numbers of edges and the laterally held points are assumptions.

Everything may be rotated, the interface with it. An interface inclined to the load is no test of contact without
friction: the uniform state has a shear stress on it.
"""

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Literal

import numpy as np

from flangeway.cases.case import Progress
from flangeway.contact import (
    AugmentedLagrange,
    ContactSolution,
    Multiplier,
    NodeToSegment,
    Pairing,
    Penalty,
    SegmentToSegment,
)
from flangeway.contact.enforcement import Enforcement
from flangeway.post import Stresses, cell_stresses, corner_stresses
from flangeway.post.pressure import PressurePatch, pressure_patches
from flangeway.validation.contact_patch.pressed_boxes import (
    STEEL,
    BoxDiscretisation,
    ContactCase,
    Method,
    pressed_boxes,
)
from flangeway.validation.published_numbers import Reproduced, ReproducedNumber, Row, compare, percent

Weighting = Literal["standard", "dual"]

PUBLISHED = -1125.0
"""Uniform vertical stress of (6.1) in kN/cm^2."""
WIDTH, HEIGHT, APPROACH = 2.0, 1.0, 0.1
PENALTY = 1e6
"""Published penalty in kN/cm at each secondary node; read as kN/cm^3 where it is per length."""
N_EDGES: Mapping[int, tuple[int, int]] = MappingProxyType({1: (9, 7), 2: (17, 13), 3: (33, 25)})
"""Triangles' edges along the upper and the lower box by refinement: no multiple of each other."""
ROTATION_RAD = np.deg2rad(30.0)
PASSED = 1e-8
"""Maximum relative deviation from the converged uniform pressure that passes the test."""
OFF = 1e-3
"""Relative deviation of the stress that node-to-segment must exceed: it fails the test, as published."""
MAX_OFF = 0.5
"""Relative deviation of the stress beyond which node-to-segment is not of the published order of magnitude."""
SAME_STRESS = 0.01
"""Maximum relative difference of the mean stress from the published one, for node-to-segment."""

LAWS: Mapping[str, Enforcement] = MappingProxyType(
    {
        "penalty": Penalty(PENALTY, per="length"),
        "augmented": AugmentedLagrange(PENALTY, per="length", penetration=1e-11 * APPROACH),
        "multiplier": Multiplier(),
    }
)
"""Enforcements that segment-to-segment is shown with."""
ELEMENTS: Mapping[str, tuple[Method, int]] = MappingProxyType(
    {"T3": ("fem", 1), "T6": ("fem", 2), "VEM1": ("vem", 1), "VEM2": ("vem", 2)}
)
MIXED = (("T6", "VEM1"), ("VEM2", "T3"), ("T3", "T6"), ("VEM1", "VEM2"))


@dataclass(frozen=True, eq=False)
class PatchRun:
    """One computation of the contact patch test.

    Parameters
    ----------
    code
        Published code for node-to-segment, such as ``FPTM3O2``; else what was computed, in words.
    pairing, law
        Names of how surfaces are compared and of the enforcement.
    upper, lower
        Discretisations of the secondary and of the primary box.
    matching
        Whether both boxes have the same mesh, mirrored.
    rotation_rad
        Rotation of everything.
    case
        What was computed.
    solution
        Its solution.

    """

    code: str
    pairing: str
    law: str
    upper: BoxDiscretisation
    lower: BoxDiscretisation
    matching: bool
    rotation_rad: float
    case: ContactCase
    solution: ContactSolution

    @property
    def expected(self) -> float:
        """Uniform pressure: that of (6.1), reduced by the compliance of a penalty per length."""
        compliance = 2.0 * HEIGHT / STEEL.plane_modulus
        if self.law == "penalty" and self.pairing != "node-to-segment":
            compliance += 1.0 / PENALTY
        return APPROACH / compliance

    @cached_property
    def patch(self) -> PressurePatch:
        """The region of contact, with the pressures of its nodes by influence width (Moherdaui 2021, Figure 63)."""
        patches = pressure_patches(self.solution.system, self.solution.state)
        return max(patches, key=lambda patch: len(patch.pressures))

    @cached_property
    def stresses(self) -> tuple[Stresses, Stresses]:
        """Stresses at all corners of the elements of the upper and of the lower box, unaveraged."""
        upper, lower = (self.solution.field(self.case.part(name)) for name in ("upper", "lower"))
        return corner_stresses(upper.problem, upper.displacements), corner_stresses(lower.problem, lower.displacements)

    @property
    def pressure_range(self) -> tuple[float, float]:
        """Minimum and maximum pressure of a node, relative to the expected one."""
        pressures = self.patch.pressures / self.expected
        return float(pressures.min()), float(pressures.max())

    @property
    def pressure_error(self) -> float:
        """Maximum relative deviation of a node's pressure; 1 where a constraint carries none."""
        contact = self.solution.system.contacts[0]
        n_nodes = len(contact.pairing.key_nodes(contact.secondary))
        low, high = self.pressure_range
        return max(abs(low - 1.0), abs(high - 1.0), float(len(self.patch.pressures) < n_nodes))

    @cached_property
    def stress_range(self) -> tuple[float, float]:
        """Minimum and maximum vertical stress."""
        values = np.concatenate([each.components[:, 1] for each in self.stresses])
        return float(values.min()), float(values.max())

    @cached_property
    def stress_error(self) -> float:
        """Maximum deviation of a stress component in the plane from the uniform state, over the expected pressure."""
        exact = np.array([0.0, -self.expected, 0.0])
        deviations = [np.abs(each.components[:, :3] - exact).max() for each in self.stresses]
        return float(max(deviations)) / self.expected

    @cached_property
    def stress_oscillation(self) -> float:
        """Root mean square of the elements' vertical stress less the uniform one, over both boxes, relative to it."""
        fields = [self.solution.field(self.case.part(name)) for name in ("upper", "lower")]
        values = [cell_stresses(field.problem, field.displacements).components[:, 1] for field in fields]
        areas = np.concatenate([field.problem.space.mesh.cell_areas for field in fields])
        deviation = np.concatenate(values) / -self.expected - 1.0
        return float(np.sqrt(areas @ deviation**2 / areas.sum()))

    @property
    def mean_stress(self) -> float:
        """Force over width, negative in compression."""
        force = self.solution.forces[0] @ np.array([-np.sin(self.rotation_rad), np.cos(self.rotation_rad)])
        return -float(force) / WIDTH

    @property
    def converged(self) -> bool:
        """Whether it was solved."""
        return self.solution.status.converged

    @property
    def passes(self) -> bool:
        """Whether pressures and stresses are uniform within `PASSED`."""
        return self.converged and max(self.pressure_error, self.stress_error) <= PASSED


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactPatchReproduction(Reproduced):
    """The contact patch test computed again, and beside it with segment-to-segment.

    Parameters
    ----------
    published
        Node-to-segment with the published penalty: the published configurations.
    proper
        Segment-to-segment under all enforcements.

    """

    published: tuple[PatchRun, ...]
    proper: tuple[PatchRun, ...]

    @property
    def failures(self) -> tuple[str, ...]:
        """Solutions that did not converge, and cases in which segment-to-segment does not pass."""
        failed = [
            f"{run.code}, {run.law}: {run.solution.status.message}" for run in self.published if not run.converged
        ]
        failed += [
            f"{run.code}, {run.pairing}, {run.law}: {run.solution.status.message}; relative error of the pressure "
            f"{run.pressure_error:.1e}, of the stress {run.stress_error:.1e}"
            for run in self.proper
            if not run.passes
        ]
        return tuple(failed)


def reproduce_contact_patch(*, quick: bool = False, progress: Progress = lambda _: None) -> ContactPatchReproduction:
    """Compute the published configurations, and segment-to-segment; without the finest of three meshes if `quick`."""
    start = time.perf_counter()
    levels = (1, 2) if quick else (1, 2, 3)
    published = []
    for code, elements, level in _published_codes(levels):
        progress(f"node-to-segment: {code}")
        published.append(_run(code, (elements, elements), level, NodeToSegment(), "penalty", Penalty(PENALTY, "node")))
    proper = []
    for (sides, level, matching, rotation), weighting in _proper_cases(levels):
        for law, enforcement in LAWS.items():
            pairing = SegmentToSegment(weighting=weighting)
            code = f"{sides[0]} on {sides[1]} M{level}" + (" matching" if matching else "")
            progress(f"segment-to-segment: {code}, {law}")
            proper.append(_run(code, sides, level, pairing, law, enforcement, matching=matching, rotation=rotation))
    return ContactPatchReproduction(
        published=tuple(published),
        proper=tuple(proper),
        numbers=tuple(number for run in published for number in _numbers(run)),
        seconds=time.perf_counter() - start,
    )


def _published_codes(levels: Sequence[int]) -> Iterator[tuple[str, str, int]]:
    for order in (1, 2):
        for method, elements in (("F", f"T{3 * order}"), ("V", f"VEM{order}")):
            for level in levels:
                yield f"{method}PTM{level}O{order}", elements, level


def _proper_cases(levels: Sequence[int]) -> Iterator[tuple[tuple[tuple[str, str], int, bool, float], Weighting]]:
    """Sides, refinement, matching and rotation, with the weighting of the gap."""
    for name in ELEMENTS:
        for level in levels:
            yield ((name, name), level, False, 0.0), "standard"
        yield ((name, name), 1, True, 0.0), "standard"
        yield ((name, name), 1, False, ROTATION_RAD), "standard"
        yield ((name, name), 1, True, ROTATION_RAD), "standard"
        yield ((name, name), 1, False, 0.0), "dual"
    for sides in MIXED:
        yield (sides, 1, False, 0.0), "standard"
        yield (sides, 1, False, ROTATION_RAD), "standard"


def _run(
    code: str,
    sides: tuple[str, str],
    level: int,
    pairing: Pairing,
    law: str,
    enforcement: Enforcement,
    *,
    matching: bool = False,
    rotation: float = 0.0,
) -> PatchRun:
    n_upper, n_lower = N_EDGES[level]
    counts = (n_upper, n_upper if matching else n_lower)
    # slightly larger than an exact part of the width, so that round-off does not add an edge
    sizes = [WIDTH / n * (1.0 + 1e-6) for n in counts]
    upper, lower = (BoxDiscretisation(size, *ELEMENTS[name]) for size, name in zip(sizes, sides, strict=True))
    case = pressed_boxes(
        upper, lower, pairing, enforcement, width=WIDTH, height=HEIGHT, approach=APPROACH, rotation_rad=rotation
    )
    name = f"segment-to-segment, {pairing.weighting}" if isinstance(pairing, SegmentToSegment) else "node-to-segment"
    return PatchRun(code, name, law, upper, lower, matching, rotation, case, case.solve())


def _numbers(run: PatchRun) -> Iterator[ReproducedNumber]:
    low, high = run.stress_range
    least, maximum = (100.0 * (value - 1.0) for value in run.pressure_range)
    error = run.stress_error
    order = (
        f"not exact, as published: stress errors up to {100.0 * error:.2g} %, errors of nodal pressures "
        f"{least:+.2g} to {maximum:+.2g} %; the published pictures give no numbers"
    )
    failed = "" if run.converged else f"{run.solution.status.message}; "
    mean = run.mean_stress / PUBLISHED - 1.0
    of_order = f"error of {percent(OFF)} to {percent(MAX_OFF)}"
    for quantity, value, note, words, within in (
        ("mean stress_yy over the surface", run.mean_stress, "force over width", None, abs(mean) <= SAME_STRESS),
        ("minimum stress_yy", low, order, of_order, OFF < error < MAX_OFF),
        ("maximum stress_yy", high, order, of_order, OFF < error < MAX_OFF),
    ):
        yield compare(
            "Equation 6.1", run.code, quantity, "kN/cm^2", (PUBLISHED, value), SAME_STRESS, failed + note, words=words,
            within=run.converged and within,
        )  # fmt: skip


def pass_rows(found: ContactPatchReproduction) -> list[Row]:
    """Rows of ``passes.csv``: how far from uniform each computation is."""
    return [
        {
            "code": run.code,
            "pairing": run.pairing,
            "law": run.law,
            "secondary": _elements_name(run.upper),
            "primary": _elements_name(run.lower),
            "matching": run.matching,
            "rotation_deg": float(np.rad2deg(run.rotation_rad)),
            "iterations": run.solution.status.iterations,
            "expected_pressure": run.expected,
            "pressure_error": run.pressure_error,
            "stress_error": run.stress_error,
            "passes": run.passes,
        }
        for run in (*found.published, *found.proper)
    ]


def _elements_name(side: BoxDiscretisation) -> str:
    return next(name for name, kind in ELEMENTS.items() if kind == (side.method, side.order))
