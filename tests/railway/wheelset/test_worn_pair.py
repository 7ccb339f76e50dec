"""A worn, conforming pair costs no second model: its wide contact is foreseen from the rigid wheelset."""

from benchmarks.worn import worn_pair
from flangeway.cases import WheelsetTangentCase
from flangeway.cases.rigid.rigid_case import find_geometry_case
from flangeway.cases.rigid.rigid_run import run_geometry
from flangeway.railway.rigid.rigid_side import RigidSide


def test_worn_pair(tmp_path):
    """A worn, conforming pair is solved with one model of at most 2.4 times the bundled pair's surface nodes."""
    unknowns, said = [], []
    for values in ({}, worn_pair(tmp_path)):
        run = WheelsetTangentCase.from_values({**values, "size_scale": 3.0}).run(said.append)
        assert run.result.status.converged
        unknowns.append(sum(len(nodes.points) for nodes in run.result.model.system.surface_nodes))
    assert not any(sentence.startswith("once more") for sentence in said)
    assert unknowns[1] < 2.4 * unknowns[0]


def test_rigid_geometry_is_computed_once(tmp_path, monkeypatch):
    """The geometry of a worn pair looks for touches at fewer than 40,000 positions of a wheel."""
    counts = []
    touches = RigidSide.touches

    def counted(self, lateral, roll, **options):
        counts.append(len(lateral))
        return touches(self, lateral, roll, **options)

    monkeypatch.setattr(RigidSide, "touches", counted)
    run_geometry("worn", find_geometry_case("wheelset-tangent", worn_pair(tmp_path)))
    assert sum(counts) < 40_000
