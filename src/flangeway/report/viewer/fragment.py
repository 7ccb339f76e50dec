"""The viewer as a piece of HTML that needs nothing else: styles, data, libraries and program inside."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files

from flangeway.errors import InputError
from flangeway.report.fields import PartFields
from flangeway.report.viewer.packing import json_in_script, packed_parts

PROGRAM = (
    "data.js",
    "fields.js",
    "mesh.js",
    "colours.js",
    "scene.js",
    "navigation.js",
    "picking.js",
    "reading.js",
    "scale.js",
    "viewer.js",
)
"""Files of the program, in the order in which the page holds them."""


@dataclass(frozen=True)
class View:
    """A place to which a button of the viewer flies.

    Parameters
    ----------
    name
        Text of the button.
    centre_mm
        Middle of the view (x, y), in the axes of the parts.
    width_mm
        Width of what is shown.

    """

    name: str
    centre_mm: tuple[float, float]
    width_mm: float


def field_viewer(parts: Sequence[PartFields], views: Sequence[View] = (), instead: str = "") -> str:
    """Return the viewer as HTML to be put into the body of a page, once.

    It shows the stresses of the cells and the displacements of the points of `parts` as the VTU files of
    `flangeway.report.paraview.write_part` hold them, in 32 bits. It takes its colours from the page's custom
    properties ``--ink``, ``--soft``, ``--page``, ``--card`` and ``--line``, and is dark where ``data-theme`` of the
    page's root element says so or, without it, where the reader's system does.

    Parameters
    ----------
    parts
        One part or more.
    views
        Places with a button each, beside the one for all parts.
    instead
        Sentence for browsers that cannot show it: where to find pictures.

    Raises
    ------
    InputError
        If there is no part.

    """
    if not parts:
        raise InputError("no parts", "one part or more", "give the parts of a solved problem")
    header, data = packed_parts(parts)
    header["views"] = [{"name": view.name, "centre": list(view.centre_mm), "width": view.width_mm} for view in views]
    program = "\n".join(_text(name) for name in PROGRAM)
    return (
        f"<style>\n{_text('viewer.css')}</style>\n"
        f"{_text('viewer.html').replace('$instead', escape(instead))}"
        f'<script type="application/json" id="viewer-header">{json_in_script(header)}</script>\n'
        f'<script type="text/plain" id="viewer-data">{data}</script>\n'
        f"<script>\n/*\n{_text('libraries/LICENCES.txt')}*/\n{_text('libraries/libraries.min.js')}</script>\n"
        f'<script>\n(() => {{\n"use strict";\n{program}\nstartViewer();\n}})();\n</script>\n'
    )


def _text(name: str) -> str:
    return (files("flangeway.report.viewer") / name).read_text(encoding="utf-8")
