"""Pictures for the report, a third as large as the files."""

import io

from PIL import Image

N_COLOURS = 256


def compact_png(png: bytes) -> bytes:
    """Return a PNG with at most 256 colours of its own, on white: figures have few, and shades hardly change."""
    with Image.open(io.BytesIO(png)) as picture:
        page = Image.new("RGBA", picture.size, "white")
        page.alpha_composite(picture.convert("RGBA"))
    few = page.convert("RGB").quantize(N_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    few.save(buffer, "PNG")
    return buffer.getvalue()
