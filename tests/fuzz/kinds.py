"""Every kind of file that armtwin reads: a good one of each, and what reads it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import tomli_w

from armtwin.calib.camera.images import read_gray
from armtwin.hardware.bench.bench_file import read_bench
from armtwin.models.arm import nominal_arm, read_arm
from armtwin.models.camera_files import nominal_camera, read_camera, write_camera
from armtwin.models.export.onto_urdf import export_onto_urdf
from armtwin.models.export.urdf import urdf_text
from armtwin.models.importers.csv_log import log_of, proposed_mapping, read_table
from armtwin.models.importers.lerobot import read_lerobot
from armtwin.models.importers.mapping import mapping_text, read_mapping
from armtwin.models.importers.sage import read_sage
from armtwin.models.kinematics import Deviation
from armtwin.models.motion.loads import gravity_torques
from armtwin.models.moving_twin import read_moving_twin
from armtwin.models.plan import Plan, read_plan, write_plan
from armtwin.models.recordings.moving_reader import read_moving
from armtwin.models.recordings.reader import read_recording
from armtwin.models.recordings.writer import write_recording
from armtwin.models.servo import NOMINAL_SERVO, read_servo
from armtwin.models.twin import Twin, TwinEffect, read_twin, rebuild, write_twin
from armtwin.models.wanted_path import read_wanted_path
from armtwin.scenarios import sweeps
from armtwin.scenarios.classes.class_file import read_class
from armtwin.scenarios.runner.job import open_job
from armtwin.scenarios.runner.world import build_world
from armtwin.scenarios.scenario import FILES, read_scenario
from armtwin.scenarios.scoring.outcome import Task, kept_outcome
from armtwin.scenarios.scoring.sealing import read_truth
from armtwin.scenarios.sweeps.table import read_sweep
from tests.scenarios.classes.conftest import CLASS
from tests.support.bench import BENCH
from tests.support.recordings import recording


@dataclass(frozen=True)
class Kind:
    """A kind of file: `path` of a good one, and `read`, which takes its folder's path."""

    name: str
    path: Path
    read: Callable[[], Any]


def make_kinds(folder: Path) -> list[Kind]:
    """Write a good file of every kind below `folder` and return what reads each."""
    return [
        *_recordings(folder),
        *_moving(folder),
        *_benches(folder),
        *_twins(folder),
        *_cameras(folder),
        *_imports(folder),
        *_runs(folder),
    ]


def _recordings(folder: Path) -> list[Kind]:
    made = recording()
    rows = slice(0, 12)
    short = replace(
        made,
        sample=made.sample[rows],
        time_s=made.time_s[rows],
        trajectory=made.trajectory[rows],
        q_cmd=made.q_cmd[rows],
        markers_px={name: pixels[rows] for name, pixels in made.markers_px.items()},
        held_out=(),
    )
    rec, plan, path = folder / "rec", folder / "plan.csv", folder / "path.csv"
    write_recording(rec, short)
    write_plan(plan, Plan(short.trajectory, short.q_cmd, np.zeros(12)))
    path.write_text("x_mm;y_mm;theta_F_deg\n-150,5;40;140\n-140;45;141,5\n")
    return [
        Kind("recording.json", rec / "recording.json", lambda: read_recording(rec)),
        Kind("samples.csv", rec / "samples.csv", lambda: read_recording(rec)),
        Kind("plan", plan, lambda: read_plan(plan, 3)),
        Kind("wanted path", path, lambda: read_wanted_path(path, nominal_arm())),
    ]


LINK = '<geom type="capsule" size="0.01" fromto="0 0 0 0.1 0 0"/>'
MODEL = f"""<mujoco><worldbody><body><joint name="shoulder" axis="0 0 1"/>{LINK}
<body pos="0.1 0 0"><joint name="elbow" axis="0 0 1"/>{LINK}</body></body></worldbody></mujoco>"""


def _moving(folder: Path) -> list[Kind]:
    log, twin = folder / "log", folder / "moving.toml"
    log.mkdir()
    arm = {"name": "two", "model": "arm.xml", "joints": ["shoulder", "elbow"]}
    header = {"schema": "armtwin.recording/1", "motion": "moving", "arm": arm, "held_out": ["back"]}
    (log / "recording.json").write_text(json.dumps(header))
    (log / "arm.xml").write_text(MODEL)
    angles = [
        (k, round(0.02 * k, 3), "there" if k < 8 else "back", 0.1 * np.sin(k), 0.1 * np.sin(k - 1)) for k in range(16)
    ]
    rows = [f"{k},{t},{name},{sent:.4f},{sent:.4f},{seen:.4f},{seen:.4f}" for k, t, name, sent, seen in angles]
    joints = "theta1_cmd_rad,theta2_cmd_rad,theta1_meas_rad,theta2_meas_rad"
    (log / "samples.csv").write_text("\n".join([f"sample,time_s,trajectory,{joints}", *rows]) + "\n")
    shutil.copyfile(log / "arm.xml", folder / "arm.xml")
    effect = {"effect": "latency", "joint": 1, "parameters": {"delay_s": 0.05}}
    made = {"schema": "armtwin.twin/1", "motion": "moving", "arm": arm, "effects": [effect]}
    twin.write_text(tomli_w.dumps(made))
    return [
        Kind("recording.json of a log", log / "recording.json", lambda: read_moving(log)),
        Kind("samples.csv of a log", log / "samples.csv", lambda: read_moving(log)),
        Kind("model of a log", log / "arm.xml", lambda: gravity_torques((made_ := read_moving(log)).arm, made_.q_meas)),
        Kind("twin of a moving arm", twin, lambda: read_moving_twin(twin)),
    ]


def _benches(folder: Path) -> list[Kind]:
    bench, arm, servo, scenario = (folder / name for name in ("bench.toml", "arm.toml", "servo.toml", "scenario.toml"))
    group = folder / "class.toml"
    group.write_text(CLASS, "utf-8")
    write_camera(folder / "camera.yaml", nominal_camera())
    bench.write_text(tomli_w.dumps(BENCH))
    arm.write_text('schema = "armtwin.arm/1"\nname = "two"\nlink_lengths_mm = [100.0, 80.0]\ntip_mass_kg = 0.02\n')
    shutil.copyfile(NOMINAL_SERVO, servo)
    shutil.copyfile(FILES / "paper.toml", scenario)
    return [
        Kind("bench", bench, lambda: read_bench(bench)),
        Kind("class", group, lambda: read_class(group)),
        Kind("arm", arm, lambda: read_arm(arm)),
        Kind("servo", servo, lambda: read_servo(servo)),
        Kind("scenario", scenario, lambda: build_world(read_scenario(str(scenario))).compile()),
    ]


def _twins(folder: Path) -> list[Kind]:
    effects = (
        TwinEffect("backlash", 2, None, {"width_rad": 0.02}),
        TwinEffect("joint_slip", 1, None, {"jump_rad": 0.02, "from_sample": 3}),
    )
    deviation = Deviation(np.array([1.5, -2.0, 0.4, 0.1]), np.array([0.02, -0.03, 0.01]))
    twin = Twin(nominal_arm(), deviation, np.array([40.0, -33.0, -80.0]), nominal_camera(), effects)
    path, urdf = folder / "twin.toml", folder / "own.urdf"
    write_twin(path, twin)
    urdf.write_text(urdf_text(twin))
    return [
        Kind("twin", path, lambda: rebuild(read_twin(path)).compile()),
        Kind("urdf", urdf, lambda: export_onto_urdf(twin, urdf, folder / "mended.urdf", tip="marker_f")),
    ]


def _cameras(folder: Path) -> list[Kind]:
    yaml, photo = folder / "camera_info.yaml", folder / "photo.png"
    write_camera(yaml, nominal_camera())
    cv2.imwrite(str(photo), np.kron(np.indices((6, 8)).sum(0) % 2, np.ones((20, 20))).astype(np.uint8) * 255)
    archive, lines, sweep = folder / "camera.npz", folder / "cameras.txt", folder / "sweep.toml"
    np.savez(archive, mtx=nominal_camera().K, dist=np.zeros(5), image_size=[1280, 720])
    lines.write_text("# a camera\n1 OPENCV 1280 720 1002.1 1001.7 640.7 360.1 -0.1 0.05 0.001 -0.0005\n")
    shutil.copyfile(Path(sweeps.__file__).parent / "standing.toml", sweep)
    return [
        Kind("camera", yaml, lambda: read_camera(yaml)),
        Kind("camera of NumPy", archive, lambda: read_camera(archive)),
        Kind("camera of COLMAP", lines, lambda: read_camera(lines)),
        Kind("photograph", photo, lambda: read_gray(photo)),
        Kind("sweep", sweep, lambda: read_sweep(sweep)),
    ]


def _imports(folder: Path) -> list[Kind]:
    log, mapping, sage, lerobot = (folder / name for name in ("log.csv", "mapping.toml", "sage", "lerobot"))
    log.write_text("t_ms;elbow_target_deg;elbow_actual_deg\n0;10;9,5\n20;20;18,5\n40;30;29,5\n")
    mapping.write_text(mapping_text(proposed_mapping(read_table(log))))
    sage.mkdir()
    (sage / "control.csv").write_text('type,timestamp,positions\nC,1,"[0.1, 0.2]"\nC,2,"[0.2, 0.1]"\n')
    (sage / "state_motor.csv").write_text('type,timestamp,positions\nS,1.5,"[0.1, 0.2]"\nS,2.5,"[0.2, 0.1]"\n')
    (lerobot / "meta").mkdir(parents=True)
    info = lerobot / "meta" / "info.json"
    feature = {"dtype": "float32", "names": ["shoulder.pos", "gripper.pos"]}
    table = {"codebase_version": "v3.0", "fps": 30, "data_path": "data/chunk-{chunk_index:03d}/file.parquet"}
    info.write_text(json.dumps({**table, "features": {"observation.state": feature, "action": feature}}))
    return [
        Kind("table to import", log, lambda: log_of(table_ := read_table(log), proposed_mapping(table_))),
        Kind("mapping", mapping, lambda: log_of(read_table(log), read_mapping(mapping))),
        Kind("sage", sage / "state_motor.csv", lambda: read_sage(sage)),
        Kind("lerobot", info, lambda: read_lerobot(lerobot, "deg")),
    ]


def _runs(folder: Path) -> list[Kind]:
    run, sealed = folder / "run", folder / "sealed"
    job = open_job(run, read_scenario("geometric"))
    job.save("camera", {"camera": {"fx": 1.0}})
    (sealed / "score").mkdir(parents=True)
    score = sealed / "score" / "0000.json"
    score.write_text(json.dumps({"version": "x", "recording": "y", "verdict": "none", "causes": []}))
    truth = sealed / "truth.json"
    effect = {"effect": "backlash", "joint": 2, "marker": None, "parameters": {"width_rad": 0.02}, "moved_noises": 9.0}
    world = {
        **{"kind": "single", "effects": [effect], "noise_px": 0.1, "n_poses": 100},
        **{"link_lengths_mm": [120.0, 121.7, 38.0, 6.7], "joint_offsets_rad": [0.0, 0.0, 0.0]},
        "base_in_board_mm": [40.0, -33.0, -80.0],
    }
    truth.write_text(json.dumps({"schema": "armtwin.sealed/1", "options": {}, "worlds": {"0000": world}}))
    return [
        Kind("scenario of a run", run / "scenario.json", lambda: open_job(run, read_scenario("geometric")).scenario),
        Kind("stage of a run", job.stage_path("camera"), lambda: job.done("camera")),
        Kind("truth", truth, lambda: read_truth(sealed)),
        Kind("outcome", score, lambda: kept_outcome(Task(sealed, 0, "x"))),
    ]
