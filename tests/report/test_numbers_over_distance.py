"""Numbers of worn profiles over the distance."""

import json

from flangeway.report.damage.damage_record import row_quantities


def test_a_conicity_that_does_not_exist_is_no_number() -> None:
    """A worn wheel may touch at places from which no conicity follows: the summary has null, and is written."""
    row = {"position": 17000.0, "conicity": float("nan")}
    values = {each.key: each.value(row) for each in row_quantities(["position", "conicity", "t_gamma_N"], "km")}
    assert json.loads(json.dumps(values, allow_nan=False)) == {"position": 17000.0, "conicity": None, "t_gamma_N": None}
