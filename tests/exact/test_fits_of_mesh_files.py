"""Bodies of one mesh file that overlap: interference fits beside closed forms, and beside one file for each body."""

import math

import numpy as np
import pytest

from flangeway.cases import find_case

YOUNG, POISSON = 210e3, 0.3


def quarter_ring(inner, outer, n, n_layers=4):
    """Points and quadrilaterals of second order of a quarter of a ring, by layers outwards."""
    angles = math.pi / 4.0 * np.arange(2 * n + 1) / n
    radii = np.linspace(inner, outer, 2 * n_layers + 1)
    points = (radii[:, None, None] * np.column_stack((np.cos(angles), np.sin(angles)))).reshape(-1, 2)
    width = len(angles)
    cells = []
    for layer in range(0, 2 * n_layers, 2):
        for k in range(0, 2 * n, 2):
            grid = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
            cells.append([(layer + out) * width + k + along for out, along in grid])
    return points, np.array(cells)


def deck(file, bodies):
    nodes, elements, n_nodes, n_elements = [], [], 0, 0
    for name, (points, cells) in bodies.items():
        nodes += [f"{n_nodes + n}, {x:.17g}, {y:.17g}" for n, (x, y) in enumerate(points, 1)]
        elements.append(f"*ELEMENT, TYPE=CPE8, ELSET={name}")
        elements += [", ".join(map(str, [n_elements + n, *(n_nodes + 1 + cell)])) for n, cell in enumerate(cells, 1)]
        n_nodes, n_elements = n_nodes + len(points), n_elements + len(cells)
    file.write_text("\n".join(["*NODE", *nodes, *elements]))


def pressure_of_a_fit(inner, middle, outer, interference):
    """Lame's pressure between two rings of one material in plane strain."""
    young, poisson = YOUNG / (1.0 - POISSON**2), POISSON / (1.0 - POISSON)
    hub = ((outer**2 + middle**2) / (outer**2 - middle**2) + poisson) / young
    shaft = ((middle**2 + inner**2) / (middle**2 - inner**2) - poisson) / young
    return interference / (middle * (hub + shaft))


@pytest.mark.parametrize(("n_shaft", "n_hub"), [(8, 8), (8, 9)])
def test_a_fit_of_rings_in_one_file_has_lames_pressure(tmp_path, n_shaft, n_hub):
    """Quarters of rings of second order in one deck, of which chords cross, press each other as Lame says."""
    inner, middle, outer, interference = 20.0, 40.0, 60.0, 0.02
    file = tmp_path / "fit.inp"
    deck(
        file,
        {
            "SHAFT": quarter_ring(inner, middle, n_shaft),
            "HUB": quarter_ring(middle - interference, outer, n_hub),
        },
    )
    bodies = [
        {"name": name, "file": str(file), "cells": name.upper(), "method": "vem", "order": 2}
        for name in ("shaft", "hub")
    ]
    supports = [{"body": body["name"], f"at_{axis}_mm": 0.0, "hold": axis} for body in bodies for axis in ("x", "y")]
    text = file.read_text().splitlines()
    for name, first in (("SHAFT", 1), ("HUB", 1 + len(quarter_ring(inner, middle, n_shaft)[0]))):
        n = n_shaft if name == "SHAFT" else n_hub
        level = 8 if name == "SHAFT" else 0
        row = first + level * (2 * n + 1) + np.arange(2 * n + 1)
        text += [f"*NSET, NSET=FIT{name}", *map(str, row)]
    file.write_text("\n".join(text))
    contact = {"secondary": "hub", "secondary_edges": "FITHUB", "primary": "shaft", "primary_edges": "FITSHAFT"}
    contact |= {"interference": True, "curved": True}
    case = find_case("two-bodies").from_values(
        {"bodies": bodies, "supports": supports, "contacts": [contact], "hypothesis": "plane-strain"}
    )
    run = case.run()
    assert run.status.converged, run.status
    exact = pressure_of_a_fit(inner, middle, outer, interference)
    # the force on a quarter is p r in both directions
    force = run.bodies["hub"].contact_force
    assert force == pytest.approx([exact * middle, exact * middle], rel=3e-3)
    assert np.median(run.patches[0].pressures) == pytest.approx(exact, rel=0.02)


BLOCKS = """*NODE
{nodes}
*ELEMENT, TYPE=CPE4, ELSET={name}
{cells}
*NSET, NSET=LOW{name}
{low}
*NSET, NSET=TOP{name}
{top}
"""


def block(name, x, y, first):
    numbers = first + np.arange(15).reshape(3, 5)
    nodes = [f"{numbers[j, i]}, {x + i}, {y + j}" for j in range(3) for i in range(5)]
    corners = [
        (numbers[j, i], numbers[j, i + 1], numbers[j + 1, i + 1], numbers[j + 1, i]) for j in (0, 1) for i in range(4)
    ]
    cells = [", ".join(map(str, [first + n, *row])) for n, row in enumerate(corners)]
    return BLOCKS.format(
        name=name,
        nodes="\n".join(nodes),
        cells="\n".join(cells),
        low=", ".join(map(str, numbers[0])),
        top=", ".join(map(str, numbers[2])),
    )


def pressed(files):
    names = {"lower": "LOWER", "upper": "UPPER"}
    return (
        find_case("two-bodies")
        .from_values(
            {
                "bodies": [{"name": n, "file": str(files[n]), "cells": s, "method": "vem"} for n, s in names.items()],
                "supports": [{"body": "lower", "edges": "LOWLOWER"}, {"body": "upper", "edges": "TOPUPPER"}],
                "contacts": [
                    {
                        "secondary": "upper",
                        "secondary_edges": "LOWUPPER",
                        "primary": "lower",
                        "primary_edges": "TOPLOWER",
                        "interference": True,
                    }
                ],
            }
        )
        .run()
    )


def test_overlapping_bodies_of_one_file_are_as_those_of_two(tmp_path):
    """Two blocks that overlap by a twentieth of an element press each other alike, in one file and in two."""
    texts = {"lower": block("LOWER", 0.0, 0.0, 1), "upper": block("UPPER", 0.5, 1.95, 101)}
    for name, text in [*texts.items(), ("both", "".join(texts.values()))]:
        (tmp_path / f"{name}.inp").write_text(text)
    one = pressed(dict.fromkeys(texts, tmp_path / "both.inp"))
    two = pressed({name: tmp_path / f"{name}.inp" for name in texts})
    assert one.status.converged
    assert one.bodies["lower"].contact_force == pytest.approx(two.bodies["lower"].contact_force, rel=1e-9)
    # columns of 0.05 over 3.95 of height, 3.5 wide, carry less than with the material beside them
    column = YOUNG / (1.0 - POISSON**2) * 0.05 / 3.95 * 3.5
    assert 1.0 < -one.bodies["lower"].contact_force[1] / column < 1.5
