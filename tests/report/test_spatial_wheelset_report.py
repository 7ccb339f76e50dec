"""Files, report and terminal summary of a wheelset in three dimensions."""

import csv
import xml.etree.ElementTree as ET
from dataclasses import replace

import meshio
import numpy as np
import pytest
from scipy.interpolate import interp1d

from flangeway.cases import load_case
from flangeway.cases.wheelset.wheelset_case import SpatialWheelsetRun
from flangeway.contact.rolling.creep_state import CreepState
from flangeway.contact.rolling.exact_rolling import roll
from flangeway.contact.rolling.friction import Friction
from flangeway.contact.rolling.rolling_contact import Creepages
from flangeway.railway.track.placements import SIDE_SIGN, SIDES
from flangeway.railway.wheelset.wheel_patch import rolling_contact_of
from flangeway.railway.wheelset.whole_sections import whole_sections
from flangeway.report.case_outputs import case_record, write_case
from flangeway.report.figures import drawing
from flangeway.report.wheelset.wheelset_files import write_section
from flangeway.report.wheelset.wheelset_page import BELOW_MM, below_fields, pressure_scene

pytestmark = pytest.mark.ci

INPUTS = {
    "lateral_force_kN": 60.0,
    "rail": "136RE",
    "wheel": "AAR-1B",
    "yaw_mrad": 5.0,
    "size_scale": 1.5,
    "patch_cells": 10,
}
PARTS = [f"{role}-{side}" for role in ("wheel", "rail") for side in ("left", "right")]
FILES = {
    *("wheelset.png", "patches.png", "stresses.png", "rails.png", "wheelset.pvd"),
    *("rolling.png", "shakedown.png"),
    *(f"{kind}{part}.vtu" for kind in ("", "section-", "stresses-") for part in PARTS),
    *("cells.csv", "patches.csv", "subsurface.csv", "rails.csv", "report.html", "summary.json"),
}


@pytest.fixture(scope="module")
def run():
    """A flange that is pressed to its rail: one patch on the left, two on the right, ahead of the axle by the yaw."""
    return load_case("wheelset", **INPUTS).run()


@pytest.fixture(scope="module")
def rolling(run):
    """The same with friction: creepages of a curve, another one on each side, at 20 m/s."""
    patches = []
    for patch in run.result.patches:
        contact = rolling_contact_of(patch, Friction(0.35))
        sign = SIDE_SIGN[patch.side]
        found = roll(contact, Creepages(sign * 0.5e-3, -1e-3, -sign * 4e-4))
        patches.append(replace(patch, creep=CreepState(found, contact, -sign, 20.0)))
    tractions = {
        side: sum(each.on_side(each.creep, each.creep.forces.tractions) for each in patches if each.side == side)
        for side in SIDES
    }
    patches = tuple(replace(patch, tractions=tractions[patch.side]) for patch in patches)
    return SpatialWheelsetRun(run.case, replace(run.result, patches=patches), 1.0)


@pytest.fixture(scope="module")
def folder(rolling, tmp_path_factory):
    """All its files, without the dots of its pictures."""
    out = tmp_path_factory.mktemp("rolling")
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(drawing, "png", lambda _: b"\x89PNG")
        files = write_case(rolling, out, whole_sections=True)
    assert {file.name for file in files} == FILES
    return out


@pytest.fixture(scope="module")
def plain(run, tmp_path_factory):
    """Files of the sections without friction."""
    out = tmp_path_factory.mktemp("plain")
    for role in ("wheel", "rail"):
        for side, section in whole_sections(run.result, role).items():
            write_section(section, side, role, out / f"section-{role}-{side}.vtu")
    return out


def quads(path):
    """Corners (n, 4, 3) of the cells of a surface, and their arrays."""
    found = meshio.read(path)
    corners = found.cells[0].data
    assert not any(np.nan_to_num(np.ptp(values[corners], axis=1)).any() for values in found.point_data.values())
    return found.points[corners], {name: values[corners[:, 0]] for name, values in found.point_data.items()}


@pytest.mark.parametrize("side", ["left", "right"])
def test_surfaces_carry_the_force_where_wheel_and_rail_meet(run, folder, side):
    """Pressure times area of the rail's cells is the force on the wheel; the wheel's cells lie on those of the rail."""
    corners, arrays = quads(folder / f"rail-{side}.vtu")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    normals *= np.sign(normals[:, 1:2])
    force = arrays["pressure_MPa"] @ normals
    wanted = run.result.force_on_wheel_N(side)
    np.testing.assert_allclose(force[:2], wanted, atol=5e-3 * np.linalg.norm(wanted))
    loaded = arrays["pressure_MPa"] > 0.0
    assert np.abs(arrays["gap_mm"][loaded]).max() < 1e-5
    assert arrays["gap_mm"][~loaded].min() > -1e-5
    on_wheel, of_wheel = quads(folder / f"wheel-{side}.vtu")
    assert of_wheel["pressure_MPa"].max() == arrays["pressure_MPa"].max()
    touching = on_wheel[of_wheel["pressure_MPa"] > 0.0]
    # without indentation they overlap by the approach, much less than the size of a patch
    assert np.linalg.norm(touching - corners[loaded], axis=-1).max() < 0.3
    # yaw: the right wheel is ahead and its flange root touches ahead of the axle, the left patch behind
    assert (touching[..., 2].mean() > 1.0) == (side == "right")


def test_the_viewer_shows_friction_of_the_files(rolling, folder):
    """The report's picture has pressure, sizes of traction and slip velocity, and power, as on the rails' surfaces."""
    scene = pressure_scene(rolling)
    keys = [field.key for field in scene.fields if field.group == "Contact"]
    assert keys == ["pressure_MPa", "traction_MPa", "slip_velocity_m_s", "frictional_power_W_mm2"]
    for part in scene.parts:
        _, arrays = quads(folder / f"{part.name}.vtu")
        for key in keys:
            wanted = arrays[key] if arrays[key].ndim == 1 else np.linalg.norm(arrays[key], axis=1)
            shown = part.cell_arrays[key][:, 0]
            # the cells of the contact come first, those around them have none
            np.testing.assert_allclose(shown[: len(wanted)], wanted, rtol=1e-6, atol=1e-6 * wanted.max())
            assert not shown[len(wanted) :].any()
            assert wanted.max() > 0.0


def test_the_viewer_shows_the_stress_below_the_patches(rolling):
    """The largest von Mises stress of each side is the summary's, at each depth it is that of the volumes."""
    scene = pressure_scene(rolling)
    largest, *at_depths = (field for field in scene.fields if field.group == "Below the patches")
    assert [field.name.split("depth of ")[1] for field in at_depths] == [f"{depth:g} mm" for depth in BELOW_MM]
    for part in scene.parts:
        volumes = [each.stress_fields["rail"] for each in rolling.patches if each.side == part.side]
        highest = max(each.max_von_mises.value for each in volumes)
        values = part.cell_arrays[largest.array]
        assert values.max() == pytest.approx(highest, rel=0.02)
        for field, depth in zip(at_depths, BELOW_MM, strict=True):
            values = part.cell_arrays[field.array]
            assert (values <= part.cell_arrays[largest.array] + 1e-6).all()
            wanted = max(interp1d(each.depths, each.von_mises, axis=0)(depth).max() for each in volumes)
            assert values.max() == pytest.approx(wanted, rel=0.05)
    assert "0.01969 in" in below_fields("us")[1].name


def test_collection_opens_all_surfaces_and_sections(folder):
    """The PVD has the twelve files, each part by its name, and all of a body have one number."""
    parts = {part.get("name"): part.get("file") for part in ET.parse(folder / "wheelset.pvd").getroot().iter("DataSet")}
    bodies = {
        name: {int(i) for i in meshio.read(folder / file).cell_data["body_id"][0]} for name, file in parts.items()
    }
    assert len(bodies) == 12
    for number, name in enumerate(("wheel-left", "wheel-right", "rail-left", "rail-right")):
        assert bodies[name] == bodies[f"section-{name}"] == bodies[f"stresses-{name}"] == {number}


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_volumes_below_the_patches_hold_the_maximum_at_its_position(rolling, folder, side):
    """The file's maximum von Mises stress is the summary's, at its point; the surface has the pressure."""
    patches = [each for each in rolling.patches if each.side == side]
    for role in ("rail", "wheel"):
        found = meshio.read(folder / f"stresses-{role}-{side}.vtu")
        assert found.cells[0].type == "hexahedron"
        patch = max(patches, key=lambda each: each.stress_fields[role].max_von_mises.value)
        extreme = patch.stress_fields[role].max_von_mises
        highest, point = extreme.value, patch.points_below(role, *(np.array([x]) for x in extreme.position))[0]
        mises = found.point_data["von_mises_MPa"]
        assert float(mises.max()) == pytest.approx(highest, rel=1e-6)  # single precision
        np.testing.assert_allclose(found.points[mises.argmax()], point, atol=1e-9)
        pressure = max(each.max_pressure for each in patches)
        assert float(found.point_data["stress_MPa"][:, 1].min()) == pytest.approx(-pressure, rel=1e-3)
        sides = found.points[found.cells[0].data]
        # no cell is folded: all have volumes of one sign
        volumes = np.linalg.det(sides[:, (1, 3, 4)] - sides[:, :1])
        assert (np.sign(volumes) == np.sign(volumes[0])).all()


@pytest.mark.parametrize("side", ["left", "right"])
def test_sections_have_the_pressure_of_the_patch_and_the_bending_of_the_rail(run, plain, side):
    """The normal stress at the surfaces is the pressure, the foot has the rail's stress, displaced the bodies meet."""
    patch = next(each for each in run.result.patches if each.side == side)
    normal = patch.force_on_wheel_N / patch.normal_force_N
    apart = 0.0
    for role, outward in (("rail", 1.0), ("wheel", -1.0)):
        found = meshio.read(plain / f"section-{role}-{side}.vtu")
        stresses, moved = found.point_data["stress_MPa"], found.points + found.point_data["displacement_mm"]
        near = np.linalg.norm(moved - patch.centre_mm, axis=1) < 3.0
        tensors = stresses[:, ((0, 3, 5), (3, 1, 4), (5, 4, 2))]
        pressed = -np.einsum("i,nij,j->n", normal, tensors, normal)[near]
        assert pressed.max() == pytest.approx(patch.max_pressure, rel=0.15)
        apart += (moved[near] @ normal * outward).max()
        if role == "rail":
            _check_foot(run.result, side, found.points, stresses[:, 2])
    # the rail has moved by 0.2 to 2 mm; the flange's patch is as wide as three of these coarse elements
    assert abs(apart) < (0.02 if side == "left" else 0.15)


def _check_foot(result, side, points, along):
    """Compare the stresses along the track in the underside of the foot with those of the rail along the track."""
    rail, frame = result.rails[side], result.equilibrium.state.sides[side].grid.surfaces.rail_frame
    x, y = frame.inverse().points(points[:, :2] * (SIDE_SIGN[side], 1.0)).T
    at, middles = y < y.min() + 1e-6, rail.stresses.points_mm
    below = np.flatnonzero(middles[:, 1] < middles[:, 1].min() + 1e-6)
    wanted = [np.interp(points[0, 2], rail.z_mm, rail.stresses.along_MPa[:, number]) for number in below]
    order, places = np.argsort(x[at]), np.sort(middles[below, 0])
    np.testing.assert_allclose(
        np.interp(places, x[at][order], along[at][order]), np.array(wanted)[np.argsort(middles[below, 0])], rtol=0.05
    )


def test_tables_hold_the_patches_and_the_stresses_below_them(rolling, folder):
    """A row a patch with the summary's numbers, empty where there is none; the maxima below are the summary's."""
    with (folder / "patches.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    patches = rolling.summary["patches"]
    assert [(row["side"], row["region"]) for row in rows] == [(p["side"], p["region"]) for p in patches]
    for row, patch in zip(rows, patches, strict=True):
        assert float(row["semi_axes_a_mm"]) == pytest.approx(patch["semi_axes_mm"][0], rel=1e-5)
        assert float(row["wheel_position_x_mm"]) == pytest.approx(patch["wheel_position_mm"][0], rel=1e-5)
        assert float(row["in_rail_max_tresca_MPa"]) == pytest.approx(patch["in_rail_max_tresca_MPa"], rel=1e-5)
        assert bool(row["hertz_pressure_MPa"]) == (patch["hertz_pressure_MPa"] is not None)
    with (folder / "subsurface.csv").open(encoding="utf-8") as file:
        below = list(csv.DictReader(file))
    for patch in rolling.patches:
        where, line = (patch.side, patch.region), patch.lines["rail"]
        mises = [float(row["von_mises_MPa"]) for row in below if (row["side"], row["region"]) == where]
        assert max(mises) == pytest.approx(line.maximum(line.stresses.von_mises)[0], rel=1e-5)


def test_a_search_without_patches_has_no_empty_pictures_and_tables(run):
    """Where no equilibrium was found, pictures and tables of patches are left out; position and forces stay."""
    nothing = replace(run.result, patches=())
    record = case_record(replace(run, result=nothing))
    assert [picture.file for picture in record.pictures()] == ["wheelset.png", "rails.png"]
    assert "Patches" not in [table.caption for table in record.tables]
    assert record.results.rows
    assert "Rolling" not in record.chapters


@pytest.mark.parametrize("side", ["left", "right"])
def test_surfaces_carry_the_creep_forces_and_their_power(rolling, folder, side):
    """Tractions times areas are the creep forces, opposite on the rail; power over the area sums to that of friction.

    No traction is above 0.35 times the pressure; where it sticks there is no slip.
    """
    mine = [each for each in rolling.patches if each.side == side]
    wanted = sum(each.creep_force_on_wheel_N for each in mine)
    corners, arrays = quads(folder / f"rail-{side}.vtu")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    np.testing.assert_allclose(areas @ arrays["traction_MPa"], -wanted, atol=5e-3 * np.linalg.norm(wanted))
    power = sum(20.0 * each.creep.forces.frictional_power for each in mine)
    assert areas @ arrays["frictional_power_W_mm2"] == pytest.approx(power, rel=5e-3)
    assert power > 0.0
    size = np.linalg.norm(arrays["traction_MPa"], axis=1)
    assert (size <= 0.35 * arrays["pressure_MPa"] + 1e-2).all()
    # tractions lie in the surface
    along_normal = np.abs(np.sum(arrays["traction_MPa"] * normals, axis=1)) / areas
    assert along_normal.max() < 0.02 * size.max()
    slip = np.linalg.norm(arrays["slip_velocity_m_s"], axis=1)
    states = arrays["stick_slip_state"]
    assert set(states) == {0.0, 1.0, 2.0}
    assert slip[states == 1.0].max() < 1e-3 * slip.max()
    assert ((states > 0.0) == (arrays["pressure_MPa"] > 0.0)).all()
    _, of_wheel = quads(folder / f"wheel-{side}.vtu")
    assert of_wheel["traction_MPa"].sum(axis=0) == pytest.approx(-arrays["traction_MPa"].sum(axis=0), abs=1e-6)


def test_the_tables_have_columns_of_friction(rolling, folder):
    """A row a patch has the summary's creepages and forces, and the report a section with its three pictures."""
    with (folder / "patches.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row, (patch, own) in zip(rows, rolling.result.rolling, strict=True):
        wanted = {
            "longitudinal_creepage": own.longitudinal_creepage,
            "lateral_creepage": own.lateral_creepage,
            "spin_creepage_per_m": own.spin_creepage_per_m,
            "lateral_creep_force_kN": 1e-3 * own.lateral_force_N,
            "spin_moment_Nm": own.spin_moment_Nm,
            "t_gamma_N": own.t_gamma_N,
            "traction_coefficient": own.used_friction,
            "pressure_over_shear_strength": patch.max_pressure * np.sqrt(3.0) / 510.0,
            "frictional_power_W": 20.0 * own.forces.frictional_power,
            # normal and creep force together
            "lateral_force_kN": 1e-3 * patch.force_on_wheel_N[0],
            "vertical_force_kN": 1e-3 * patch.force_on_wheel_N[1],
        }
        assert {name: float(row[name]) for name in wanted} == pytest.approx(wanted, rel=1e-5)
    text = (folder / "report.html").read_text(encoding="utf-8")
    start, end = text.index('<h2 id="rolling">'), text.index('<h2 id="numbers">')
    assert text.index('<h2 id="pictures">') < start < end
    assert text[start:end].count("<figure>") == 2
