"""Hertz's problem (Moherdaui 2021, 6.2.2): condensed beside sparse, and times of the published configurations.

Accuracy is the relative difference of the force from that of the published reference solution, or, where the discs are
pressed by a tenth of the approach, that of both paths from each other.
"""

import time
from collections.abc import Iterator
from dataclasses import replace

from benchmarks.measurement import ITSELF, NO_PEER, Measurement, timed
from flangeway.validation.hertz.hertz_discs import HertzModel, HertzProblem, build_hertz, solve_hertz
from flangeway.validation.hertz.hertz_reproduced import CODES, LEVELS, REFERENCE_FORCE, published_problem


def measurements() -> Iterator[Measurement]:
    """Both paths on the coarsest mesh and for one load step of the finest; all six codes on all meshes."""
    yield _both_paths("ten load steps", published_problem("VVO2", LEVELS[0]))
    problem = published_problem("VVO2", LEVELS[-1])
    yield _both_paths("the first of ten load steps", problem, share=0.1)
    yield _after_meshing(problem)
    yield _all_configurations()


def _both_paths(what: str, problem: HertzProblem, share: float = 1.0) -> Measurement:
    """Times from assembled stiffnesses to the fields of both discs."""
    meshed = build_hertz(problem)
    first = replace(problem, approach=share * problem.approach, n_steps=round(share * problem.n_steps))
    model = HertzModel(first, meshed.contact)
    for part in model.parts:
        _ = part.body.stiffness
    seconds, ours = timed(lambda: solve_hertz(model, path="condensed"))
    sparse_seconds, theirs = timed(lambda: solve_hertz(model, path="sparse"))
    expected = REFERENCE_FORCE if share == 1.0 else theirs.force
    work = (
        f"Hertz VVO2, {model.n_unknowns} unknowns, {what}: the path condensed to "
        f"{ours.contact.response.n_unknowns} unknowns beside the full sparse path"
    )
    return Measurement(
        work,
        ITSELF,
        seconds,
        sparse_seconds,
        abs(ours.force / expected - 1.0),
        abs(theirs.force / expected - 1.0),
        f"forces of both paths differ by {abs(ours.force / theirs.force - 1.0):.1e}; the peer is the full sparse path",
    )


def _after_meshing(problem: HertzProblem) -> Measurement:
    """Assembly, condensation, ten load steps and recovery of the finest polygons of order 2."""
    model = build_hertz(problem)
    seconds, solution = timed(lambda: solve_hertz(model))
    stages = ", ".join(f"{name} {value:.2f} s" for name, value in solution.timings_s.items() if name != "meshing")
    return Measurement(
        f"Hertz VVO2M4, {model.n_unknowns} unknowns, after meshing, ten load steps",
        NO_PEER,
        seconds,
        None,
        abs(solution.force / REFERENCE_FORCE - 1.0),
        None,
        f"budget 5 s; {stages}",
    )


def _all_configurations() -> Measurement:
    """All published configurations, meshing included."""
    start, worst, n_unknowns = time.perf_counter(), 0.0, 0
    for code in CODES:
        for level in LEVELS:
            solution = solve_hertz(published_problem(code, level))
            worst = max(worst, abs(solution.force / REFERENCE_FORCE - 1.0))
            n_unknowns += solution.model.n_unknowns
    seconds = time.perf_counter() - start
    work = f"Hertz, {len(CODES)} codes on M1 to M4, node-to-segment, {n_unknowns} unknowns in all, meshing included"
    return Measurement(work, NO_PEER, seconds, None, worst, None, "budget 180 s; accuracy is the worst of all")
