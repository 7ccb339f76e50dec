"""A slice of a wheelset stands on two rails: where they touch, and how hard.

        o  300 kN at the car's centre of gravity
        |
    ||==|==||      two wheels on a rigid axle
    ||     ||
    _I_   _I_      two rails, fixed along their bases

Run it with ``python examples/wheelset_tangent.py``. Steps:

1. choose the inputs; what is left out has a default (`flangeway cases wheelset` lists all);
2. solve: wheels and rails are meshed, condensed to their surfaces, and brought into balance with the load;
3. read the results: forces and pressures here, fields and pictures in the folder of results.
"""

import math
import tempfile
from pathlib import Path
from typing import Literal

import flangeway as fw
from flangeway.report import write_case


def main(size_scale: float = 1.0, folder: Path | None = None) -> None:
    """Solve the case by both methods, check the results, and write one set of files.

    Parameters
    ----------
    size_scale
        Factor on all element sizes: 2 is quick, 0.5 is fine.
    folder
        Where the files go; a temporary folder if left out.

    """
    found = {}
    methods: tuple[Literal["fem", "vem"], ...] = ("fem", "vem")
    for method in methods:
        case = fw.Wheelset(
            track=fw.Track(rail="136RE", gauge_mm=1600.0, gauge_at="narrowest"),
            wheelset=fw.WheelPair(wheel="AAR-1B", radius_mm=500.0, radius_at="flange-tip"),
            load=fw.Load(axle_load_kN=300.0),
            contact=fw.Plane(),
            mesh=fw.Mesh(method=method, order=1, size_scale=size_scale),
        )
        run = case.solve()
        found[method] = run

        # the iteration has ended well, and the contact forces bear the load of 300 kN
        assert run.result.status.converged
        assert run.result.equilibrium.residuals.equilibrium_residual < 1e-10
        left, right = run.result.patches
        assert math.isclose(left.force_on_wheel_N[1] + right.force_on_wheel_N[1], 300e3, rel_tol=1e-9)

        # the left side mirrors the right side: the axle sinks without sliding or tilting
        assert math.isclose(left.force_on_wheel_N[1], right.force_on_wheel_N[1], rel_tol=1e-3)
        assert abs(run.result.equilibrium.position.lateral_mm) < 1e-3 * run.result.approach_mm

        # Hertz's theory for the same force and the radii at the contact is close
        numbers = {name: values[1] for name, values in run.table.columns.items()}  # of the right patch
        pressure, hertz = numbers["max_pressure_MPa"], numbers["hertz_pressure_MPa"]
        assert math.isclose(pressure, hertz, rel_tol=0.1)
        print(
            f"{method}: the axle sinks {run.result.approach_mm:.3f} mm; maximum pressure {pressure:.0f} MPa "
            f"(Hertz {hertz:.0f} MPa) over a half width of {numbers['half_width_mm']:.2f} mm"
        )

    # triangles and polygons agree about the place of the contact to half a millimetre
    apart = found["fem"].result.patches[1].rail_point_mm - found["vem"].result.patches[1].rail_point_mm
    assert math.hypot(*apart) < 0.5

    with tempfile.TemporaryDirectory() as temporary:
        files = write_case(found["vem"], folder or Path(temporary))
        assert all(file.stat().st_size > 0 for file in files)
        print("written:", ", ".join(file.name for file in files))


if __name__ == "__main__":
    main(folder=Path("out/wheelset-tangent"))
