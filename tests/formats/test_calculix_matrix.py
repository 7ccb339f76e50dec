"""CalculiX's files of a stiffness matrix: the sample is of CalculiX 2.x on the deck beside it."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from flangeway.elements import Lagrange
from flangeway.errors import InputError
from flangeway.formats import read_calculix_matrix, read_mesh
from flangeway.materials import Elastic
from flangeway.problems import Elasticity
from flangeway.space import Space

SAMPLE = Path(__file__).parents[1] / "independent" / "calculix"


def test_the_sample_is_the_stiffness_of_the_same_triangles() -> None:
    """Our own stiffness of the deck's mesh, without the held nodes, equals the one read."""
    written = read_calculix_matrix(SAMPLE / "block.dof")
    mesh = read_mesh(SAMPLE / "block.inp").mesh
    rows = written.rows(np.arange(mesh.n_points) + 1).ravel()
    whole = Elasticity(Space(mesh, Lagrange(1)), Elastic(210e3, 0.3)).stiffness().full().toarray()
    free = rows >= 0
    assert (mesh.points[~free.reshape(-1, 2)[:, 0], 1] == 1.0).all()
    found = written.matrix.toarray()[np.ix_(rows[free], rows[free])]
    np.testing.assert_allclose(found, whole[np.ix_(free, free)], atol=1e-12 * whole.max())
    assert (written.rows([99]) == -1).all()


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("x.sti", None, "SOLVER=MATRIXSTORAGE"),
        ("x.sti", "1 1 2.0\n1 2\n", "row, column and value"),
        ("x.sti", "1 99 2.0\n", "run CalculiX once more"),
        ("x.dof", "1.1\n1.3\n", "a plane model"),
        ("x.dof", "one.1\n", "node.direction"),
    ],
)
def test_broken_files_are_refused(tmp_path: Path, name: str, text: str | None, message: str) -> None:
    """Missing files, files of something else and models in three dimensions are refused."""
    for ending in ("sti", "dof"):
        shutil.copy(SAMPLE / f"block.{ending}", tmp_path / f"x.{ending}")
    file = tmp_path / name
    if text is None:
        file.unlink()
    else:
        file.write_text(text)
    with pytest.raises(InputError, match=message):
        read_calculix_matrix(tmp_path / "x")
