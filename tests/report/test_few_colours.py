"""Pictures in few colours: the same to the eye, and exactly the same if they have few."""

import numpy as np
import pytest
from PIL import Image

from flangeway.report.figures.few_colours import few_colours


def with_opacity(colours):
    """Pixels (height, width, 4) of colours (height, width, 3)."""
    return np.dstack([colours, np.full(colours.shape[:2], 255)]).astype(np.uint8)


def shades():
    """A picture with flat areas, a fine line, and thousands of shades."""
    across, down = np.meshgrid(np.arange(400), np.arange(300))
    colours = np.dstack([across // 2, (across + down) // 3, 255 - down // 2]).clip(0, 255)
    colours[:, :100] = 255
    colours[:120, 200:] = (228, 231, 235)
    colours[200, :] = (26, 26, 26)
    return colours


def error(picture, colours):
    """Mean difference of a picture's colours from the given ones."""
    return np.abs(np.asarray(picture.convert("RGB"), dtype=float) - colours).mean()


@pytest.mark.parametrize("n_colours", [1, 2, 17, 256])
def test_a_picture_of_few_colours_stays_as_it_is(n_colours):
    """Up to 256 colours come back exactly, however they are scattered."""
    rng = np.random.default_rng(n_colours)
    palette = rng.choice(1 << 24, n_colours, replace=False)
    codes = palette[rng.integers(0, n_colours, (60, 70))]
    codes.ravel()[:n_colours] = palette
    colours = np.dstack([codes >> 16, codes >> 8 & 255, codes & 255])
    picture = few_colours(with_opacity(colours))
    assert picture.mode == "P"
    assert np.array_equal(np.asarray(picture.convert("RGB")), colours)


def test_shades_are_as_near_as_those_of_a_median_cut():
    """Of thousands of colours 256 are kept, and on average they are as near as those of a cut through all pixels."""
    colours = shades()
    assert len(np.unique(colours.reshape(-1, 3), axis=0)) > 5000
    picture = few_colours(with_opacity(colours))
    whole = Image.fromarray(colours.astype(np.uint8)).quantize(256, Image.Quantize.MEDIANCUT, dither=0)
    assert len(picture.getcolors()) <= 256
    assert error(picture, colours) <= 1.1 * error(whole, colours)


def test_large_flat_areas_keep_their_colours():
    """Colours of a hundredth of the picture or more hardly change beside thousands of shades."""
    colours = shades()
    found = np.asarray(few_colours(with_opacity(colours)).convert("RGB"), dtype=int)
    for row, column in ((10, 10), (60, 300)):
        assert np.abs(found[row, column] - colours[row, column]).max() <= 1
    assert np.abs(found[200] - 26).max() < 20


def test_opacity_is_left_out():
    """A picture cut out of a larger one, which is not in one piece in memory, is read as it is."""
    colours = shades()
    window = with_opacity(colours)[50:90:2, 5:60]
    picture = few_colours(window)
    assert picture.size == (55, 20)
    assert error(picture, colours[50:90:2, 5:60]) == 0.0
