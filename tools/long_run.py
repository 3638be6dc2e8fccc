#!/usr/bin/env python3
"""Long runs: memory, drift, and kills.

  tools/long_run.py [--steps N]       a box at rest on a plane for N steps (a million): how much memory a recorded frame
                                      keeps, and how far the box has moved
  tools/long_run.py --kills N         the same run in one go, and killed and gone on with N times: the states of all frames
                                      must be the same bits

Fails where memory grows by more than 40 bytes a frame once buffers are full, the box moves by more than a tenth of a millimetre, or a bit differs.
Needs h5py (Debian's python3-h5py) for the kills.
"""

import argparse
import json
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import with_numpy

with_numpy.need("numpy", "h5py")

STEPS_PER_FRAME = 10
MOST_BYTES = 40.0  # that a recorded frame may keep: over 60,000 frames 2.4 MB, by which resident memory varies by itself
MOST_DRIFT = 1e-4  # [m]


def scene(frames, steps_per_frame, response, boxes=1):
    floor = {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}}
    stack = [{"kind": "rigid", "name": f"box{i}", "shape": {"kind": "box", "size": [1, 1, 1]},
              "transform": {"position": [0.1 * i, 0.05 * i, 0.5 + 1.1 * i]}} for i in range(boxes)]
    return {"brim": 1, "name": "long", "frames": frames, "steps_per_frame": steps_per_frame,
            "world": {"response": response}, "bodies": [floor, *stack]}


def resident(pid):
    """[bytes] of a process, or nothing when it has ended."""
    try:
        for line in Path(f"/proc/{pid}/status").read_text().splitlines():
            if line.startswith("VmRSS"):
                return 1024 * int(line.split()[1])
    except OSError:
        pass
    return None


def command(brim, *words):
    return [str(brim), "run", *map(str, words), "--threads", "1"]


def memory_and_drift(brim, folder, steps, response):
    frames = max(20, steps // STEPS_PER_FRAME)
    path = folder / "long.json"
    path.write_text(json.dumps(scene(frames, STEPS_PER_FRAME, response)))
    started = time.time()
    run = subprocess.Popen(command(brim, path, "-o", folder / "run", "--force", "--json"), stdout=subprocess.PIPE, text=True)
    samples = []  # (frame, bytes)
    for line in run.stdout:
        frame = json.loads(line).get("frame")
        if frame is not None and frame % max(1, frames // 250) == 0:
            held = resident(run.pid)
            if held:
                samples.append((frame, held))
    if run.wait() != 0:
        sys.exit(f"long_run: brim ended with {run.returncode}")
    # Highest in the last fifth over highest in the second, where buffers have their size. What HDF5 keeps of an open file
    # grows and is dropped every 8192 frames, several times in each.
    most = lambda fifth: max(held for frame, held in samples if fifth <= 5 * frame / frames <= fifth + 1)
    growth = (most(4) - most(1)) / (3 * frames / 5)
    import h5py
    with h5py.File(folder / "run/run.h5") as file:
        places = file["poses/translation"][:, -1, :]
    drift = float(abs(places[-1] - places[len(places) // 50]).max())
    good = growth <= MOST_BYTES and drift <= MOST_DRIFT
    print(f"{response}: {frames * STEPS_PER_FRAME} steps, {frames} frames in {time.time() - started:.0f} s: {growth:.0f} bytes a frame, "
          f"{samples[-1][1] / 1e6:.0f} MB at the end, drift {1e3 * drift:.4f} mm{'' if good else '  MISSED'}")
    return good


def states(folder):
    import h5py
    with h5py.File(folder / "run.h5") as file:
        return {name: file[name][...].tobytes() for name in
                ("frames/time", "frames/step", "frames/q", "frames/v", "memory/offset", "memory/value")}


def frames_on_disk(folder):
    import h5py
    try:
        with h5py.File(folder / "run.h5") as file:
            return int(file["frames/count"][0])
    except (OSError, KeyError):
        return 0  # killed before its first flush


def killed(brim, folder, kills, response, seed):
    frames = 40 * kills
    path = folder / "killed.json"
    path.write_text(json.dumps(scene(frames, 20, response, boxes=4)))
    straight, broken = folder / "straight", folder / "broken"
    started = time.time()
    subprocess.run(command(brim, path, "-o", straight, "--force", "--quiet"), check=True, stdout=subprocess.DEVNULL)
    whole = time.time() - started
    shutil.rmtree(broken, ignore_errors=True)
    chance = random.Random(seed)
    lives = []  # frames on disk after each kill

    def go_on(seconds):
        """Goes on with the run. @param seconds  after its first new frame it is killed  @return True where it was"""
        how = ["--resume", broken] if (broken / "run.h5").exists() else ["-o", broken]
        run = subprocess.Popen(command(brim, path, *how, "--json"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for line in run.stdout:
            if seconds is not None and json.loads(line).get("frame"):
                time.sleep(seconds)
                run.send_signal(signal.SIGKILL)
                break
        _, errors = run.communicate()
        if run.returncode not in (0, -signal.SIGKILL):
            sys.exit(f"long_run: brim ended with {run.returncode}: {errors}")
        return run.returncode != 0

    # Some are killed before they have written anything, most after some frames; all together they live as long as the run.
    while len(lives) < kills and go_on(chance.uniform(0.0, max(0.2, 2.0 * whole / kills))):
        lives.append(frames_on_disk(broken))
    if len(lives) == kills:
        go_on(None)
    one, other = states(straight), states(broken)
    differ = [name for name in one if one[name] != other[name]]
    print(f"{response}: killed {len(lives)} times, at {len(set(lives))} different frames of {frames}, the last at {max(lives, default=0)}, then "
          f"{'the same bits' if not differ else 'other bits in ' + ', '.join(differ) + '  MISSED'} (seed {seed})", flush=True)
    return not differ and len(lives) > 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--brim", type=Path, default=Path("build/release/brim"))
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--kills", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--response", choices=("constraint", "penalty"), action="append")
    options = parser.parse_args()
    good = True
    with tempfile.TemporaryDirectory(prefix="brim_long_") as folder:
        for response in options.response or ("constraint", "penalty"):
            if options.kills:
                good &= killed(options.brim, Path(folder), options.kills, response, options.seed)
            else:
                good &= memory_and_drift(options.brim, Path(folder), options.steps, response)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
