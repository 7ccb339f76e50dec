"""Wheel and rail: profiles and their files, track and wheelset, rigid contact and conicity, equilibrium, wear.

What notebooks and scripts need stands here; all is loaded when it is first used. `Wheelset(...).solve()` runs the case.

- profiles: bundled ones by `rail` and `wheel`; files by `read_profile` with `ReadOptions`, and `joined` to a body;
- inputs of a wheelset: `Track` with `RailSide`, `RailFile` and the supports `Sleepers`, `Continuous` and `Fixed`;
  `WheelPair` with `WheelSide`, `WheelFile`, the sections `RimSection` and `WholeWheel`, and the axles `ElasticAxle` and
  `RigidAxle`; `Load` with `Car` and `Curve` (superelevation `FromSpeed`), whose forces are a `WheelsetLoad` on a track
  turned by `superelevation_angle`; `Position`; `RollingMotion` with `FrictionAlongTrack`; `Steel`, `YieldingSteel`;
  `Mesh` with `BodyMesh`; contact that is `Spatial` or `Plane`;
- rigid contact: `RigidGeometry`, `rigid_equilibrium`, and `RollingRadiusDifference` with `equivalent_conicity` and
  `conicity_by_regression`;
- the elastic wheelset in space: `WheelsetProblem`, `solve_spatial` with its
  `SpatialResult`; for many positions of the same bodies `running_surfaces`, `SpatialWheelset` and `solve_position`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # the names are in __init__.pyi
