"""`armtwin serve --check`: what is between this machine and a server, step by step."""

from __future__ import annotations

import http.server
import threading
from collections.abc import Iterator

import pytest

from armtwin.models.errors import InputError
from armtwin.scenarios.serving.check_server import check_server
from tests.scenarios.serving.conftest import TOKEN, Served

pytestmark = pytest.mark.xdist_group("serving")


def test_all_steps_to_a_bench_that_works(served: Served) -> None:
    steps = list(check_server(f"{served.url}/?token={TOKEN}"))
    assert [step.name for step in steps if step.name != "proxy"] == ["name", "port", "web", "token", "speed"]
    assert all(step.works is not False for step in steps)


def test_a_wrong_token_is_the_last_step(served: Served) -> None:
    last = list(check_server(served.url, "not-the-token"))[-1]
    assert (last.name, last.works) == ("token", False)
    assert "link" in last.said


def test_a_port_where_nobody_listens_and_a_name_that_nobody_knows() -> None:
    assert list(check_server("http://127.0.0.1:9/"))[-1].name == "port"
    assert list(check_server("http://nobody.invalid/"))[-1].name == "name"


def test_a_page_of_something_else_is_told_apart(foreign_server: str) -> None:
    last = list(check_server(foreign_server))[-1]
    assert (last.name, last.works) == ("web", False)
    assert "no armtwin" in last.said


@pytest.mark.parametrize("address", ["lab", "ftp://lab/", "http://[::1/", ""])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(InputError, match="is no address"):
        list(check_server(address))


@pytest.fixture
def foreign_server() -> Iterator[str]:
    class Page(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.end_headers()
            self.wfile.write(b"<html>login</html>")

        def log_message(self, *_: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Page)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
