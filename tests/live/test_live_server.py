"""The live page's server answers this machine, with the token, and nothing else."""

import json
import urllib.error
import urllib.request

import pytest


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


def test_other_names_of_the_machine_are_refused(served):
    """A page of another host cannot reach the server by a name that it lets point here."""
    assert answered(served.address, headers={"Host": "example.org"})[0] == 400


def test_wrong_inputs_have_messages(served):
    """An input that is not allowed is answered with the message of the case, which names the input."""
    status, text = answered(f"{served.address}geometry", json.dumps({"gauge_mm": "-5"}))
    assert status == 422
    assert "gauge_mm" in json.loads(text)["error"]


def test_large_files_are_refused(served):
    """A file beyond the limit is refused while it arrives."""
    assert answered(f"{served.address}profile?name=big.whl", "1" * 20_000_001)[0] == 413


def test_the_page_loads_nothing(served):
    """The page has no address of another host in it, and a policy by which the browser would refuse one."""
    text = answered(served.address)[1]
    assert "http" not in text.replace("http-equiv", "")
    with urllib.request.urlopen(served.address, timeout=60) as response:
        assert response.headers["Content-Security-Policy"].startswith("default-src 'none'")


@pytest.mark.parametrize("name", ["passwd", "evil.sh"])
def test_files_of_other_kinds_are_refused(served, name):
    """Only endings of profiles are kept."""
    assert answered(f"{served.address}profile?name={name}", "1 2")[0] == 422
    assert not list(served.engine.folder.glob(name))
