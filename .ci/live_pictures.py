"""Writes docs/images/live.gif and live.png from the live page in Chromium: ``python .ci/live_pictures.py``."""

import io
import shutil
import threading
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from flangeway.live import LiveServer

IMAGES = Path(__file__).parents[1] / "docs" / "images"
POSITIONS_MM = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 6.6, 6.0, 4.0, 2.0, 0.0, -2.0, -4.0, -2.0]
WIDTH, HEIGHT = 1100, 1600
SHOWN_PX, SHOWN_HEIGHT_PX, FRAME_MS, COLOURS = 760, 960, 500, 128
STANDS = "document.querySelector('#state').className.match(/good|warned/) && !document.querySelector('#tables.stale')"


def picture(page: Page, width: int) -> Image.Image:
    """Return what the window shows."""
    whole = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    return whole.resize((width, round(width * whole.height / whole.width)), Image.Resampling.LANCZOS)


def main() -> None:
    """Move the wheelset and take a picture at each position."""
    server = LiveServer([])
    threading.Thread(target=server.run, daemon=True).start()
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, bypass_csp=True, color_scheme="light")
        page.goto(server.address)
        frames = []
        for lateral in POSITIONS_MM:
            page.wait_for_function("state.rigid !== null", timeout=120_000)
            page.evaluate(f"shift({lateral})")
            page.wait_for_function(f"state.elastic?.lateral_mm === {lateral} && {STANDS}", timeout=120_000)
            page.evaluate("$('h-move').scrollIntoView()")
            page.wait_for_timeout(200)
            frames.append(picture(page, SHOWN_PX).crop((0, 0, SHOWN_PX, SHOWN_HEIGHT_PX)).quantize(COLOURS))
        page.evaluate("scrollTo(0, 0); shift(3)")
        page.wait_for_function(f"state.elastic.lateral_mm === 3 && {STANDS}", timeout=120_000)
        picture(page, 980).quantize(64).save(IMAGES / "live.png", optimize=True)
        browser.close()
    first, *others = frames
    first.save(
        IMAGES / "live.gif", save_all=True, append_images=others, duration=FRAME_MS, loop=0, optimize=True, disposal=1
    )
    server.server.should_exit = True


if __name__ == "__main__":
    main()
