"""A bench at the other end of an HTTP address, by the four methods that every bench has.

with RemoteBench("http://127.0.0.1:8000/", token) as bench:
    bench.move(q_cmd_rad)
    frame = bench.capture()
"""

from __future__ import annotations

import threading
import time
from types import TracebackType
from typing import Any

import cv2
import httpx
import numpy as np
from numpy.typing import NDArray

from armtwin.models.bench import Frame
from armtwin.models.errors import InputError, JobError

Array = NDArray[np.float64]

# A move of a slow arm, or the first frame of a renderer that has to compile its shaders.
_ANSWER_S = 60.0
_HEARTBEAT_S = 3.0
# A network that breaks off for a moment is waited for; the server keeps the arm fifteen seconds.
_ATTEMPTS, _PAUSE_S = 4, 1.0
# A picture of 50 megapixels without loss.
_MOST_BYTES = 200 << 20


class RemoteBench:
    """Satisfies `armtwin.models.bench.Bench` through a served bench; `token` is what `armtwin serve` printed.

    Raises `InputError` where the address or the token is wrong, `JobError` where the bench is somebody else's, refuses
    a command or cannot be reached any more.
    """

    def __init__(self, url: str, token: str) -> None:
        if not url.startswith(("http://", "https://")):
            raise InputError(f"'{url[:80]}' is no address of a served bench; http://HOST:PORT/ is wanted")
        self.url = url.rstrip("/")
        self._client = httpx.Client(headers={"Authorization": f"Bearer {token}"}, timeout=_ANSWER_S, trust_env=False)
        self._lease: str | None = None
        self._ended = threading.Event()

    def info(self) -> dict[str, Any]:
        """Return what the bench says of itself: arm, camera, limits, plans."""
        answer: dict[str, Any] = self._ask("GET", "/api/bench").json()
        return answer

    def connect(self) -> None:
        """Take the arm and open the bench."""
        if self._lease is None:
            self._lease = str(self._ask("POST", "/api/lease").json()["lease"])
            self._ended.clear()
            threading.Thread(target=self._keep_alive, args=(self._ended,), name="remote-bench", daemon=True).start()
        self._ask("POST", "/api/connect")

    def move(self, q_cmd_rad: Array) -> None:
        """Command (n,) joint angles, rad, and return when the arm rests."""
        self._ask("POST", "/api/move", {"q_cmd_rad": np.asarray(q_cmd_rad, dtype=float).tolist()})

    def hang(self, payload_kg: float) -> None:
        """Hang a known mass at the tip, where the bench can."""
        self._ask("POST", "/api/hang", {"payload_kg": payload_kg})

    def capture(self) -> Frame:
        """Take one picture."""
        answer = self._ask("POST", "/api/capture", {})
        image = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR)
        if image is None:
            raise JobError(f"{self.url}: the picture that it sent cannot be read")
        return Frame(np.asarray(image, dtype=np.uint8), float(answer.headers["X-Time-S"]))

    def close(self) -> None:
        """Give the arm back, which detaches it; safe to call twice."""
        self._ended.set()
        if self._lease is None:
            return
        try:
            self._ask("DELETE", "/api/lease")
        except JobError:
            pass  # the server detaches an arm whose mover is silent
        finally:
            self._lease = None

    def __enter__(self) -> RemoteBench:
        self.connect()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _keep_alive(self, ended: threading.Event) -> None:
        while not ended.wait(_HEARTBEAT_S):
            try:
                self._client.get(f"{self.url}/api/state", headers=self._holder())
            except httpx.HTTPError:
                continue  # the next call tells

    def _holder(self) -> dict[str, str]:
        return {} if self._lease is None else {"X-Lease": self._lease}

    def _ask(self, method: str, path: str, body: dict[str, Any] | None = None) -> httpx.Response:
        """Ask once; only what cannot have reached the server is asked again, since a move is not made twice."""
        for attempt in range(1, _ATTEMPTS + 1):
            try:
                answer = self._client.request(method, f"{self.url}{path}", json=body, headers=self._holder())
                break
            except httpx.ConnectError as error:
                if attempt == _ATTEMPTS:
                    raise JobError(f"{self.url}: no bench answers ({error}); is armtwin serve running there?") from None
                time.sleep(_PAUSE_S)
            except httpx.HTTPError as error:
                raise JobError(f"{self.url}: broke off ({type(error).__name__}); run the same command again") from None
        if len(answer.content) > _MOST_BYTES:
            raise JobError(f"{self.url}: answers more than {_MOST_BYTES} bytes")
        if answer.is_success:
            return answer
        said = _detail(answer)
        if answer.status_code in (401, 403, 404, 422):
            raise InputError(f"{self.url}: {said}")
        raise JobError(f"{self.url}: {said}")


def _detail(answer: httpx.Response) -> str:
    try:
        return str(answer.json()["detail"])[:300]
    except (ValueError, KeyError, TypeError):
        return f"answers {answer.status_code}, no served bench of armtwin"
