"""A stack of five blocks: the lower one is held, the upper one is pressed and pushed, friction holds those between.

     ->  _________
        |  upper  |   pressed by a force, then shifted to the right
      __|_________|__
     |   block 4     |
      ...               held by contact and friction alone
    |_______________|
    |     lower       |
    ------------------

Run it with ``python examples/stack_with_friction.py``. Steps:

1. make bodies; those of which nothing is held are held by contact alone;
2. put contacts with coefficients of friction between neighbours;
3. press with a load, then shift, and follow the path;
4. read forces, slips and the dissipated work, and check them by statics.
"""

import itertools

import numpy as np

import flangeway as fw
from flangeway.contact import Contact, Surface, press
from flangeway.mesh import rectangle_grid

HEIGHT, FORCE, SHIFT = 10.0, 1000.0, 0.02
COEFFICIENTS = (0.5, 0.4, 0.2, 0.3)


def main() -> None:
    """Press and push the stack, and print what each interface carries."""
    names = ("lower", "block 2", "block 3", "block 4", "upper")
    parts = []
    for number, name in enumerate(names):
        width = 40.0 - 4.0 * number
        mesh = rectangle_grid(width, HEIGHT, 16 - number, 4, origin=(-width / 2.0, number * HEIGHT))
        held = {"lower": "bottom", "upper": "top"}.get(name)
        parts.append(fw.Part(name, fw.Body(name, mesh, fw.Lagrange(1), fw.Elastic(210e3, 0.3), held)))
    contacts = []
    for (below, above), friction in zip(itertools.pairwise(parts), COEFFICIENTS, strict=True):
        contacts.append(Contact(Surface(above, "bottom"), Surface(below, "top"), friction=friction))

    path = [{}, {parts[-1]: fw.Placement(0.0, (SHIFT, 0.0))}]
    solution = press(contacts, path, loads={parts[-1]: (None, -FORCE, None)})
    assert solution.status.converged, solution.status.message
    print(solution.status.message)

    table = {name: np.asarray(values) for name, values in solution.friction_table.columns.items()}
    for number, (contact, friction) in enumerate(zip(contacts, COEFFICIENTS, strict=True)):
        mine = table["contact"] == number
        tangential = abs(table["tangential_force"][mine].sum())
        print(
            f"{contact.secondary.part.name} on {contact.primary.part.name}: tangential over normal force "
            f"{tangential / FORCE:.4f} of {friction}, sticks at {table['sticks'][mine].mean():.0%} of the nodes"
        )
        # the interface with the least friction slides, and the whole stack carries its limit
        assert abs(tangential / (min(COEFFICIENTS) * FORCE) - 1.0) < 0.01
        assert table["sticks"][mine].any() == (friction != min(COEFFICIENTS))
    slip = abs(table["slip"][table["contact"] == COEFFICIENTS.index(min(COEFFICIENTS))]).mean()
    work = solution.dissipated_work[-1]
    print(f"slip {slip:.5f} mm, dissipated work {work:.4f} N mm per mm")
    assert abs(work / (min(COEFFICIENTS) * FORCE * slip) - 1.0) < 0.05


if __name__ == "__main__":
    main()
