"""The page inside a notebook: what the how-to says."""

import re
import urllib.request

from tests.docs.conftest import blocks_of


def test_the_cell_of_the_how_to_shows_the_page(profiles, monkeypatch):
    """The code of `how-to/live-page.md` gives a value whose HTML is a frame with the page, which knows both files."""
    code = next(block.text for block in blocks_of("how-to/live-page.md") if block.kind == "python")
    imported, call = code.strip().split("\n\n")
    monkeypatch.chdir(profiles)
    names = {}
    exec(imported, names)
    widget = eval(call, names)
    try:
        address = re.search(r'src="([^"]+)"', widget._repr_html_())[1]
        while not widget.server.server.started:
            pass
        with urllib.request.urlopen(address, timeout=60) as page:
            assert "<title>flangeway live</title>" in page.read().decode()
        assert widget.server.engine.form()["files"] == ["my-wheel.whl", "my-rail.ban"]
    finally:
        widget.close()
