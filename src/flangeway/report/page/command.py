"""The command that runs a case again."""

import shlex
from collections.abc import Mapping

from flangeway.cases import RunnableCase
from flangeway.cases.case_template import toml_value
from flangeway.cases.section.torsion_case import TorsionCase

OPTIONS = {
    "method": "--method",
    "order": "--order",
    "size_scale": "--size-scale",
    "primary": "--primary",
    "crown_radius_in": "--crown-radius",
}
"""Inputs of a case with an option of their own; all others go through ``--set``."""
SECTION_OPTIONS = {
    "size": "--size",
    "order": "--order",
    "method": "--method",
    "poisson": "--poisson",
    "unit": "--unit",
    "half": "--mirror",
}
"""Options of ``flangeway section`` by the inputs of a case of torsion."""


def command_line(case: RunnableCase) -> str:
    """Return the command that runs a case, with what differs from the defaults; cases with tables have none."""
    words = ["flangeway", "run", case.name]
    for key, text in _changed(case).items():
        words += [OPTIONS[key], text] if key in OPTIONS else ["--set", f"{key}={text}"]
    return shlex.join(words)


def section_command(case: TorsionCase) -> str:
    """Return the command that computes the same section with ``flangeway section``."""
    words = ["flangeway", "section", case.section]
    for key, text in _changed(case).items():
        if key == "half":
            words.append(SECTION_OPTIONS[key])
        elif key != "section":
            words += [SECTION_OPTIONS[key], text]
    return shlex.join(words)


def _changed(case: RunnableCase) -> Mapping[str, str]:
    """Values that are not the defaults, as text with all digits."""
    found = {}
    for key, field in type(case).model_fields.items():
        value = getattr(case, key)
        if value != field.default:
            found[key] = value if isinstance(value, str) else toml_value(value)
    return found
