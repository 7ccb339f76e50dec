"""The benchmark of EN 15302: rolling radius differences and equivalent conicity of its reference profiles."""

from collections.abc import Iterator

import numpy as np

from flangeway.cases.rigid_run import find_geometry_case
from flangeway.railway.rigid.conicity import RollingRadiusDifference, equivalent_conicity
from flangeway_studies.study import Limit, Row, Run, published_rows

COMBINATIONS: dict[str, tuple[str, str, float]] = {
    "E1": ("A", "A", 0.0), "E2": ("B", "B", 0.0), "E3": ("H", "H", 0.0), "E4": ("I", "I", 0.0),
    "E5": ("A", "A", 1.0), "E6": ("B", "B", 1.0), "E7": ("H", "H", 1.0), "E8": ("I", "I", 1.0),
    "E9": ("A", "B", 0.0), "C": ("C", "C", 0.0),
}  # fmt: skip
"""Right wheel, left wheel, and by how much the left radius is smaller, in mm."""
TOLERANCE, MAX_RATIO = (
    0.05,
    0.5,
)  # the standard allows an error of the lesser of this number and this part of a conicity
DIFFERENCE_LIMIT_MM = 0.002
HALF_DIGIT = 5e-4  # half of the last digit in which the standard gives its results
STEP_MM, REACH_MM = 0.01, 12.0
SHOWN_MM = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)


def title(name: str) -> str:
    """Wheels, and the difference of their diameters."""
    right, left, smaller = COMBINATIONS[name]
    more = f", {920.0 - 2.0 * smaller:g} mm left" if smaller else ""
    number = "" if name in (right, left) else f"{name}: "
    return f"{number}{right if right == left else f'{right} right, {left} left'}{more}"


def rolling_radius_difference(name: str) -> RollingRadiusDifference:
    """Compute one of `COMBINATIONS`, as ``flangeway geometry en15302`` does."""
    right, left, smaller = COMBINATIONS[name]
    inputs: dict[str, object] = {"wheelset.wheel": f"R-519-{right}"}
    inputs |= {"wheelset.left.wheel": f"R-519-{left}"} if left != right else {}
    inputs |= {"wheelset.left.radius_mm": 460.0 - smaller} if smaller else {}
    geometry = find_geometry_case("en15302", inputs).geometry()
    low, high = geometry.limits(REACH_MM, roll=False)
    steps = np.arange(np.ceil(low / STEP_MM), np.floor(high / STEP_MM) + 1.0)
    return RollingRadiusDifference.of(geometry.locus(steps * STEP_MM, roll=False))


def rows(run: Run) -> Iterator[Row]:
    """Worst difference of the radii, worst conicity over its tolerance, and conicities at whole amplitudes."""
    published = published_rows("en15302.csv")
    for name in COMBINATIONS:
        (lateral, known_mm), (amplitudes, known) = (
            np.array([[float(r["y"]), float(r["value"])] for r in published if (r["case"], r["quantity"]) == case]).T
            for case in ((name, "difference"), (name, "conicity"))
        )
        difference, code = rolling_radius_difference(name), title(name)
        worst = np.abs(difference(lateral) - known_mm).max()
        quantity = "error of the rolling radius difference, worst of all"
        note = f"{len(lateral)} lateral displacements"
        yield Row("EN 15302, J", code, quantity, "mm", worst, 0.0, DIFFERENCE_LIMIT_MM, note)
        conicity = equivalent_conicity(difference, amplitudes)
        # what the standard allows, and the rounding where it allows nothing
        tolerances = np.maximum(np.minimum(TOLERANCE, MAX_RATIO * known), HALF_DIGIT)
        worst = (np.abs(conicity - known) / tolerances).max()
        quantity, note = "error of the conicity over its tolerance, worst of all", f"{len(known)} amplitudes"
        yield Row("EN 15302, K", code, quantity, "", worst, 0.0, 1.0, note)
        for at in np.flatnonzero(np.isin(amplitudes, SHOWN_MM)):
            limit = Limit(f"{tolerances[at]:g}", abs(conicity[at] - known[at]) <= tolerances[at])
            location = f"{code}, {amplitudes[at]:g} mm"
            yield Row("EN 15302, K", location, "conicity", "", conicity[at], known[at], limit)
        run.curve("conicity", code, "EN 15302", amplitudes, known, ".")
        run.curve("conicity", code, "computed", amplitudes, conicity)
