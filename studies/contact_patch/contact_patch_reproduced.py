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
from typing import Any

import numpy as np

from flangeway.cases.bodies.bodies_run import BodiesRun
from flangeway.cases.bodies.presets import ContactPatchCase
from flangeway.cases.case import Progress
from flangeway.contact import ContactSolution
from flangeway.materials import Elastic
from flangeway.post import Stresses, cell_stresses, corner_stresses
from flangeway.post.pressure import PressurePatch
from flangeway.problems import ElasticField
from studies.published_numbers import Reproduced, ReproducedNumber, Row, compare, percent

PUBLISHED = -1125.0  # uniform vertical stress of (6.1) in kN/cm^2
WIDTH, HEIGHT, APPROACH = 2.0, 1.0, 0.1
STEEL = Elastic(20e3, 1.0 / 3.0)  # units are cm, kN and kN/cm^2, where the keys of the case have mm, N and MPa
PENALTY = 1e6  # published penalty in kN/cm at each secondary node; read as kN/cm^3 where it is per length
N_EDGES: Mapping[int, tuple[int, int]] = MappingProxyType({1: (9, 7), 2: (17, 13), 3: (33, 25)})
"""Triangles' edges along the upper and the lower box by refinement: no multiple of each other."""
ROTATION_DEG = 30.0
PASSED = 1e-8  # maximum relative deviation from the converged uniform pressure that passes the test
OFF = 1e-3  # relative deviation of the stress that node-to-segment must exceed: it fails the test, as published
MAX_OFF = 0.5
"""Relative deviation of the stress beyond which node-to-segment is not of the published order of magnitude."""
SAME_STRESS = 0.01  # maximum relative difference of the mean stress from the published one, for node-to-segment

LAWS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "penalty": {"enforcement": "penalty", "penalty_MPa_mm": PENALTY},
        "augmented": {
            "enforcement": "augmented-lagrange", "penalty_MPa_mm": PENALTY, "penetration_mm": 1e-11 * APPROACH,
        },
        "multiplier": {"enforcement": "multiplier"},
    }
)  # fmt: skip
"""Enforcements that segment-to-segment is shown with."""
NODAL_PENALTY = {"pairing": "node-to-segment", "enforcement": "penalty", "nodal_penalty_N_per_mm": PENALTY}
ELEMENTS: Mapping[str, tuple[str, int]] = MappingProxyType(
    {"T3": ("fem", 1), "T6": ("fem", 2), "VEM1": ("vem", 1), "VEM2": ("vem", 2)}
)
MIXED = (("T6", "VEM1"), ("VEM2", "T3"), ("T3", "T6"), ("VEM1", "VEM2"))


@dataclass(frozen=True, eq=False)
class PatchRun:
    """One computation of the contact patch test."""

    code: str  # published code for node-to-segment, such as ``FPTM3O2``; else what was computed, in words
    law: str  # name of the enforcement
    sides: tuple[str, str]
    level: int  # sides, level: keys of `ELEMENTS` of the secondary and of the primary box, and the refinement
    matching: bool  # whether both boxes have the same mesh, mirrored
    case: ContactPatchCase
    run: BodiesRun  # case, run: what was computed, and its result

    @property
    def pairing(self) -> str:
        """Name of how surfaces are compared."""
        averages = self.case.pairing == "segment-to-segment"
        return f"{self.case.pairing}, {self.case.weighting}" if averages else self.case.pairing

    @property
    def solution(self) -> ContactSolution:
        """Solution of the contact."""
        assert self.run.contact is not None
        return self.run.contact

    @property
    def fields(self) -> tuple[ElasticField, ElasticField]:
        """Displacements of the upper and of the lower box, in its own frame."""
        return self.run.bodies["upper"].field, self.run.bodies["lower"].field

    @property
    def expected(self) -> float:
        """Uniform pressure: that of (6.1), reduced by the compliance of a penalty per length."""
        compliance = 2.0 * HEIGHT / STEEL.plane_modulus
        if self.law == "penalty" and self.case.pairing != "node-to-segment":
            compliance += 1.0 / PENALTY
        return APPROACH / compliance

    @cached_property
    def patch(self) -> PressurePatch:
        """The region of contact, with the pressures of its nodes by influence width (Moherdaui 2021, Figure 63)."""
        return max(self.run.patches, key=lambda patch: len(patch.pressures))

    @cached_property
    def stresses(self) -> tuple[Stresses, Stresses]:
        """Stresses at all corners of the elements of the upper and of the lower box, unaveraged."""
        upper, lower = self.fields
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
        values = [cell_stresses(field.problem, field.displacements).components[:, 1] for field in self.fields]
        areas = np.concatenate([field.problem.space.mesh.cell_areas for field in self.fields])
        deviation = np.concatenate(values) / -self.expected - 1.0
        return float(np.sqrt(areas @ deviation**2 / areas.sum()))

    @property
    def mean_stress(self) -> float:
        """Force over width, negative in compression."""
        turn = np.deg2rad(self.case.rotation_deg)
        force = self.solution.forces[0] @ np.array([-np.sin(turn), np.cos(turn)])
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
    """The contact patch test computed again, and beside it with segment-to-segment."""

    published: tuple[PatchRun, ...]  # node-to-segment with the published penalty: the published configurations
    proper: tuple[PatchRun, ...]  # segment-to-segment under all enforcements

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
        published.append(patch_run(code, "penalty", (elements, elements), level, NODAL_PENALTY))
    proper = []
    for sides, level, matching, changed in _proper_cases(levels):
        code = f"{sides[0]} on {sides[1]} M{level}" + (" matching" if matching else "")
        for law, keys in LAWS.items():
            progress(f"segment-to-segment: {code}, {law}")
            proper.append(patch_run(code, law, sides, level, {**keys, **changed}, matching=matching))
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


def _proper_cases(levels: Sequence[int]) -> Iterator[tuple[tuple[str, str], int, bool, dict[str, Any]]]:
    """Sides, refinement, matching, and further keys of the case."""
    rotated = {"rotation_deg": ROTATION_DEG}
    for name in ELEMENTS:
        for level in levels:
            yield (name, name), level, False, {}
        yield (name, name), 1, True, {}
        yield (name, name), 1, False, rotated
        yield (name, name), 1, True, rotated
        yield (name, name), 1, False, {"weighting": "dual"}
    for sides in MIXED:
        yield sides, 1, False, {}
        yield sides, 1, False, rotated


def patch_run(
    code: str, law: str, sides: tuple[str, str], level: int, keys: Mapping[str, Any], *, matching: bool = False
) -> PatchRun:
    """Compute one test: its `PatchRun.code`, `law`, `sides` and `level`, and keys of the case."""
    n_upper, n_lower = N_EDGES[level]
    values: dict[str, Any] = {"width_mm": WIDTH, "height_mm": HEIGHT, "approach_mm": APPROACH, "young_MPa": STEEL.young}
    for box, elements, n_edges in zip(
        ("upper", "lower"), sides, (n_upper, n_upper if matching else n_lower), strict=True
    ):
        method, order = ELEMENTS[elements]
        # slightly larger than an exact part of the width, so that round-off does not add an edge
        size = WIDTH / n_edges * (1.0 + 1e-6)
        values |= {f"{box}_method": method, f"{box}_order": order, f"{box}_size_mm": size}
    case = ContactPatchCase.from_values({**values, **keys})
    return PatchRun(code, law, sides, level, matching, case, case.run())


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
            "secondary": run.sides[0],
            "primary": run.sides[1],
            "matching": run.matching,
            "rotation_deg": run.case.rotation_deg,
            "iterations": run.solution.status.iterations,
            "expected_pressure": run.expected,
            "pressure_error": run.pressure_error,
            "stress_error": run.stress_error,
            "passes": run.passes,
        }
        for run in (*found.published, *found.proper)
    ]
