"""A box girder and the same girder cut open: torsion constant, shear centre, warping constant.

     ____________          ____________
    |  ________  |        |  ________  |
    | |        | |        | |        | |
    | |________| |        | |___  ___| |
    |____________|        |_____||_____|

    the shear flow        it turns back
    runs around           in each wall

Run it with ``python examples/section_constants.py``. Steps:

1. draw regions of lines and arcs (`flangeway section` reads them from files);
2. mesh them, choose an element, and solve for the warping function and for Prandtl's function;
3. read the constants, and check them by what thin-walled theory says.
"""

import math

import flangeway as fw
from flangeway.geometry import Region, Section, polygon
from flangeway.mesh import triangulate_section

WALL = 8.0
WIDTH, HEIGHT = 200.0, 120.0
SLIT = 0.5


def box(*, slit: bool) -> Region:
    """Return a rectangular box with walls of `WALL` mm, closed or with a slit in the middle of the bottom."""
    x, y, t = WIDTH / 2.0, HEIGHT, WALL
    inside = [(x - t, t), (x - t, y - t), (t - x, y - t), (t - x, t)]
    if not slit:
        return Region(polygon([(-x, 0.0), (x, 0.0), (x, y), (-x, y)]), (polygon(inside),))
    s = SLIT / 2.0
    return Region(polygon([(s, 0.0), (x, 0.0), (x, y), (-x, y), (-x, 0.0), (-s, 0.0), (-s, t), *inside[::-1], (s, t)]))


def main() -> None:
    """Compute both boxes with triangles and with polygons, and check the results."""
    found = {}
    for slit in (False, True):
        region = box(slit=slit)
        triangles = triangulate_section(Section({"box": region}), size=3.0)
        name = "slit box" if slit else "closed box"

        # triangles bound the torsion constant from both sides
        constants = fw.post.section_constants(fw.Space(triangles, fw.Lagrange(2)))
        lower, upper = constants.torsion_bounds
        assert lower < upper < 1.01 * lower

        # polygons with virtual elements agree
        polygons = fw.mesh.dual(triangles)
        virtual = fw.post.section_constants(fw.Space(polygons, fw.Virtual(2)))
        assert math.isclose(virtual.torsion_constant, constants.torsion_constant, rel_tol=5e-3)

        # the mesh has the area of the outline
        assert math.isclose(constants.area, region.area, rel_tol=1e-12)
        found[slit] = constants
        print(
            f"{name}: J = {constants.torsion_constant:.4g} mm4 (between {lower:.5g} and {upper:.5g}), shear centre at "
            f"y = {constants.shear_centre[1]:.1f} mm, warping constant {constants.warping_constant:.3g} mm6"
        )

    # Bredt on the middle line: 4 A^2 / sum of length over thickness, a little low for walls of this thickness
    width, height = WIDTH - WALL, HEIGHT - WALL
    bredt = 4.0 * (width * height) ** 2 / (2.0 * (width + height) / WALL)
    assert math.isclose(found[False].torsion_constant, bredt, rel_tol=0.04)

    # open: a third of length times thickness cubed; the closed box is hundreds of times stiffer
    strip = (2.0 * (width + height) - SLIT) * WALL**3 / 3.0
    assert math.isclose(found[True].torsion_constant, strip, rel_tol=0.05)
    assert found[False].torsion_constant > 200.0 * found[True].torsion_constant

    # symmetry keeps the shear centre on the axis; the slit sends it out through the top
    assert abs(found[True].shear_centre[0]) < 0.1
    assert found[True].shear_centre[1] > HEIGHT


if __name__ == "__main__":
    main()
