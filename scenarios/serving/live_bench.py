"""The bench that is served: moved, photographed and recorded by one thread, since OpenGL wants one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.bench import Bench
from armtwin.models.errors import InputError, JobError
from armtwin.models.plan import Plan, steps_between
from armtwin.models.twin import Twin
from armtwin.scenarios.marker_finder import marker_finder
from armtwin.scenarios.scenario import EffectTable
from armtwin.scenarios.serving.live_recording import LiveRecording, last_recording, new_recording
from armtwin.scenarios.serving.shot import Miss, Shot
from armtwin.scenarios.serving.sources import BenchSource
from armtwin.scenarios.serving.twin_arm import TwinArm
from armtwin.sim.bench import SimulatedBench

Array = NDArray[np.float64]


class LiveBench:
    """A source's bench with its twin and its recording; call it from one thread only.

    Args:
        source: what is served.
        recordings: folder in which every recording gets a folder of its own.

    """

    def __init__(self, source: BenchSource, recordings: Path) -> None:
        self.source = source
        self.described = source.description
        self.faults: tuple[EffectTable, ...] = ()
        self.shot: Shot | None = None
        self.misses: list[Miss] = []
        self.twin = TwinArm.drawn(self.described.arm, self.described.camera, self.described.arm_plane_z_mm)
        self._recordings = recordings
        self._recording = None if source.terms is None else last_recording(recordings, source)
        self._find = marker_finder(self.described.arm, self.described.camera, self.described.arm_plane_z_mm)
        self._bench: Bench | None = None
        self._q: Array | None = None
        self._payload_kg = 0.0
        self._pictures = 0

    @property
    def connected(self) -> bool:
        """Whether the bench is open."""
        return self._bench is not None

    @property
    def notes(self) -> tuple[str, ...]:
        """What the open bench says of its camera."""
        return self._open().notes

    @property
    def clock_origin_s(self) -> float | None:
        """Unix time that the open bench's clock counts from, where it counts this world's."""
        return self._open().clock_origin_s

    @property
    def q_cmd(self) -> Array | None:
        """(n,) last command, rad; None before the first."""
        return self._q

    @property
    def poses(self) -> int:
        """Poses in the present recording."""
        return 0 if self._recording is None else len(self._recording)

    @property
    def pictures_left(self) -> int | None:
        """How many pictures may still be taken; None: as many as one likes."""
        terms = self.source.terms
        return None if terms is None else max(0, terms.pictures() - self.poses)

    def connect(self) -> None:
        """Open the bench anew, its arm as it stands when it is switched on."""
        self.close()
        bench = self.source.make(self.faults, self.poses)
        try:
            bench.connect()
        except BaseException:
            bench.close()
            raise
        self._bench, self._q = bench, None

    def move(self, q_cmd: Array) -> None:
        """Command (n,) rad; raises `InputError` outside the limits, `JobError` where the bench is not open."""
        bench = self._open()
        q = np.asarray(q_cmd, dtype=float)
        self.described.limits.check_pose(q, "move")
        if self._q is not None:
            self.described.limits.check_step(self._q, q, "move")
        self._tell({"what": "move", "q_cmd_rad": q.tolist()})
        bench.move(q)
        self._q = q
        self.twin.move(q)

    def approach(self, q_cmd: Array) -> None:
        """Go to (n,) rad in as many steps as the limits want."""
        q = np.asarray(q_cmd, dtype=float)
        self.described.limits.check_pose(q, "move")
        if self._q is None:
            self.move(q)
            return
        for step in steps_between(self._q, q, self.described.limits.max_step_rad):
            self.move(step)

    def hang(self, payload_kg: float) -> None:
        """Hang a mass at the tip; raises `InputError` where nothing can do it."""
        self._open().hang(payload_kg)
        self._payload_kg = payload_kg
        self._tell({"what": "hang", "payload_kg": payload_kg})

    def capture(self, keep: str | None = None) -> Shot:
        """Take a picture and find its markers; keep the pose in the recording as one of trajectory `keep`."""
        bench = self._open()
        if self._q is None:
            raise JobError("the arm was not moved yet; move it first")
        if self.pictures_left == 0:
            raise JobError("all pictures are taken; diagnose what you have, hand in, or ask for more")
        if self.source.terms is not None:
            keep = keep or "poses"
        frame = bench.capture()
        measured = dict(self._find(frame.image, self._q))
        truth = bench.body_poses() if isinstance(bench, SimulatedBench) else {}
        self._pictures += 1
        shot = Shot(
            number=self._pictures,
            frame=frame,
            q_cmd=self._q,
            measured_px=measured,
            twin_px=self.twin.markers_px(self.described.camera, self.described.arm_plane_z_mm, measured),
            twin_bodies=self.twin.bodies(),
            true_bodies=truth,
        )
        if keep is not None:
            with self._losing_a_pose():
                self._record().add(shot, keep, self._payload_kg)
            seen = self.described
            self.misses.append(shot.miss(self.twin.name, seen.arm, seen.camera, seen.arm_plane_z_mm))
        if self.source.terms is not None:  # what was paid for is on disk before it is shown
            with self._losing_a_pose():
                self._record().wait()
            self._tell({"what": "picture", "number": self.poses})
        self.shot = shot
        return shot

    def run(self, plan: Plan, number: int) -> None:
        """Take pose `number` of a plan and keep it."""
        if plan.payload_kg[number] != self._payload_kg:
            self.hang(float(plan.payload_kg[number]))
        self.approach(plan.q_cmd[number])
        self.capture(keep=str(plan.trajectory[number]))

    def put_faults(self, faults: Sequence[EffectTable]) -> None:
        """Put these faults into the bench, instead of those that are in it; it is opened anew at the same pose.

        Raises `InputError` where the bench takes none or one cannot be built; the old ones then stay.
        """
        if not self.source.takes_faults:
            raise InputError("faults: only a simulated bench takes them; this one has what it has")
        before, q = self.faults, self._q
        self.faults = tuple(faults)
        try:
            self.connect()
            if q is not None:
                self.approach(q)
        except BaseException:
            self.faults = before
            self.connect()
            raise

    def set_twin(self, name: str, twin: Twin) -> None:
        """Let another twin stand beside the bench from now on."""
        self.twin = self.twin.replaced_by(name, twin)
        if self.shot is not None:
            px = self.twin.markers_px(self.described.camera, self.described.arm_plane_z_mm, self.shot.measured_px)
            self._pictures += 1
            self.shot = replace(self.shot, number=self._pictures, twin_px=px, twin_bodies=self.twin.bodies())

    def begin_recording(self) -> None:
        """Begin an empty recording; the last one stays on disk."""
        if self.source.terms is not None:
            raise InputError("recording: every picture of this robot is kept in one recording")
        self._end_recording()

    def recording_folder(self) -> Path:
        """Where the present recording stands; raises `JobError` while it is empty."""
        if self._recording is None:
            raise JobError("nothing is recorded yet; run a trajectory or keep a pose first")
        with self._losing_a_pose():
            self._recording.wait()
        return self._recording.folder

    def shut_down(self) -> None:
        """Close the bench and the recording for good."""
        self.close()
        self._end_recording()

    def close(self) -> None:
        """Detach the servos and free the camera; safe to call twice."""
        if self._bench is not None:
            self._bench.close()
        self._bench = None

    def _end_recording(self) -> None:
        if self._recording is not None:
            self._recording.close()
        self._recording = None
        self.misses.clear()

    @contextmanager
    def _losing_a_pose(self) -> Iterator[None]:
        """Forget how far off the last pose was where it turns out that it cannot be kept."""
        try:
            yield
        except JobError:
            del self.misses[-1:]
            raise

    def _tell(self, command: dict[str, Any]) -> None:
        if self.source.terms is not None:
            self.source.terms.told(command)

    def _open(self) -> Bench:
        if self._bench is None:
            raise JobError("the bench is not open (its last mover fell silent or closed it); connect first")
        return self._bench

    def _record(self) -> LiveRecording:
        if self._recording is None:
            self._recording = new_recording(self._recordings, self.source)
        return self._recording
