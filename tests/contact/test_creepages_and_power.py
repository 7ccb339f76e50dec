"""Longitudinal creepages of the exact theory were biased; T-gamma meant another thing for each theory."""

import numpy as np
import pytest

from flangeway.contact.patch.patch_grid import PatchGrid
from flangeway.contact.rolling.creepages import Creepages
from flangeway.contact.rolling.fast_theories import linear_theory, polach
from flangeway.contact.rolling.fastsim import fastrip, fastsim
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import RollingContact
from flangeway.materials import Elastic
from flangeway.railway.wheelset.rolling.patch_rolling import RollingPatch

STEEL = Elastic(210000.0, 0.3)
FORCE, FRICTION = 80000.0, 0.3


def ellipse(along: float, across: float, n: int = 16) -> RollingContact:
    """Hertz's pressure on n x n cells about an ellipse."""
    grid = PatchGrid(1.1 * across * np.linspace(-1.0, 1.0, n + 1), 2.2 * along / n, n)
    s = (grid.bounds[1:] + grid.bounds[:-1]) / 2.0 / across
    pressures = np.sqrt(np.maximum(1.0 - s[:, None] ** 2 - (grid.along / along) ** 2, 0.0))
    pressures *= FORCE / float((pressures * grid.widths[:, None] * grid.strip).sum())
    return RollingContact.between_half_spaces(grid, pressures, Friction(FRICTION), (STEEL, STEEL))


def test_longitudinal_creepage_of_a_cone_on_a_round_rail_is_that_of_its_radius() -> None:
    """Rows whose spin turns with the rail's normal, slip by the mean radius: b^2 / (5 r R) was added to it."""
    contact, radius, rail, cone = ellipse(6.0, 5.0), 460.0, 254.0, 0.05
    s = contact.places[0]
    # a row at s, with the contact angle cone + s / rail, turns about its normal by the sine over the radius
    spin = np.sin(cone + s / rail) / radius
    slip = 1.0 - (radius - cone * s) / radius + 3e-4
    motion = Creepages(slip - spin * s, 1e-4, spin, 1.0)
    state = linear_theory(contact, motion)
    patch = RollingPatch(None, state, contact)  # type: ignore[arg-type]  # creepages do not need the bodies
    shares = contact.row_shares
    assert patch.longitudinal_creepage == pytest.approx(
        float(shares @ slip) - float(shares @ s * (shares @ spin)), abs=1e-12
    )
    assert patch.longitudinal_creepage == pytest.approx(3e-4, abs=1e-9)
    biased = float(motion.along @ shares)
    assert patch.longitudinal_creepage - biased == pytest.approx(5.0**2 / (5.0 * radius * rail), rel=0.02)


MOTIONS = [(4e-3, 0.0, 0.0), (-5e-4, 5e-4, -1e-3)]


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("theory", [fastsim, fastrip])
def test_t_gamma_is_the_power_of_the_tractions_over_the_speed(theory, motion) -> None:
    """The sum of the power densities of the cells is T-gamma times the speed."""
    contact = ellipse(6.0, 4.0, 24)
    found = theory(contact, Creepages(*motion, 20.0))
    power = float(np.sum(found.power_density * contact.areas))
    assert power == pytest.approx(20.0 * found.t_gamma, rel=1e-9)
    assert found.frictional_power == pytest.approx(20.0 * found.t_gamma, rel=1e-12)


def test_no_theory_dissipates_less_than_nothing() -> None:
    """On 60 random ellipses and motions T-gamma is not negative, nor Polach's above the exact limit of full slip."""
    random = np.random.default_rng(7)
    for _ in range(60):
        along, across = np.exp(random.uniform(np.log(2.0), np.log(12.0), 2))
        contact = ellipse(along, across)
        unit = FRICTION * FORCE / (80000.0 * along * across)
        xi, eta, phi = random.normal(size=3) * unit * 10.0 ** random.uniform(-1.0, 0.7, 3)
        motion = Creepages(xi, eta, phi / np.sqrt(along * across))
        for theory in (polach, linear_theory, fastsim, fastrip):
            assert theory(contact, motion).t_gamma >= 0.0
        assert polach(contact, motion).t_gamma <= FRICTION * FORCE * np.hypot(xi, eta) * (1.0 + 1e-9)
