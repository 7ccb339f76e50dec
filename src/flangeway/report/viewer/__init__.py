"""Fields of parts to look at in a browser: choose, zoom, read values under the pointer; no network."""

from flangeway.report.viewer.fragment import field_viewer
from flangeway.report.viewer.packing import packed_parts
from flangeway.report.viewer.scene_model import Scene, ShownField, ShownPart, View

__all__ = [
    "Scene",
    "ShownField",
    "ShownPart",
    "View",
    "field_viewer",
    "packed_parts",
]
