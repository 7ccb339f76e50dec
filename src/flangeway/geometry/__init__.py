"""Outlines made of straight lines and circular arcs, and the regions and sections inside them."""

from flangeway.geometry.arrays import FloatArray, IntArray, Point, as_point, as_points, cross_product
from flangeway.geometry.contour import Contour
from flangeway.geometry.outline import Outline
from flangeway.geometry.placement import Placement
from flangeway.geometry.region import Region, Section, nested_regions
from flangeway.geometry.segments import Arc, Line, Segment, crossing_shares
from flangeway.geometry.shapes import circle, polygon, rectangle, square
from flangeway.geometry.splines import Spline

__all__ = [
    "Arc",
    "Contour",
    "FloatArray",
    "IntArray",
    "Line",
    "Outline",
    "Placement",
    "Point",
    "Region",
    "Section",
    "Segment",
    "Spline",
    "as_point",
    "as_points",
    "circle",
    "cross_product",
    "crossing_shares",
    "nested_regions",
    "polygon",
    "rectangle",
    "square",
]
