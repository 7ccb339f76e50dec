"""``flangeway section``."""

from pathlib import Path
from typing import Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import Out, Unit, errors_as_exit_status, progress_shown, stdout

SectionName = Annotated[
    str,
    typer.Argument(
        metavar="NAME_OR_FILE", help="136RE, 136RE-8, 136RE-14, 60E1, or an outline in a .toml, .csv or .dxf file."
    ),
]
SectionSize = Annotated[
    float | None,
    typer.Option("--size", metavar="LENGTH", help="Element size in the outline's unit.", show_default=False),
]
SectionOrder = Annotated[int, typer.Option("--order", metavar="K", help="Order of the elements.")]
SectionMethod = Annotated[str, typer.Option("--method", metavar="[fem|vem]", help="Triangles, or virtual polygons.")]
SectionPoisson = Annotated[
    float | None,
    typer.Option(
        "--poisson", metavar="NU", help="Poisson's ratio for the shear centre; 0 if left out.", show_default=False
    ),
]
SectionMirror = Annotated[bool, typer.Option("--mirror", help="The CSV file contains one half, up to x = 0.")]


@app.command()
def section(
    name_or_file: SectionName,
    size: SectionSize = None,
    order: SectionOrder = 2,
    method: SectionMethod = "fem",
    poisson: SectionPoisson = None,
    unit: Unit = None,
    mirror: SectionMirror = False,
    out: Out = None,
) -> None:
    """Compute the constants of a cross-section; report, JSON, pictures and VTU in a folder (out/section-NAME)."""
    with errors_as_exit_status():
        from flangeway.cases.section.section_run import SectionOptions, find_section, run_section  # noqa: PLC0415
        from flangeway.cases.section.torsion_case import TorsionCase  # noqa: PLC0415
        from flangeway.report.section.section_outputs import NAMES, print_section, write_section  # noqa: PLC0415
        from flangeway.system.output_folder import refuse_unwritable  # noqa: PLC0415

        drawn = find_section(name_or_file, unit=unit, mirrored=mirror)
        options = SectionOptions(size, order, method, poisson)
        inputs = {"section": name_or_file, "unit": unit, "half": mirror, "method": method, "order": order}
        case = TorsionCase.from_values({**inputs, "size": size, "poisson": poisson})
        folder = out or Path("out", f"section-{Path(name_or_file).stem}")
        refuse_unwritable(folder, NAMES)
        with progress_shown() as progress:
            done = run_section(drawn, options, progress)
            files = write_section(done, case, folder, progress)
        print_section(stdout(), done.summary, files)
