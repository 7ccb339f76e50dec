"""Contact patch of a wheel on a rail in three dimensions."""

from collections.abc import Callable

import numpy as np

from flangeway.contact import Surface
from flangeway.contact.patch.patch_body import Axis, PatchBody
from flangeway.contact.patch.patch_contact import PatchContact, press_patch
from flangeway.contact.patch.patch_grid import grid_about
from flangeway.geometry import Placement
from flangeway.problems import Body, Elasticity, Harmonic
from flangeway.railway.track.placements import Side
from flangeway.railway.wheelset.wheelset_model import WheelsetModel


def spatial_patch(
    model: WheelsetModel,
    side: Side,
    force: float,
    *,
    cell_mm: float | None = None,
    window_mm: tuple[float, float] = (16.0, 24.0),
    tolerance: float = 1e-3,
    progress: Callable[[str], None] = lambda _: None,
) -> PatchContact:
    """Press a wheel on its rail vertically, from the position in which the rigid wheelset touches.

    Parameters
    ----------
    model
        Meshed wheelset and track.
    side
        Side of the track.
    force
        Vertical force in N.
    cell_mm
        Size of square cells; chosen with the window if left out.
    window_mm
        Width across and length along the track of the grid, with `cell_mm`.
    tolerance
        See `flangeway.solve.compliance_table`.
    progress
        Called with a sentence at each stage.

    Returns
    -------
    PatchContact
        Pressures on the rail's cells, in the axes of the track, mm and MPa.

    Raises
    ------
    InputError
        As `flangeway.contact.patch.patch_contact.press_patch`.

    """
    contact = model.contact(side)
    wheel, rail = contact.secondary, contact.primary
    if wheel.part.name.startswith("rail"):
        wheel, rail = rail, wheel
    placement = model.rigid_position.placement(model.problem.wheelset, side)
    back, roll = placement.inverse(), model.rigid_position.roll_rad
    axle = back.points([model.rigid_position.axle(model.problem.wheelset)])[0]
    direction = back.vectors([(np.cos(roll), np.sin(roll))])[0]
    lower = _body(rail, rail.part.placement)
    upper = _body(wheel, placement, Axis((axle[0], axle[1]), (direction[0], direction[1])))
    grid = None if cell_mm is None else grid_about(lower, upper, cell_mm, window_mm)
    return press_patch(lower, upper, force=force, grid=grid, tolerance=tolerance, progress=progress)


def _body(surface: Surface, placement: Placement, axis: Axis | None = None) -> PatchBody:
    body = surface.part.body
    assert isinstance(body, Body)  # wheels and rails are meshed
    problem = Harmonic(Elasticity(body.space, body.material, name=body.name), held=dict.fromkeys(body.supports, "xyz"))
    return PatchBody(problem, surface.edges.astype(np.int64), surface.curve, placement, axis)
