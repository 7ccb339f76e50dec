"""Places and pieces of an outline by the length along it."""

import numpy as np

from flangeway.geometry import FloatArray, Outline, Point, Segment, as_point

_SAME = 1e-6


def lengths_along(outline: Outline) -> FloatArray:
    """Return the lengths (n_segments + 1,) along an outline at the ends of its segments, from 0."""
    return np.concatenate([[0.0], np.cumsum([segment.length for segment in outline.segments])])


def point_at(outline: Outline, lengths: FloatArray, place: float) -> Point:
    """Return the point at a length along an outline."""
    i = min(int(np.searchsorted(lengths, place, side="right")) - 1, outline.n_segments - 1)
    return as_point(outline.segments[i].point((place - lengths[i]) / outline.segments[i].length)[0])


def pieces_between(outline: Outline, lengths: FloatArray, first: float, last: float) -> list[tuple[str, Segment]]:
    """Return the named pieces of an outline from one length along it forwards to another."""
    total = float(lengths[-1])
    last = last if last > first else last + total
    pieces: list[tuple[str, Segment]] = []
    for lap in (0.0, total):
        for i, segment in enumerate(outline.segments):
            low, high = lengths[i] + lap, lengths[i + 1] + lap
            start, end = max(first, low), min(last, high)
            if end - start <= _SAME:
                continue
            cuts = [(at - low) / segment.length for at in (start, end) if low + _SAME < at < high - _SAME]
            parts = segment.split(cuts) if cuts else (segment,)
            inside = 1 if start > low + _SAME else 0
            pieces.append((outline.names[i], parts[inside]))
    return pieces
