"""What all figures share: words for keys, colours of signed values, wear along the normal."""

from types import SimpleNamespace

import numpy as np
import pytest

from flangeway.elements import Virtual
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import rectangle_grid
from flangeway.problems import Elasticity, Traction, fixed
from flangeway.railway.profiles.bundled import rail
from flangeway.report.figures.drawing import COLOURS, SIGNED
from flangeway.report.figures.plots import plot_stress
from flangeway.report.profile import profile_figures
from flangeway.solve import solve_elasticity
from flangeway.space import Space


def test_signed_stresses_are_white_at_zero():
    """A stress that changes its sign is drawn in diverging colours about zero, an equivalent one is not."""
    space = Space(rectangle_grid(3.0, 1.0, 6, 3), Virtual(1))
    beam = Elasticity(space, Elastic(1e3, 0.3), loads=[Traction("right", (0.0, 1.0))], supports=[fixed("left")])
    solution = solve_elasticity(beam)
    drawn = {name: plot_stress(solution, name).collections[0] for name in ("xx", "von_mises")}
    assert drawn["xx"].get_cmap() is SIGNED
    assert drawn["xx"].norm.vmin == -drawn["xx"].norm.vmax
    assert drawn["von_mises"].get_cmap() is COLOURS


def test_wear_is_measured_along_the_normal():
    """A head that lies 0.5 mm lower is 0.5 mm below the nominal one at its top, and off its flanks only by a share."""
    nominal = rail("60E1")
    lowered = nominal.running_surface.transformed(Placement(0.0, (0.0, -0.5)))
    joint = SimpleNamespace(end=(0.0, 0.0), landing=(0.0, 0.0))
    profile = SimpleNamespace(outline=nominal.outline, title="lowered")
    joined = SimpleNamespace(nominal=nominal, measured=lowered, profile=profile, joints=2 * [joint])
    axes = profile_figures.join_figure(joined).axes[1]
    x, off = axes.lines[0].get_data()
    assert off.min() == pytest.approx(-0.5, abs=1e-3)
    assert off[np.abs(x).argmin()] == pytest.approx(-0.5, abs=1e-3)
    flank = np.abs(x) > 0.999 * np.abs(x).max()
    assert np.abs(off[flank]).max() < 0.2
    assert "at most 0.5 mm below it" in axes.get_title()
