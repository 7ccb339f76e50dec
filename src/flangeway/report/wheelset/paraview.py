"""Files for ParaView: one VTU for each part of a wheelset."""

from pathlib import Path

from flangeway.formats import write_vtu
from flangeway.post import Stresses
from flangeway.report.figures.fields import PartFields
from flangeway.types import Floats


def write_part(path: Path, fields: PartFields) -> None:
    """Write one part as it stands in space, with real polygons.

    The points are those of the undeformed part at its final place, mm. Point array ``displacement_mm`` (axes of space,
    third component 0) is elastic: it holds nothing of a wheel's rigid motion, which is in its place, so
    "Warp By Vector" with factor 1 shows the parts as they touch. Cell arrays are means over cells in MPa, tension
    positive, axes of space: ``stress_xx_MPa``, ``_yy_``, ``_xy_``, ``_zz_``; ``von_mises_MPa``; ``principal_1_MPa`` to
    ``principal_3_MPa``, descending, zz among them; ``max_in_plane_shear_MPa``.
    """
    stresses = fields.stresses
    arrays = stress_arrays(stresses)
    principal = stresses.principal
    for i in range(3):
        arrays[f"principal_{i + 1}_MPa"] = principal[:, i]
    arrays["max_in_plane_shear_MPa"] = stresses.in_plane_shear
    write_vtu(path, fields.mesh, {"displacement_mm": fields.displacement}, arrays)


def stress_arrays(stresses: Stresses) -> dict[str, Floats]:
    """Components and von Mises stress by the names that the files of parts and bodies have for them."""
    arrays = {f"stress_{name}_MPa": stresses.components[:, i] for i, name in enumerate(("xx", "yy", "xy", "zz"))}
    return {**arrays, "von_mises_MPa": stresses.von_mises}
