"""Elastic contact in two dimensions with finite and virtual elements, up to a wheelset on two rails.

The packages follow the flow of data: `geometry`, `mesh`, `elements`, `space`, `materials`, `problems`, `solve`,
`contact`, `post`, `railway`, `study`, `report`. What most scripts need stands here; it is loaded when it is first used,
so that importing this package takes no time.
"""

from importlib import import_module
from importlib.metadata import version
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flangeway import elements, exact, geometry, mesh, post
    from flangeway.contact import (
        AugmentedLagrange,
        Contact,
        ContactSolution,
        ContactSystem,
        Multiplier,
        NodeToSegment,
        Penalty,
        SegmentToSegment,
        Surface,
        press,
    )
    from flangeway.elements import Lagrange, Virtual
    from flangeway.errors import FlangewayError, InputError
    from flangeway.geometry import Outline, Placement
    from flangeway.materials import Elastic, Orthotropic
    from flangeway.mesh import PolyMesh, dual, read_mesh, refined, triangulate, write_vtu
    from flangeway.post import (
        displacements_at,
        force_through_cut,
        nodal_stresses,
        pressure_patches,
        reactions,
        recovered_stresses,
        stresses_along,
        stresses_at,
    )
    from flangeway.problems import (
        Body,
        BodyForce,
        Elasticity,
        Gravity,
        Part,
        PointForce,
        PrescribedDisplacement,
        Pressure,
        RigidHandle,
        Spring,
        TemperatureChange,
        Torsion,
        Traction,
        fixed,
    )
    from flangeway.report import (
        plot_deformed,
        plot_displacement,
        plot_function,
        plot_mesh,
        plot_stress,
        solution_frame,
        write_series,
    )
    from flangeway.solve import (
        CondensedBodies,
        ContactState,
        ElasticitySolution,
        SparseBodies,
        Status,
        solve_contact,
        solve_elasticity,
        solve_torsion,
    )
    from flangeway.space import Space
    from flangeway.study import adapt

_PACKAGES = ("elements", "exact", "geometry", "mesh", "post")
_HOMES = {
    "contact": (
        "AugmentedLagrange",
        "Contact",
        "ContactSolution",
        "ContactSystem",
        "Multiplier",
        "NodeToSegment",
        "Penalty",
        "SegmentToSegment",
        "Surface",
        "press",
    ),
    "elements": ("Lagrange", "Virtual"),
    "errors": ("FlangewayError", "InputError"),
    "geometry": ("Outline", "Placement"),
    "materials": ("Elastic", "Orthotropic"),
    "mesh": ("PolyMesh", "dual", "read_mesh", "refined", "triangulate", "write_vtu"),
    "post": (
        "displacements_at",
        "force_through_cut",
        "nodal_stresses",
        "pressure_patches",
        "reactions",
        "recovered_stresses",
        "stresses_along",
        "stresses_at",
    ),
    "problems": (
        "Body",
        "BodyForce",
        "Elasticity",
        "Gravity",
        "Part",
        "PointForce",
        "PrescribedDisplacement",
        "Pressure",
        "RigidHandle",
        "Spring",
        "TemperatureChange",
        "Torsion",
        "Traction",
        "fixed",
    ),
    "report": (
        "plot_deformed",
        "plot_displacement",
        "plot_function",
        "plot_mesh",
        "plot_stress",
        "solution_frame",
        "write_series",
    ),
    "solve": (
        "CondensedBodies",
        "ContactState",
        "ElasticitySolution",
        "SparseBodies",
        "Status",
        "solve_contact",
        "solve_elasticity",
        "solve_torsion",
    ),
    "space": ("Space",),
    "study": ("adapt",),
}
_PACKAGE_OF = {name: package for package, names in _HOMES.items() for name in names}

__version__ = version("flangeway")

__all__ = [
    "AugmentedLagrange",
    "Body",
    "BodyForce",
    "CondensedBodies",
    "Contact",
    "ContactSolution",
    "ContactState",
    "ContactSystem",
    "Elastic",
    "Elasticity",
    "ElasticitySolution",
    "FlangewayError",
    "Gravity",
    "InputError",
    "Lagrange",
    "Multiplier",
    "NodeToSegment",
    "Orthotropic",
    "Outline",
    "Part",
    "Penalty",
    "Placement",
    "PointForce",
    "PolyMesh",
    "PrescribedDisplacement",
    "Pressure",
    "RigidHandle",
    "SegmentToSegment",
    "Space",
    "SparseBodies",
    "Spring",
    "Status",
    "Surface",
    "TemperatureChange",
    "Torsion",
    "Traction",
    "Virtual",
    "adapt",
    "displacements_at",
    "dual",
    "elements",
    "exact",
    "fixed",
    "force_through_cut",
    "geometry",
    "mesh",
    "nodal_stresses",
    "plot_deformed",
    "plot_displacement",
    "plot_function",
    "plot_mesh",
    "plot_stress",
    "post",
    "press",
    "pressure_patches",
    "reactions",
    "read_mesh",
    "recovered_stresses",
    "refined",
    "solution_frame",
    "solve_contact",
    "solve_elasticity",
    "solve_torsion",
    "stresses_along",
    "stresses_at",
    "triangulate",
    "write_series",
    "write_vtu",
]

if not TYPE_CHECKING:  # type checkers read the names above, and know of no others

    def __getattr__(name: str) -> object:
        if name in _PACKAGES:
            return import_module(f"flangeway.{name}")
        if name not in _PACKAGE_OF:
            raise AttributeError(f"module 'flangeway' has no attribute {name!r}")
        value = getattr(import_module(f"flangeway.{_PACKAGE_OF[name]}"), name)
        globals()[name] = value
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
