"""The wheelset in three dimensions: what ``flangeway reproduce wheelset3d`` computes."""

from collections.abc import Iterator

from studies.spatial.profile_blocks import pressed_profiles, profile_numbers
from studies.study import Row, Run
from studies.wheelset3d.element_methods import DIRECT, direct_numbers, method_rows
from studies.wheelset3d.manchester import benchmark_numbers, benchmark_positions

QUICK = 5  # every so many positions of the benchmark are computed if quick


def rows(run: Run) -> Iterator[Row]:
    """Rows of all parts; if quick, some positions of the benchmark, and elements of order 2 only."""
    points = []
    for position in benchmark_positions(run, every=QUICK if run.quick else 1):
        yield from benchmark_numbers(position)
        known = position.published
        points.append((known["y"], known["p0"], position.real.patches[0].max_pressure))
    y, published, computed = zip(*points, strict=True)
    run.curve("manchester", "S1002 on UIC60, left wheel, 10 kN", "CONTACT", y, published, "o")
    run.curve("manchester", "S1002 on UIC60, left wheel, 10 kN", "flangeway", y, computed)
    yield from method_rows(run)
    for name in DIRECT:
        run.progress(name)
        yield from direct_numbers(name)
    run.progress("one position beside CalculiX")
    yield from profile_numbers(pressed_profiles())
