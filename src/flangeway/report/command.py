"""The command that runs a case again."""

import shlex

from flangeway.study import WheelsetCase

OPTIONS = {
    "method": "--method",
    "order": "--order",
    "size_scale": "--size-scale",
    "primary": "--primary",
    "crown_radius_in": "--crown-radius",
}
"""Inputs with an option of their own; all others go through ``--set``."""


def command_line(case: WheelsetCase) -> str:
    """Return the command that runs a case, with what differs from the defaults."""
    words = ["flangeway", "run", case.name]
    for key, field in type(case).model_fields.items():
        value = getattr(case, key)
        if value == field.default:
            continue
        # repr keeps every digit of a number
        text = value if isinstance(value, str) else repr(value)
        words += [OPTIONS[key], text] if key in OPTIONS else ["--set", f"{key}={text}"]
    return shlex.join(words)
