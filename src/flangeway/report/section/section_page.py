"""The report of a section under torsion."""

from collections.abc import Mapping, Sequence
from typing import Any

from flangeway.cases.section.section_run import SectionRun
from flangeway.cases.section.torsion_case import TorsionCase
from flangeway.report.page.case_text import case_text, inputs_tables
from flangeway.report.page.html_page import Again, Page, Picture
from flangeway.report.page.page_tables import Table, timings_table
from flangeway.report.scenes import section_scene
from flangeway.report.section.section_tables import section_rows, weights_sentences

SOLVED = "both formulations of torsion are solved"
AXES = {
    "x, y": "those of the outline's coordinates, to the right and up",
    "principal axes": "1 has the larger second moment; angles are counter-clockwise from x",
    "shear stress": "of a positive torque, which turns from x to y",
}


def section_page(
    run: SectionRun, case: TorsionCase, pictures: Sequence[Picture], *, command: str, summary_file: str
) -> Page:
    """Return what the report of a section says.

    Parameters
    ----------
    run
        The section.
    case
        The inputs.
    pictures
        Pictures, the most telling first.
    command
        The command that computes it again.
    summary_file
        Name of the file with the numbers.

    """
    summary = run.summary
    mesh = summary["mesh"]
    kind = "triangles" if mesh["method"] == "fem" else "polygons, virtual elements"
    return Page(
        title=run.drawn.title,
        subtitle=f"A section under torsion; {mesh['cells']:,} {kind} of order {mesh['order']}, lengths in "
        f"{run.drawn.unit}",
        converged=True,
        message=SOLVED,
        facts=_facts(summary),
        again=Again(
            command,
            case_text(case),
            files=f"The same numbers, for programs, are in `{summary_file}`; the fields are in `section.vtu`, for "
            "ParaView.",
        ),
        versions=summary["versions"],
        sentences=weights_sentences(summary),
        warnings=summary["notices"],
        assumptions=_assumptions(summary),
        scene=section_scene(run),
        pictures=pictures,
        tables=[
            Table("Constants of the section", ("", "value"), tuple(section_rows(summary))),
            timings_table(summary["timings_s"]),
        ],
        axes=AXES,
        inputs=inputs_tables(case),
    )


def _facts(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    unit = summary["unit"]
    rows = [
        (f"area_{unit}2", f"{unit}²", "area"),
        (f"torsion_constant_{unit}4", f"{unit}⁴", "torsion constant J"),
        (f"warping_constant_{unit}6", f"{unit}⁶", "warping constant"),
        (f"max_shear_stress_per_torque_per_{unit}3", f"{unit}⁻³", "maximum shear stress per torque"),
    ]
    return [(f"{summary[key]:.5g} {power}", name) for key, power, name in rows if summary[key] is not None]


def _assumptions(summary: Mapping[str, Any]) -> list[str]:
    sentences = [
        "Saint-Venant's torsion of a straight bar: the section turns as a whole and may warp freely.",
        "Linear elastic, isotropic material; parts that share edges are joined there.",
        "Area, centroid and second moments are those of the outline's lines and arcs; all that concerns torsion is "
        "that of the meshed polygon.",
    ]
    if summary["certainty"]:
        sentences.append(f"Outline: {summary['certainty']}")
    return sentences
