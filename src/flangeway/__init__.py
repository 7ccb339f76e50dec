"""Elastic contact with finite and virtual elements, up to a wheelset on two rails.

What most scripts need stands here, in the order in which a script uses it:

- a shape and its mesh: `Outline`, `triangulate`, `dual` (polygons), `read_mesh`, `PolyMesh`, `write_vtu`;
- elements on it: `Lagrange`, `Virtual`, `Space`;
- a problem: `Elastic`, `Elasticity` with `Traction`, `BodyForce`, `fixed` and `PrescribedDisplacement`, or `Torsion`;
  one's own by `flangeway.forms`;
- its solution: `solve_elasticity`, `solve_torsion`; `recovered_stresses`, `stresses_at`, `plot_mesh`; solutions
  have `plot`, `table`, `to_csv` and `to_dataframe`, and show themselves in notebooks;
- bodies in contact: `Body`, `Part` (a body at its `Placement`), `Surface`, `Contact` by `NodeToSegment`,
  `SegmentToSegment` or `NodeToNode`, with `Penalty` or `Multiplier`; `press` brings them together, `pressure_patches`
  says how hard they touch;
- whole cases, a wheelset among them: `load_case` gives one by name or from a case file, and its `run` computes it.

Wrong input is an `InputError`, every error of the package a `FlangewayError`. The packages have the rest, and follow
the flow of data: `exact`, `geometry`, `mesh`, `formats`, `elements`, `space`, `materials`, `problems`, `solve`,
`contact`, `post`, `forms`, `railway`, `cases`, `campaign`, `tables`, `report`. All is loaded when it is
first used, so that importing this package takes no time.
"""

from importlib import import_module

TYPE_CHECKING = False  # as that of typing, which takes longer to import than this package
if TYPE_CHECKING:
    __version__: str
    from flangeway import elements as elements
    from flangeway import exact as exact
    from flangeway import forms as forms
    from flangeway import geometry as geometry
    from flangeway import mesh as mesh
    from flangeway import post as post
    from flangeway.cases import load_case
    from flangeway.contact import (
        Contact,
        Multiplier,
        NodeToNode,
        NodeToSegment,
        Penalty,
        SegmentToSegment,
        Surface,
        press,
    )
    from flangeway.elements import Lagrange, Virtual
    from flangeway.errors import FlangewayError, InputError
    from flangeway.formats import read_mesh, write_vtu
    from flangeway.geometry import Outline, Placement
    from flangeway.materials import Elastic
    from flangeway.mesh import PolyMesh, dual, triangulate
    from flangeway.post import pressure_patches, recovered_stresses, stresses_at
    from flangeway.problems import (
        Body,
        BodyForce,
        Elasticity,
        Part,
        PrescribedDisplacement,
        Torsion,
        Traction,
        fixed,
    )
    from flangeway.report import plot_mesh
    from flangeway.solve import solve_elasticity, solve_torsion
    from flangeway.space import Space

_PACKAGES = ("elements", "exact", "forms", "geometry", "mesh", "post")
_HOMES = {
    "cases": ("load_case",),
    "contact": (
        "Contact",
        "Multiplier",
        "NodeToNode",
        "NodeToSegment",
        "Penalty",
        "SegmentToSegment",
        "Surface",
        "press",
    ),
    "elements": ("Lagrange", "Virtual"),
    "errors": ("FlangewayError", "InputError"),
    "geometry": ("Outline", "Placement"),
    "materials": ("Elastic",),
    "formats": ("read_mesh", "write_vtu"),
    "mesh": ("PolyMesh", "dual", "triangulate"),
    "post": ("pressure_patches", "recovered_stresses", "stresses_at"),
    "problems": ("Body", "BodyForce", "Elasticity", "Part", "PrescribedDisplacement", "Torsion", "Traction", "fixed"),
    "report": ("plot_mesh",),
    "solve": ("solve_elasticity", "solve_torsion"),
    "space": ("Space",),
}
_PACKAGE_OF = {name: package for package, names in _HOMES.items() for name in names}

__all__ = [
    "Body",
    "BodyForce",
    "Contact",
    "Elastic",
    "Elasticity",
    "FlangewayError",
    "InputError",
    "Lagrange",
    "Multiplier",
    "NodeToNode",
    "NodeToSegment",
    "Outline",
    "Part",
    "Penalty",
    "Placement",
    "PolyMesh",
    "PrescribedDisplacement",
    "SegmentToSegment",
    "Space",
    "Surface",
    "Torsion",
    "Traction",
    "Virtual",
    "dual",
    "fixed",
    "load_case",
    "plot_mesh",
    "press",
    "pressure_patches",
    "read_mesh",
    "recovered_stresses",
    "solve_elasticity",
    "solve_torsion",
    "stresses_at",
    "triangulate",
    "write_vtu",
]

if not TYPE_CHECKING:  # type checkers read the names above, and know of no others

    def __getattr__(name: str) -> object:
        if name == "__version__":
            return import_module("importlib.metadata").version("flangeway")
        if name in _PACKAGES:
            return import_module(f"flangeway.{name}")
        if name not in _PACKAGE_OF:
            raise AttributeError(f"module 'flangeway' has no attribute {name!r}")
        value = getattr(import_module(f"flangeway.{_PACKAGE_OF[name]}"), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
