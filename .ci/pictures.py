"""Makes anew the pictures of docs/images/ that one command of flangeway writes: ``python .ci/pictures.py``.

It draws the axes and signs of rolling, too, and the thumbnails of ``examples/gallery`` with their table on the page
Gallery. The other pictures there are written by the code of the page that shows
them. With words, only pictures whose command or name has one of them are made.
"""

import ast
import importlib
import io
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse
from PIL import Image

from flangeway.report.figures.drawing import GREY, INK, new_figure, png

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
PICTURES = {
    "run wheelset": {"wheelset.png": ("wheelset", 1400)},
    "run wheelset --set curve.radius_m=300 --set curve.speed_km_h=80 --set curve.superelevation_mm=100": {
        "wheelset.png": ("gallery-wheelset", 1100),
        "patches.png": ("gallery-patches", 900),
        "rails.png": ("gallery-rails", 900),
    },
    "run wheelset-curve --size-scale 3": {
        "wheelset.png": ("gallery-curve", 900),
        "stresses.png": ("gallery-contact-stresses", 900),
    },
    "geometry s1002-60e1": {"contact_locus.png": ("gallery-contact-locus", 800)},
    "run hertz --method vem --order 2": {"stresses.png": ("gallery-hertz", 900)},
    "section 136RE": {"prandtl.png": ("gallery-prandtl", 700)},
    "reproduce elasticity": {"elasticity/cook.png": ("elasticity-nearly-incompressible", 900)},
}
"""Files of each command: the name that they get here, and their width."""


def small(picture: Path | io.BytesIO, width: int) -> bytes:
    """Return a picture of a width in 96 colours, as PNG."""
    with Image.open(picture) as full:
        size = (width, round(full.height * width / full.width))
        scaled = full.convert("RGB").resize(size, Image.Resampling.LANCZOS)
    packed = io.BytesIO()
    scaled.quantize(96, dither=Image.Dither.NONE).save(packed, "PNG", optimize=True)
    return packed.getvalue()


def rolling_axes() -> Figure:
    """Draw a patch from above with the axes, creepages and moments of this program, of CONTACT, and of FASTSIM."""
    figure = new_figure(11.0, 4.0)
    here, contact, fastsim = figure.subplots(1, 3)
    _draw_axes(here, ("t", "z", "n"), up=True, names=("across", "along", "spin, moment"))
    here.set_title("flangeway: n out of the rail", fontsize=11)
    _draw_axes(contact, ("y", "x", "z"), up=False, names=("η, F_y", "ξ, F_x", "φ, M_z"))
    contact.set_title("CONTACT, Kalker: z into the rail", fontsize=11)
    x = [1.0 - 2.0 * step / 200.0 for step in range(201)]
    bound = [1.0 - each**2 for each in x]
    traction, slips = [0.0], False
    for here_x, limit in zip(x[1:], bound[1:], strict=True):
        wanted = 0.55 * (1.0 - here_x)
        slips = slips or wanted > limit
        traction.append(limit if slips else wanted)
    fastsim.plot(bound, x, color=GREY, ls="--", lw=1.4, label="limit: a parabola")
    fastsim.plot(traction, x, color=INK, lw=1.8, label="traction in one strip")
    fastsim.annotate("leading edge", (0.02, 1.0), (0.28, 1.12), fontsize=9.5, va="center", arrowprops=_ARROW)
    fastsim.text(0.04, -0.3, "sticks: grows with\nthe rigid slip over L", fontsize=9.5)
    fastsim.text(0.2, -0.72, "slips", fontsize=9.5)
    fastsim.set(
        xlim=(-0.04, 1.25), ylim=(-1.1, 1.25), xlabel="traction over its maximum limit", ylabel="x over half the strip"
    )
    fastsim.set_title("FASTSIM: CONTACT's axes, strip by strip", fontsize=11)
    fastsim.legend(loc="lower right", fontsize=9, frameon=False)
    return figure


_ARROW = {"arrowstyle": "-|>", "color": INK, "lw": 1.6, "shrinkA": 0.0, "shrinkB": 0.0}


def _draw_axes(axes: Axes, labels: tuple[str, str, str], *, up: bool, names: tuple[str, str, str]) -> None:
    """Draw a rail from above with a patch, two axes in its plane, the third towards the reader or away, and turns."""
    axes.axvspan(-1.6, 1.6, color="#e8e8e8", lw=0.0)
    axes.add_patch(Ellipse((0.0, 0.0), 2.0, 3.2, fc="#d3e3f3", ec=INK, lw=1.0))
    for (x, z), label, name, shift in (
        ((2.3, 0.0), labels[0], names[0], (-0.25, -0.42)),
        ((0.0, 2.5), labels[1], names[1], (0.16, 0.1)),
    ):
        axes.annotate("", (x, z), (0.0, 0.0), arrowprops=_ARROW)
        axes.text(x + shift[0], z + shift[1], f"{label}: {name}", fontsize=11, ha="left" if shift[0] > 0 else "center")
    axes.plot(0.0, 0.0, "o", ms=13.0, mfc="white", mec=INK, mew=1.4)
    axes.plot(0.0, 0.0, "o" if up else "x", ms=4.0 if up else 8.0, color=INK, mew=1.6)
    axes.text(0.0, -2.15, f"{labels[2]} {'towards you' if up else 'away from you'}", fontsize=10, ha="center")
    style = {**_ARROW, "color": "#8b1a8b", "connectionstyle": f"arc3,rad={0.45 if up else -0.45}"}
    ends = ((0.75, -0.9), (0.75, 0.9)) if up else ((-0.75, -0.9), (-0.75, 0.9))
    axes.annotate("", ends[1], ends[0], arrowprops=style)
    axes.text(1.35 if up else -1.35, 1.05, names[2], fontsize=10.5, color="#8b1a8b", ha="left" if up else "right")
    axes.annotate("", (-2.4, 2.6), (-2.4, 0.9), arrowprops={**_ARROW, "color": GREY, "lw": 2.4})
    axes.text(-2.55, 1.7, "rolls", rotation=90.0, fontsize=10.5, color=GREY, ha="right", va="center")
    axes.text(1.5, -2.65, "rail", fontsize=10, color=GREY, ha="right")
    axes.set(xlim=(-3.0, 3.4), ylim=(-2.8, 3.0), aspect="equal")
    axes.set_axis_off()


EXAMPLES = ROOT / "examples" / "gallery"
THUMBNAIL, COLUMNS = 220, 5  # width in pixels; pictures beside each other
BEGIN, END = "<!-- examples: written by .ci/pictures.py -->\n", "<!-- end of examples -->\n"


def examples(words: list[str]) -> None:
    """Run the examples, or those of some names; write their thumbnails, and the table of all on the page."""
    sys.path.insert(0, str(EXAMPLES))
    cells = []
    for path in sorted(EXAMPLES.glob("*.py")):
        name = path.stem
        if name == "gallery_drawing":
            continue
        title = (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").splitlines()[0].rstrip(".")
        if not words or name in words:
            (IMAGES / "examples").mkdir(exist_ok=True)
            full = io.BytesIO(png(importlib.import_module(name).main()))
            (IMAGES / "examples" / f"{name}.png").write_bytes(small(full, THUMBNAIL))
        cells.append(f"![{title}](images/examples/{name}.png)<br>{title}: [`{name}`](examples/{name}.ipynb)")
    cells += [""] * (-len(cells) % COLUMNS)
    rows = [cells[i : i + COLUMNS] for i in range(0, len(cells), COLUMNS)]
    table = [
        " | ".join([""] * (COLUMNS + 2)).strip(),
        "| --- " * COLUMNS + "|",
        *(f"| {' | '.join(row)} |" for row in rows),
    ]
    page = ROOT / "docs" / "gallery.md"
    before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    page.write_text(before + BEGIN + "\n" + "\n".join(table) + "\n\n" + END + rest.partition(END)[2], encoding="utf-8")


DRAWN = {"rolling-axes": (rolling_axes, 1000)}
"""What draws a picture, and its width."""


def main(words: list[str]) -> None:
    """Run the commands, draw, and write the pictures."""

    def wanted(name: str) -> bool:
        return not words or any(word in name for word in words)

    if not words or "examples" in words:
        examples(words[1:])
    with TemporaryDirectory() as folder:
        for name, (draw, width) in DRAWN.items():
            if wanted(name):
                full = Path(folder) / "drawn.png"
                full.write_bytes(png(draw()))
                (IMAGES / f"{name}.png").write_bytes(small(full, width))
        for number, (line, pictures) in enumerate(PICTURES.items()):
            if not wanted(line):
                continue
            out = Path(folder) / str(number)
            subprocess.run([sys.executable, "-m", "flangeway", *line.split(), "--out", str(out)], check=True)
            for file, (name, width) in pictures.items():
                (IMAGES / f"{name}.png").write_bytes(small(out / file, width))


if __name__ == "__main__":
    main(sys.argv[1:])
