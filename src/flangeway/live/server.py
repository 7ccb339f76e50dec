"""The live page's server: this machine only, a random token in its address, and nothing but what the engine answers."""

import asyncio
import json
import secrets
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

import uvicorn
from anyio import to_thread
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from flangeway.errors import FlangewayError, InputError
from flangeway.live.engine import MAX_FILE_BYTES, LiveEngine, SupersededError
from flangeway.units import Units

HOST = "127.0.0.1"
TOKEN_BYTES = 24
SUPERSEDED = 409
"""Status of an answer that nobody waits for any more: a newer position was asked for."""
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors "
)
"""The page loads nothing: script and style are inside, and it talks to this server alone; pages that may show it."""
NOTEBOOKS = f"http://{HOST}:* http://localhost:* vscode-webview:"
MAX_JSON_BYTES, MAX_INPUTS = 1_000_000, 200
OPTIONS = {"mirror": bool, "unit": str, "tape_mm": int | float}
"""Options of how a dropped file is read, and their types."""
REMOVE = "import shutil, sys; sys.stdin.read(); shutil.rmtree(sys.argv[1], ignore_errors=True)"
"""Program that waits for the end of this process, however it ends, and then removes its folder."""


def application(engine: LiveEngine, token: str, frames: str = "'none'") -> Starlette:
    """Return the application: every address begins with the token; anything else is refused with status 403.

    - `frames`: addresses of pages that may show it inside of them.
    """

    async def page(_: Request) -> Response:
        source = files("flangeway.live")
        text = (source / "live.html").read_text(encoding="utf-8")
        for name in ("live.css", "live.js"):
            text = text.replace(f"/*{name}*/", (source / name).read_text(encoding="utf-8"))
        return HTMLResponse(text)

    async def profile(request: Request) -> Response:
        options, content = _object(request.query_params.get("options", "{}")), await _body(request, MAX_FILE_BYTES)
        for name, value in options.items():
            if not isinstance(value, OPTIONS.get(name, ())):
                raise _refused(400, "options", f"an object of {', '.join(OPTIONS)}")
        return await _answer(engine.add_profile, request.query_params.get("name", ""), content, options)

    def route(name: str, answer: Callable[[Mapping[str, str]], Any]) -> Route:
        async def endpoint(request: Request) -> Response:
            inputs = _object(await _body(request, MAX_JSON_BYTES))
            texts = [text for item in inputs.items() for text in item]
            if len(inputs) > MAX_INPUTS or not all(isinstance(text, str) and text.isprintable() for text in texts):
                raise _refused(400, "inputs", f"an object of up to {MAX_INPUTS} names with texts")
            return await _answer(answer, inputs)

        return Route(f"/{token}/{name}", endpoint, methods=["POST"])

    async def refused(_: Request) -> Response:
        return PlainTextResponse("The address has no valid token; open the one that `flangeway live` prints.", 403)

    routes = [
        Route(f"/{token}/", page),
        Route(f"/{token}/profile", profile, methods=["POST"]),
        route("form", engine.form),
        route("geometry", engine.geometry),
        route("position", engine.position),
        route("report", lambda inputs: {"html": engine.report(inputs)}),
        route("saved", engine.saved),
        route("tables", engine.tables),
        route("cancel", lambda _: engine.cancel()),
        Route("/{rest:path}", refused, methods=["GET", "POST", "PUT", "DELETE"]),
    ]
    guards = [
        Middleware(_Guard, policy=POLICY + frames),
        Middleware(TrustedHostMiddleware, allowed_hosts=[HOST, "localhost"]),
    ]
    return Starlette(routes=routes, exception_handlers={HTTPException: _failure}, middleware=guards)


class _Guard:
    """Refuses requests of other pages, and adds security headers to each answer."""

    def __init__(self, app: ASGIApp, policy: str) -> None:
        self._app, self._headers = app, {
            "Content-Security-Policy": policy,
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
            "X-Content-Type-Options": "nosniff",
        }  # fmt: skip

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(self._headers)
            await send(message)

        headers = Headers(scope=scope)
        address = f"http://{headers.get('host')}"
        foreign = headers.get("origin", address) != address
        answer = PlainTextResponse("The request comes from another page.", 403) if foreign else self._app
        await answer(scope, receive, sent)


async def _body(request: Request, limit: int) -> bytes:
    """Return the content of a request, refused while it arrives if it is larger than a limit."""
    content = bytearray()
    async for part in request.stream():
        content += part
        if len(content) > limit:
            raise _refused(413, f"more than {limit / 1e6:g} MB", "less")
    return bytes(content)


def _object(text: str | bytes) -> dict[str, Any]:
    """Return an object in JSON."""
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        value = None
    if not isinstance(value, dict):
        raise _refused(400, "a request", "an object in JSON")
    return value


def _refused(status: int, given: str, allowed: str) -> HTTPException:
    return HTTPException(status, f"{given}; allowed: {allowed}")


async def _failure(_: Request, reason: Exception) -> Response:
    assert isinstance(reason, HTTPException)
    return _failed(reason.detail, reason.status_code)


async def _answer(work: Callable[..., Any], *arguments: Any) -> Response:
    """Return what a function gives, computed beside the other requests, or its error as a message."""
    try:  # who stops the server does not wait for what is computed
        return JSONResponse(await to_thread.run_sync(work, *arguments, abandon_on_cancel=True))
    except asyncio.CancelledError:
        return _failed("The server has stopped.", 503)
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

    def __init__(self, given: Sequence[Path], port: int = 0, units: Units = "metric", frames: str = "'none'") -> None:
        for path in given:
            if not path.is_file():
                raise InputError(f"the file {path}", "files of measured profiles", "give files that exist")
        folder = Path(tempfile.mkdtemp(prefix="flangeway-live-"))
        # in a session of its own: what ends this process, as Ctrl-C in its terminal, does not end that one
        command = [sys.executable, "-IS", "-c", REMOVE, str(folder)]
        self._remover = subprocess.Popen(command, stdin=subprocess.PIPE, start_new_session=True)
        self.engine = LiveEngine(folder, {path.name: path.resolve() for path in given}, units)
        self.token = secrets.token_urlsafe(TOKEN_BYTES)
        app = application(self.engine, self.token, frames)
        config = uvicorn.Config(app, HOST, port, log_level="warning", lifespan="off")
        self.server, self._socket = _Server(config), config.bind_socket()

    @property
    def address(self) -> str:
        """Address of the page, with its token."""
        return f"http://{HOST}:{self._socket.getsockname()[1]}/{self.token}/"

    def opener(self) -> Path:
        """Write a page that leads to the address, and that only this user can read: commands are seen by all."""
        path = self.engine.folder / "flangeway-live.html"
        path.touch(mode=0o600)
        path.write_text(f'<meta http-equiv="refresh" content="0; url={self.address}">', encoding="utf-8")
        return path

    def run(self) -> None:
        """Serve until Ctrl-C or `close`, then remove the dropped files."""
        try:
            self.server.run(sockets=[self._socket])
        finally:
            self.engine.cancel()
            self._remover.communicate()

    def close(self) -> None:
        """Stop serving, at once."""
        self.server.should_exit = self.server.force_exit = True


class _Server(uvicorn.Server):
    """A server that the first signal stops, without waiting for requests."""

    def handle_exit(self, sig: int, frame: Any) -> None:  # noqa: ARG002 (uvicorn's signature)
        """See `uvicorn.Server`."""
        self.should_exit = self.force_exit = True
