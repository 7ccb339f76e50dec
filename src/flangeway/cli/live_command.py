"""``flangeway live``."""

import webbrowser
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from flangeway.cli.app import app
from flangeway.cli.common import Units, completion, errors_as_exit_status, stdout, units_given
from flangeway.cli.shape_commands import PROFILE_FILES
from flangeway.errors import InputError


@app.command()
@errors_as_exit_status()
def live(
    profiles: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[WHEEL] [RAIL]",
            help="Files of measured profiles to begin with.",
            autocompletion=completion(list, *PROFILE_FILES),
        ),
    ] = None,
    port: Annotated[
        int, typer.Option("--port", metavar="NUMBER", help="Port on this machine; a free one if left out.")
    ] = 0,
    units: Units = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
) -> None:
    """Move a wheelset on its rails with the mouse: a page in the browser, from this machine alone (Ctrl-C ends)."""
    try:
        from flangeway.live.server import LiveServer  # noqa: PLC0415
    except ModuleNotFoundError as reason:
        raise InputError(
            f"the live page without the package {reason.name}",
            "an installation with the extra `live`",
            "pip install 'flangeway[live]'",
        ) from reason
    server = LiveServer(profiles or [], port, units_given(units) or "metric")
    stdout().print(f"{server.address}\nThe page is served on this machine alone; Ctrl-C ends it.", soft_wrap=True)
    if browser:
        webbrowser.open(server.address)
    with suppress(KeyboardInterrupt):  # the way to end it
        server.run()
