"""Bodies of revolution in contact beside exact solutions, with the force of the whole circumference.

*A rigid flat punch* of radius a (J. Boussinesq, 1885; I. N. Sneddon, 1965, Int. J. Eng. Sci. 3): a half-space yields by
d under the force ``2 E* a d``. If nothing slips, the force is larger by ``(1 - nu) ln(3 - 4 nu) / (1 - 2 nu)`` (V. I.
Mossakovskii, 1954; D. A. Spence, 1968, Proc. R. Soc. Lond. A 305), 9.9 % for Poisson's ratio 0; friction with a large
coefficient comes near, though it slips at the very edge. *A sphere* of radius R (H. Hertz, 1882; K. L. Johnson, 1985,
"Contact Mechanics", 4.2) touches a half-space on the radius ``a = sqrt(R d)``, ``a^3 = 3 F R / (4 E*)``. The mean
square radius of its pressure is ``2 a^2 / 5``, which gives a from the forces. On meshes of three sizes the errors fall,
down to what blocks of a thousand contact radii in place of half-spaces and punches of finite stiffness leave.
"""

from collections.abc import Iterator

import numpy as np

from flangeway.contact import ContactSolution, press
from flangeway.materials import Elastic
from flangeway.problems import Part
from flangeway.types import Floats
from flangeway_studies.friction.blocks import Solved, block, columns, face, growing, shift, touching
from flangeway_studies.study import Row

YOUNG_MPA, POISSON = 210e3, 0.3
MODULUS_MPA = YOUNG_MPA / (1.0 - POISSON**2)
PUNCH_MM, PUNCH_DEPTH_MM, RIGID = 1.0, 0.001, 1e4  # radius, approach, and stiffness of the punch over the half-space's
SPHERE_MM, SPHERE_DEPTH_MM = 100.0, 0.01
FAR = 1000.0  # size of what stands for a half-space, over the contact radius
CELLS = (8, 16, 32)  # on the radius of the sphere's contact; the first is the size of the cells at the punch's edge
STICKING = 10.0  # coefficient of friction
REVOLVED_LIMIT = 0.005


def revolved_rows(solved: Solved) -> Iterator[Row]:
    """Rows of the punch and the sphere; the finest mesh has the limit, the coarser ones show how the error falls."""
    for cells in CELLS:
        punch, sphere = solved(flat_punch(PUNCH_MM / cells)), solved(round_punch(cells))
        sticking = solved(flat_punch(PUNCH_MM / cells, poisson=0.0, friction=STICKING))
        force, radius = _pressed(sphere)
        exact = 4.0 / 3.0 * MODULUS_MPA * np.sqrt(SPHERE_MM * SPHERE_DEPTH_MM**3)
        no_slip = 2.0 * np.log(3.0) * YOUNG_MPA * PUNCH_MM * PUNCH_DEPTH_MM
        slips = 2.0 * MODULUS_MPA * PUNCH_MM * PUNCH_DEPTH_MM
        limit, code = REVOLVED_LIMIT if cells == CELLS[-1] else None, f"{cells} cells"
        yield Row("Flat punch of revolution", code, "force", "N", punch.forces[0, 1], slips, limit)
        yield Row("Flat punch that sticks", code, "force", "N", sticking.forces[0, 1], no_slip, limit)
        yield Row("Sphere", code, "force", "N", force, exact, limit)
        hertz = np.cbrt(0.75 * force * SPHERE_MM / MODULUS_MPA)
        yield Row("Sphere", code, "contact radius", "mm", radius, hertz, limit)


def flat_punch(size: float, *, poisson: float = POISSON, friction: float = 0.0) -> ContactSolution:
    """A nearly rigid cylinder on a half-space, with cells of a size at its edge."""
    inner = PUNCH_MM - growing(0.0, size, PUNCH_MM)[::-1]
    depth = growing(0.0, size, FAR * PUNCH_MM)
    x = np.concatenate((inner, PUNCH_MM + depth[1:]))
    rigid = Elastic(RIGID * YOUNG_MPA, POISSON, "axisymmetric")
    upper = block("upper", inner, growing(0.0, size, PUNCH_MM), rigid, near=PUNCH_MM, order=2)
    soft = Elastic(YOUNG_MPA, poisson, "axisymmetric")
    return _onto(upper, soft, x, depth, 2.0 * PUNCH_MM, PUNCH_DEPTH_MM, friction)


def round_punch(cells: int) -> ContactSolution:
    """A nearly rigid sphere on a half-space, with a number of cells on the contact radius."""
    radius = np.sqrt(SPHERE_MM * SPHERE_DEPTH_MM)
    size = radius / cells
    depth = growing(0.0, size, FAR * radius)
    x = np.concatenate((np.arange(cells + cells // 2) * size, growing(1.5 * radius, size, FAR * radius)))
    rigid = Elastic(RIGID * YOUNG_MPA, POISSON, "axisymmetric")
    near = 3.0 * radius
    upper = block("upper", x[x < near], growing(0.0, size, near), rigid, near=near, radius=SPHERE_MM, order=2)
    return _onto(upper, Elastic(YOUNG_MPA, POISSON, "axisymmetric"), x, depth, near, SPHERE_DEPTH_MM)


def _onto(
    upper: Part, soft: Elastic, x: Floats, depth: Floats, reach: float, approach: float, friction: float = 0.0
) -> ContactSolution:
    lower = block("lower", x, depth, soft, near=reach, order=2)
    contact = touching(face(upper, reach), face(lower, reach), friction)
    return press([contact], shift(upper, 0.0, -approach))


def _pressed(solution: ContactSolution) -> tuple[float, float]:
    """Force, and the contact radius by the mean square radius of the pressure."""
    table = columns(solution)
    force = table["normal_force"]
    return force.sum(), np.sqrt(2.5 * (force @ table["x"] ** 2) / force.sum())
