"""Pictures as files."""

from collections.abc import Mapping

from matplotlib.figure import Figure

from flangeway.report.figures.drawing import png
from flangeway.system.output_folder import Writer, bytes_writer


def picture_writers(figures: Mapping[str, Figure]) -> dict[str, Writer]:
    """Draw figures now, and return functions that write them as PNG files, by the files' names."""
    return {name: bytes_writer(png(figure)) for name, figure in figures.items()}
