"""Advice that could not be followed."""

import pytest

TRIANGLE = "x,y\n0,0\n10,0\n0,10\n"
CASES = {
    "bodies": 'case = "two-bodies"\n[[bodies]]\nname = "a"\nfile = "a.csv"\n{unit}',
    "torsion": 'case = "torsion"\nsection = "a.csv"\n{unit}',
}


@pytest.mark.parametrize("text", CASES.values(), ids=CASES)
def test_an_outline_without_a_unit_is_told_what_works(text, call, tmp_path):
    """The key that the message names is one of the case, and with it the case is right."""
    (tmp_path / "a.csv").write_text(TRIANGLE, encoding="utf-8")
    (tmp_path / "case.toml").write_text(text.format(unit=""), encoding="utf-8")
    status, _, err = call("check", "case.toml")
    assert status == 2
    assert 'give unit = "mm" in the case, --unit mm to `flangeway section`' in err
    (tmp_path / "case.toml").write_text(text.format(unit='unit = "mm"\n'), encoding="utf-8")
    assert call("check", "case.toml")[0] == 0
    status, _, err = call("section", "a.csv")
    assert status == 2
    assert call("section", "a.csv", "--unit", "mm", "--size", "3", "--no-pictures")[0] == 0
