"""Numbers of two bodies in contact in three dimensions."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flangeway.cases.patch_quantities import (
    ANGLE,
    AREA,
    AXES,
    CELLS,
    HERTZ_AXES,
    HERTZ_PRESSURE,
    MAX_PRESSURE,
    ON_SURFACE,
)
from flangeway.contact.patch.contact_ellipse import ContactEllipse
from flangeway.contact.patch.patch_contact import PatchContact
from flangeway.exact import PointContact
from flangeway.post.patch_stresses import DepthProfile
from flangeway.quantities import Quantities, Quantity
from flangeway.types import Floats


@dataclass(frozen=True, eq=False)
class SpatialPatchResult:
    """A patch of a contact."""

    contact: PatchContact
    ellipse: ContactEllipse
    remark: str = ""

    @cached_property
    def hertz(self) -> PointContact | None:
        """Hertz's contact for its force and curvatures."""
        return self.contact.hertz(self.ellipse)


@dataclass(frozen=True, eq=False)
class SpatialBodyResult:
    """One of both bodies, and the stresses below the centre of the first patch."""

    contact: PatchContact
    number: int
    profile: DepthProfile

    @property
    def name(self) -> str:
        """Of the body."""
        return (self.contact.pair.first, self.contact.pair.second)[self.number].name

    @property
    def sizes(self) -> tuple[int, int]:
        """Elements, and unknowns of each wavenumber."""
        body = (self.contact.pair.first, self.contact.pair.second)[self.number]
        space = body.problem.elasticity.space
        return space.mesh.n_cells, 3 * space.n_dofs

    def maximum(self, values: Floats) -> tuple[float, float]:
        """Maximum of a stress on the line below the patch, MPa, and its depth in mm."""
        at = int(np.nanargmax(values))
        return float(values[at]), float(self.profile.depths[at])

    @property
    def von_mises(self) -> tuple[float, float]:
        """Maximum von Mises stress and its depth."""
        return self.maximum(self.profile.stresses.von_mises)

    @property
    def tresca(self) -> tuple[float, float]:
        """Maximum of Tresca's stress and its depth."""
        return self.maximum(self.profile.stresses.tresca)


LOAD: Quantity[PatchContact] = Quantity("load", "force", "force.1", "kN", ".5g", factor=1e-3)
"""The force as it is given; the summary has its components."""
APPROACH: Quantity[PatchContact] = Quantity("approach", "approach from first touch", "approach", "mm", ".5g")
CONTACT: Quantities[PatchContact] = (
    Quantity("force", "force on the upper body", "force", "N", "z.1f", ("x", "y")),
    APPROACH,
    Quantity(
        *("cell", "size of the cells", lambda c: (float(c.pair.grid.widths.mean()), c.pair.grid.strip), "mm"),
        parts=ON_SURFACE,
    ),
    Quantity("cells", "cells of the grid", "loaded.shape", "", "d", ON_SURFACE),
    Quantity("gap_error", "", "closed_error", meaning="gap under pressure over the approach"),
    Quantity("overlap_error", "", "overlap", meaning="overlap outside of the patch over the approach"),
)
PATCH: Quantities[SpatialPatchResult] = (
    Quantity("force", "force", "ellipse.force", "N", "z.1f", ("x", "y")),
    Quantity("centre", "centre of pressure", "ellipse.centre", "mm", "z.3f", ("x", "y", "z")),
    MAX_PRESSURE,
    HERTZ_PRESSURE,
    AXES,
    HERTZ_AXES,
    ANGLE,
    AREA,
    CELLS,
)
MAX_VON_MISES: Quantity[SpatialBodyResult] = Quantity(
    "max_von_mises",
    "maximum von Mises stress",
    "von_mises.0",
    "MPa",
    ".1f",
    meaning="on the normal below the centre of the first patch",
)
BODY: Quantities[SpatialBodyResult] = (
    Quantity("name", "", "name"),
    Quantity("elements", "elements", "sizes.0", form=","),
    Quantity("unknowns", "unknowns", "sizes.1", form=","),
    Quantity(
        "wavenumbers", "wavenumbers", lambda body: len(body.contact.pair.tables[body.number].wavenumbers), form="d"
    ),
    Quantity("interpolation_error", "", lambda body: body.contact.pair.tables[body.number].error),
    MAX_VON_MISES,
    Quantity("max_von_mises_depth", "  at the depth", "von_mises.1", "mm", ".3f"),
    Quantity("max_tresca", "maximum Tresca stress", "tresca.0", "MPa", ".1f"),
    Quantity("max_tresca_depth", "  at the depth", "tresca.1", "mm", ".3f"),
)
