"""Makes anew the pictures of docs/images/ that one command of flangeway writes: ``python .ci/pictures.py``.

The other pictures there are written by the code of the page that shows them.
"""

import io
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
PICTURES = {
    "run wheelset": {"wheelset.png": ("wheelset", 1400)},
    "run wheelset --set curve_radius_m=300 --set speed_km_h=80 --set superelevation_mm=100": {
        "wheelset.png": ("gallery-wheelset", 1100),
        "patches.png": ("gallery-patches", 900),
        "rails.png": ("gallery-rails", 900),
    },
    "run wheelset-curve --size-scale 3": {
        "wheelset.png": ("gallery-curve", 900),
        "stresses-right.png": ("gallery-contact-stresses", 760),
        "bending.png": ("gallery-bending", 900),
    },
    "geometry s1002-60e1": {"contact_locus.png": ("gallery-contact-locus", 800)},
    "run hertz --method vem --order 2": {"stresses.png": ("gallery-hertz", 900)},
    "section 136RE": {"prandtl.png": ("gallery-prandtl", 700)},
    "reproduce elasticity --quick": {"elasticity/nearly_incompressible.png": ("elasticity-nearly-incompressible", 900)},
}
"""Files of each command: the name that they get here, and their width."""


def small(picture: Path, width: int) -> bytes:
    """Return a picture of a width in 96 colours, as PNG."""
    with Image.open(picture) as full:
        size = (width, round(full.height * width / full.width))
        scaled = full.convert("RGB").resize(size, Image.Resampling.LANCZOS)
    packed = io.BytesIO()
    scaled.quantize(96, dither=Image.Dither.NONE).save(packed, "PNG", optimize=True)
    return packed.getvalue()


def main() -> None:
    """Run the commands and write the pictures."""
    with TemporaryDirectory() as folder:
        for number, (line, pictures) in enumerate(PICTURES.items()):
            out = Path(folder) / str(number)
            subprocess.run([sys.executable, "-m", "flangeway", *line.split(), "--out", str(out)], check=True)
            for file, (name, width) in pictures.items():
                (IMAGES / f"{name}.png").write_bytes(small(out / file, width))


if __name__ == "__main__":
    main()
