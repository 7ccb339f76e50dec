"""What all commands that leave files share: pictures as files, and the list of files on the terminal."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure
from rich.console import Console

from flangeway.report.drawing import png


def picture_writers(figures: Mapping[str, Figure]) -> dict[str, Callable[[Path], None]]:
    """Draw figures now, and return functions that write them as PNG files, by the files' names."""
    return {name: bytes_writer(png(figure)) for name, figure in figures.items()}


def bytes_writer(data: bytes) -> Callable[[Path], None]:
    """Return a function that writes bytes to a file."""

    def write(path: Path) -> None:
        path.write_bytes(data)

    return write


def text_writer(text: str) -> Callable[[Path], None]:
    """Return a function that writes text to a file, in UTF-8."""
    return bytes_writer(text.encode("utf-8"))


def print_files(console: Console, files: Sequence[Path], seconds: float | None = None) -> None:
    """Print the time, if it is given, and the files."""
    console.print("Files:" if seconds is None else f"Computed in {seconds:.1f} s. Files:", markup=False)
    for file in files:
        console.print(f"  {file}", markup=False, soft_wrap=True)
