"""A number is a number, not a text and not a truth value."""

import pytest

from flangeway.campaign import Campaign
from flangeway.errors import InputError


def test_settings_are_read_by_the_type_of_their_input(call):
    """``--set`` is text: numbers, truth values and lists are read where the input is one, and only there."""
    for setting in ("size_mm=true", "order=true", "order=1.5", "order='1'", 'poisson="0.3"', "n_steps=1e0"):
        status, _, err = call("check", "hertz", "--set", setting)
        assert status == 2, setting
        assert setting.partition("=")[0] in err
    for setting in ("size_mm=0.5", "order=2", "poisson=1e-1", "lower=block"):
        assert call("check", "hertz", "--set", setting)[0] == 0, setting
    assert call("check", "torsion", "--set", "half=1")[0] == 2
    assert call("check", "torsion", "--set", "half=false")[0] == 0


def test_campaigns_are_strict(tmp_path):
    """Lists under [vary] and values under [inputs] are typed; cells of a table are text, read by their input's type."""

    def campaign(text):
        (tmp_path / "c.toml").write_text('case = "cook"\n' + text, encoding="utf-8")
        return Campaign.from_file(tmp_path / "c.toml")

    for text in (
        '[vary]\nlevel = ["1", "2"]\n',
        "[vary]\npoisson = [true]\n",
        '[inputs]\npoisson = "0.3"\n[vary]\nlevel = [1]\n',
        "[inputs]\norder = true\n[vary]\nlevel = [1]\n",
        'table = "t.csv"\n[inputs]\npoisson = "0.3"\n',
    ):
        (tmp_path / "t.csv").write_text("level,method\n1,fem\n2,vem\n", encoding="utf-8")
        with pytest.raises(InputError):
            campaign(text)
    rows = campaign('table = "t.csv"\n').rows
    assert [(row.case.level, row.case.method) for row in rows] == [(1, "fem"), (2, "vem")]
    (tmp_path / "t.csv").write_text("level\ntrue\n", encoding="utf-8")
    with pytest.raises(InputError, match="level = 'true'"):
        campaign('table = "t.csv"\n')
