"""Constants of a cross-section from a name or a file: what ``flangeway section`` computes, and the case of torsion."""

# ruff: noqa: N815 (units in names)

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

import annotated_types as at
import numpy as np
from pydantic import Field

from flangeway.cases.case import RunnableCase
from flangeway.cases.summary import RunResult
from flangeway.elements import Element, Lagrange, Virtual
from flangeway.errors import InputError, located
from flangeway.formats import DrawnSection, read_section
from flangeway.formats.drawn_section import UNITS_MM
from flangeway.formats.outline_files import ENDINGS
from flangeway.forms import BeamSection
from flangeway.geometry import Arc, Section
from flangeway.geometry.arrays import norms
from flangeway.mesh import PolyMesh, Refinement, dual_section, triangulate_section
from flangeway.mesh.connectivity import connected
from flangeway.mesh.gmsh_mesher import mesh_bound
from flangeway.post import SectionConstants, corner_shear_stresses, section_constants
from flangeway.railway.profiles.bundled import bundled_section
from flangeway.records import LengthUnit, Pair
from flangeway.results import ResultTable
from flangeway.solve import Status
from flangeway.space import Space
from flangeway.types import Floats, Progress

SOLVED = Status(True, "both formulations of torsion are solved", 1)
STEEL_KG_M3 = 7850.0
_USUAL_TRIANGLES = 3000
_MAX_TRIANGLES = 30_000
_MAX_EDGES = 10_000
_CELLS_ACROSS_WALL = 4.0
_SAGITTA = 1e-4  # of the mean thickness: chords then change the torsion constant by about 1e-4 of it
_MAX_CHORD = 0.6  # chords hardly shorter than the size are not worth a refinement of their own
_GROWTH = 0.3


class TorsionCase(RunnableCase):
    """Warping, shear stresses and the constants of a bundled section or of an outline."""

    name = "torsion"
    title = "A section under torsion: warping, shear stress, and all constants of the section"
    essential = ("section", "method", "order")

    section: str = "136RE"
    """136RE, 136RE-8, 136RE-14, 60E1, or an outline file .toml, .csv, .dxf"""
    unit: LengthUnit | None = None
    """unit of a file that does not name one; coordinates are not converted"""
    half: bool = False
    """whether a CSV file contains one half only, to be mirrored about x = 0"""
    layers: list[str] = Field([])
    """layers of a DXF file, shown or not (default: what is visible)"""
    method: Literal["fem", "vem"] = "fem"
    """fem is triangles, vem is polygons with virtual elements"""
    order: Annotated[int, at.Ge(1), at.Le(6)] = 2
    """order of the elements; fem up to 3"""
    size: Annotated[float, at.Ge(1e-9), at.Le(1e9)] | None = None
    """edge length in the section's unit (default: chosen from the section)"""
    poisson: Annotated[float, at.Ge(0.0), at.Le(0.5)] | None = None
    """Poisson's ratio for the shear centre (default: Trefftz's shear centre)"""
    axial_N: float = 0.0
    """axial force at the centroid in N, tension positive"""
    shear_N: Pair = (0.0, 0.0)
    """shear forces in N along x and y through the shear centre"""
    moments: Pair = (0.0, 0.0)
    """bending moments about x and y in N times the section's unit: they pull at positive y, and at negative x"""
    torque: float = 0.0
    """torque about the shear centre in N times the section's unit, counter-clockwise"""

    @property
    def element(self) -> Element:
        """The element; an `InputError` if there is none of this order."""
        if self.method == "vem":
            return Virtual(self.order)
        with located(f"order = {self.order} with method = fem: "):
            return Lagrange(self.order)

    @property
    def has_forces(self) -> bool:
        """Whether there are forces, and so stresses."""
        return any((self.axial_N, self.torque, *self.shear_N, *self.moments))

    @property
    def drawn(self) -> DrawnSection:
        """What was drawn of the section."""
        return find_section(self.section, unit=self.unit, mirrored=self.half, layers=self.layers)

    def check(self) -> None:
        """See `RunnableCase.check`."""
        _ = self.element
        if len(self.drawn.section.parts) > 1 and self.has_forces:
            raise InputError(
                "forces on a section of several materials", "one material", "take flangeway.forms.BeamSection in Python"
            )

    def run(self, progress: Progress = lambda _: None) -> "SectionRun":
        """See `RunnableCase.run`."""
        return run_section(self.drawn, self, progress)


@dataclass(frozen=True, eq=False)
class SectionRun(RunResult):
    """A section and its constants."""

    case: TorsionCase  # the inputs
    drawn: DrawnSection  # what was read
    size: float  # edge length, chosen if it was not given
    poisson: float  # Poisson's ratio for the shear centre
    space: Space  # space on the mesh
    beam: BeamSection  # bending, shear and stresses on the mesh
    constants: SectionConstants
    """The constants; area, centroid and second moments exact for the outline's lines and arcs."""
    notices: Sequence[str]  # what the reader should know
    timings_s: Mapping[str, float]  # seconds by stage
    status: Status = SOLVED  # how it ended

    @cached_property
    def stresses(self) -> Floats | None:
        """Stresses zz, zx, zy at the points of the mesh under all forces, (n_points, 3); None without forces."""
        if not self.case.has_forces:
            return None
        axial, shear = self.case.axial_N, self.case.shear_N
        moments, torque = self.case.moments, self.case.torque
        return self.beam.stresses(self.space.mesh.points, force=axial, shear=shear, moments=moments, torque=torque)

    @property
    def von_mises(self) -> Floats:
        """Von Mises stresses of `stresses`, (n_points,)."""
        assert self.stresses is not None  # asked for where there are forces
        normal, shear = self.stresses[:, 0], norms(self.stresses[:, 1:])
        return np.asarray(np.sqrt(normal**2 + 3.0 * shear**2))

    @property
    def stress_unit(self) -> str:
        """Unit of the stresses: MPa of lengths in mm, else as N/in²."""
        return "MPa" if self.drawn.unit == "mm" else f"N/{self.drawn.unit}²"

    @cached_property
    def numbers(self) -> dict[str, Any]:
        """The numbers, with the section's unit in the keys."""
        return _numbers(self)

    def parts(self) -> dict[str, Any]:
        """See `RunResult.parts`: the keys have the section's unit."""
        return self.numbers | {"notices": self.notices}

    @property
    def table(self) -> ResultTable:
        """The constants."""
        return ResultTable.of_numbers({key: value for key, value in self.numbers.items() if key != "mesh"})


def find_section(
    name_or_file: str, *, unit: str | None = None, mirrored: bool = False, layers: Sequence[str] = ()
) -> DrawnSection:
    """Return a bundled section by its name, or read one from a file.

    It is an `InputError` if there is neither, or the file is wrong.
    """
    path = Path(name_or_file)
    if path.suffix.lower() in ENDINGS or path.exists() or len(path.parts) > 1:
        return read_section(path, unit=unit, mirrored=mirrored, layers=layers)
    if unit is not None or mirrored or layers:
        asked = f"the unit {unit}" if unit is not None else "a mirror image" if mirrored else "layers"
        raise InputError(f"{asked} for {name_or_file}", "a file", "leave it out for a bundled section")
    return bundled_section(name_or_file)


def run_section(
    drawn: DrawnSection, case: TorsionCase | None = None, progress: Progress = lambda _: None
) -> SectionRun:
    """Mesh a section and compute its constants by both formulations of torsion.

    It is an `InputError` if the section is in several pieces, its parts overlap, or an option is not allowed.
    `MissingLibraryError`: if the mesh generator lacks a shared library of the system.
    - `case`: how; the usual way if left out. The section is the one that is given.
    """
    start = time.perf_counter()
    given = case or TorsionCase.from_values({})
    element = given.element
    poisson, notices = _poisson(drawn, given)
    size = given.size or usual_size(drawn.section)
    progress("meshing the section")
    space = Space(section_mesh(drawn.section, size, given.method), element)
    progress(f"solving for the warping function and Prandtl's function, {space.n_dofs} unknowns each")
    moduli = {name: material.shear_modulus_MPa for name, material in drawn.materials.items()} or 1.0
    constants = section_constants(space, shear_modulus=moduli, poisson=poisson)
    weights = _young_weights(drawn)
    exact = replace(
        constants,
        area=drawn.section.area,
        centroid=drawn.section.centroid(weights),
        second_moments=drawn.section.second_moments(weights),
    )
    beam = BeamSection(space, poisson=poisson, known=constants)
    notices = [*drawn.notices, *notices, *_corner_notices(drawn)]
    if exact.all_axes_principal:
        notices.append("Both principal moments are equal: every axis through the centroid is principal, no angle is.")
    return SectionRun(given, drawn, size, poisson, space, beam, exact, notices, {"total": time.perf_counter() - start})


def usual_size(section: Section) -> float:
    """Return an element size with four triangles across a wall and about 3000 in a compact section.

    Limits of 30,000 triangles and 10,000 edges on the boundary keep foils from taking minutes.
    """
    per_triangle = section.area / (0.25 * math.sqrt(3.0))
    compact, smallest = math.sqrt(per_triangle / _USUAL_TRIANGLES), math.sqrt(per_triangle / _MAX_TRIANGLES)
    boundary = sum(region.boundary_length for region in section.regions)
    return max(min(section.mean_thickness / _CELLS_ACROSS_WALL, compact), smallest, boundary / _MAX_EDGES)


def section_mesh(section: Section, size: float, method: str) -> PolyMesh:
    """Return triangles, or their dual polygons, finer along arcs so that their chords hardly change the section.

    It is an `InputError` if the section is in pieces that do not touch, or as for `triangulate_section`.
    """
    mesh_bound(section.regions, size)  # refuses a size before arcs are cut into chords as fine
    triangles = triangulate_section(section, size=size, refinements=_along_arcs(section, size))
    n_pieces = int(connected(triangles.cell_neighbours, triangles.n_cells).max()) + 1
    if n_pieces > 1:
        raise InputError(
            f"a section in {n_pieces} pieces that do not touch",
            "parts that share edges",
            "join them, or compute each piece alone",
        )
    return triangles if method == "fem" else dual_section(triangles)


def _along_arcs(section: Section, size: float) -> list[Refinement]:
    """Return refinements along arcs; the sagitta of chords shrinks with the square of the size."""
    sagitta = _SAGITTA * section.mean_thickness * (size / usual_size(section)) ** 2
    # parts that touch draw their common arc twice, in both directions
    arcs = {
        (min(arc.start, arc.end), max(arc.start, arc.end), arc.centre): arc
        for region in section.regions
        for loop in region.loops
        for arc in loop.segments
        if isinstance(arc, Arc)
    }
    refinements = []
    for arc in arcs.values():
        # rounded, so that arcs of one radius are refined alike, by one field of sizes
        chord = float(f"{math.sqrt(8.0 * arc.radius * sagitta):.10g}")
        if chord < _MAX_CHORD * size:
            n_chords = max(math.ceil(arc.length / chord), 2)
            refinements.append(Refinement(arc.point(np.linspace(0.0, 1.0, n_chords + 1)), chord, _GROWTH))
    return refinements


def _poisson(drawn: DrawnSection, case: TorsionCase) -> tuple[float, list[str]]:
    """Return Poisson's ratio for the shear centre, and what to say about it."""
    ratios = {material.poisson for material in drawn.materials.values()}
    if case.poisson is not None and ratios:
        raise InputError(
            f"poisson = {case.poisson:g} for a section with materials", "the materials' own", "leave it out"
        )
    if len(ratios) > 1:
        return 0.0, [
            "The materials have several Poisson's ratios: the shear centre is Trefftz's, and it and the warping "
            "constant are weighted by shear moduli."
        ]
    return next(iter(ratios), case.poisson or 0.0), []


def _young_weights(drawn: DrawnSection) -> dict[str, float] | None:
    """Return each part's Young's modulus over their mean over the area, None for one material."""
    if not drawn.materials:
        return None
    mean = _mean(drawn, "young_MPa")
    return {name: material.young_MPa / mean for name, material in drawn.materials.items()}


def _mean(drawn: DrawnSection, modulus: str) -> float:
    """Return the mean over the area of a modulus, by its name in `PartMaterial`."""
    moments = (getattr(drawn.materials[name], modulus) * part.area for name, part in drawn.section.parts.items())
    return sum(moments) / drawn.section.area


def _corner_notices(drawn: DrawnSection) -> list[str]:
    corners = np.vstack([region.reentrant_corners() for region in drawn.section.regions])
    if not len(corners) or len(drawn.section.parts) > 1:
        return []
    x, y = corners[0]
    return [
        f"{len(corners)} sharp reentrant corner{'s' * (len(corners) > 1)}, the first at ({x:.6g}, {y:.6g}): the "
        "elastic stress there has no limit, so that no maximum shear stress is given."
    ]


def _numbers(run: SectionRun) -> dict[str, Any]:
    """Return the numbers, with the section's unit in the keys."""
    drawn, constants, unit, mesh = run.drawn, run.constants, run.drawn.unit, run.space.mesh
    maximum, smallest = constants.principal_moments
    low, high = constants.torsion_bounds
    summary: dict[str, Any] = {
        "title": drawn.title,
        f"area_{unit}2": constants.area,
        "mass_per_metre_kg_m": None if drawn.materials else 1e-6 * UNITS_MM[unit] ** 2 * constants.area * STEEL_KG_M3,
        f"boundary_length_{unit}": sum(region.boundary_length for region in drawn.section.regions),
        f"centroid_{unit}": list(constants.centroid),
        f"second_moments_{unit}4": dict(zip(("xx", "yy", "xy"), constants.second_moments, strict=True)),
        f"principal_moments_{unit}4": [maximum, smallest],
        "principal_angle_deg": _angle_deg(constants.principal_angle),
        **_bending(run),
        f"torsion_constant_{unit}4": constants.torsion_constant,
        f"torsion_constant_prandtl_{unit}4": low,
        f"torsion_constant_warping_{unit}4": high,
        "torsion_bounds_certain": constants.bounds_certain,
        f"shear_centre_{unit}": list(constants.shear_centre),
        f"shear_centre_trefftz_{unit}": list(constants.shear_centre_trefftz),
        "poisson": run.poisson,
        f"warping_constant_{unit}6": constants.warping_constant,
        f"max_shear_stress_per_torque_per_{unit}3": _max_shear(drawn, constants),
        "mesh": {
            "method": run.case.method,
            "order": run.case.order,
            f"size_{unit}": run.size,
            "cells": mesh.n_cells,
            "unknowns": run.space.n_dofs,
            f"area_{unit}2": float(mesh.cell_areas.sum()),
        },
        **_forces(run),
        "unit": unit,
        "certainty": drawn.certainty or None,
    }
    if drawn.materials:
        summary["weights"] = {
            "reference_young_MPa": _mean(drawn, "young_MPa"),
            "reference_shear_modulus_MPa": _mean(drawn, "shear_modulus_MPa"),
            "meaning": "Centroid and second moments are weighted by Young's modulus over its reference, all that "
            "concerns torsion by shear modulus over its reference. Multiply by the reference for stiffnesses.",
        }
    return summary


def _bending(run: SectionRun) -> dict[str, dict[str, float]]:
    """Return radii of gyration, elastic and plastic moduli, their ratios, and shear areas."""
    drawn, constants = run.drawn, run.constants
    unit, (xx, yy, _) = drawn.unit, constants.second_moments
    radii = {"xx": math.sqrt(xx / constants.area), "yy": math.sqrt(yy / constants.area)}
    properties = {f"radii_of_gyration_{unit}": radii}
    if len(drawn.section.parts) == 1:  # of several materials each has a stress of its own
        low, high = np.abs(drawn.section.bounds() - constants.centroid).tolist()
        properties[f"section_moduli_{unit}3"] = {
            "top": xx / high[1],
            "bottom": xx / low[1],
            "right": yy / high[0],
            "left": yy / low[0],
        }
        plastic = {axis: run.beam.plastic(angle=angle)[1] for axis, angle in (("xx", 0.0), ("yy", 0.5 * math.pi))}
        least = {"xx": xx / max(low[1], high[1]), "yy": yy / max(low[0], high[0])}
        properties[f"plastic_moduli_{unit}3"] = plastic
        properties["shape_factors"] = {axis: plastic[axis] / least[axis] for axis in plastic}
        properties[f"shear_areas_{unit}2"] = dict(zip("xy", run.beam.shear_areas.tolist(), strict=False))
    return properties


def _forces(run: SectionRun) -> dict[str, Any]:
    """Return the maximum stresses under the forces of the case, and where the von Mises stress has its maximum."""
    if run.stresses is None:
        return {}
    of, normal, mises = stress_key(run), run.stresses[:, 0], run.von_mises
    return {
        f"normal_stress_{of}": [float(normal.min()), float(normal.max())],
        f"max_shear_stress_{of}": float(norms(run.stresses[:, 1:]).max()),
        f"max_von_mises_{of}": float(mises.max()),
        f"max_von_mises_position_{run.drawn.unit}": run.space.mesh.points[mises.argmax()].tolist(),
    }


def stress_key(run: SectionRun) -> str:
    """Return the unit of stresses as keys have it: MPa, or as N_per_in2."""
    return run.stress_unit.replace("/", "_per_").replace("²", "2")


def _angle_deg(angle_rad: float) -> float:
    """Return an angle of an axis above -90 and up to 90 degrees."""
    angle = math.degrees(angle_rad)
    return angle + 180.0 if angle <= -90.0 + 1e-9 else angle


def _max_shear(drawn: DrawnSection, constants: SectionConstants) -> float | None:
    """Return the maximum shear stress for a torque of one, None where it has no limit or depends on the part."""
    if len(drawn.section.parts) > 1 or any(len(region.reentrant_corners()) for region in drawn.section.regions):
        return None
    stresses = corner_shear_stresses(constants.prandtl)
    return float(norms(stresses).max() / constants.prandtl.torsional_rigidity)
