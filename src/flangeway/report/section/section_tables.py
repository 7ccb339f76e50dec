"""Numbers of a cross-section as rows of text, for the terminal and for the page."""

import math
from typing import Any


def section_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Name with unit and value of every constant, as shown."""
    unit, mesh = summary["unit"], summary["mesh"]

    def point(key: str) -> str:
        size = summary[f"boundary_length_{unit}"]
        # noise of rounding would look like a result
        x, y = (0.0 if abs(value) < 1e-7 * size else value for value in summary[key])
        return f"({x:.6g}, {y:.6g})"

    moments = summary[f"second_moments_{unit}4"]
    noise = 1e-9 * math.sqrt(moments["xx"] * moments["yy"])
    product = 0.0 if abs(moments["xy"]) < noise else moments["xy"]
    bounds = [summary[f"torsion_constant_{kind}_{unit}4"] for kind in ("prandtl", "warping")]
    half_gap = 0.5 * abs(bounds[1] - bounds[0]) / summary[f"torsion_constant_{unit}4"]
    certain = "bounds of the meshed polygon's" if summary["torsion_bounds_certain"] else "both formulations"
    angle = summary["principal_angle_deg"]
    rows = [
        (f"area, {unit}²", f"{summary[f'area_{unit}2']:.7g}"),
        (f"centroid (x, y), {unit}", point(f"centroid_{unit}")),
        *(
            (f"second moment {name} about the centroid, {unit}⁴", f"{value:.7g}")
            for name, value in (("Ixx", moments["xx"]), ("Iyy", moments["yy"]), ("Ixy", product))
        ),
        *(
            (f"principal moment I{number}, {unit}⁴", f"{value:.7g}")
            for number, value in enumerate(summary[f"principal_moments_{unit}4"], 1)
        ),
        ("angle of principal axis 1 from x, degrees", f"{0.0 if abs(angle) < 1e-7 else angle:.5g}"),
        *_bending_rows(summary),
        (f"torsion constant J, {unit}⁴", f"{summary[f'torsion_constant_{unit}4']:.7g}"),
        (f"  {certain}: from Prandtl's function", f"{bounds[0]:.7g}"),
        ("  from the warping function", f"{bounds[1]:.7g}"),
        ("  half of the gap, relative", f"{half_gap:.1e}"),
        (f"shear centre (x, y), {unit}", point(f"shear_centre_{unit}")),
    ]
    if summary["poisson"]:
        rows[-1] = (f"shear centre for ν = {summary['poisson']:g} (x, y), {unit}", point(f"shear_centre_{unit}"))
        rows.append((f"shear centre by Trefftz (x, y), {unit}", point(f"shear_centre_trefftz_{unit}")))
    rows.append((f"warping constant, {unit}⁶", f"{summary[f'warping_constant_{unit}6']:.7g}"))
    maximum = summary[f"max_shear_stress_per_torque_per_{unit}3"]
    if maximum is not None:
        rows.append((f"maximum shear stress per torque, {unit}⁻³", f"{maximum:.5g}"))
    rows.append(
        (
            f"{mesh['cells']} {'triangles' if mesh['method'] == 'fem' else 'polygons'} of order {mesh['order']}, "
            f"size {mesh[f'size_{unit}']:.4g} {unit}",
            f"{mesh['unknowns']} unknowns",
        )
    )
    return rows


def _bending_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    unit = summary["unit"]
    radii = summary[f"radii_of_gyration_{unit}"]
    rows = [(f"radii of gyration (about x, about y), {unit}", f"({radii['xx']:.6g}, {radii['yy']:.6g})")]
    moduli = summary.get(f"section_moduli_{unit}3")
    if moduli is not None:
        rows += [
            (f"section moduli ({one}, {other}), {unit}³", f"({moduli[one]:.6g}, {moduli[other]:.6g})")
            for one, other in (("top", "bottom"), ("left", "right"))
        ]
    return rows


def weights_sentences(summary: dict[str, Any]) -> list[str]:
    """Return what several materials mean for the constants, nothing for one material."""
    if "weights" not in summary:
        return []
    weights = summary["weights"]
    return [
        f"{weights['meaning']} References: E = {weights['reference_young_MPa']:.6g} MPa, "
        f"G = {weights['reference_shear_modulus_MPa']:.6g} MPa."
    ]
