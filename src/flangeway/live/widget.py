"""The live page inside a notebook: the same page, served from the notebook's own process."""

import html
import threading
from dataclasses import dataclass
from pathlib import Path

from flangeway.live.server import NOTEBOOKS, LiveServer
from flangeway.units import Units

HEIGHT_PX = 900


@dataclass(frozen=True, eq=False)
class LiveWidget:
    """A live page that a notebook shows as the value of a cell.

    - `server`: what serves it, in a thread of this process, until `close` or the end of the process.
    """

    server: LiveServer

    @classmethod
    def show(cls, *profiles: str | Path, port: int = 0, units: Units = "metric") -> "LiveWidget":
        """Serve a page for some files of profiles, none for bundled ones, and return it.

        Parameters
        ----------
        profiles
            Files of measured wheels and rails; an `InputError` if one does not exist.
        port
            Port on this machine; 0 for a free one.
        units
            Units of inputs and numbers of the page.

        """
        server = LiveServer([Path(path) for path in profiles], port, units, NOTEBOOKS)
        threading.Thread(target=server.run, daemon=True).start()
        return cls(server)

    def close(self) -> None:
        """Stop serving, and remove the dropped files."""
        self.server.close()

    def _repr_html_(self) -> str:
        address = html.escape(self.server.address)
        return (
            f'<iframe src="{address}" width="100%" height="{HEIGHT_PX}" title="flangeway live"></iframe>'
            f'<p><a href="{address}" target="_blank" rel="noreferrer">open it in its own window</a></p>'
        )
