"""Everything that goes on at a served bench: its thread, who moves it, the plan that runs, the jobs beside it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

from armtwin.models.errors import ArmtwinError, InputError, JobError
from armtwin.models.plan import Plan, plan_of, read_plan
from armtwin.models.twin import read_twin
from armtwin.scenarios.scenario import EffectTable
from armtwin.scenarios.serving.jobs import Job, Jobs
from armtwin.scenarios.serving.lease import MoverLease
from armtwin.scenarios.serving.live_bench import LiveBench
from armtwin.scenarios.serving.sources import BenchSource

Result = TypeVar("Result")

# Calls that wait for the bench; one mover at a time needs no more.
MOST_WAITING = 16
ALL_PLANS = "all"
_WATCH_S = 1.0


class BusyError(JobError):
    """More was asked of the bench than it can do now."""


class Visit:
    """A served bench from its start to its end; every method may be called from any thread.

    Several visits may share a `thread`, which then does what all of them ask of their benches, and `slots` for jobs.
    """

    def __init__(
        self,
        source: BenchSource,
        out: Path,
        thread: ThreadPoolExecutor | None = None,
        slots: threading.BoundedSemaphore | None = None,
    ) -> None:
        self.source = source
        self.lease = MoverLease()
        self.live = LiveBench(source, out / "recordings")
        self.jobs = Jobs(out / "jobs", self._take_over, slots)
        self.running: str | None = None
        self.progress = 0.0
        self.said = ""
        self._shared = thread is not None
        self._thread = thread or ThreadPoolExecutor(1, thread_name_prefix="bench")
        self._paced = None if source.terms is None else ThreadPoolExecutor(1, thread_name_prefix="paced")
        self._waiting = threading.BoundedSemaphore(MOST_WAITING)
        self._stop_plan = threading.Event()
        self._ended = threading.Event()
        threading.Thread(target=self._watch, name="watch", daemon=True).start()

    def submit(self, call: Callable[[], Result]) -> Future[Result]:
        """Let the bench's thread do `call` in its turn; raises `BusyError` where too many wait already."""
        if not self._waiting.acquire(blocking=False):
            raise BusyError("the bench has too much to do; ask again when it has caught up")
        future = self._thread.submit(call) if self._paced is None else self._paced.submit(self._in_pace, call)
        future.add_done_callback(lambda _: self._waiting.release())
        return future

    def _in_pace(self, call: Callable[[], Result]) -> Result:
        """Do `call` on the bench's thread and answer in the bench's pace; the visit's next call waits for that too."""
        try:
            return self._thread.submit(call).result()
        finally:
            if self.source.terms is not None:
                self.source.terms.pace.pay()

    def check_idle(self) -> None:
        """Raise `BusyError` while a plan runs."""
        if self.running is not None:
            raise BusyError(f"'{self.running}' is running; wait for its end, or stop it")

    def start_plan(self, name: str | None, job: int | None) -> None:
        """Run a plan of the bench, all of them, or a job's next experiment, and keep every pose of it."""
        self.check_idle()
        shown, plan = self._plan(name, job)
        self._stop_plan.clear()
        self.running, self.progress = shown, 0.0
        threading.Thread(target=self._run, args=(shown, plan), name="plan", daemon=True).start()

    def stop_plan(self) -> None:
        """End the plan after the pose that is being taken."""
        self._stop_plan.set()

    def diagnose(self, kind: str) -> Job:
        """Begin a job on what is recorded; raises `InputError` where the bench's terms do not allow it."""
        terms = self.source.terms
        if terms is not None and kind not in terms.tools:
            raise InputError(f"kind: '{kind}' is not allowed here; {', '.join(terms.tools) or 'no tool'} is")
        folder = self.submit(self.live.recording_folder).result()
        return self.jobs.start("calibrate" if kind == "calibrate" else "diagnose", folder)

    def put_faults(self, faults: Sequence[EffectTable]) -> None:
        """Put faults into a simulated bench; waits until it stands as it stood."""
        self.check_idle()
        self.submit(lambda: self.live.put_faults(faults)).result()

    def close(self) -> None:
        """Detach the arm and end what runs."""
        self._ended.set()
        self._stop_plan.set()
        self.jobs.close()
        if self._paced is not None:
            self._paced.shutdown(cancel_futures=True)
        self._thread.submit(self.live.shut_down).result()
        if not self._shared:
            self._thread.shutdown()
        self.source.release()

    def _plan(self, name: str | None, job: int | None) -> tuple[str, Plan]:
        if job is not None:
            path = self.jobs.get(job).folder / "next_experiment.csv"
            if not path.is_file():
                raise InputError(f"job: job {job} proposes no experiment")
            return "next experiment", read_plan(path, self.source.description.arm.n_joints)
        plans = self.source.plans
        if name == ALL_PLANS:
            return name, plan_of({key: plan.q_cmd for key, plan in plans.items()})
        if name not in plans:
            raise InputError(f"name: no plan '{name}'; this bench has {', '.join([*plans, ALL_PLANS])}")
        return name, plans[name]

    def _run(self, shown: str, plan: Plan) -> None:
        self.said = ""
        try:
            for number in range(len(plan)):
                if self._stop_plan.is_set():
                    self.said = f"{shown} was stopped after {number} poses"
                    return
                self.submit(lambda number=number: self.live.run(plan, number)).result()  # type: ignore[misc]
                self.progress = (number + 1) / len(plan)
            self.said = f"{shown}: {len(plan)} poses are recorded"
        except ArmtwinError as error:
            self.said = f"{shown} broke off: {error}"
        except Exception as error:  # noqa: BLE001  # a defect of ours: told where somebody waits for the plan
            self.said = f"{shown} broke down ({type(error).__name__}: {error}); report it"
        finally:
            self.running = None

    def _take_over(self, job: Job) -> None:
        """Let the twin that a job found stand beside the bench from now on."""
        path = job.folder / "twin.toml"
        if path.is_file():
            twin = read_twin(path)
            self.submit(lambda: self.live.set_twin({"calibrate": "calibrated", "diagnose": "extended"}[job.kind], twin))

    def _watch(self) -> None:
        """Detach an arm whose mover is not heard any more."""
        while not self._ended.wait(_WATCH_S):
            if self.lease.lapsed:
                self._stop_plan.set()
                self.lease.end()
                self._thread.submit(self.live.close)
