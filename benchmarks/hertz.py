"""Hertz's problem (Moherdaui 2021, 6.2.2): condensed beside sparse, and times of the published configurations.

Accuracy is the relative difference of the force from that of the published reference solution, or, where the discs are
pressed by a tenth of the approach, that of both paths from each other.
"""

import time
from collections.abc import Iterator

from benchmarks.measurement import ITSELF, NO_PEER, Measurement, timed
from flangeway.cases.bodies.presets import HertzCase
from flangeway.contact import ContactSolution, press
from flangeway.contact.bodies_model import BodiesModel, build_bodies
from flangeway.geometry import Placement
from flangeway.solve import StepSettings
from flangeway_studies.hertz import CODES, LEVELS, REFERENCE_FORCE, published_case


def measurements() -> Iterator[Measurement]:
    """Both paths on the coarsest mesh and for one load step of the finest; all six codes on all meshes."""
    yield _both_paths("ten load steps", published_case("VVO2", LEVELS[0]))
    case = published_case("VVO2", LEVELS[-1])
    yield _both_paths("the first of ten load steps", case, share=0.1)
    yield _after_meshing(case)
    yield _all_configurations()


def _pressed(model: BodiesModel, case: HertzCase, path: str = "condensed", share: float = 1.0) -> ContactSolution:
    """Contact and displacements of both discs after a share of the approach."""
    upper = model.contacts[0].secondary.part
    step = 1.0 / round(share * case.n_steps)
    motion = {upper: Placement(0.0, (0.0, -share * case.indentation_mm))}
    solution = press(model.contacts, motion, steps=StepSettings(step, step, step / 1024.0), path=path)  # type: ignore[arg-type]
    for part in solution.system.parts:
        solution.field(part)
    return solution


def _force(solution: ContactSolution) -> float:
    return float(solution.forces[0, 1])


def _n_unknowns(solution: ContactSolution) -> int:
    spaces = [part.body.space for part in solution.system.parts]
    inside = sum(2 * (space.n_dofs - space.n_nodes) for space in spaces)
    return inside + sum(int(part.body.free.sum()) for part in solution.system.parts)


def _both_paths(what: str, case: HertzCase, share: float = 1.0) -> Measurement:
    """Times from assembled stiffnesses to the fields of both discs."""
    model = build_bodies(case.general())
    for side in (model.contacts[0].secondary, model.contacts[0].primary):
        _ = side.part.body.stiffness
    seconds, ours = timed(lambda: _pressed(model, case, "condensed", share))
    sparse_seconds, theirs = timed(lambda: _pressed(model, case, "sparse", share))
    expected = REFERENCE_FORCE if share == 1.0 else _force(theirs)
    work = (
        f"Hertz VVO2, {_n_unknowns(ours)} unknowns, {what}: the path condensed to "
        f"{ours.response.n_unknowns} unknowns beside the full sparse path"
    )
    return Measurement(
        work,
        ITSELF,
        seconds,
        sparse_seconds,
        abs(_force(ours) / expected - 1.0),
        abs(_force(theirs) / expected - 1.0),
        f"forces of both paths differ by {abs(_force(ours) / _force(theirs) - 1.0):.1e}; the peer is the full sparse "
        "path",
    )


def _after_meshing(case: HertzCase) -> Measurement:
    """Assembly, condensation, ten load steps and recovery of the finest polygons of order 2."""
    model = build_bodies(case.general())
    seconds, solution = timed(lambda: _pressed(model, case))
    return Measurement(
        f"Hertz VVO2M4, {_n_unknowns(solution)} unknowns, after meshing, ten load steps",
        NO_PEER,
        seconds,
        None,
        abs(_force(solution) / REFERENCE_FORCE - 1.0),
        None,
        "budget 5 s: assembly, condensation, contact and displacements",
    )


def _all_configurations() -> Measurement:
    """All published configurations, meshing included."""
    start, worst, n_unknowns = time.perf_counter(), 0.0, 0
    for code in CODES:
        for level in LEVELS:
            solution = published_case(code, level).run().contact
            assert solution is not None
            worst = max(worst, abs(_force(solution) / REFERENCE_FORCE - 1.0))
            n_unknowns += _n_unknowns(solution)
    seconds = time.perf_counter() - start
    work = f"Hertz, {len(CODES)} codes on M1 to M4, node-to-segment, {n_unknowns} unknowns in all, meshing included"
    return Measurement(work, NO_PEER, seconds, None, worst, None, "budget 180 s; accuracy is the worst of all")
