"""Outlines made of straight lines and circular arcs, and the regions and sections inside them."""

from flangeway.geometry.arrays import FloatArray, IntArray, Point, as_point, as_points, cross_product
from flangeway.geometry.outline import Contour, Outline
from flangeway.geometry.placement import Placement
from flangeway.geometry.region import Region, Section, nested_regions
from flangeway.geometry.segments import Arc, Line, Segment, Spline, crossing_shares
from flangeway.geometry.shapes import (
    angle_section,
    box_section,
    channel_section,
    circle,
    half_disc,
    i_section,
    pipe_section,
    polygon,
    rectangle,
    rounded_polygon,
    square,
    tee_section,
)

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
    "angle_section",
    "as_point",
    "as_points",
    "box_section",
    "channel_section",
    "circle",
    "cross_product",
    "crossing_shares",
    "half_disc",
    "i_section",
    "nested_regions",
    "pipe_section",
    "polygon",
    "rectangle",
    "rounded_polygon",
    "square",
    "tee_section",
]
