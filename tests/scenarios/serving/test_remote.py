"""A bench behind an address is a bench like the others."""

from __future__ import annotations

from collections.abc import Iterator

import httpx
import numpy as np
import pytest

from armtwin.models.bench import Bench
from armtwin.models.errors import InputError, JobError
from armtwin.scenarios.serving.remote import RemoteBench
from armtwin.scenarios.serving.sources import source_of
from tests.scenarios.serving.conftest import TOKEN, Served

pytestmark = pytest.mark.xdist_group("serving")
POSES = source_of("simulated").plans["circle_25"].q_cmd[:4]


@pytest.fixture
def remote(served: Served) -> Iterator[RemoteBench]:
    with RemoteBench(served.url, TOKEN) as bench:
        yield bench


def ask(served: Served, method: str, path: str, **more: object) -> httpx.Response:
    headers = {"Authorization": f"Bearer {TOKEN}", **more.pop("headers", {})}  # type: ignore[dict-item]
    return httpx.request(method, served.url + path, headers=headers, trust_env=False, timeout=60, **more)  # type: ignore[arg-type]


def test_it_is_a_bench_and_gives_the_same_bytes_as_the_one_it_leads_to(remote: RemoteBench) -> None:
    assert isinstance(remote, Bench)
    local = source_of("simulated").make((), 0)
    local.connect()
    for q in POSES:
        remote.move(q)
        local.move(q)
        there, here = remote.capture(), local.capture()
        np.testing.assert_array_equal(there.image, here.image)
        assert there.time_s == here.time_s
    local.close()


def test_while_one_moves_the_arm_another_is_told_so(served: Served, remote: RemoteBench) -> None:
    with pytest.raises(JobError, match="somebody else"):
        RemoteBench(served.url, TOKEN).connect()
    answer = ask(served, "POST", "/api/move", json={"q_cmd_rad": [0.0, 0.0, 0.0]}, headers={"X-Lease": "guessed"})
    assert answer.status_code == 409


def test_an_arm_that_is_given_back_is_detached_and_free(served: Served) -> None:
    with RemoteBench(served.url, TOKEN):
        assert ask(served, "GET", "/api/state").json()["connected"]
    state = ask(served, "GET", "/api/state").json()
    assert not state["connected"]
    assert not state["held"]


@pytest.mark.parametrize(
    ("q", "said"), [([3.0, 0.0, 0.0], "limits"), ([0.0, 0.0], "3 joint angles"), ([0.0] * 7, "q_cmd_rad")]
)
def test_a_pose_outside_the_limits_or_of_another_arm_is_refused(remote: RemoteBench, q: list[float], said: str) -> None:
    remote.move(POSES[0])
    with pytest.raises(InputError, match=said):
        remote.move(np.array(q))


def test_without_the_token_nothing_but_the_empty_page_is_shown(served: Served) -> None:
    with pytest.raises(InputError, match="token"):
        RemoteBench(served.url, "a wrong token").connect()
    for path in ("/api/bench", "/api/state", "/api/picture.jpg", "/openapi.json", "/api/recording.zip"):
        assert httpx.get(served.url + path, trust_env=False).status_code == 401
    assert httpx.get(served.url + "/", trust_env=False).status_code == 200


def test_another_name_for_this_machine_is_not_answered(served: Served) -> None:
    assert ask(served, "GET", "/api/state", headers={"Host": "bench.example"}).status_code == 403


def test_a_body_without_measure_is_refused(served: Served) -> None:
    assert ask(served, "POST", "/api/lease", content=b"x" * (3 << 20)).status_code == 413


@pytest.mark.parametrize("path", ["/api/jobs/1/../../etc/passwd", "/static/../app.py", "/static/%2e%2e/app.py"])
def test_no_path_climbs_out_of_what_is_served(served: Served, path: str) -> None:
    answer = ask(served, "GET", path)
    assert answer.status_code in (404, 422, 503)
    assert "FastAPI" not in answer.text


def test_its_interface_is_documented(served: Served) -> None:
    paths = ask(served, "GET", "/openapi.json").json()["paths"]
    assert {"/api/move", "/api/capture", "/api/state", "/api/plan", "/api/stream.mjpeg"} <= paths.keys()
    assert all(operation.get("description") for path in paths.values() for operation in path.values())


def test_an_address_where_no_bench_is_served_is_told_as_that() -> None:
    with pytest.raises(InputError, match="no address"):
        RemoteBench("bench.toml", TOKEN)
