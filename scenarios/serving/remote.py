"""A bench at the other end of an HTTP address, by the four methods that every bench has.

with RemoteBench("http://127.0.0.1:8000/", token) as bench:
    bench.move(q_cmd_rad)
    frame = bench.capture()
"""

from __future__ import annotations

import threading
import time
from functools import cached_property
from typing import Any, Self

import cv2
import httpx
import numpy as np
from numpy.typing import NDArray

from armtwin.models.arm import arm_from_table
from armtwin.models.bench import BenchDescription, Frame
from armtwin.models.errors import InputError, JobError
from armtwin.models.joint_limits import JointLimits
from armtwin.models.recordings.reader import camera_from_table
from armtwin.models.validation import ArmTable, CameraTable, check

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
        self._opened: dict[str, Any] = {}

    @cached_property
    def description(self) -> BenchDescription:
        """What the server says of its bench; asked for once."""
        said = self.info()
        header, joints = said["recording_header"], said["joints"]
        low, high = (np.array([joint[key] for joint in joints]) for key in ("min_rad", "max_rad"))
        return BenchDescription(
            kind="remote",
            arm=arm_from_table(check(ArmTable, header["arm"], self.url)),
            camera=camera_from_table(check(CameraTable, header["camera"], self.url)),
            arm_plane_z_mm=float(header["arm_plane_z_mm"]),
            limits=JointLimits(low, high, float(said["max_step_rad"])),
            hangs_loads=bool(said["hangs_loads"]),
            actuation=said["actuation"],
        )

    @property
    def notes(self) -> tuple[str, ...]:
        """What the bench at the other end said of its camera when it was opened."""
        return tuple(self._opened.get("notes", ()))

    @property
    def detached(self) -> bool:
        """Whether the arm was given back, on which the server detaches it."""
        return self._lease is None

    @property
    def clock_origin_s(self) -> float | None:
        """Unix time, by the server's clock, that the times count from."""
        return self._opened.get("clock_origin_s")

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
        self._opened = self._ask("POST", "/api/connect").json()

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
        given = answer.headers.get("X-Commanded-S")
        times = float(answer.headers["X-Time-S"]), None if given is None else float(given)
        return Frame(np.asarray(image, dtype=np.uint8), *times)

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

    def __enter__(self) -> Self:
        self.connect()
        return self

    def __exit__(self, *error: object) -> None:
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
