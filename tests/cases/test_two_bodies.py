"""The general case against answers found without it: exact stresses, Hertz's theory, and itself turned and moved."""

import json
import re
from dataclasses import replace

import meshio
import numpy as np
import pytest

from flangeway.cases import CASES, load_case
from flangeway.cases.bodies.bodies_run import TwoBodiesCase
from flangeway.exact import LineContact, contact_modulus
from flangeway.materials import Elastic
from flangeway.post import check_contact, cut_zones
from flangeway.report.case_outputs import write_case
from flangeway_studies.contact_patch import boxes

WIDTH, UPPER, LOWER = 6.0, 2.0, 3.0
UPPER_POISSON = 0.2
# both boxes spread by nu (1 + nu) / E: equal, so that no edge hangs over
LOWER_POISSON = (np.sqrt(1.0 + 4.0 * 3.0 * UPPER_POISSON * (1.0 + UPPER_POISSON)) - 1.0) / 2.0
PAIR = {"secondary": "upper", "secondary_edges": "bottom", "primary": "lower", "primary_edges": "top"}


def box(name, low, height, **keys):
    """Body of a rectangle from a height up."""
    shape = {"width_mm": WIDTH, "height_mm": height, "centre_mm": [0.0, low + height / 2.0]}
    return {"name": name, "rectangle": shape, "size_mm": 1.3, **keys}


def stack(gap=0.0, **keys):
    """Two boxes, the far sides held upright, free to spread."""
    values = {
        "thickness_mm": 2.0,
        "bodies": [
            box("upper", gap, UPPER, young_MPa=1000.0, poisson=UPPER_POISSON),
            box("lower", -LOWER, LOWER, young_MPa=3000.0, poisson=LOWER_POISSON, method="vem"),
        ],
        "supports": [
            {"body": "upper", "edges": "top", "hold": "y"},
            {"body": "upper", "point_mm": [-WIDTH / 2.0, gap + UPPER], "hold": "x"},
            {"body": "lower", "edges": "bottom", "hold": "y"},
            {"body": "lower", "point_mm": [-WIDTH / 2.0, -LOWER], "hold": "x"},
        ],
        "contacts": [{**PAIR, "enforcement": "multiplier"}],
    }
    return TwoBodiesCase.from_values({**values, **keys})


def pressures(run):
    return np.concatenate([patch.pressures for patch in run.patches])


@pytest.mark.parametrize("gap", [0.0, 0.7])
def test_a_force_on_stacked_boxes_gives_uniform_pressure_and_their_shortening(gap):
    """A pushed stack has force over area everywhere and deflects by the sum of p h (1 - nu^2) / E, and the gap."""
    run = stack(gap, motions=[{"body": "upper", "push_N": [0.0, -240.0]}]).run()
    pressure = 240.0 / (WIDTH * 2.0)
    shorter = pressure * (UPPER * (1.0 - UPPER_POISSON**2) / 1000.0 + LOWER * (1.0 - LOWER_POISSON**2) / 3000.0)
    assert run.status.converged
    assert pressures(run) == pytest.approx(pressure, rel=1e-6)
    assert run.summary["results"]["pushed_mm"] == pytest.approx(gap + shorter, rel=1e-6)
    forces = {row["body"]: row for row in run.summary["forces"]}
    assert forces["upper"]["contact_N"] == pytest.approx([0.0, 240.0], rel=1e-6, abs=1e-6)
    assert forces["lower"]["supports_N"] == pytest.approx([0.0, 240.0], rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("supports", [[{"at_x_mm": -3.0, "hold": "x"}], [{"point_mm": [-3.0, 2.0], "hold": "x"}], []])
def test_a_body_that_its_supports_leave_free_rests_on_the_contact(supports):
    """Slides, turns or floats: under a pressure the contact carries it; without one the case is valid too."""
    values = stack().model_dump()
    values["supports"] = [{"body": "upper", **each} for each in supports] + values["supports"][2:]
    TwoBodiesCase.from_values(values).check()
    values["loads"] = [{"body": "upper", "edges": "top", "pressure_MPa": 1.0}]
    run = TwoBodiesCase.from_values(values).run()
    assert run.status.converged, run.status.message
    assert pressures(run) == pytest.approx(1.0, rel=1e-5)


@pytest.mark.parametrize(
    ("motion", "converged", "words"),
    [
        ({"push_N": [0.0, 100.0]}, False, "no contact holds a load: `upper` can slide in y"),
        ({"push_N": [0.0, -1e12]}, False, "check the direction and the size of loads"),
        ({"shift_mm": [0.0, 5.0]}, True, "nothing touches"),
    ],
)
def test_contact_that_cannot_happen_is_a_result_that_says_so(motion, converged, words):
    """A push away or through the other body does not converge, with the reason; no touch without a push does."""
    values = stack(motions=[{"body": "upper", **motion}]).model_dump()
    values["supports"] = [{"body": "upper", "edges": "top"}, {"body": "lower", "edges": "bottom"}]
    status = TwoBodiesCase.from_values(values).run().status
    assert status.converged == converged
    assert words in status.message


def test_loads_deform_bodies_before_they_touch():
    """A hanging column under body force b meets a standing one: their pressure is b h / 4, for equal columns."""
    h, b = 3.0, 40.0
    values = {
        "hypothesis": "plane-stress",
        "bodies": [box(name, low, h, young_MPa=500.0, poisson=0.0) for name, low in (("upper", 0.0), ("lower", -h))],
        "supports": [{"body": "upper", "edges": "top"}, {"body": "lower", "edges": "bottom"}],
        "loads": [{"body": "upper", "body_force_N_mm3": [0.0, -b]}],
        "contacts": [{**PAIR, "enforcement": "multiplier"}],
        "steps": {"number": 3},
    }
    values["bodies"] = [{**body, "order": 2} for body in values["bodies"]]
    run = TwoBodiesCase.from_values(values).run()
    assert len(run.contact.steps) == 3
    assert pressures(run) == pytest.approx(b * h / 4.0, rel=1e-6)
    forces = run.summary["forces"][0]
    assert forces["loads_N"] == pytest.approx([0.0, -b * h * WIDTH], abs=1e-6)
    assert forces["supports_N"][1] == pytest.approx(0.75 * b * h * WIDTH, rel=1e-6)
    # the field has both parts: at the middle of the hanging column u = -b (h y - y^2 / 2) / E + p y / E, y downwards
    field = run.bodies["upper"].field
    nodes = field.problem.space.nodes
    depth = h - nodes[:, 1]
    exact = (-b * (h * depth - depth**2 / 2.0) + b * h / 4.0 * depth) / 500.0
    assert field.displacements[: len(nodes), 1] == pytest.approx(exact, abs=1e-8)


@pytest.mark.parametrize("load", ["pressure", "traction", "force", "point", "support"])
def test_one_body_without_contact_is_plane_elasticity(load):
    """A box pulled or pressed by any kind of load has the exact uniform stress and stretch."""
    loads = {
        "pressure": [{"body": "upper", "at_y_mm": UPPER, "pressure_MPa": -5.0}],
        "traction": [{"body": "upper", "edges": ["top"], "traction_MPa": [0.0, 5.0]}],
        "force": [{"body": "upper", "box_mm": [-3.0, 2.0, 3.0, 2.0], "force_N": [0.0, 5.0 * WIDTH * 2.0]}],
        "point": [{"body": "upper", "point_mm": [3.0, 2.0], "force_N": [0.0, 5.0 * WIDTH * 2.0]}],
        "support": [],
    }[load]
    stretch = 5.0 * (1.0 - 0.2**2) / 1000.0 * UPPER
    supports = [
        {"body": "upper", "edges": "bottom", "hold": "y"},
        {"body": "upper", "point_mm": [-WIDTH / 2.0, 0.0], "hold": "x"},
    ]
    if load == "support":
        supports.append({"body": "upper", "edges": "top", "hold": "y", "y_mm": stretch})
    bodies = [box("upper", 0.0, UPPER, young_MPa=1000.0, poisson=0.2)]
    run = TwoBodiesCase.from_values({"thickness_mm": 2.0, "bodies": bodies, "supports": supports, "loads": loads}).run()
    field = run.bodies["upper"].field
    top = field.displacements[np.flatnonzero(field.problem.space.nodes[:, 1] == UPPER)[:, None], 1]
    assert run.contact is None
    if load == "point":  # at one corner: the box turns and the mean is what the resultant does
        assert top.max() > stretch
        assert field.problem.load_vector().sum(axis=0) == pytest.approx([0.0, 60.0])
    else:
        assert top == pytest.approx(stretch, rel=1e-9)


def test_cylinders_agree_with_hertz():
    """Maximum pressure and half width of cylinders are within 2 and 5 % of Hertz's under the same force."""
    other = {"lower_young_MPa": 70e3, "lower_radius_mm": 60.0, "lower_method": "vem"}
    results = load_case("hertz", order=2, size_mm=0.15, force_N=2e4, **other).run().summary["results"]
    modulus = contact_modulus(200e3 / (1.0 - 1.0 / 9.0), 70e3 / (1.0 - 1.0 / 9.0))
    hertz = LineContact(2e4 / 10.0, 1.0 / 40.0 + 1.0 / 60.0, modulus)
    assert results["force_N"] == pytest.approx(2e4, rel=1e-6)
    assert results["max_pressure_MPa"] == pytest.approx(hertz.max_pressure, rel=0.02)
    assert results["half_width_mm"] == pytest.approx(hertz.half_width, rel=0.05)
    assert results["hertz_max_pressure_MPa"] == pytest.approx(hertz.max_pressure, rel=1e-12)
    assert not results["reaches_an_end"]


BOX_SIZES_MM = {"upper": 2.3, "lower": 3.1}


@pytest.mark.parametrize(("method", "order"), [("fem", 2), ("vem", 1)])
def test_node_to_node_cases_get_the_nodes_that_they_need(method, order):
    """Boxes of different meshes pass to round-off, turned too; only triangles with more nodes become virtual."""
    of_boxes = {name: {"method": method, "order": order, "size_mm": size} for name, size in BOX_SIZES_MM.items()}
    contact = {"pairing": "node-to-node", "enforcement": "multiplier"}
    run = boxes(20.0, 10.0, rotation_deg=20.0, of_boxes=of_boxes, contact=contact).run()
    assert run.status.converged
    exact = Elastic(210e3, 0.3).plane_modulus * 0.1 / 20.0
    assert run.patches[0].pressures == pytest.approx(exact, rel=1e-9)
    body = run.contact.system.parts[0].body
    assert (body.mesh.cell_sizes > 3).any()
    if method == "fem":
        assert set(body.element) == {"triangles", "polygons"}
        assert len(body.mesh.cell_sets["triangles"]) > len(body.mesh.cell_sets["polygons"]) > 0


def test_supports_tell_what_they_bear():
    """Supports of a beam bear its loads, and share what two of them hold."""
    clamped = TwoBodiesCase.from_values(
        {
            "bodies": [{"name": "beam", "rectangle": {"width_mm": 8.0, "height_mm": 2.0}, "order": 2, "size_mm": 1.0}],
            "supports": [
                {"body": "beam", "edges": "left", "hold": "x"},
                {"body": "beam", "point_mm": [-4.0, -1.0]},
                {"body": "beam", "edges": "bottom", "hold": "y"},
            ],
            "loads": [{"body": "beam", "edges": "right", "force_N": [10.0, -3.0]}],
        }
    ).run()
    forces = np.array([row["force_N"] for row in clamped.summary["supports"]])
    assert forces.sum(axis=0) == pytest.approx([-10.0, 3.0])
    assert forces[0, 1] == forces[2, 0] == 0.0
    assert abs(forces[1]).min() > 0.0


def test_several_materials_are_taken_by_cell_sets(tmp_path):
    """Two squares side by side with moduli 1 and 10 stretch as springs in a row."""
    (tmp_path / "bar.inp").write_text(
        "*NODE\n1, 0, 0\n2, 1, 0\n3, 2, 0\n4, 0, 1\n5, 1, 1\n6, 2, 1\n*ELEMENT, TYPE=CPS4, ELSET=soft\n1, 1, 2, 5, 4\n"
        "*ELEMENT, TYPE=CPS4, ELSET=stiff\n2, 2, 3, 6, 5\n*NSET, NSET=held\n1, 4\n*NSET, NSET=pulled\n3, 6\n",
        encoding="utf-8",
    )
    case = TwoBodiesCase.from_values(
        {
            "hypothesis": "plane-stress",
            "bodies": [
                {
                    "name": "bar", "file": str(tmp_path / "bar.inp"), "method": "vem",
                    "materials": {n: {"young_MPa": young, "poisson": 0.0} for n, young in (("soft", 1), ("stiff", 10))},
                }
            ],
            "supports": [{"body": "bar", "edges": "held"}],
            "loads": [{"body": "bar", "edges": "pulled", "traction_MPa": [0.1, 0.0]}],
        }
    )  # fmt: skip
    assert case.run().summary["bodies"][0]["max_displacement_mm"] == pytest.approx(0.11)


def test_an_outline_file_in_another_unit_is_a_body(tmp_path):
    """An outline drawn in cm is meshed in mm: its weight is that of its area, its size and its sides are as named."""
    (tmp_path / "box.csv").write_text(
        "# unit: cm\nname,type,x0,y0,x1,y1\na,line,0,0,2,0\nb,line,2,0,2,1\nc,line,2,1,0,1\nd,line,0,1,0,0\n",
        encoding="utf-8",
    )
    (tmp_path / "box.toml").write_text(
        'case = "two-bodies"\n[[bodies]]\nname = "box"\nfile = "box.csv"\nsize_mm = 3.0\n[[supports]]\nbody = "box"\n'
        'edges = "a"\n[[loads]]\nbody = "box"\nbody_force_N_mm3 = [1.0, 0.0]\n', encoding="utf-8",
    )  # fmt: skip
    case = load_case(tmp_path / "box.toml")
    problem = case.run().bodies["box"].field.problem
    assert problem.load_vector().sum(axis=0) == pytest.approx([200.0, 0.0])
    assert 60 < problem.space.mesh.n_cells < 120


def test_the_files_show_the_whole_motion(tmp_path):
    """The ParaView files have the bodies at their first places, their whole motion, and stresses with their unit."""
    run = stack(0.3, motions=[{"body": "upper", "push_N": [0.0, -240.0]}]).run()
    files = write_case(run, tmp_path)
    assert [file.name for file in files] == [
        *("stresses.png", "pressure.png", "1-upper.vtu", "2-lower.vtu", "contact.vtu", "bodies.pvd"),
        *("report.html", "summary.json"),
    ]
    assert json.loads(files[-1].read_text(encoding="utf-8")) == run.summary
    read = meshio.read(tmp_path / "1-upper.vtu")
    motion = read.point_data["displacement_mm"]
    top = read.points[:, 1] > UPPER + 0.3 - 1e-9
    assert motion[top, 1] == pytest.approx(-run.summary["results"]["pushed_mm"], rel=1e-9)
    assert read.point_data["stress_MPa"][:, 1] == pytest.approx(-20.0, rel=1e-5)
    assert read.point_data["von_mises_MPa"].max() < 20.0
    surface = meshio.read(tmp_path / "contact.vtu")
    assert surface.point_data["pressure_MPa"] == pytest.approx(20.0, rel=1e-5)


NAMES = ["the contact"]


def found(motions=None, **changes):
    """Run of the disc on the block with other inputs of its contact, and another motion."""
    case = CASES["two-bodies"]
    values = {**case.example, "contacts": [{**case.example["contacts"][0], **changes}]}
    values["motions"] = motions or values["motions"]
    return case.from_values(values).run()


@pytest.fixture(scope="module")
def good():
    return found()


def test_a_good_contact_has_no_doubts(good):
    """The disc on the block of the case's example is converged, without errors and cut zones."""
    contact = good.contact
    checks = check_contact(contact.system, contact.state, good.patches, NAMES)
    assert good.status.converged
    assert checks.errors == ()
    assert cut_zones(contact.system, contact.state) == ()


@pytest.mark.parametrize(("body", "box"), [("block", "primary_box_mm")])
def test_a_zone_that_cuts_the_contact_is_told(body, box):
    """If the edges that may touch end within the contact, the note says that contact beyond is missing."""
    down = [{"body": "cylinder", "shift_mm": [0.0, -0.02]}]
    run = found(down, **{box: [-8.0, -1.0, 0.2, 2.0]})
    assert not any("end of the edges" in note for note in found(down).summary["notices"])
    assert any(note.startswith(f"{body}: there is contact at the end") for note in run.summary["notices"])


def test_segments_are_counted_by_order(good):
    """A patch of 7 constraints is 7 segments, which is reported as too few; 8 on a smooth ellipse are enough."""
    patch = good.patches[0]
    short = replace(patch, pressures=patch.pressures[:7])
    checks = check_contact(good.contact.system, good.contact.state, [short], NAMES)
    assert any("only 7 segments wide, fewer than 8" in warning for warning in checks.warnings)
    places = np.linspace(-1.0, 1.0, 10)[1:-1]
    smooth = replace(patch, pressures=100.0 * np.sqrt(1.0 - places**2))
    assert check_contact(good.contact.system, good.contact.state, [smooth], NAMES).warnings == ()


@pytest.mark.parametrize("pairing", ["segment-to-segment", "node-to-segment"])
def test_segments_of_order_2_are_counted_whole(pairing):
    """A contact reported as n segments wide has that width, though its constraints are at ends or at all nodes."""
    case = CASES["hertz"].from_values({"order": 2, "size_mm": 0.5, "pairing": pairing, "enforcement": "multiplier"})
    run = case.run()
    (patch,) = run.patches
    (told,) = (note for note in run.summary["notices"] if "wide, fewer than 8" in note)
    n_segments = float(re.search(r"only ([\d.]+) segments? wide", told)[1])
    lengths = run.contact.system.contacts[0].secondary.edge_lengths
    assert n_segments == pytest.approx(patch.width / lengths.min(), abs=0.6)
