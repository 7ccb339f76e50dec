"""Whether a balance that was found is an answer: every check that stands between a result and its user."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from flangeway.post import cell_stresses, check_contact
from flangeway.railway.track.discretisation import ROLES
from flangeway.railway.track.placements import SIDES, Side
from flangeway.railway.wheelset.equilibrium import Equilibrium
from flangeway.railway.wheelset.validity import below_contacts
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.solve import Status
from flangeway.types import Floats

if TYPE_CHECKING:
    from flangeway.railway.wheelset.wheelset_result import WheelRailPatch


MAX_RESIDUAL = 1e-6
"""Difference of contact forces and load over the vertical load; the search stops below 1e-10."""

YIELD_MPa = 510.0
"""Least yield strength of standard rail steel, 74 ksi (AREMA Manual for Railway Engineering, chapter 4)."""

FARTHEST_WAY = 0.05
"""Displacement over the rail's height, a mean rotation, above which linear strains of a rotation, half its square, are
no longer small against the elastic ones: 0.00125, 260 MPa in steel."""

STEEL_MPa = (190e3, 220e3)
"""Young's moduli that are taken for those of steel, whose yield strength is assumed where none is given."""


def checked(
    model: WheelsetModel,
    equilibrium: Equilibrium,
    patches: Sequence["WheelRailPatch"],
    missed: Sequence[Side],
    displacements: Mapping[str, Floats],
) -> tuple[Status, tuple[str, ...]]:
    """Return the final status, and warnings about what a converged iteration does not show.

    Errors, which make the status that of a failure: forces that do not balance the load, numbers that are not finite,
    contact that pulls, contact at the edge of the candidate zone or outside of it, and a penetration as large as the
    elastic sinking. Warnings: an unstable balance, a wheel in the air, a mesh too coarse for the contact, a pressure
    that oscillates, penetration that is not small, a rail that deflects more than linear bodies follow, and stresses
    below the contacts beyond the yield strength of rail steel.

    Parameters
    ----------
    model, equilibrium
        The wheelset and its position.
    patches
        Regions of contact.
    missed
        Sides on which wheel and rail overlap outside of the candidate zone.
    displacements
        Of all nodes of each part in its own frame, by name, each (n_dofs, 2).

    """
    names = [f"the {side} contact" for side in SIDES]
    regions = [patch.pressure for patch in patches]
    settings = model.problem.discretisation
    stiffer = "raise penalty_factor" if settings.nodal_penalty_N_per_mm is None else "raise nodal_penalty_N_per_mm"
    if settings.enforcement == "augmented-lagrange":
        stiffer = "lower penetration_mm"
    checks = check_contact(model.system, equilibrium.state, regions, names, "lower size_scale", stiffer)
    errors = [*_unbalanced(model, patches), *checks.errors, *_outside(patches, missed)]
    if not all(np.isfinite(each).all() for each in displacements.values()):
        errors.append("displacements are not finite numbers")
    status = equilibrium.status
    if status.converged and errors:
        status = Status(False, "; ".join(errors), status.iterations)
    warnings = list(checks.warnings)
    if equilibrium.stable is False:
        warnings.append("the balance is unstable: a small push carries the wheelset away from it")
    lost = [side for side in SIDES if not any(patch.side == side for patch in patches)]
    if lost and status.converged:
        warnings.append(f"the {' and '.join(lost)} wheel does not touch its rail")
    if status.converged:
        warnings += _beyond_linear(model, displacements)
        warnings += _beyond_yield(model, patches, displacements)
    return status, tuple(warnings)


def _unbalanced(model: WheelsetModel, patches: Iterable["WheelRailPatch"]) -> list[str]:
    """Compare the sum of the regions' forces with the load, along what is not held."""
    problem = model.problem
    along, onto = problem.load.in_track
    total = sum((patch.force_on_wheel_N for patch in patches), np.zeros(2))
    rows = (
        ("lateral", problem.prescribed.lateral_mm, total[0] + along),
        ("vertical", problem.prescribed.vertical_mm, total[1] - onto),
    )
    return [
        f"{name} contact forces and load differ by {abs(rest):.3g} N; raise this with the case file as a fault"
        for name, held, rest in rows
        if held is None and not abs(rest) <= MAX_RESIDUAL * math.hypot(along, onto)
    ]


def _outside(patches: Iterable["WheelRailPatch"], missed: Sequence[Side]) -> list[str]:
    sides = [side for side in SIDES if any(patch.side == side and patch.pressure.at_edge for patch in patches)]
    errors = [
        f"the {side} contact reaches the edge of the candidate zone, so contact outside of it is missing; check the "
        "profiles and the load"
        for side in sides
    ]
    if missed:
        errors.append(
            f"wheel and rail overlap outside of the candidate zone on the {' and '.join(missed)} side; check the "
            "profiles, the gauge and the load"
        )
    return errors


def _beyond_linear(model: WheelsetModel, displacements: Mapping[str, Floats]) -> list[str]:
    """Compare the maximum displacement of each rail with its height."""
    warnings = []
    for side in SIDES:
        points = model.parts[f"rail-{side}"].body.mesh.points
        way = float(np.linalg.norm(displacements[f"rail-{side}"], axis=1).max())
        share = way / float(np.ptp(points[:, 1]))
        if share > FARTHEST_WAY:
            warnings.append(
                f"the {side} rail gives way by {way:.1f} mm, {100.0 * share:.0f} % of its height, farther than linear "
                "bodies follow: believe neither its stresses nor the wheelset's motion"
            )
    return warnings


def _beyond_yield(
    model: WheelsetModel, patches: Sequence["WheelRailPatch"], displacements: Mapping[str, Floats]
) -> list[str]:
    """Compare the cells' maximum von Mises stress below the contacts with the yield strength; see `validity`."""
    given = model.problem.yield_MPa
    strength = YIELD_MPa if given is None else given
    beyond = []
    for role in ROLES:
        if given is None and not STEEL_MPa[0] <= model.problem.material_of(role).young <= STEEL_MPa[1]:
            continue
        maximum = 0.0
        for name, displacement in displacements.items():
            if name.startswith(role):
                mises = cell_stresses(model.parts[name].body.elasticity, displacement).von_mises
                maximum = max(maximum, float(mises[below_contacts(model, patches, name)].max(initial=0.0)))
        if maximum > strength:
            beyond.append(f"{maximum / strength:.1f} times in the {role}")
    if not beyond:
        return []
    assumed = "the least yield strength of standard rail steel (AREMA Manual, chapter 4)"
    source = assumed if given is None else "the yield strength"
    return [
        f"elastic von Mises stresses below the contacts exceed {strength:g} MPa, {source}: up to "
        f"{' and '.join(beyond)}; the material would yield, with less pressure on wider contact"
    ]
