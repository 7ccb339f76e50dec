"""Makes of the site what Markdown cannot: formulas as MathML, which browsers show without a script."""

import html
import os
import re
from typing import Any

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.pages import Page

FORMULA = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Show a menu of versions where mike publishes this one beside others."""
    if "MIKE_DOCS_VERSION" in os.environ:
        config.extra["version"] = {"provider": "mike"}
    return config


def on_page_content(content: str, page: Page, **_: Any) -> str:
    """Replace the formulas of a page, which pymdownx.arithmatex has marked; search lists the reference last."""
    if page.file.src_uri.startswith("reference/"):
        page.meta.setdefault("search", {"boost": 0.2})
    return FORMULA.sub(_mathematics, content)


def _mathematics(found: re.Match[str]) -> str:
    kind, formula = found[1], html.unescape(found[2]).strip()
    fenced = formula.replace("\\lvert", "\\left|").replace("\\rvert", "\\right|")  # else spaced as operators
    made = convert(fenced, display="block" if kind == "div" else "inline")
    if "\\" in re.sub(r"<[^>]*>", "", html.unescape(made)):
        raise ValueError(f"a formula with an unknown command: {formula}")
    return f'<{kind} class="formula">{made}</{kind}>'
