"""What goes over the wire: the JSON of requests and answers, bounded and documented by its types."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from armtwin.models.validation import Strict

Angle = Annotated[float, Field(ge=-7.0, le=7.0, allow_inf_nan=False)]


class MoveRequest(Strict):
    """Joint angles to go to, rad; `approach`: in as many steps as the bench's largest step wants."""

    q_cmd_rad: Annotated[list[Angle], Field(min_length=1, max_length=6)]
    approach: bool = False


class CaptureRequest(Strict):
    """`keep`: the trajectory under which the pose is kept in the recording; left out, it is only looked at."""

    keep: Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,40}$")] | None = None


class HangRequest(Strict):
    """A mass at the tip, kg."""

    payload_kg: Annotated[float, Field(ge=0, le=5)]


class Fault(Strict):
    """One effect of the catalogue, where it sits, and its injector's parameters."""

    name: Annotated[str, Field(max_length=60)]
    joint: int | None = None
    marker: Annotated[str, Field(max_length=10)] | None = None
    parameters: dict[str, Any] = Field(default_factory=dict, max_length=30)


class FaultsRequest(Strict):
    """Every fault that is to be in the bench."""

    faults: Annotated[list[Fault], Field(max_length=20)]


class JobRequest(Strict):
    """What to do with the recording."""

    kind: Literal["calibrate", "diagnose"]


class PlanRequest(Strict):
    """A plan to run: one of the bench's by name, all of them, or a job's next experiment."""

    name: Annotated[str, Field(max_length=60)] | None = None
    job: int | None = None


class Connected(Strict):
    """How the bench was opened: what a person should know of its camera, and the Unix time its clock counts from."""

    notes: list[str]
    clock_origin_s: float | None


class JointInfo(Strict):
    """A joint and its limits, rad."""

    min_rad: float
    max_rad: float


class BenchInfo(Strict):
    """What does not change while the server runs."""

    kind: str
    title: str
    version: str
    arm: dict[str, Any]
    joints: list[JointInfo]
    max_step_rad: float
    image_width: int
    image_height: int
    marker_names: list[str]
    link_lengths_mm: list[float]
    start_rad: list[float]
    plans: dict[str, int]
    takes_faults: bool
    hangs_loads: bool
    actuation: dict[str, Any]
    recording_header: dict[str, Any]
    tools: list[str]


class JobInfo(Strict):
    """A job as it stands."""

    number: int
    kind: str
    state: str
    said: str
    headline: str
    seconds: float
    results: list[str]


class State(Strict):
    """What changes: asked for about once a second."""

    version: str
    connected: bool
    held: bool
    yours: bool
    q_cmd_rad: list[float] | None
    picture: int
    poses: int
    twin: str
    faults: list[Fault]
    running: str | None
    progress: float
    said: str
    jobs: list[JobInfo]
    pictures_left: int | None = None


class ShotInfo(Strict):
    """What a picture shows: places in pixels and mm, bodies as (4, 4) placements in the robot frame, mm."""

    number: int
    time_s: float
    q_cmd_rad: list[float]
    poses: int
    measured_px: dict[str, list[float]]
    twin_px: dict[str, list[float]]
    miss_mm: dict[str, list[float]]
    twin_bodies: dict[str, list[list[float]]]
    true_bodies: dict[str, list[list[float]]]
