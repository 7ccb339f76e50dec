"""The case of Cook's membrane."""

import time
from typing import ClassVar, Literal

from pydantic import Field

from flangeway.cases.bodies.bodies_run import BodiesRun, BodyResult, summarise_bodies
from flangeway.cases.bodies.cook import CORNER, ENERGY, MAX_LEVEL, MIDDLE, CookCode, solve_cook
from flangeway.cases.case import Progress, RunnableCase
from flangeway.elements.lagrange import HIGHEST_ORDER
from flangeway.errors import InputError
from flangeway.post import displacements_at
from flangeway.solve import Status

LETTERS = {"fem": "F", "vem": "V", "mixed": "H"}
PUBLISHED_POISSON = 1.0 / 3.0


class CookCase(RunnableCase):
    """Cook's membrane, 48 mm wide, E = 70 MPa, with a shear of 6.25 MPa on its right side (Moherdaui 2021, 5.2.2)."""

    name: ClassVar[str] = "cook"
    title: ClassVar[str] = "Cook's membrane: a tapered panel held on the left and sheared on the right"
    essential: ClassVar[tuple[str, ...]] = ("method", "level", "order")

    method: Literal["fem", "vem", "mixed"] = Field(
        "vem", description="fem: triangles; vem: polygons; mixed: triangles inside, virtual quadrilaterals on the rim"
    )
    level: int = Field(3, ge=1, le=MAX_LEVEL, description="refinement: each cuts the triangles before in four")
    order: int = Field(2, ge=1, le=4, description="order of the elements; fem up to 3")
    poisson: float = Field(PUBLISHED_POISSON, gt=-1.0, lt=0.5, description="Poisson's ratio; 0.4999 shows locking")

    def check(self) -> None:
        """See `RunnableCase.check`."""
        if self.order > HIGHEST_ORDER and self.method != "vem":
            raise InputError(
                f"order = {self.order} with method = {self.method}", f"up to {HIGHEST_ORDER}", 'set method = "vem"'
            )

    def run(self, progress: Progress = lambda _: None) -> BodiesRun:
        """See `RunnableCase.run`."""
        self.check()
        start = time.perf_counter()
        code = CookCode(LETTERS[self.method], self.level, self.order)
        progress("meshing the membrane")
        space = code.space()
        progress(f"solving for {2 * space.n_dofs} unknowns")
        solution = solve_cook(space, self.poisson)
        middle, corner = displacements_at(solution, [MIDDLE, CORNER])[:, 1].tolist()
        results = {
            "code": str(code),
            "middle_vertical_mm": middle,
            "upper_corner_vertical_mm": corner,
            "strain_energy_N_mm_per_mm": solution.energy,
        }
        if self.poisson == PUBLISHED_POISSON:
            results["energy_norm_error"] = max(1.0 - solution.energy / ENERGY, 0.0) ** 0.5
        bodies = {"membrane": BodyResult(solution)}
        timings = {"total": time.perf_counter() - start}
        status: Status = solution.status
        summary = summarise_bodies(self, status, bodies, None, results, timings, [])
        return BodiesRun(self, status, summary, bodies)
