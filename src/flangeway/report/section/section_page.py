"""Report, files and terminal summary of a section under torsion."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from flangeway.cases.section.section_run import STEEL_KG_M3, SectionRun
from flangeway.formats import write_vtu
from flangeway.post import corner_shear_stresses
from flangeway.quantities import Quantity, measured, present
from flangeway.report.page.case_text import case_text, inputs_tables
from flangeway.report.page.record import Again, Picture, Record
from flangeway.report.page.tables import SummaryTable, fact, rows_of
from flangeway.report.scenes import section_arrays, section_scene
from flangeway.report.section.section_figures import mesh_figure, prandtl_figure, shear_figure, warping_figure
from flangeway.units import Units

SUMMARY, FIELDS = "section.json", "section.vtu"
ASSUMPTIONS = (
    "Saint-Venant torsion of a straight bar: the section rotates without distortion and warps freely.",
    "Linear elastic, isotropic material; parts that share edges are joined there.",
    "Area, centroid and second moments are those of the outline's lines and arcs; torsion is that of the meshed "
    "polygon.",
)
AXES = {
    "x, y": "those of the outline's coordinates, to the right and up",
    "principal axes": "1 has the larger second moment; angles are counter-clockwise from x",
    "shear stress": "of a positive torque, which turns from x to y",
}


def section_record(run: SectionRun, command: str, summary_file: str = SUMMARY) -> Record:
    """Return what was found of a section; its first page is one to pass on.

    - `command`: computes it again.
    - `summary_file`: file of the numbers for programs.
    """
    found, case, units, unit = run.summary, run.case, run.case.units, run.drawn.unit
    kind = "triangles" if case.method == "fem" else "polygons, virtual elements"
    quantities = section_quantities(run, units)
    return Record(
        name=run.drawn.title,
        title=run.drawn.title,
        subtitle=f"Constants of a section; {run.space.mesh.n_cells:,} {kind} of order {case.order}, size "
        f"{measured(run.size, unit, units)}, {run.space.n_dofs:,} unknowns",
        converged=True,
        success="solved",
        message="by both formulations of torsion",
        facts=[fact(replace(of, form=".5g"), run, units) for of in present(quantities, run) if of.key in FACTS],
        results=SummaryTable(
            "Constants of the section", ("", "value"), tuple(rows_of(present(quantities, run), run, units))
        ),
        summary=found,
        summary_file=summary_file,
        again=Again(
            command,
            case_text(case),
            files=f"The same numbers, for programs, are in `{summary_file}`; the fields are in `section.vtu`, for "
            "ParaView.",
        ),
        units=units,
        notes=[
            *found["notices"],
            *weights_sentences(found),
            *([f"Outline: {found['certainty']}"] if found["certainty"] else []),
        ],
        assumptions=ASSUMPTIONS,
        scene=lambda: section_scene(run),
        pictures=[Picture(name, partial(draw, run, units), f"{words}.") for name, (draw, words) in PICTURES.items()],
        axes=AXES,
        inputs=inputs_tables(case),
        timings_s=found["timings_s"],
        files=lambda: {FIELDS: partial(_write_fields, run)},
    )


FACTS = ("area", "ixx", "iyy", "mass_per_metre", "torsion_constant", "warping_constant", "max_shear_stress_per_torque")
"""Keys of the numbers at the top of the page."""


def section_quantities(run: SectionRun, units: Units) -> list[Quantity[SectionRun]]:
    """Return the constants of a section, in its unit of length."""
    unit, constants, found = run.drawn.unit, run.constants, run.summary
    size = found[f"boundary_length_{unit}"]
    bounds = ("lower bound (Prandtl)", "upper bound (warping)")
    if not constants.bounds_certain:
        bounds = ("from Prandtl's function", "from the warping function")

    def number(key: str, label: str, value: Any, power: str = "", form: str = ".7g") -> Quantity[SectionRun]:
        return Quantity(key, label, lambda _: value, f"{unit}{power}" if power != "-" else "", form)

    def point(key: str, label: str, at: Sequence[float]) -> list[Quantity[SectionRun]]:
        # round-off would look like a result
        values = [0.0 if abs(value) < 1e-7 * size else value for value in at]
        return [number(f"{key}_{x}", f"{label} {x}", value, form=".6g") for x, value in zip("xy", values, strict=True)]

    steel = f"steel of {measured(STEEL_KG_M3, 'kg/m³', units)}"
    ixx, iyy, ixy = constants.second_moments
    moments = {"Ixx": ixx, "Iyy": iyy, "Ixy": 0.0 if abs(ixy) < 1e-9 * math.sqrt(ixx * iyy) else ixy}
    angle, torsion = found["principal_angle_deg"], constants.torsion_constant
    low, high = constants.torsion_bounds
    poisson, maximum = found["poisson"], found[f"max_shear_stress_per_torque_per_{unit}3"]
    centre = f"shear centre for ν = {poisson:g}" if poisson else "shear centre"
    return [
        number("area", "area", constants.area, "²"),
        Quantity("mass_per_metre", f"mass per length, {steel}", lambda _: found["mass_per_metre_kg_m"], "kg/m"),
        *point("centroid", "centroid", constants.centroid),
        *(
            number(name.lower(), f"second moment {name} about the centroid", value, "⁴")
            for name, value in moments.items()
        ),
        *(
            number(f"i{place}", f"principal moment I{place}", value, "⁴")
            for place, value in enumerate(constants.principal_moments, 1)
        ),
        number(
            "principal_angle",
            "angle of principal axis 1 from x, degrees",
            0.0 if abs(angle) < 1e-7 else angle,
            "-",
            ".5g",
        ),
        *(
            number(f"radius_{axis}", f"radius of gyration about {axis[0]}", value, form=".6g")
            for axis, value in found[f"radii_of_gyration_{unit}"].items()
        ),
        *(
            number(f"modulus_{side}", f"section modulus, {side}", value, "³", ".6g")
            for side, value in found.get(f"section_moduli_{unit}3", {}).items()
        ),
        number("torsion_constant", "torsion constant J", torsion, "⁴"),
        *(number(name, f"  {name}", value, "⁴") for name, value in zip(bounds, (low, high), strict=True)),
        number("half_gap", "  half their difference, relative", 0.5 * abs(high - low) / torsion, "-", ".1e"),
        *point("shear_centre", centre, constants.shear_centre),
        *(point("shear_centre_trefftz", "shear centre by Trefftz", constants.shear_centre_trefftz) if poisson else []),
        number("warping_constant", "warping constant", constants.warping_constant, "⁶"),
        number("max_shear_stress_per_torque", "maximum shear stress per torque", maximum, "⁻³", ".5g"),
    ]


def weights_sentences(summary: Mapping[str, Any]) -> list[str]:
    """Return what several materials mean for the constants, nothing for one material."""
    if "weights" not in summary:
        return []
    weights = summary["weights"]
    return [
        f"{weights['meaning']} References: E = {weights['reference_young_MPa']:.6g} MPa, "
        f"G = {weights['reference_shear_modulus_MPa']:.6g} MPa."
    ]


PICTURES: dict[str, tuple[Callable[[SectionRun, Units], Figure], str]] = {
    "mesh.png": (mesh_figure, "The mesh, with the centroid, the shear centre and the principal axes"),
    "warping.png": (warping_figure, "Warping about the shear centre over the rate of twist, with contour lines"),
    "shear_stress.png": (shear_figure, "Shear stress for a unit torque, with arrows in its direction"),
    "prandtl.png": (prandtl_figure, "Prandtl's function, whose contour lines are lines of shear flow"),
}
"""Functions that draw the pictures, the most important first, and what they show, by the files' names."""


def _write_fields(run: SectionRun, path: Path) -> None:
    """Write warping about the shear centre, Prandtl's function, and shear stress per torque, unit in the names."""
    mesh = run.space.mesh
    part = np.zeros(mesh.n_cells, dtype=np.int32)
    for number, cells in enumerate(mesh.cell_sets.values()):
        part[cells] = number
    points, (shear,) = section_arrays(run)
    prandtl = run.constants.prandtl
    corners = {shear: corner_shear_stresses(prandtl) / prandtl.torsional_rigidity}
    write_vtu(path, mesh, points, {"part": part}, corners)
