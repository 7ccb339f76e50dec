"""The pages on three dimensions: their scripts print what they show."""

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


def test_positions_of_a_wheelset_share_their_surfaces(follow):
    """The script of the page on the wheelset runs as it stands, and prints the page's numbers, to 1 %."""
    assert follow("theory/spatial-wheelset.md", tolerance=0.01) == {"python": 1, "text": 1}


def test_the_page_on_rolling_prints_what_it_shows(follow):
    """One patch by the exact theory and by fast ones, as it stands on the page, to 1 %."""
    assert follow("theory/rolling.md", tolerance=0.01) == {"python": 1, "text": 1}
