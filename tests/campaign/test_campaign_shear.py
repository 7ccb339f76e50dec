"""Campaigns that ask for the maximum shear stress below the contacts."""

from collections import OrderedDict

import numpy as np
import pytest

from flangeway.campaign import Campaign, chunk, results, run_campaign
from flangeway.campaign.chunk import Chunk, compute
from flangeway.campaign.columns import PATCH_SHEAR_COLUMNS, WHEELSET_SHEAR_COLUMNS

SWEEP = """
case = "wheelset-tangent"
[inputs]
size_scale = 8
[vary]
lateral_mm = { from = -2, to = 9, n = 24 }
[results]
subsurface_shear = true
"""


def campaign_of(folder, text):
    file = folder / "c.toml"
    file.write_text(text, encoding="utf-8")
    return Campaign.from_file(file)


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """One sweep from the tread to the flange, computed in this process as of a campaign of few rows."""
    campaign = campaign_of(tmp_path_factory.mktemp("shear"), SWEEP)
    found = [compute(Chunk(rows, first, shear=True)).results for first, rows in campaign.chunks]
    return campaign, [result for chunk in found for result in chunk]


def test_each_side_has_the_maximum_below_its_patches(sweep):
    """Values and depths of a side are those of the patch with the maximum; they are a part of that patch's pressure."""
    _, found = sweep
    n_two = 0
    for result in found:
        assert result.status == "converged"
        for side in ("left", "right"):
            patches = [patch for patch in result.patches if patch["side"] == side]
            n_two += len(patches) > 1
            for role in ("wheel", "rail"):
                value, depth = (name for name in PATCH_SHEAR_COLUMNS if name.startswith(role))
                worst = max(patches, key=lambda patch: patch[value])
                assert result.values[f"{side}_{value}"] == worst[value]
                assert result.values[f"{side}_{depth}"] == worst[depth] > 0.0
                for patch in patches:  # 0.300 below Hertz's contact of half planes, more in narrow bodies
                    assert 0.2 < patch[value] / patch["max_pressure_MPa"] < 0.6
    assert n_two > 0


def test_a_chunk_has_the_same_digits_whatever_was_computed_before(sweep, monkeypatch):
    """The second chunk after the first and the second alone, in a new worker, agree in every digit."""
    campaign, _ = sweep
    chunks = [Chunk(rows, first, shear=True) for first, rows in campaign.chunks]
    monkeypatch.setattr(chunk, "_prepared", OrderedDict())
    _, after = (compute(chunk).results for chunk in chunks)
    monkeypatch.setattr(chunk, "_prepared", OrderedDict())
    alone = compute(chunks[1]).results
    for one, other in zip(after, alone, strict=True):
        assert one.values == other.values
        assert one.patches == other.patches


def test_a_row_alone_is_near(sweep):
    """A row computed alone, by the full search on its own coarse mesh, has nearly the same stresses."""
    campaign, found = sweep
    row = campaign.rows[4]
    (alone,) = compute(Chunk((row,), shear=True)).results
    for name in (name for name in WHEELSET_SHEAR_COLUMNS if name.endswith("MPa")):
        assert found[4].values[name] == pytest.approx(alone.values[name], rel=0.1), name


def test_the_tables_have_the_columns_if_they_are_asked_for(tmp_path):
    """With the key both tables have them, and they can be chosen; without it neither; the results do not mix."""
    text = 'case = "wheelset-tangent"\n[inputs]\nsize_scale = 8\n[vary]\nrail_inclination = [0.025]\n'
    chosen = "[results]\nsubsurface_shear = true\ncolumns = ['left_rail_max_in_plane_shear_MPa']\n"
    asked, plain = campaign_of(tmp_path, text + chosen), campaign_of(tmp_path, text)
    assert asked.identity != plain.identity
    run_campaign(asked, tmp_path / "asked.sqlite", workers=1)
    found = results(tmp_path / "asked.sqlite")
    assert list(found.rows) == [
        "row",
        "status",
        "rail_inclination",
        "left_rail_max_in_plane_shear_MPa",
        "message",
        "warnings",
    ]
    assert list(found.patches)[-4:] == list(PATCH_SHEAR_COLUMNS)
    assert np.isfinite(found.numbers("left_rail_max_in_plane_shear_MPa")).all()
    with pytest.raises(Exception, match="with other results"):
        run_campaign(plain, tmp_path / "asked.sqlite", workers=1)
    run_campaign(plain, tmp_path / "plain.sqlite", workers=1)
    found = results(tmp_path / "plain.sqlite")
    assert not {*WHEELSET_SHEAR_COLUMNS, *PATCH_SHEAR_COLUMNS} & {*found.rows, *found.patches}
