"""Writes docs/reference/summary.md, the keys of `summary.json`, from the quantities: ``python .ci/summary_page.py``."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flangeway.cases import rigid_run, rolling_patch_case, spatial_case
from flangeway.cases.bodies import bodies_run, presets
from flangeway.cases.patch_quantities import BY_THEORY
from flangeway.cases.profile_run import FOLDER_QUANTITIES
from flangeway.cases.profile_run import QUANTITIES as PROFILE
from flangeway.cases.wheelset import wheelset_quantities as wheelset
from flangeway.quantities import Quantity, reference

PAGE = Path(__file__).parents[1] / "docs" / "reference" / "summary.md"
HEAD = """# Keys of summary.json

*Written by `python .ci/summary_page.py` from the quantities that the program reports.*

`flangeway run CASE` writes `summary.json`: how it ended (`status`), the inputs (`case`), `timings_s`, `peak_memory_MB`,
`versions`, and the numbers below. They are metric, the unit is at the end of a key; a point or a pair of numbers is a
list; `null` is what does not exist. Axes and signs are those of [conventions](../conventions.md). A row of a table of
a campaign, or of a CSV file, has the same keys, one column for each number of a list.
"""
Kinds = dict[str, tuple[str, dict[str, Sequence[Quantity[Any]]]]]
KINDS: Kinds = {
    "A wheelset": (
        "`wheelset`, `wheelset-tangent`, `wheelset-curve`; in a plane model the keys of a plane contact",
        {
            "position": wheelset.POSITION,
            "track": wheelset.TRACK,
            "load": wheelset.LOAD,
            "residual": wheelset.RESIDUAL,
            "sides, one for each wheel": (*wheelset.WHEEL, *wheelset.HEAD, *wheelset.NADAL),
            "patches, in three dimensions": wheelset.PATCH,
            "patches, in the plane": wheelset.PLANE_PATCH,
            "rolling, with friction": wheelset.ROLLING,
            "bodies, in the plane": wheelset.MESH,
        },
    ),
    "Bodies in the plane": (
        "`hertz`, `two-bodies` and the bundled files of it; `results` depends on the case, here Hertz's with "
        "`indentation_mm`",
        {
            "results": presets.HERTZ,
            "contacts": bodies_run.PAIR,
            "patches of a contact": bodies_run.PATCH,
            "friction": bodies_run.FRICTION,
            "forces": bodies_run.FORCES,
            "bodies": bodies_run.BODY,
            "supports": bodies_run.REACTION,
        },
    ),
    "Two bodies in three dimensions": (
        "`spatial`, `crane-wheel`, `roller`, `crossed-cylinders`",
        {
            "at the top": spatial_case.CONTACT,
            "patches": spatial_case.PATCH,
            "bodies": spatial_case.BODY,
        },
    ),
    "A patch that rolls": (
        "`rolling-patch`; `residuals` has how far the law of friction is violated: `cone`, `complementarity`, "
        "`opposition`",
        {
            "at the top": (*rolling_patch_case.PATCH, *rolling_patch_case.STATE, rolling_patch_case.ENERGY_ERROR),
            "theories, and curve": BY_THEORY,
        },
    ),
    "Contact geometry": (
        "`geometry.json` of `flangeway geometry`",
        {
            "track": wheelset.TRACK,
            "equilibrium": rigid_run.POSITION_QUANTITIES,
            "contacts": rigid_run.CONTACT_QUANTITIES,
        },
    ),
    "Profiles": (
        "`profile.json` and `profiles.json` of `flangeway profile` and `flangeway profiles`",
        {"a profile": PROFILE, "a profile of a folder": FOLDER_QUANTITIES},
    ),
}
"""Kinds of results: which cases, and the quantities of each table."""


def page() -> str:
    """Return the page."""
    lines = [HEAD]
    for kind, (cases, tables) in KINDS.items():
        lines += [f"## {kind}\n", f"{cases[0].upper() if cases[0] != '`' else '`'}{cases[1:]}.\n"]
        for name, quantities in tables.items():
            lines += [f"### {kind}: {name}\n", "| key | unit | meaning |", "|---|---|---|"]
            lines += [f"| `{key}` | {unit} | {meaning} |" for key, unit, meaning in reference(quantities)]
            lines.append("")
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
