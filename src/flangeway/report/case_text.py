"""The inputs of a case as the text of a case file."""

from flangeway.study import WheelsetCase
from flangeway.study.case_file import FORMAT
from flangeway.study.case_template import toml_value


def case_text(case: WheelsetCase) -> str:
    """Return a case file that computes a case again: every input that is set, with all digits, defaults too.

    Names of files stand as they were given; in a case file they are read from its own folder.
    """
    lines = [f"flangeway = {FORMAT}", f"case = {toml_value(case.name)}"]
    for key in type(case).model_fields:
        value = getattr(case, key)
        if value is not None:
            lines.append(f"{key} = {toml_value(value)}")
    return "\n".join(lines) + "\n"
