"""ROS 2 bags in MCAP: joint states beside what was commanded, by the messages' own stamps.

Commands come from a controller's state (`reference` and `feedback`; older: `desired` and `actual`), or from a topic of
commands beside `sensor_msgs/JointState`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from armtwin.models.errors import InputError, JobError, nearest, shown
from armtwin.models.importers.clocks import on_clock_of
from armtwin.models.importers.log import MOST_ROWS, JointLog, checked, in_force

Array = NDArray[np.float64]

_STATE = "sensor_msgs/msg/JointState"
_CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
_TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
_NUMBERS = "std_msgs/msg/Float64MultiArray"
_COMMANDS = (_STATE, _TRAJECTORY, _NUMBERS)


@dataclass(eq=False)
class _Series:
    names: tuple[str, ...]
    time_ns: list[int] = field(default_factory=list)
    values: list[list[float]] = field(default_factory=list)

    def add(self, time_ns: int, values: list[float], topic: str) -> None:
        if len(values) != len(self.names):
            raise InputError(f"{topic}: {len(values)} values for {len(self.names)} joints")
        if len(self.time_ns) >= MOST_ROWS:
            raise InputError(f"{topic}: more than {MOST_ROWS} messages")
        self.time_ns.append(time_ns)
        self.values.append(values)


def read_mcap(path: Path, state: str | None = None, command: str | None = None) -> JointLog:
    """Read a bag; `state` and `command` name the topics where more than one would do.

    Raises `InputError` where topics are missing, cannot be told apart or have other joints, `JobError` where the
    library is not installed.
    """
    path = _file_of(path)
    topics = _topics(path)
    controllers = [name for name, kind in topics.items() if kind == _CONTROLLER]
    if state is None and command is None and len(controllers) == 1:
        return _from_controller(path, controllers[0])
    state = _chosen(path, topics, state, (_STATE,), "--state-topic", "joint_states")
    command = _chosen(path, topics, command, _COMMANDS, "--command-topic", None, without=state)
    seen: _Series | None = None
    sent: _Series | None = None
    for topic, message, time_ns in _messages(path, [state, command]):
        if topic == state:
            seen = _Series(tuple(message.name)) if seen is None else seen
            seen.add(time_ns, _in_order(message.name, message.position, seen.names, topic), topic)
        elif seen is not None:
            names, values = _command(message, seen.names)
            sent = _Series(seen.names) if sent is None else sent
            sent.add(time_ns, _in_order(names, values, seen.names, topic), topic)
    if seen is None or sent is None:
        empty = state if seen is None else command
        raise InputError(f"{path.name}: topic '{shown(empty)}' has no messages; see --state-topic, --command-topic")
    start = seen.time_ns[0]
    seen_s, sent_s = _seconds(seen, start), _seconds(sent, start)
    notes = [f"measured: {state}", f"commanded: {command} ({topics[command]})"]
    if topics[command] == _NUMBERS:
        notes.append(f"{command} carries no stamp: its times are those of the log, later by what the bus took")
    sent_s, moved = on_clock_of(seen_s, np.array(seen.values), sent_s, np.array(sent.values), path.name)
    q_cmd, given, has = in_force(sent_s, np.array(sent.values), seen_s)
    notes += [] if moved is None else [moved]
    if not has.all():
        notes.append(f"{int((~has).sum())} rows before the first command are left out")
    return checked(
        JointLog(
            joints=seen.names,
            time_s=seen_s[has],
            trajectory=np.full(int(has.sum()), path.stem or "bag"),
            q_cmd=q_cmd[has],
            q_meas=np.array(seen.values)[has],
            commanded_s=given[has],
            notes=tuple(notes),
        ),
        path.name,
    )


def _file_of(path: Path) -> Path:
    """Return the bag's file; a bag that `ros2 bag record` made is a folder with it and metadata.yaml."""
    if not path.is_dir():
        return path
    files = sorted(path.glob("*.mcap"))
    if len(files) != 1:
        raise InputError(f"{path}: {len(files)} .mcap files in the folder, one is wanted; name one of them")
    return files[0]


def _from_controller(path: Path, topic: str) -> JointLog:
    series: _Series | None = None
    n = 0
    for _, message, time_ns in _messages(path, [topic]):
        fields = ("reference", "feedback") if hasattr(message, "reference") else ("desired", "actual")
        names = tuple(message.joint_names)
        n = len(names)
        series = _Series((*names, *names)) if series is None else series
        both = [list(getattr(message, name).positions) for name in fields]
        series.add(time_ns, [*both[0], *both[1]], topic)
    if series is None:
        raise InputError(f"{path.name}: topic '{shown(topic)}' has no messages")
    values = np.array(series.values)
    return checked(
        JointLog(
            joints=series.names[:n],
            time_s=_seconds(series, series.time_ns[0]),
            trajectory=np.full(len(values), path.stem or "bag"),
            q_cmd=values[:, :n],
            q_meas=values[:, n:],
            notes=(f"commanded and measured: {topic}, the controller's reference and feedback",),
        ),
        path.name,
    )


def _command(message: Any, joints: tuple[str, ...]) -> tuple[list[str], list[float]]:
    if hasattr(message, "points"):  # the goal of a trajectory
        points = message.points
        return list(message.joint_names), list(points[-1].positions) if points else []
    if hasattr(message, "data"):
        return list(joints), list(message.data)
    return list(message.name), list(message.position)


def _in_order(names: Any, values: Any, joints: tuple[str, ...], topic: str) -> list[float]:
    by_name = dict(zip(names, values, strict=False))
    for name in joints:
        if name not in by_name:
            raise InputError(
                f"{topic}: a message has no joint '{shown(name)}'; it has {', '.join(map(shown, by_name))}"
            )
    return [float(by_name[name]) for name in joints]


def _chosen(
    path: Path,
    topics: dict[str, str],
    said: str | None,
    kinds: tuple[str, ...],
    option: str,
    usual: str | None,
    without: str | None = None,
) -> str:
    if said is not None:
        if said not in topics:
            raise InputError(f"{option}: {path.name} has no topic '{shown(said)}'{nearest(said, topics)}")
        if topics[said] not in kinds:
            raise InputError(f"{option}: '{shown(said)}' is {shown(topics[said])}; {', '.join(kinds)} can be read")
        return said
    found = [name for name, kind in topics.items() if kind in kinds and name != without]
    named = [name for name in found if usual is not None and name.rsplit("/", 1)[-1] == usual]
    if len(named or found) == 1:
        return (named or found)[0]
    listed = ", ".join(f"{shown(name)} ({shown(kind)})" for name, kind in topics.items()) or "none"
    what = "no topic" if not found else f"{len(found)} topics"
    raise InputError(f"{path.name}: {what} can be meant; name one with {option}. Its topics: {listed}")


def _topics(path: Path) -> dict[str, str]:
    if not path.is_file():
        raise InputError(f"{path}: no such file; a bag's .mcap file is wanted (it lies in the bag's folder)")
    make_reader = _library()[0]
    with path.open("rb") as stream, _readable(path):
        summary = make_reader(stream).get_summary()
        if summary is None:
            raise InputError(f"{path.name}: has no summary, it was cut off; mend it with `mcap recover`")
        kinds = {number: schema.name for number, schema in summary.schemas.items()}
        return {channel.topic: kinds.get(channel.schema_id, "") for channel in summary.channels.values()}


def _messages(path: Path, topics: list[str]) -> Iterator[tuple[str, Any, int]]:
    """Yield topic, message and its own stamp, ns; the log's time where it has none."""
    make_reader, decoder = _library()
    with path.open("rb") as stream, _readable(path):
        reader = make_reader(stream, decoder_factories=[decoder()])
        for _, channel, record, message in reader.iter_decoded_messages(topics=topics):
            stamp = getattr(getattr(message, "header", None), "stamp", None)
            own = 0 if stamp is None else int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)
            yield channel.topic, message, own or int(record.log_time)


class _readable:  # noqa: N801  used as a block
    """Turn what the library raises of a broken file into one line."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        from mcap.exceptions import McapError

        if isinstance(error, McapError | ValueError | EOFError | OSError) and not isinstance(error, InputError):
            reason = (str(error).splitlines() or [type(error).__name__])[0][:120]
            raise InputError(f"{self._path.name}: no MCAP file that can be read ({shown(reason)})") from None


def _library() -> tuple[Any, Any]:
    try:
        from mcap.reader import make_reader
        from mcap_ros2.decoder import DecoderFactory
    except ModuleNotFoundError as error:
        raise JobError(f"{error.name} is not installed, which reads ROS 2 bags; install armtwin[import]") from None
    return make_reader, DecoderFactory


def _seconds(series: _Series, start_ns: int) -> Array:
    return 1e-9 * np.array([time - start_ns for time in series.time_ns], dtype=float)
