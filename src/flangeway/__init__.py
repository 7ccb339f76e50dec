"""Elastic contact with finite and virtual elements, up to a wheelset on two rails.

What most scripts need stands here, in the order in which a script uses it:

- a shape and its mesh: `Outline`, `triangulate`, `dual` (polygons), `read_mesh`, `PolyMesh`, `write_vtu`;
- elements on it: `Lagrange`, `Virtual`, `Space`;
- a problem: `Elastic`, `Elasticity` with `Traction`, `BodyForce`, `fixed` and `PrescribedDisplacement`, or `Torsion`;
  one's own by `flangeway.forms`;
- its solution: `solve_elasticity`, `solve_torsion`; `recovered_stresses`, `stresses_at`; solutions have `plot`,
  `table`, `to_csv` and `to_dataframe`, and show themselves in notebooks;
- bodies in contact: `Body`, `Part` (a body at its `Placement`), `Surface`, `Contact` by `NodeToSegment`,
  `SegmentToSegment` or `NodeToNode`, with `Penalty` or `Multiplier`; `press` brings them together, `pressure_patches`
  says how hard they touch;
- the main job: a `Wheelset` on two rails, ``Wheelset(track=Track(rail="136RE"), load=Load(axle_load_kN=300)).solve()``;
  its inputs are `Track` with `RailSide` and `Sleepers`, `Continuous` or `Fixed`, `WheelPair` with `WheelSide`,
  `Load` with `Curve`, `Position`, `RollingMotion`, `Mesh`, and `Plane` for a slice; `load_case` reads any case by name
  or from a case file, and its `run` computes it.

Wrong input is an `InputError`, every error of the package a `FlangewayError`. The packages have the rest, and follow
the flow of data: `exact`, `geometry`, `mesh`, `formats`, `elements`, `space`, `materials`, `problems`, `solve`,
`contact`, `rolling`, `post`, `forms`, `railway`, `cases`, `campaign`, `tables`, `report`. All is loaded when it is
first used, so that importing this package takes no time.
"""

import lazy_loader

from flangeway.views import Views, register_views

_loaded, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # the names are in __init__.pyi


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version  # noqa: PLC0415 (it takes longer than all the rest)

        return version("flangeway")
    return _loaded(name)


@register_views
def _report() -> Views:
    from flangeway import report  # noqa: PLC0415 (loaded when a result is shown)

    return report
