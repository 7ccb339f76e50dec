"""The viewer as a piece of HTML that needs nothing else: styles, data, libraries and program inside."""

from dataclasses import asdict
from html import escape
from importlib.resources import files

from flangeway.errors import InputError
from flangeway.report.viewer.packing import json_in_script, packed_parts
from flangeway.report.viewer.scene_model import Scene

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
    "steps.js",
    "viewer.js",
)
"""Files of the program, in the order in which the page holds them."""


def field_viewer(scene: Scene, instead: str = "") -> str:
    """Return the viewer as HTML to be put into the body of a page, once.

    It holds the arrays of the parts in 32 bits. It takes its colours from the page's custom properties ``--ink``,
    ``--soft``, ``--page``, ``--card`` and ``--line``, and is dark where ``data-theme`` of the page's root element says
    so or, without it, where the reader's system does.

    Parameters
    ----------
    scene
        What is shown.
    instead
        Sentence for browsers that cannot show it: where to find pictures.

    Raises
    ------
    InputError
        If there is no part.

    """
    if not scene.parts:
        raise InputError("no parts", "one part or more", "give the parts of a solved problem")
    headers, data = packed_parts(scene.parts)
    header = {
        "parts": headers,
        "fields": [asdict(field) for field in scene.fields],
        "views": [asdict(view) for view in scene.views],
        "unit": scene.unit,
        "axes": list(scene.axes),
        "steps": list(scene.steps),
    }
    program = "\n".join(_text(name) for name in PROGRAM)
    body = _text("viewer.html").replace("$instead", escape(instead)).replace("$notes", escape(" ".join(scene.notes)))
    body = body.replace("$steps", escape(scene.steps_note))
    return (
        f"<style>\n{_text('viewer.css')}</style>\n"
        f"{body}"
        f'<script type="application/json" id="viewer-header">{json_in_script(header)}</script>\n'
        f'<script type="text/plain" id="viewer-data">{data}</script>\n'
        f"<script>\n/*\n{_text('libraries/LICENCES.txt')}*/\n{_text('libraries/libraries.min.js')}</script>\n"
        f'<script>\n(() => {{\n"use strict";\n{program}\nstartWhenShown();\n}})();\n</script>\n'
    )


def _text(name: str) -> str:
    return (files("flangeway.report.viewer") / name).read_text(encoding="utf-8")
