"""Plane elasticity on the page of validation."""

from flangeway.validation.elasticity.elasticity_figures import cook_convergence_figure
from flangeway.validation.elasticity.elasticity_reproduced import (
    FEWER_UNKNOWNS,
    INCOMPRESSIBLE_LIMIT,
    ElasticityReproduction,
)
from flangeway.validation.elasticity.refinement_figures import refinement_convergence_figure
from flangeway.validation.published_numbers import percent
from flangeway.validation.validation_page import Chapter, PagePicture
from flangeway.validation.validation_tables import PageTable, digits, relative


def _tables(found: ElasticityReproduction) -> list[PageTable]:
    """Nearly incompressible material, and what adaptive refinement saves."""
    soft = tuple(
        (row.code, f"{row.n_unknowns}", relative(row.relative_difference)) for row in found.incompressible_rows
    )
    saved = tuple(
        (
            case.body,
            f"{case.order}",
            f"{case.uniform[-1].n_unknowns}",
            digits(case.uniform[-1].error, 2),
            digits(case.saving, 2) if case.saving > 0.0 else "**not reached**",
        )
        for case in found.refinements
    )
    return [
        PageTable(
            "Cook's membrane with Poisson's ratio 0.4999: the load's work against a reference of orders 3 and 4 on "
            f"fine meshes; order 2 must be within {percent(INCOMPRESSIBLE_LIMIT)} on every mesh, triangles of order 1 "
            "lock",
            ("code", "unknowns", "difference"),
            soft,
        ),
        PageTable(
            "How many times fewer unknowns adaptive refinement by virtual elements needs for the error in energy that "
            f"uniform refinement ends with; on the L-shaped body at least {FEWER_UNKNOWNS:g} times fewer",
            ("body", "order", "unknowns of uniform refinement", "its error", "times fewer"),
            saved,
        ),
    ]


CHAPTER = Chapter(
    "Plane elasticity",
    """A body under uniform tension (Moherdaui's Figure 56, page 149), which every element must bear without error.
    Cook's membrane of Moherdaui's section 5.3.2, for which it prints pictures: energy and displacements are those of
    Artioli, Beirão da Veiga, Lovadina and Sacco (2017), whose problem it takes; order 2 on the finest mesh must meet
    them, and each mesh must be nearer than the one before. The plate with a hole (Kirsch 1898) and the thick cylinder
    under pressure (Lamé 1852) in closed form. Codes such as VCM3O2: F, V or H, finite elements, virtual ones, or
    virtual ones at the boundary alone; the mesh; the order.""",
    (
        PagePicture(
            "elasticity-cook",
            "Errors of energy and of two displacements of Cook's membrane over the number of unknowns: all fall with "
            "each mesh, those of order 2 on the finest mesh to below 0.1 %",
            cook_convergence_figure,
        ),
        PagePicture(
            "elasticity-refinement",
            "Error in energy of Cook's membrane and of the L-shaped body over the number of unknowns: adaptive "
            "refinement falls faster than uniform refinement, most so on the L-shaped body with order 2",
            refinement_convergence_figure,
        ),
    ),
    _tables,
)
