"""Fields of parts to look at in a browser: choose, zoom, read values under the pointer; no network."""

from flangeway.report.viewer.fragment import View, field_viewer
from flangeway.report.viewer.packing import packed_parts

__all__ = ["View", "field_viewer", "packed_parts"]
