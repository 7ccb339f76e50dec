"""What of a wheelset's stresses may be believed: those below the contacts, not those of web, fillets and foot.

The model is a slice whose whole length is loaded, so that its rail bears alone what a rail in track hands on along its
axis; see the page on limits.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from flangeway.railway.track.placements import Side
from flangeway.railway.wheelset.wheelset_model import WheelsetModel
from flangeway.types import Bools

if TYPE_CHECKING:
    from flangeway.railway.wheelset.wheelset_result import WheelRailPatch


BELOW = 2.0
"""Distance from a centre of pressure, over the contact's half width, that counts as below the contact: the largest
stresses of Hertz's contact are at 0.7 to 0.8 half widths."""

SLICE = (
    "Stresses in web, fillets and foot, the motion of the rail's head and the approach are those of a prism of {:g} mm "
    "that carries the whole load alone: compare them between runs, not with a rail in track."
)
"""What the limits say of the slice, with its thickness in mm."""


def below_contacts(model: WheelsetModel, patches: Iterable["WheelRailPatch"], name: str) -> Bools:
    """Return which cells of a part lie below one of its contacts, within `BELOW` half widths, shape (n_cells,)."""
    mesh = model.parts[name].body.mesh
    near = np.zeros(mesh.n_cells, dtype=np.bool_)
    for patch in patches:
        if name.endswith(patch.side):
            place = patch.wheel_point_mm if name.startswith("wheel") else patch.rail_point_mm
            distance = np.linalg.norm(mesh.cell_centroids - place, axis=1)
            near |= distance <= max(BELOW * patch.pressure.half_width, float(distance.min()))
    return near


def above_the_web(model: WheelsetModel, name: str) -> Bools:
    """Return which cells of a part belong to a rail's head, as far down as its running surface, or to a wheel."""
    mesh = model.parts[name].body.mesh
    if name.startswith("wheel"):
        return np.ones(mesh.n_cells, dtype=np.bool_)
    side: Side = "left" if name.endswith("left") else "right"
    lowest = float(model.problem.track.rail_of(side).running_surface.bounds()[0, 1])
    above: Bools = mesh.cell_centroids[:, 1] >= lowest
    return above
