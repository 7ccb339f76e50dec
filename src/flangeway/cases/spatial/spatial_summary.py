"""What a case of two bodies in three dimensions leaves for programs to read."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flangeway.cases.summary import StatusSummary, Summary, SummaryPart
from flangeway.contact.patch.contact_ellipse import ContactEllipse
from flangeway.contact.patch.patch_contact import PatchContact
from flangeway.post.patch_stresses import DepthProfile
from flangeway.types import Floats

# ruff: noqa: N815 (units in names)


@dataclass(frozen=True)
class AtDepth(SummaryPart):
    """A maximum below a patch."""

    value_MPa: float
    depth_mm: float


@dataclass(frozen=True, kw_only=True)
class SpatialPatchSummary(SummaryPart):
    """A contact patch; Hertz's values are those for its force and its curvatures, None where these vary too much."""

    force_N: Sequence[float]
    centre_mm: Sequence[float]
    semi_axes_mm: Sequence[float]
    angle_deg: float
    area_mm2: float
    cells: Sequence[int]
    max_pressure_MPa: float
    hertz_semi_axes_mm: Sequence[float] | None
    hertz_pressure_MPa: float | None


@dataclass(frozen=True, kw_only=True)
class SpatialBodySummary(SummaryPart):
    """A body: its mesh, its compliance, and maxima on the line below the first patch."""

    name: str
    elements: int
    unknowns: int
    wavenumbers: int
    interpolation_error: float
    max_von_mises: AtDepth
    max_tresca: AtDepth


@dataclass(frozen=True, kw_only=True)
class SpatialSummary(Summary):
    """What ``summary.json`` of such a case holds."""

    force_N: Sequence[float]
    approach_mm: float
    patches: Sequence[SpatialPatchSummary]
    bodies: Sequence[SpatialBodySummary]
    cell_mm: Sequence[float]
    cells: Sequence[int]
    gap_error: float
    overlap_error: float
    notices: Sequence[str]


def summarise_spatial(
    case: dict[str, Any],
    found: PatchContact,
    profiles: Sequence[DepthProfile],
    timings_s: Mapping[str, float],
    notices: Sequence[str],
) -> SpatialSummary:
    """Return the summary of a contact.

    Parameters
    ----------
    case
        Name and inputs.
    found
        Pressures.
    profiles
        Stresses below the first patch in both bodies.
    timings_s
        Seconds by stage.
    notices
        What the reader should know.

    """
    pair = found.pair
    bodies = []
    for body, table, profile in zip((pair.first, pair.second), pair.tables, profiles, strict=True):
        space = body.problem.elasticity.space
        bodies.append(
            SpatialBodySummary(
                name=body.name,
                elements=space.mesh.n_cells,
                unknowns=3 * space.n_dofs,
                wavenumbers=len(table.wavenumbers),
                interpolation_error=table.error,
                max_von_mises=_maximum(profile, profile.stresses.von_mises),
                max_tresca=_maximum(profile, profile.stresses.tresca),
            )
        )
    return SpatialSummary(
        status=StatusSummary(found.status.converged, found.status.message),
        case=case,
        timings_s=dict(timings_s),
        force_N=found.force.tolist(),
        approach_mm=found.approach,
        patches=[_patch(found, patch) for patch in found.patches],
        bodies=bodies,
        cell_mm=(float(pair.grid.widths.mean()), pair.grid.strip),
        cells=found.loaded.shape,
        gap_error=found.closed_error,
        overlap_error=found.overlap,
        notices=list(notices),
    )


def _patch(found: PatchContact, patch: ContactEllipse) -> SpatialPatchSummary:
    hertz = found.hertz(patch)
    return SpatialPatchSummary(
        force_N=patch.force.tolist(),
        centre_mm=patch.centre.tolist(),
        semi_axes_mm=patch.semi_axes,
        angle_deg=float(np.rad2deg(patch.angle_rad)),
        area_mm2=patch.area,
        cells=patch.cells,
        max_pressure_MPa=patch.max_pressure,
        hertz_semi_axes_mm=None if hertz is None else hertz.semi_axes,
        hertz_pressure_MPa=None if hertz is None else hertz.max_pressure,
    )


def _maximum(profile: DepthProfile, values: Floats) -> AtDepth:
    at = int(np.nanargmax(values))
    return AtDepth(float(values[at]), float(profile.depths[at]))
