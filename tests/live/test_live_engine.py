"""The live page's engine computes what commands do, in a notebook too; its server answers this machine alone."""

import http.client
import json
import os
import re
import signal
import stat
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.parse
import urllib.request
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from flangeway.campaign import Campaign
from flangeway.cases.case_file import read_case
from flangeway.errors import InputError
from flangeway.live.engine import LiveEngine, SupersededError
from flangeway.railway.profiles import bundled
from flangeway.railway.rigid.rigid_geometry import RigidGeometry
from flangeway.report.wheelset.wheelset_page import results_table
from tests.docs.conftest import blocks_of

COARSE = {
    "mesh.size_scale": "6", "mesh.order": "1", "track.support": "continuous", "wheelset.wheel": "S1002",
    "track.rail": "60E1",
}  # fmt: skip
STATES = [
    {"position.lateral_mm": "-1", "position.yaw_mrad": "3", "load.axle_load_kN": "160"},
    {"position.lateral_mm": "0.5", "rolling.friction": "0.3", "rolling.speed_km_h": "80", "rolling.theory": "fastsim"},
]


@pytest.fixture(scope="module")
def engine(tmp_path_factory):
    """One engine, so that its bodies are shared by the states."""
    return LiveEngine(tmp_path_factory.mktemp("dropped"))


def test_a_position_has_the_numbers_of_a_run(engine):
    """The table of the page is that of ``flangeway run wheelset`` to the last digit, with bodies of other states.

    Pressures times areas of the cells that are drawn sum to the normal forces.
    """
    other, state = STATES
    assert engine.position(COARSE | other)["converged"]
    found = engine.position(COARSE | state)
    run = engine.case(COARSE | state).run()
    assert found["converged"]
    assert found["table"]["rows"] == results_table(run).rows
    assert found["max_pressure_MPa"] == max(patch.max_pressure for patch in run.result.patches)
    assert found["lateral_mm"] == run.result.equilibrium.position.lateral_mm
    for side, patch in found["patches"].items():
        # the shoelace formula of each polygon
        x, y = np.moveaxis(np.array(patch["polygons"]), 2, 0)
        areas = abs(np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)) / 2.0
        force = float(np.array(patch["pressures"]) @ areas)
        normal = run.result.equilibrium.state.sides[side].forces.sum()
        assert force == pytest.approx(normal, rel=1e-3)  # numbers of pictures are rounded


def test_rigid_contact_is_that_of_the_geometry(engine):
    """Contact points, angles, radii and conicity are those of the rigid geometry of the same track and wheelset."""
    inputs = COARSE | {"position.yaw_mrad": "5"}
    found, case = engine.geometry(inputs), engine.case(inputs)
    geometry = RigidGeometry.of(case.track, case.wheels, 5e-3)
    locus = geometry.locus(np.array(found["lateral"])[::40])
    right = found["sides"]["right"]
    assert np.array(right["points"])[::40] == pytest.approx(locus.right.points_mm[:, 0], abs=1e-4)
    assert np.radians(right["angles"])[::40] == pytest.approx(locus.right.contact_angles_rad[:, 0], abs=1e-5)
    assert np.array(found["difference"])[::40] == pytest.approx(locus.rolling_radius_difference_mm, abs=1e-4)


def test_what_is_saved_computes_the_same_case(engine, tmp_path):
    """The saved file is the case of the page; the saved campaign has its inputs at 25 lateral positions."""
    inputs = COARSE | {"position.lateral_mm": "1.25", "load.axle_load_kN": "180"}
    saved = engine.saved(inputs)
    (tmp_path / "case.toml").write_text(saved["case"])
    assert read_case(tmp_path / "case.toml") == engine.case(inputs)
    assert "lateral_mm=1.25" in saved["command"]
    (tmp_path / "campaign.toml").write_text(saved["campaign"])
    rows = Campaign.from_file(tmp_path / "campaign.toml").rows
    assert [row.case.position.lateral_mm for row in rows] == pytest.approx(np.linspace(-6.0, 6.0, 25))
    assert {row.case.load.axle_load_kN for row in rows} == {180.0}


def test_a_file_that_is_dropped_again_replaces_the_one_before(engine):
    """Rigid contact is that of the content of a file, not of its name."""
    heights = []
    for wheel in ("S1002", "heavy-haul"):
        points = bundled.wheel(wheel).running_surface.sampled(spacing=0.3)
        lines = ["# kind: wheel", *(f"{x:.4f},{y:.4f}" for x, y in points)]
        engine.add_profile("worn.csv", "\n".join(lines).encode(), {})
        heights.append(engine.geometry(COARSE | {"wheelset.wheel": "worn.csv"})["difference"])
    assert heights[0] != heights[1]


def test_a_newer_position_stops_the_one_before(engine):
    """Of twenty positions asked for at once the last one is answered, and the others are not kept waiting for."""
    answers = {}

    def ask(number):
        try:
            answers[number] = engine.position(COARSE | {"position.lateral_mm": f"{0.1 * number:g}"})["lateral_mm"]
        except SupersededError:
            answers[number] = None

    threads = [threading.Thread(target=ask, args=(number,)) for number in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sum(answer is not None for answer in answers.values()) == 1


@pytest.mark.parametrize(
    ("key", "name"),
    [("wheelset.wheel", "../secret.whl"), ("track.left.rail", "/etc/passwd"), ("rolling.friction.file", "/etc/passwd")],
)
def test_only_files_that_were_given_are_read(engine, key, name):
    """A path that the user did not give is refused before anything is opened."""
    with pytest.raises(InputError, match=r"files? (that were given to|of) this page"):
        engine.case({key: name})


def test_a_bad_file_has_the_message_of_the_command(engine, tmp_path):
    """A dropped file that is no profile is refused as ``flangeway profile`` refuses it, and is not kept."""
    from flangeway.railway.profiles.profile_file import read_profile  # noqa: PLC0415

    content = b"no numbers here\n"
    (tmp_path / "bad.whl").write_bytes(content)
    with pytest.raises(InputError) as expected:
        read_profile(tmp_path / "bad.whl")
    with pytest.raises(InputError) as given:
        engine.add_profile("bad.whl", content, {})
    assert str(given.value) == str(expected.value).replace(f"{tmp_path}/", "")
    assert "bad.whl" not in engine.files


def test_the_cell_of_the_how_to_shows_the_page(profiles, monkeypatch):
    """The code of `how-to/live-page.md` gives a value whose HTML is a frame with the page, which knows both files."""
    code = next(block.text for block in blocks_of("how-to/live-page.md") if block.kind == "python")
    imported, call = code.strip().split("\n\n")
    monkeypatch.chdir(profiles)
    names = {}
    exec(imported, names)
    widget = eval(call, names)
    try:
        address = re.search(r'src="([^"]+)"', widget._repr_html_())[1]
        while not widget.server.server.started:
            pass
        with urllib.request.urlopen(address, timeout=60) as page:
            assert "<title>flangeway live</title>" in page.read().decode()
        assert widget.server.engine.form({})["files"] == ["my-wheel.whl", "my-rail.ban"]
    finally:
        widget.close()


def answered(url, body=None, headers=None):
    """Status and text of a request."""
    request = urllib.request.Request(url, None if body is None else body.encode(), headers or {})
    try:
        with urllib.request.urlopen(request, timeout=60) as response:
            return response.status, response.read().decode()
    except urllib.error.HTTPError as reason:
        return reason.code, reason.read().decode()


def test_the_page_needs_its_token(served):
    """With the token there is a page; without it, or with another one, the status is 403, whatever is asked for."""
    root = served.address.rpartition(f"{served.token}/")[0]
    assert served.address.startswith("http://127.0.0.1:")
    assert answered(served.address)[0] == 200
    for path in ("", "form", "x" * len(served.token) + "/", "../../etc/passwd"):
        assert answered(root + path)[0] == 403
        assert answered(root + path, "{}")[0] == 403


def test_pages_of_others_are_refused(served):
    """A request that another page sends is refused; answers may not be shown inside of others, nor guessed at."""
    own = served.address.rpartition(f"/{served.token}/")[0]
    for origin, status in ((own, 200), ("http://example.org", 403), ("null", 403)):
        assert answered(f"{served.address}form", "{}", {"Origin": origin})[0] == status
    with urllib.request.urlopen(served.address, timeout=60) as response:
        assert "frame-ancestors 'none'" in response.headers["Content-Security-Policy"]
        assert response.headers["X-Content-Type-Options"] == "nosniff"


BODIES = [
    *("", "[]", "null", "1", '"x"', "{", "[" * 900_000, '{"a":' * 100_000),
    *('{"wheel": 1}', '{"wheel": null}', '{"wheel": {}}', r'{"wheel": "S\u0000"}', r'{"wheel\u0000": "S"}'),
    *(r'{"\ud800": "x"}', '{"gauge_mm": "1e999"}', '{"rolling.friction.file": "/etc/passwd"}', '{"x": NaN}'),
    *(json.dumps({f"k{number}": "1" for number in range(n)}) for n in (199, 60_000)),
    *(
        '{"a": "%s"}' % ("x" * 1_100_000),
        '{"axle_load_kN": "%s"}' % ("9" * 500_000),
    ),
]


@pytest.mark.parametrize("name", ["geometry", "position", "report", "saved"])
def test_any_body_is_answered(served, name):
    """Whatever is sent in place of inputs is refused with a message, at once."""
    for body in BODIES:
        begun = time.perf_counter()
        status, text = answered(f"{served.address}{name}", body)
        assert 400 <= status < 500, (body[:50], status)
        assert json.loads(text)["error"]
        assert time.perf_counter() - begun < 5.0  # 0.1 on a quiet machine


@pytest.mark.parametrize(
    "options", ["[]", "x", '{"mirror": "x"}', '{"no": 1}', '{"tape_mm": NaN}', '{"unit": "parsec"}']
)
@pytest.mark.parametrize("name", ["a.whl", "a\0.whl", "", "..", "x" * 300 + ".whl", "../x.whl"])
def test_any_file_is_answered(served, name, options):
    """A name or options that are not allowed are refused with a message, and no file stays."""
    query = urllib.parse.urlencode({"name": name, "options": options})
    for content in ("", "1 2\n3 4\n", "\0" * 100):
        status, text = answered(f"{served.address}profile?{query}", content)
        assert 400 <= status < 500
        assert json.loads(text)["error"]
    assert not [
        path for path in served.engine.folder.rglob("*") if path.is_file() and path.name not in served.engine.files
    ]


@pytest.mark.parametrize(
    "kind", ["SIGINT", *(pytest.param(kind, marks=pytest.mark.ci) for kind in ("SIGTERM", "SIGHUP", "SIGKILL"))]
)
def test_a_signal_ends_it_at_once_and_leaves_nothing(profiles, tmp_path, interruptible, kind):
    """While a position is computed each signal ends the command within seconds, and the folder of files is gone.

    The browser's command line, which all users can read, has no token: it names a file of this user.
    """
    browser = tmp_path / "browser"
    browser.write_text('#!/bin/sh\necho "$@" > "$(dirname "$0")/opened"\n')
    browser.chmod(0o755)
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    environment = os.environ | {"TMPDIR": str(temporary), "BROWSER": f"{browser} %s"}
    command = [sys.executable, "-m", "flangeway", "live"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, env=environment, text=True)
    address = process.stdout.readline().strip()
    token = address.rstrip("/").rpartition("/")[2]

    def ask():
        with suppress(OSError, http.client.HTTPException):
            answered(f"{address}position", json.dumps({"wheel": "S1002", "rail": "60E1", "size_scale": "0.5"}))

    try:
        while True:
            with suppress(OSError):
                if answered(address)[0] == 200:
                    break
        content = (profiles / "my-wheel.whl").read_text()
        assert answered(f"{address}profile?name=my.whl", content)[0] == 200
        opened = (tmp_path / "opened").read_text()
        page = Path(urllib.parse.urlparse(opened.strip()).path)
        assert token not in opened
        assert address in page.read_text()
        assert stat.S_IMODE(page.stat().st_mode) == 0o600
        assert len(list(temporary.rglob("my.whl"))) == 1
        threading.Thread(target=ask, daemon=True).start()
        time.sleep(1.0)
        process.send_signal(getattr(signal, kind))
        process.wait(timeout=5)
        for _ in range(100):
            if not list(temporary.iterdir()):
                break
            time.sleep(0.05)
        assert not list(temporary.iterdir())
    finally:
        process.kill()
        process.communicate()


def test_other_names_of_the_machine_are_refused(served):
    """A page of another host cannot reach the server by a name that it lets point here."""
    assert answered(served.address, headers={"Host": "example.org"})[0] == 400


def test_wrong_inputs_have_messages(served):
    """An input that is not allowed is answered with the message of the case, which names the input."""
    status, text = answered(f"{served.address}geometry", json.dumps({"gauge_mm": "-5"}))
    assert status == 422
    assert "gauge_mm" in json.loads(text)["error"]


def test_positions_are_computed_by_one_thread(engine):
    """Positions, whoever asks for them, are computed by one thread, so that memory that is freed serves the next."""
    threads = set()

    def noted(_):
        threads.add(threading.get_ident())

    askers = [threading.Thread(target=lambda: engine._alone(noted)) for _ in range(5)]
    for asker in askers:
        asker.start()
        asker.join()
    assert len(threads) == 1
    assert not threads & {asker.ident for asker in askers}


def test_large_files_are_refused(served):
    """A file beyond the limit is refused while it arrives."""
    assert answered(f"{served.address}profile?name=big.whl", "1" * 20_000_001)[0] == 413


def test_the_page_loads_nothing(served):
    """The page has no address of another host in it, and a policy by which the browser would refuse one."""
    text = answered(served.address)[1]
    assert "http" not in text.replace("http-equiv", "").replace("http://www.w3.org/2000/svg", "")  # a name, no address
    with urllib.request.urlopen(served.address, timeout=60) as response:
        assert response.headers["Content-Security-Policy"].startswith("default-src 'none'")


@pytest.mark.parametrize("name", ["passwd", "evil.sh"])
def test_files_of_other_kinds_are_refused(served, name):
    """Only endings of profiles are kept."""
    assert answered(f"{served.address}profile?name={name}", "1 2")[0] == 422
    assert not list(served.engine.folder.glob(name))
