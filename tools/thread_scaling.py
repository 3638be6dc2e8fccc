#!/usr/bin/env python3
"""Measures how much quicker a scene steps with more threads, phase by phase.

    tools/thread_scaling.py [SCENE[:FRAMES] ...] [--threads 1 2 4 8 16] [--program build/release/brim] [--repeat N] [--keep DIR]

Wall clock of the steps, recording not counted; the quickest of N runs. Run it where nothing else runs. Without scenes: those
of docs/performance.md. A speed-up s of n threads leaves a serial part of (n/s - 1)/(n - 1) (Amdahl's law), whatever it is made of.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENES = [
    "scenes/mixed_stack.json:48",
    "scenes/pile.json:120",
    "scenes/dam_large.json:20",
    "scenes/grid_float.json:20",
    "bench/scenes/slabs.json:6",
    "bench/scenes/cloth_ball.json:60",
    "bench/scenes/boxes_balls_5000.json:120",
]
# Phases as the summary names them. It counts "solve_contact" within "solve".
PHASES = ["presence", "refine", "rasterize", "detect", "respond", "solve", "advance"]


def step_seconds(program, scene, frames, threads, folder):
    """Seconds of wall clock of each phase of one run."""
    command = [program, "run", scene, "--threads", str(threads), "-o", folder, "--force", "--quiet"]
    if frames:
        command += ["--frames", frames]
    subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    seconds = json.loads((pathlib.Path(folder) / "summary.json").read_text())["seconds"]
    return {name: seconds[name] for name in PHASES}


def measure(program, scene, frames, counts, repeat, keep):
    """Per number of threads, the phases of the quickest run."""
    best = {}
    for threads in counts:
        runs = []
        for _ in range(repeat):
            with tempfile.TemporaryDirectory() as folder:
                runs.append(step_seconds(program, scene, frames, threads, folder))
        best[threads] = min(runs, key=lambda run: sum(run.values()))
    if keep:
        (keep / (pathlib.Path(scene).stem + ".json")).write_text(json.dumps(best, indent=1))
    return best


def table(name, best):
    """Lines of the scene's table, in Markdown."""
    counts = list(best)
    one, most = best[counts[0]], counts[-1]
    total = {n: sum(best[n].values()) for n in counts}
    lines = [f"| {name} | " + " | ".join(f"{n} thread{'s' * (n > 1)}" for n in counts) + " |", "|---" * (len(counts) + 1) + "|"]

    def row(title, of):
        cells = [f"{of(counts[0]):.2f} s"] + [f"{of(counts[0]) / max(of(n), 1e-9):.2f} x" for n in counts[1:]]
        lines.append(f"| {title} | " + " | ".join(cells) + " |")

    row("step", lambda n: total[n])
    for phase in PHASES:
        if one[phase] > 0.01 * total[counts[0]] or best[most][phase] > 0.01 * total[most]:
            row(phase, lambda n, phase=phase: best[n][phase])
    if len(counts) > 1:
        serial = [(n / (total[counts[0]] / total[n]) - 1.0) / (n - 1.0) for n in counts[1:]]
        lines.append("| serial part | - | " + " | ".join(f"{100 * s:.1f} %" for s in serial) + " |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="*", default=SCENES, metavar="SCENE[:FRAMES]")
    parser.add_argument("--threads", type=int, nargs="+", default=None, help="1 first; default 1, 2, 4 ... up to the cores")
    parser.add_argument("--program", default=str(ROOT / "build/release/brim"))
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path, help="folder for what was measured, a file a scene")
    options = parser.parse_args()
    counts = options.threads or [n for n in (1, 2, 4, 8, 16, 32) if n <= (os.cpu_count() or 1)]
    if counts[0] != 1 or min(counts) < 1 or options.repeat < 1:
        parser.error(f"--threads {counts}, --repeat {options.repeat}: 1 must come first, as all else is compared with it; none may be less")
    if options.keep:
        options.keep.mkdir(parents=True, exist_ok=True)
    for item in options.scenes:
        scene, _, frames = item.partition(":")
        try:
            best = measure(options.program, scene, frames, counts, options.repeat, options.keep)
        except (subprocess.CalledProcessError, OSError) as error:
            sys.exit(f"{scene}: {error}")
        print("\n".join(table(pathlib.Path(scene).stem, best)), end="\n\n", flush=True)


if __name__ == "__main__":
    main()
