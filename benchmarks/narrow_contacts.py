"""Random rollers and spheres on blocks whose contact is narrower than an edge or a few wide: force and its error.

Radii, materials, meshes, elements, pairings, laws and positions of nodes are random, indentations are 0.02 to 2 edges.
The force is compared with that of a mesh four times finer. It is wrong where it differs by more than both state as
their error (`Checks.force_error`) and one hundredth, and both converged.

``python -m benchmarks.narrow_contacts FIRST COUNT`` prints each case.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.measurement import NO_PEER, Measurement
from flangeway.cases.bodies.bodies_run import TwoBodiesCase

FINER, TOLERANCE = 4, 0.01


@dataclass(frozen=True)
class Pressed:
    """A solution: whether it converged, its force, the stated error, and why it did not converge."""

    converged: bool
    force: float
    error: float
    message: str


@dataclass(frozen=True)
class NarrowContact:
    """A random roller or sphere on a block.

    - `values`: the case without sizes.
    - `size`: length of the edges in contact.
    """

    values: dict[str, Any]
    size: float

    @classmethod
    def random(cls, number: int) -> "NarrowContact":
        """A case by its number."""
        rng = np.random.default_rng(number)
        radius = float(np.exp(rng.uniform(np.log(5.0), np.log(200.0))))
        size = radius * float(np.exp(rng.uniform(np.log(0.02), np.log(0.12))))
        depth = size * float(np.exp(rng.uniform(np.log(0.02), np.log(min(2.0, 0.05 * radius / size)))))
        sphere = rng.random() < 0.25
        x = 0.0 if sphere else float(rng.uniform(-0.5, 0.5)) * size
        order = 2 if sphere else int(rng.integers(1, 3))
        young, below = (float(np.exp(rng.uniform(np.log(1e3), np.log(3e5)))) for _ in range(2))
        method = "fem" if sphere else str(rng.choice(["fem", "vem"]))
        shape: dict[str, Any] = {"disc": {"radius_mm": radius, "centre_mm": [x, radius], "half": "lower"}}
        rectangle = {"width_mm": 4.0 * radius, "height_mm": 2.0 * radius, "centre_mm": [0.0, -radius]}
        if sphere:
            path: list[dict[str, Any]] = [
                {"from": [0.0, 0.0]},
                {"arc_to": [radius, radius], "centre": [0.0, radius], "turn": "left", "name": "rim"},
                {"line_to": [0.0, radius], "name": "cut"},
                {"line_to": [0.0, 0.0], "name": "axis"},
            ]
            shape = {"outline": {"path": path}}
            rectangle = {"width_mm": 2.0 * radius, "height_mm": 2.0 * radius, "centre_mm": [radius, -radius]}
        names = [("roller", "rim"), ("block", "top")]
        (one, its_edges), (other, other_edges) = names if rng.random() < 0.5 else names[::-1]
        contact: dict[str, Any] = {
            "secondary": one,
            "secondary_edges": its_edges,
            "primary": other,
            "primary_edges": other_edges,
            "pairing": str(rng.choice(["segment-to-segment", "node-to-segment"])),
            "enforcement": {"kind": str(rng.choice(["multiplier", "augmented-lagrange", "penalty"]))},
            "curved": bool(rng.random() < 0.75),
        }
        if contact["enforcement"]["kind"] == "augmented-lagrange":
            contact["enforcement"]["penetration_mm"] = 1e-4 * depth
        return cls(
            {
                "hypothesis": "axisymmetric" if sphere else str(rng.choice(["plane-strain", "plane-stress"])),
                "bodies": [
                    {"name": "roller", **shape, "young_MPa": young, "order": order, "method": method},
                    {"name": "block", "rectangle": rectangle, "young_MPa": below, "order": order, "method": method},
                ],
                "supports": [{"body": "roller", "edges": "cut"}, {"body": "block", "edges": "bottom"}],
                "motions": [{"body": "roller", "shift_mm": [0.0, -depth]}],
                "contacts": [contact],
            },
            size,
        )

    def solve(self, finer: int = 1) -> Pressed:
        """Solve with edges shorter by a factor."""
        size, half = self.size / finer, 4.0 * self.size
        radius = self.values["bodies"][1]["rectangle"]["height_mm"] / 2.0
        x = np.linspace(0.0 if self.values["hypothesis"] == "axisymmetric" else -half, half, 33)
        rim = radius - np.sqrt(radius**2 - x**2)
        bodies = []
        for body, heights in zip(self.values["bodies"], (rim, np.zeros(len(x))), strict=True):
            fine = {"at_mm": np.column_stack((x, heights)).tolist(), "size_mm": size, "growth": 0.3}
            bodies.append(body | {"size_mm": max(radius / 4.0, size), "fine": [fine]})
        box = [float(x[0]) - size, -radius, half, radius]
        contacts = [self.values["contacts"][0] | {"secondary_box_mm": box, "primary_box_mm": box}]
        run = TwoBodiesCase.from_values(self.values | {"bodies": bodies, "contacts": contacts}).run()
        assert run.contact is not None
        checks = run.contact.status.checks
        error = float("inf") if checks is None else checks.force_error
        return Pressed(run.status.converged, abs(float(run.contact.forces[0, 1])), error, run.status.message)

    def outcome(self) -> tuple[Pressed, Pressed, float]:
        """Solution, that of the finer mesh, and the difference of their forces relative to the first one."""
        coarse, fine = self.solve(), self.solve(FINER)
        return coarse, fine, abs(fine.force / coarse.force - 1.0) if coarse.force > 0.0 else float("inf")


def is_wrong(coarse: Pressed, fine: Pressed, difference: float) -> bool:
    """Whether a converged force differs by more than both errors from the one of a finer mesh, which converged."""
    allowed = coarse.error + fine.error + TOLERANCE
    return coarse.converged and fine.converged and not difference <= allowed


def measurements(count: int = 300) -> Iterator[Measurement]:
    """Number of wrong forces among random contacts; more: refused ones."""
    outcomes = [NarrowContact.random(number).outcome() for number in range(count)]
    wrong = sum(is_wrong(*outcome) for outcome in outcomes)
    refused = sum(not coarse.converged for coarse, _, _ in outcomes)
    yield Measurement(
        f"{count} random narrow contacts",
        NO_PEER,
        0.0,
        None,
        float(wrong),
        None,
        "wrong forces",
        more={"refused": refused},
    )


def main(arguments: list[str]) -> int:
    """Print cases by their numbers; 1 if one is wrong."""
    first, count = map(int, arguments)
    any_wrong = False
    for number in range(first, first + count):
        case = NarrowContact.random(number)
        coarse, fine, difference = case.outcome()
        wrong = is_wrong(coarse, fine, difference)
        any_wrong |= wrong
        contact, body = case.values["contacts"][0], case.values["bodies"][0]
        what = (case.values["hypothesis"], body["method"], body["order"], contact["pairing"], contact["enforcement"])
        depth = -case.values["motions"][0]["shift_mm"][1] / case.size
        state = "WRONG" if wrong else "right" if coarse.converged else "refused"
        print(
            f"{number} {state} {depth:.3f} edges: {coarse.force:.5g} {fine.force:.5g}, difference {difference:.3f}, "
            f"stated {coarse.error:.3f} {fine.error:.3f} {fine.converged} {what} {contact['curved']} "
            f"{contact['secondary']} {'' if coarse.converged else coarse.message[:150]}",
            flush=True,
        )
    return int(any_wrong)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
