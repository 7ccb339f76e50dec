"""Newton's method on items, held against Hill's thick cylinder beyond yield."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.typing import NDArray

from flangeway.elements import Element, Lagrange, Virtual
from flangeway.errors import InputError
from flangeway.geometry import rectangle
from flangeway.materials import Elastic
from flangeway.mesh import dual, triangulate
from flangeway.problems import Elasticity, Pressure
from flangeway.problems.items import Item, LinearItem
from flangeway.problems.nonlinear_body import NonlinearBody
from flangeway.problems.supports import PrescribedDisplacement
from flangeway.solve import solve_elasticity
from flangeway.solve.item_newton import ItemSolution, solve_items
from flangeway.space import Space

Floats = NDArray[np.float64]

INNER, OUTER, HEIGHT = 100.0, 200.0, 20.0
YOUNG, POISSON, YIELD = 210e3, 0.3, 240.0


@dataclass(frozen=True)
class VonMises:
    """Linear elasticity and von Mises plasticity with linear isotropic hardening, by radial return.

    Simo and Hughes (1998), "Computational Inelasticity", box 3.2; history: plastic strains xx, yy, 2 xy, zz and the
    equivalent plastic strain.
    """

    young: float
    poisson: float
    strength: float
    hardening: float = 0.0

    def initial(self, n_points: int) -> Floats:
        return np.zeros((5, n_points))

    def respond(self, strains: Floats, history: Floats) -> tuple[Floats, Floats, Floats]:
        shear = self.young / (2.0 * (1.0 + self.poisson))
        bulk = self.young / (3.0 * (1.0 - 2.0 * self.poisson))
        unit = np.array([1.0, 1.0, 0.0, 1.0])
        halved = np.diag([1.0, 1.0, 0.5, 1.0])
        deviatoric = halved - np.outer(unit, unit) / 3.0
        trial = 2.0 * shear * deviatoric @ (strains - history[:4])
        norm = np.sqrt((trial**2 * np.array([1.0, 1.0, 2.0, 1.0])[:, None]).sum(axis=0))
        radius = np.sqrt(2.0 / 3.0) * (self.strength + self.hardening * history[4])
        yields = norm > radius
        multiplier = np.where(yields, (norm - radius) / (2.0 * shear + 2.0 / 3.0 * self.hardening), 0.0)
        normal = trial / np.where(yields, norm, 1.0)
        stresses = trial - 2.0 * shear * multiplier * normal + bulk * unit[:, None] * (unit @ strains)
        theta = np.where(yields, 1.0 - 2.0 * shear * multiplier / np.where(yields, norm, 1.0), 1.0)
        theta_bar = np.where(yields, 1.0 / (1.0 + self.hardening / (3.0 * shear)) - (1.0 - theta), 0.0)
        moduli = (bulk * np.outer(unit, unit))[..., None] + 2.0 * shear * deviatoric[..., None] * theta
        moduli = moduli - 2.0 * shear * theta_bar * normal[:, None] * normal
        flow = multiplier * normal * np.array([1.0, 1.0, 2.0, 1.0])[:, None]
        return stresses, moduli, np.vstack((history[:4] + flow, history[4] + np.sqrt(2.0 / 3.0) * multiplier))


def strip(element: Element, poisson: float = 0.499, *, polygons: bool = False, size: float = 10.0) -> Elasticity:
    """A slice of the cylinder about its axis; its ends do not move along the axis, as in plane strain."""
    mesh = triangulate(rectangle(OUTER - INNER, HEIGHT, ((INNER + OUTER) / 2.0, HEIGHT / 2.0)), size=size)
    material = Elastic(YOUNG, poisson, hypothesis="axisymmetric")
    rollers = [PrescribedDisplacement(side, y=0.0) for side in ("bottom", "top")]
    space = Space(dual(mesh) if polygons else mesh, element)
    return Elasticity(space, material, loads=[Pressure("left", 1.0)], supports=rollers)


def free_unknowns(problem: Elasticity) -> NDArray[np.bool_]:
    """All but the axial displacements of the ends."""
    height = problem.space.nodes[:, 1]
    free = np.ones((problem.space.n_dofs, 2), dtype=np.bool_)
    free[: len(height), 1] = (height > 1e-9) & (height < HEIGHT - 1e-9)
    return free.ravel()


def pressed(problem: Elasticity, items: Sequence[Item], pressure: float, *, condense: bool = True) -> ItemSolution:
    """The items under an inner pressure on the cylinder."""
    n = 2 * problem.space.n_dofs
    load = LinearItem(np.arange(n), sp.csr_array((n, n)), pressure * problem.load_vector().ravel())
    return solve_items([*items, load], np.zeros(n), free_unknowns(problem), condense=condense)


def outer_displacement(problem: Elasticity, found: ItemSolution) -> float:
    """Mean radial displacement of the outer face."""
    at_nodes = found.state.reshape(-1, 2)[: problem.space.n_nodes, 0]
    return float(at_nodes[problem.space.nodes[:, 0] > OUTER - 1e-9].mean())


def hill(front: float) -> tuple[float, float]:
    """Inner pressure and outer radial displacement with yield up to a radius (Hill, 1950, V.2, incompressible)."""
    in_shear = YIELD / np.sqrt(3.0)
    pressure = in_shear * (2.0 * np.log(front / INNER) + 1.0 - front**2 / OUTER**2)
    return pressure, 1.5 * in_shear * front**2 / (YOUNG * OUTER)


@pytest.mark.parametrize(("element", "polygons"), [(Lagrange(2), False), (Virtual(2), True)], ids=["fem", "vem"])
def test_a_thick_cylinder_beyond_yield_is_hills(element: Element, polygons: bool) -> None:
    """With yield half way through the wall, the outer radius grows as Hill's closed form has it, to 0.2 %."""
    problem = strip(element, polygons=polygons)
    pressure, expected = hill(150.0)
    found = pressed(problem, [NonlinearBody(problem, VonMises(YOUNG, 0.499, YIELD))], pressure)
    assert found.status.converged
    assert outer_displacement(problem, found) == pytest.approx(expected, rel=2e-3)


def test_the_cylinder_fails_at_the_limit_load() -> None:
    """Just below Hill's limit pressure there is an equilibrium, just above there is none."""
    problem = strip(Lagrange(2))
    limit, _ = hill(OUTER)
    body = NonlinearBody(problem, VonMises(YOUNG, 0.499, YIELD))
    assert pressed(problem, [body], 0.99 * limit).status.converged
    beyond = pressed(problem, [body], 1.01 * limit)
    assert not beyond.status.converged
    assert "smaller load steps" in beyond.status.message


@pytest.mark.parametrize(("element", "polygons"), [(Lagrange(2), False), (Virtual(1), True)], ids=["fem", "vem"])
def test_newtons_method_converges_quadratically_with_hardening(element: Element, polygons: bool) -> None:
    """The last residual above round-off is at most the power 1.7 of the one before."""
    problem = strip(element, 0.3, polygons=polygons)
    pressure, _ = hill(150.0)
    found = pressed(problem, [NonlinearBody(problem, VonMises(YOUNG, 0.3, YIELD, hardening=YOUNG / 20.0))], pressure)
    assert found.status.converged
    settled = [value for value in found.residuals if 1e-12 < value < 0.05]
    assert len(settled) >= 2
    assert np.log(settled[-1]) <= 1.7 * np.log(settled[-2])


def test_what_yielded_stays_when_the_pressure_goes() -> None:
    """Unloading from an accepted state is elastic: displacements fall by those of the elastic cylinder, to 1e-9."""
    problem = strip(Lagrange(2), 0.3)
    pressure, _ = hill(130.0)
    loaded = pressed(problem, [NonlinearBody(problem, VonMises(YOUNG, 0.3, YIELD, hardening=YOUNG / 20.0))], pressure)
    unloaded = pressed(problem, loaded.items[:1], 0.0)
    elastic = pressure * solve_elasticity(problem).displacements.ravel()
    assert loaded.status.converged
    assert unloaded.status.converged
    assert np.abs(loaded.state - unloaded.state - elastic).max() <= 1e-9 * np.abs(elastic).max()
    assert outer_displacement(problem, unloaded) > 1e-3 * outer_displacement(problem, loaded)


@pytest.mark.parametrize("condense", [True, False])
def test_linear_items_need_one_iteration(condense: bool) -> None:
    """An elastic body with its load is `solve_elasticity`'s to 1e-10, found by one step."""
    problem = strip(Virtual(2), 0.3, polygons=True)
    n = 2 * problem.space.n_dofs
    body = LinearItem(np.arange(n), problem.stiffness().full(), np.zeros(n))
    found = pressed(problem, [body], 1.0, condense=condense)
    expected = solve_elasticity(problem).displacements.ravel()
    assert found.status.iterations == 1
    assert np.abs(found.state - expected).max() <= 1e-10 * np.abs(expected).max()


@dataclass(frozen=True, eq=False)
class HardeningSprings(Item):
    """Springs whose force is ``u + u^3`` times a stiffness."""

    numbers: NDArray[np.int64]
    stiffness: float

    @property
    def unknowns(self) -> NDArray[np.int64]:
        return self.numbers

    def residual(self, state: Floats) -> Floats:
        return self.stiffness * (state + state**3)

    def tangent(self, state: Floats) -> sp.csr_array:
        return sp.csr_array(sp.diags_array(self.stiffness * (1.0 + 3.0 * state**2)))


def test_condensed_linear_items_give_the_same_state() -> None:
    """A linear cylinder in nonlinear springs has the same displacements with its inside condensed, to 1e-10."""
    problem = strip(Lagrange(2), 0.3)
    n = 2 * problem.space.n_dofs
    body = LinearItem(np.arange(n), problem.stiffness().full(), np.zeros(n))
    outer = 2 * np.flatnonzero(problem.space.nodes[:, 0] > OUTER - 1e-9)
    items = [body, HardeningSprings(outer, 1e7)]
    condensed, full = (pressed(problem, items, 2000.0, condense=condense) for condense in (True, False))
    assert condensed.status.converged
    assert condensed.status.iterations > 2
    assert np.abs(condensed.state - full.state).max() <= 1e-10 * np.abs(full.state).max()


def test_an_unknown_without_stiffness_is_refused() -> None:
    """The message names the unknown."""
    springs = HardeningSprings(np.array([0]), 1.0)
    load = LinearItem(np.arange(2), sp.csr_array((2, 2)), np.ones(2))
    with pytest.raises(InputError, match="unknown 1"):
        solve_items([springs, load], np.zeros(2), np.ones(2, dtype=np.bool_))
