"""A rigid sphere on a block of polyhedra with hanging nodes: contact in space and Hertz's pressure."""

import numpy as np
from gallery_drawing import curves
from matplotlib.figure import Figure

import flangeway as fw
from flangeway.contact import FaceSurface, RigidSphere, SpatialContact, press_spatial
from flangeway.mesh import octree
from flangeway.problems import PrescribedDisplacement, fixed


def main() -> Figure:
    """The largest pressure is Hertz's to 1 %."""
    size, ball, radius, steel = 20.0, 50.0, 1.0, fw.Elastic(210e3, 0.3)

    def finer(centres: np.ndarray, sides: np.ndarray) -> np.ndarray:
        """Cells of 0.16 mm where the sphere touches; farther away half of the distance to it."""
        away = np.linalg.norm(centres - (0.0, 0.0, size), axis=1)
        return sides > np.maximum(0.17, 0.5 * (away - radius))

    # a quarter of the block, between two planes of symmetry
    mesh = octree((size, size, size), (1, 1, 1), finer=finer, levels=7)
    mesh = mesh.with_face_set("patch", lambda p: (p[:, 2] == size) & (np.hypot(p[:, 0], p[:, 1]) < 2.0 * radius))
    supports = [PrescribedDisplacement("x-", x=0.0), PrescribedDisplacement("y-", y=0.0), fixed("z-", 3)]
    block = fw.Elasticity(fw.Space(mesh, fw.Virtual(1)), steel, supports=supports)
    sphere = RigidSphere((0.0, 0.0, size + ball), ball)
    force = 4.0 / 3.0 * steel.plane_modulus * radius**3 / ball
    found = press_spatial([SpatialContact(FaceSurface(block, "patch"), sphere)], {sphere: (0.0, 0.0, -force / 4.0)})
    (patch,) = found.contacts
    largest = 2.0 * steel.plane_modulus * radius / np.pi / ball
    print(f"{mesh.n_cells} cells; largest pressure {patch.pressures.max():.0f} MPa, Hertz {largest:.0f} MPa")
    assert abs(patch.pressures.max() / largest - 1.0) < 0.01
    r, x = np.hypot(*patch.points[:, :2].T), np.linspace(0.0, radius, 50)
    order = np.argsort(r)
    theory = largest * np.sqrt(1.0 - (x / radius) ** 2)
    return curves((r[order], patch.pressures[order], "computed"), (x, theory, "Hertz"), axes=("radius", "pressure"))
