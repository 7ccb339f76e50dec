"""What all results share: a short text, a table, a view in notebooks, a picture."""

import csv
import dataclasses
import sys
from functools import cache
from html import escape
from types import SimpleNamespace

import numpy as np
import pytest

from flangeway.cases import load_case
from flangeway.cases.profile_run import run_profile
from flangeway.cases.rigid_run import ConicityRun, GeometryRun
from flangeway.cases.section_run import SectionRun
from flangeway.contact import Contact, Multiplier, NodeToSegment, Surface, press
from flangeway.elements import Virtual
from flangeway.errors import InputError
from flangeway.geometry import Placement
from flangeway.materials import Elastic
from flangeway.mesh import dual, rectangle_grid
from flangeway.mesh.polyhedral_mesh import PolyhedralMesh
from flangeway.post import adapt, pressure_patches, recovered_stresses, stresses_along
from flangeway.problems import Body, Elasticity, Part, Torsion, Traction, fixed
from flangeway.railway.profiles import bundled
from flangeway.report.case_outputs import case_record
from flangeway.results import Result, ResultTable, Shown
from flangeway.solve import solve_elasticity, solve_torsion
from flangeway.space import Space

PNG = b"\x89PNG"


def solve(mesh):
    """A beam held at the left with a shear load on the right."""
    space = Space(mesh, Virtual(1))
    return solve_elasticity(
        Elasticity(space, Elastic(1e3, 0.3), loads=[Traction("right", (0.0, 1.0))], supports=[fixed("left")])
    )


def touching():
    """Two blocks pressed together."""
    blocks = []
    for name, low in (("upper", 1.0), ("lower", 0.0)):
        mesh = dual(rectangle_grid(2.0, 1.0, 6, 3)).placed(Placement(0.0, (0.0, low)))
        held = "top" if name == "upper" else "bottom"
        blocks.append(Part(name, Body(name, mesh, Virtual(1), Elastic(1e3, 0.3), held)))
    surfaces = [
        Surface(part, part.body.mesh.edge_set(edge)) for part, edge in zip(blocks, ("bottom", "top"), strict=True)
    ]
    contact = Contact(*surfaces, NodeToSegment(), Multiplier())
    return press([contact], {blocks[0]: Placement(0.0, (0.0, -0.01))})


@cache
def result(name):
    mesh = dual(rectangle_grid(3.0, 1.0, 6, 3))
    made = {
        "elasticity": lambda: solve(mesh),
        "torsion": lambda: solve_torsion(Torsion(Space(mesh, Virtual(2)), formulation="prandtl")),
        "contact": touching,
        "patch": lambda: pressure_patches(touching().system, touching().state)[0],
        "line": lambda: stresses_along(solve(mesh), (0.1, 0.5), (2.9, 0.5), 20),
        "adaptive": lambda: adapt(
            solve, mesh, lambda s: recovered_stresses(s).cell_errors, tolerance=1e-9, most_steps=3
        ),
        "recovered": lambda: recovered_stresses(solve(mesh)),
        "bodies": lambda: load_case("cook").run(),
        "profile": lambda: run_profile("60E1"),
    }
    return made[name]()


NAMES = ("elasticity", "torsion", "contact", "patch", "line", "adaptive", "recovered", "bodies", "profile")


@pytest.mark.parametrize("name", NAMES)
def test_a_result_shows_itself(name, tmp_path):
    """Its text is one short line without arrays; its table is a view and a CSV file with all rows and digits."""
    found = result(name)
    text = repr(found)
    assert text.startswith(type(found).__name__)
    assert len(text) < 200
    assert "\n" not in text
    table = found.table
    assert len(table) > 0
    view = found._repr_html_()
    if name == "bodies":  # a run of a case shows what its command prints
        results = case_record(found).results
        assert "<p><b>converged" in view
        assert view.count("<td>") == len(results.rows) * len(results.header)
        assert all(f"<td>{escape(cell)}</td>" in view for row in results.rows for cell in row)
    else:
        assert view.count("<th>") == len(table.columns)
        assert view.count("<tr>") == 1 + min(len(table), 12)
    found.to_csv(tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(table)
    for column, values in table.columns.items():
        if isinstance(values[0], float):
            read = [float(row[column]) if row[column] else np.nan for row in rows]
            np.testing.assert_allclose(read, np.asarray(values, dtype=float), rtol=1e-9)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "recovered"])
def test_a_result_draws_itself(name):
    """Its picture is a figure that notebooks show."""
    assert result(name).plot()._repr_png_().startswith(PNG)


@cache
def wheelset():
    """A coarse wheelset on its rails."""
    return load_case("wheelset", size_scale=4.0, patch_cells=12).run().result


MADE = {
    "wheel": lambda: bundled.wheel("S1002"),
    "rail": lambda: bundled.rail("60E1"),
    "mesh": lambda: dual(rectangle_grid(3.0, 1.0, 6, 3)),
    "mesh in space": lambda: PolyhedralMesh.voronoi(np.random.default_rng(0).random((8, 3)), (0, 0, 0, 1, 1, 1)),
    "problem": lambda: result("elasticity").problem,
    "wheelset": wheelset,
    "patch": lambda: wheelset().patches[0],
}
"""What holds many numbers, and is no result of a command."""


@pytest.mark.parametrize("name", MADE)
def test_what_holds_many_numbers_has_a_short_text_and_a_picture(name):
    """Profiles, meshes, problems, wheelsets and patches are one line in a console, and draw themselves."""
    found = MADE[name]()
    assert repr(found).startswith(type(found).__name__)
    assert len(repr(found)) < 200
    assert found.plot()._repr_png_().startswith(PNG)


def test_a_picture_of_a_patch_has_its_pressures():
    """The cells that are drawn have the pressures of the patch, between the bounds of its cells."""
    patch = wheelset().patches[0]
    axes = patch.plot().axes[0]
    (drawn,) = axes.collections
    assert np.asarray(drawn.get_array()).ravel() == pytest.approx(patch.cells.pressures.T.ravel())
    assert np.ptp(drawn.get_coordinates()[..., 0]) == pytest.approx(np.ptp(patch.cells.grid.bounds))


def test_the_text_of_inputs_has_what_was_changed():
    """A record shows the inputs that are not the defaults, as Python makes it."""
    curve = {"load.curve.radius_m": 300.0, "load.curve.speed_km_h": 60.0}
    case = load_case("wheelset", lateral_mm=3.0, **curve)
    assert repr(case) == (
        "Wheelset(load=Load(curve=Curve(radius_m=300.0, speed_km_h=60.0)), position=Position(lateral_mm=3.0))"
    )


def test_options_reach_the_picture():
    """Other stresses look otherwise; what has no picture, or no such option, is refused."""
    beam = result("elasticity")
    assert beam.plot(quantity="xx")._repr_png_() != beam.plot()._repr_png_()
    with pytest.raises(InputError, match="a picture of RecoveredStresses with colour"):
        result("recovered").plot(colour="red")
    with pytest.raises(TypeError):
        result("line").plot(colour="red")


def test_tables_hold_what_was_computed():
    """Displacements at the nodes, forces of contacts, and the tables of a run by the names of its summary."""
    beam = result("elasticity")
    assert np.array_equal(beam.table.columns["displacement_y"], beam.displacements[: beam.problem.space.n_nodes, 1])
    pair = result("contact")
    assert pair.table.columns["force_on_secondary_y"] == pytest.approx(pair.forces[:, 1])
    run = result("bodies")
    assert run.table.columns["max_von_mises_MPa"] == [body["max_von_mises_MPa"] for body in run.summary["bodies"]]
    assert set(run.tables) == {"bodies", "supports"}


def test_every_result_is_a_dataclass_with_a_short_text():
    """No class of results has the text of a dataclass, which prints all arrays."""
    kinds = [Result]
    for kind in kinds:
        kinds += kind.__subclasses__()
    assert {GeometryRun, ConicityRun, SectionRun} <= set(kinds)
    for kind in kinds[1:]:
        assert kind.__repr__ is Shown.__repr__
        assert dataclasses.is_dataclass(kind) or kind.__subclasses__()


def test_tables_from_rows():
    """Lists become columns before the unit, mappings prefixes; missing values are empty, longer lists left out."""
    rows = [
        {"name": "a", "centre_mm": [1.0, 2.0], "in_rail": {"depth_mm": 0.5}, "axes_mm": None, "long": [1, 2, 3, 4]},
        {"name": "b", "centre_mm": [3.0, float("nan")], "in_rail": {"depth_mm": None}, "axes_mm": [5.0, 4.0]},
    ]
    table = ResultTable.of_rows(rows, {"axes_mm": ("longer", "shorter")})
    assert table.csv() == (
        "name,centre_x_mm,centre_y_mm,in_rail_depth_mm,axes_longer_mm,axes_shorter_mm\na,1,2,0.5,,\nb,3,,,5,4\n"
    )
    assert repr(table).splitlines()[2].split() == ["b", "3", "–", "–", "5", "4"]
    numbers = ResultTable.of_numbers({"unit": "mm", "area_mm2": 2.0, "centroid_mm": [1.0, 0.0]})
    assert numbers.rows() == [("area_mm2", 2.0), ("centroid_x_mm", 1.0), ("centroid_y_mm", 0.0)]
    with pytest.raises(InputError, match="columns of"):
        ResultTable({"a": [1], "b": [1, 2]})


def test_frames_are_optional(monkeypatch):
    """With pandas the table becomes a frame; without it the error says what to do."""
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=dict))
    assert result("contact").to_dataframe()["secondary"] == ["upper"]
    monkeypatch.delitem(sys.modules, "pandas")
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match="to_csv"):
        result("contact").to_dataframe()
