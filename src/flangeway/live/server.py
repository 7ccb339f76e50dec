"""The live page's server: this machine only, a random token in its address, and nothing but what the engine answers."""

import json
import secrets
import tempfile
from collections.abc import Callable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route

from flangeway.errors import FlangewayError, InputError
from flangeway.live.engine import MAX_FILE_BYTES, LiveEngine, SupersededError
from flangeway.results import Units

HOST = "127.0.0.1"
TOKEN_BYTES = 24
SUPERSEDED = 409
"""Status of an answer that nobody waits for any more: a newer position was asked for."""
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; connect-src 'self'"
"""The page loads nothing: script and style are inside, and it talks to this server alone."""


def application(engine: LiveEngine, token: str) -> Starlette:
    """Return the application: every address begins with the token; anything else is refused with status 403."""

    async def page(_: Request) -> Response:
        source = files("flangeway.live")
        text = (source / "live.html").read_text(encoding="utf-8")
        for name in ("live.css", "live.js"):
            text = text.replace(f"/*{name}*/", (source / name).read_text(encoding="utf-8"))
        headers = {"Content-Security-Policy": POLICY, "Referrer-Policy": "no-referrer", "Cache-Control": "no-store"}
        return HTMLResponse(text, headers=headers)

    async def profile(request: Request) -> Response:
        options = json.loads(request.query_params.get("options", "{}"))
        content = b""
        async for part in request.stream():
            content += part
            if len(content) > MAX_FILE_BYTES:
                return _failed(f"a file of more than {MAX_FILE_BYTES / 1e6:g} MB; profiles have less", 413)
        return await _answer(engine.add_profile, request.query_params.get("name", ""), content, options)

    def route(name: str, answer: Callable[[Mapping[str, str]], Any]) -> Route:
        async def endpoint(request: Request) -> Response:
            return await _answer(answer, await request.json())

        return Route(f"/{token}/{name}", endpoint, methods=["POST"])

    async def refused(_: Request) -> Response:
        return PlainTextResponse("The address has no valid token; open the one that `flangeway live` prints.", 403)

    routes = [
        Route(f"/{token}/", page),
        Route(f"/{token}/profile", profile, methods=["POST"]),
        route("form", lambda _: engine.form()),
        route("geometry", engine.geometry),
        route("position", engine.position),
        route("report", lambda inputs: {"html": engine.report(inputs)}),
        route("saved", engine.saved),
        route("cancel", lambda _: engine.cancel()),
        Route("/{rest:path}", refused, methods=["GET", "POST", "PUT", "DELETE"]),
    ]
    return Starlette(routes=routes, middleware=[Middleware(TrustedHostMiddleware, allowed_hosts=[HOST, "localhost"])])


async def _answer(work: Callable[..., Any], *arguments: Any) -> Response:
    """Return what a function gives, computed beside the other requests, or its error as a message."""
    try:
        return JSONResponse(await run_in_threadpool(work, *arguments))
    except SupersededError as reason:
        return _failed(str(reason), SUPERSEDED)
    except FlangewayError as reason:
        return _failed(str(reason), 422)


def _failed(message: str, status: int) -> Response:
    return JSONResponse({"error": message}, status)


class LiveServer:
    """A page for some profiles, served until it is stopped.

    Parameters
    ----------
    given
        Files that the user named; the page shows the first wheel and the first rail among them.
    port
        Port on this machine; 0 for a free one.
    units
        Units of inputs and numbers of the page.

    """

    def __init__(self, given: Sequence[Path], port: int = 0, units: Units = "metric") -> None:
        for path in given:
            if not path.is_file():
                raise InputError(f"the file {path}", "files of measured profiles", "give files that exist")
        self._folder = tempfile.TemporaryDirectory(prefix="flangeway-live-")
        self.engine = LiveEngine(Path(self._folder.name), {path.name: path.resolve() for path in given}, units)
        self.token = secrets.token_urlsafe(TOKEN_BYTES)
        config = uvicorn.Config(application(self.engine, self.token), HOST, port, log_level="warning", lifespan="off")
        self.server, self._socket = uvicorn.Server(config), config.bind_socket()

    @property
    def address(self) -> str:
        """Address of the page, with its token."""
        return f"http://{HOST}:{self._socket.getsockname()[1]}/{self.token}/"

    def run(self) -> None:
        """Serve until Ctrl-C, then remove the dropped files."""
        try:
            self.server.run(sockets=[self._socket])
        finally:
            self.engine.cancel()
            self._folder.cleanup()
