"""The page on three dimensions: its script prints what it shows."""

import re
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "theory" / "three-dimensions.md"


def test_the_script_prints_what_the_page_shows(capsys):
    """The bar under a cosine pressure runs as it stands on the page, and prints the page's numbers."""
    ((code, shown),) = re.findall(
        r"```python\n(.*?)```\n\n```text\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL
    )
    exec(code, {})
    assert capsys.readouterr().out == shown
