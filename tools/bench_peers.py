#!/usr/bin/env python3
"""Measures brim beside Bullet and MuJoCo, row by row of the table of docs/performance.md.

    tools/bench_peers.py [--quick] [--write] [--rows NAME ...] [--build build/release]

Times are processor time of one thread, where a row does not say otherwise, and are told in B: one step of Bullet on its pile
of 1,000 boxes and balls at rest (steps of 1/120 s, 10 iterations, no sleeping, one thread), measured before and after each row.
Every measurement is a process of its own with a limit of time; one that fails says so, and the others go on.
Results are kept in out/bench/peers.json, row by row, so that rows can be measured one at a time; --write puts all that is
there into the table of docs/performance.md. --quick starts piles where Bullet's lie at rest and cuts long scenes short.
"""
import argparse
import datetime
import json
import pathlib
import subprocess
import sys
import tempfile
import time

from scene_file import read_scene

ROOT = pathlib.Path(__file__).resolve().parent.parent
STORE = ROOT / "out/bench/peers.json"
PAGE = ROOT / "docs/performance.md"
BEGIN, END = "<!-- made by ./dev bench peers -->\n", "<!-- end of what ./dev bench peers makes -->\n"
UNIT_SCENE = "bench/scenes/boxes_balls_1000.json"
# Seconds of wall time after which a measurement is given up.
LIMIT, QUICK_LIMIT = 900, 90


class Failed(Exception):
    """A measurement that gave no result; says why."""


def execute(command, limit):
    """Standard output of a command that may take limit seconds."""
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        raise Failed(f"no result within {limit:.0f} s") from None
    if done.returncode != 0:
        last = (done.stderr.strip() or "no message").splitlines()[-1]
        raise Failed(f"exit {done.returncode}: {last[:120]}")
    return done.stdout


class Bench:
    def __init__(self, build, quick):
        self.build, self.quick = pathlib.Path(build), quick
        self.limit = QUICK_LIMIT if quick else LIMIT
        self.units = []  # [ms] B as measured, in order
        self.home = STORE.parent
        self.home.mkdir(parents=True, exist_ok=True)

    def peer(self, scene, engine, **options):
        command = [str(self.build / "bench/peers/peer"), scene, engine]
        options = {"budget": 0.6 * self.limit, **options}
        for key, value in options.items():
            name = "--" + key.replace("_", "-")
            command += [name] if value is True else [name, str(value)] if value else []
        return json.loads(execute(command, self.limit))

    def rest(self, scene):
        """File that says where the scene's solids lie in Bullet at its end; made once."""
        file = self.home / f"rest_{pathlib.Path(scene).stem}.json"
        if not file.exists() or file.stat().st_mtime < (ROOT / scene).stat().st_mtime:
            self.peer(scene, "Bullet", save=file)
        return file

    def measure_unit(self):
        self.units.append(self.peer(UNIT_SCENE, "Bullet", start=self.rest(UNIT_SCENE), seconds=0.5, window=0.25)["ms_rest"])


# ---- what the rows measure: each gives a dictionary with "ms" (in the row's own unit of work) and what else is known ----


def pile(scene, steps):
    def measure(bench):
        options = {"start": bench.rest(scene), "seconds": steps / 120.0} if bench.quick else {}
        r = bench.peer(scene, "brim", **options)
        return {"ms": r["ms_rest"], "falling_ms": r["ms_before"], "overlap": r["overlap_mm"],
                "overlap_mean": r["overlap_mean_mm"], "escaped": r["escaped"], "bodies": r["bodies"], "cut": note(r)}
    return measure


def note(r):
    if r.get("started"):
        return f"{r['steps']} steps from where Bullet's pile lies"
    return "" if r["complete"] else f"cut after {r['simulated']:.2f} s of motion"


def pile_peers(scene):
    def measure(bench):
        peers = {}
        for engine in ("Bullet", "MuJoCoCG"):
            if bench.quick and engine != "Bullet":
                continue
            try:
                options = {"start": bench.rest(scene), "seconds": 0.5, "window": 0.25} if bench.quick else {}
                r = bench.peer(scene, engine, **options)
                peers[engine] = {"ms": r["ms_rest"], "overlap": r["overlap_mm"],
                                 "overlap_mean": r["overlap_mean_mm"], "escaped": r["escaped"], "cut": note(r)}
            except Failed as reason:
                peers[engine] = {"failed": str(reason)}
        return peers
    return measure


def drafted(bench, scene):
    """A copy of a scene that asks for "quality": "draft"."""
    text = read_scene(ROOT / scene)
    text.pop("$schema", None)
    text.setdefault("world", {})["quality"] = "draft"
    file = bench.home / f"{pathlib.Path(scene).stem}_draft.json"
    file.write_text(json.dumps(text))
    return file


def cloth(draft=False):
    def measure(bench):
        scene = "bench/scenes/cloth_ball.json"
        r = bench.peer(drafted(bench, scene) if draft else scene, "brim")
        return {"ms": r["ms_rest"], "falling_ms": r["ms_before"], "overlap": r["overlap_mm"], "cut": note(r)}
    return measure


def cloth_peers(bench):
    r = bench.peer("bench/scenes/cloth_ball.json", "Bullet")
    return {"Bullet": {"ms": r["ms_rest"], "overlap": r["overlap_mm"], "cut": note(r)}}


def scaled(r, seconds):
    """[ms a step] Phases are timed by the wall clock: as processor time, were the share that others took alike in all."""
    return seconds / r["steps"] * r["ms_mean"] / r["wall_ms_mean"] * 1e3


def soft(scene, draft=False):
    def measure(bench):
        r = bench.peer(drafted(bench, scene) if draft else scene, "brim")
        return {"ms": r["ms_mean"], "overlap_voxels": r["overlap_voxels"], "cut": note(r),
                "iterations": r["report"]["cg_iterations"] / max(1, r["report"]["solves"])}
    return measure


def slabs_draft(bench):
    r = bench.peer(drafted(bench, "bench/scenes/slabs.json"), "brim", seconds=0.03 if bench.quick else 0.1)
    return {"ms": r["ms_mean"], "cut": note(r), "overlap_voxels": r["overlap_voxels"],
            "iterations": r["report"]["cg_iterations"] / max(1, r["report"]["solves"])}


def slabs(bench):
    r = bench.peer("bench/scenes/slabs.json", "brim", seconds=0.03 if bench.quick else 0.1)
    phases = sum(r["report"]["seconds_" + p] for p in ("presence", "refine", "rasterize", "detect", "respond"))
    common = {"cut": note(r), "overlap_voxels": r["overlap_voxels"]}
    return {"slabs_contact": {"ms": scaled(r, phases), **common},
            "slabs": {"ms": r["ms_mean"], **common,
                      "iterations": r["report"]["cg_iterations"] / max(1, r["report"]["solves"])}}


def dam(bench):
    r = bench.peer("scenes/dam_large.json", "brim", seconds=0.1 if bench.quick else None)
    return {"ms": r["processor_seconds"] / r["simulated"] * 1e3, "overlap_voxels": r["overlap_voxels"],
            "part": bench.quick, "cut": f"first {r['simulated']:.2f} s" if bench.quick else note(r)}


def mixed_stack(bench):
    """Two threads and the wall clock, as a user waits for it."""
    r = bench.peer("scenes/mixed_stack.json", "brim", threads=2, budget=2 * bench.limit,
                   seconds=0.2 if bench.quick else None)
    return {"ms": r["wall_ms_mean"] * r["steps"], "overlap_voxels": r["overlap_voxels"], "part": r["simulated"] < 1.99,
            "cut": f"first {r['simulated']:.2f} s of 2" if r["simulated"] < 1.99 else ""}


def recording(bench):
    with tempfile.TemporaryDirectory() as folder:
        frames = 60 if bench.quick else 360
        execute([str(bench.build / "brim"), "run", "bench/scenes/boxes_balls_200.json", "-o", folder + "/run", "--quiet",
                 "--threads", "1", "--frames", str(frames)], bench.limit)
        summary = json.loads(pathlib.Path(folder, "run/summary.json").read_text())
    step = sum(v for phase, v in summary["seconds"].items() if phase not in ("record", "solve_contact"))
    return {"ms": 1e3 * summary["seconds"]["record"] / frames, "of_step": summary["seconds"]["record"] / step, "cut": ""}


# name, work, brim's figure before [B] and in words, bound [B], aim [B], what a peer takes that Debian does not have, measure
# A bound may also be told over Bullet's time on the same scene: ("Bullet", 1.5).
ROWS = [
    {"name": "boxes_balls_1000", "work": "1,000 boxes and balls in a pit, a step at rest", "before": 70, "bound": 3, "aim": 1,
     "measure": pile("bench/scenes/boxes_balls_1000.json", 12), "peers": pile_peers("bench/scenes/boxes_balls_1000.json")},
    {"name": "boxes_balls_200", "work": "the same, 200", "before": 5.1, "bound": 0.4, "aim": 0.12,
     "measure": pile("bench/scenes/boxes_balls_200.json", 60), "peers": pile_peers("bench/scenes/boxes_balls_200.json")},
    {"name": "boxes_balls_5000", "work": "the same, 5,000", "before": None, "bound": None, "aim": None, "slow": True,
     "measure": pile("bench/scenes/boxes_balls_5000.json", 6), "peers": pile_peers("bench/scenes/boxes_balls_5000.json")},
    {"name": "recording", "work": "recording that pile of 200, a frame", "before": 5.7, "bound": 0.1, "aim": 0.05,
     "measure": recording},
    {"name": "pile", "work": "`pile`: 200 gears, stars and rings, a step at rest", "before_ms": 480, "bound": ("Bullet", 1.5),
     "aim": ("Bullet", 0.7), "measure": pile("scenes/pile.json", 20), "peers": pile_peers("scenes/pile.json")},
    {"name": "cloth_ball", "work": "cloth of 50 x 50 nodes on a ball, a step", "before": 10.6, "bound": 2, "aim": 0.6,
     "elsewhere": "STARK 70 B (steps of 10 ms)", "measure": cloth(), "peers": cloth_peers},
    {"name": "cloth_ball_draft", "work": "the same, `\"quality\": \"draft\"`", "before": 10.6, "bound": 2, "aim": 0.6,
     "measure": cloth(draft=True)},
    {"name": "blocks", "work": "two soft blocks and the floor, a step", "before": 5.6, "bound": 1.2, "aim": 0.5,
     "elsewhere": "STARK 2.5 to 3.1 B", "measure": soft("bench/scenes/blocks.json")},
    {"name": "blocks_draft", "work": "the same, `\"quality\": \"draft\"`", "before": 5.6, "bound": 1.2, "aim": 0.5,
     "measure": soft("bench/scenes/blocks.json", draft=True)},
    {"name": "slabs_contact", "work": "two soft slabs, contact without the solve, a step", "before": 26, "bound": 10, "aim": 4,
     "elsewhere": "IPC Toolkit 23 B, and 133 B for the Hessian", "measure": slabs, "makes": ["slabs_contact", "slabs"]},
    {"name": "slabs", "work": "the same, the whole step", "before": 1210, "bound": 120, "aim": 50, "made_by": "slabs_contact"},
    {"name": "slabs_draft", "work": "the same, `\"quality\": \"draft\"`", "before": 1210, "bound": 120, "aim": 50,
     "measure": slabs_draft},
    {"name": "dam_large", "work": "`dam_large`, a second of motion", "before": 8600, "bound": 4000, "aim": 2000,
     "elsewhere": "SPlisHSPlasH (DFSPH) 2,120 B", "measure": dam},
    {"name": "mixed_stack", "work": "`mixed_stack`, 2 s of motion, two threads, wall clock", "before_ms": 155e3,
     "bound_ms": 30e3, "aim_ms": 12e3, "measure": mixed_stack},
]


# ---- the table ---------------------------------------------------------------------------------------------------


def number(x):
    if x is None:
        return "-"
    if x >= 1000:
        return f"{x:,.0f}"
    return f"{x:.3g}" if x >= 0.001 else f"{x:.1g}"


def milliseconds(ms):
    return f"{number(ms / 1000)} s" if ms >= 10000 else f"{number(ms)} ms"


def limit_ms(row, what, result):
    """[ms] of a bound or aim, or nothing where there is none or its measure is missing."""
    if what + "_ms" in row:
        return row[what + "_ms"]
    limit = row.get(what)
    if isinstance(limit, tuple):
        peer = result.get("peers", {}).get(limit[0], {})
        return limit[1] * peer["ms"] if "ms" in peer else None
    return None if limit is None else limit * result["unit"]


def limit_text(row, what):
    if what + "_ms" in row:
        return milliseconds(row[what + "_ms"])
    limit = row.get(what)
    if isinstance(limit, tuple):
        return f"{limit[1]:g} x {limit[0]}"
    return "-" if limit is None else f"{number(limit)} B"


def overlap_text(r):
    if "failed" in r:
        return "-"
    if "overlap" in r:
        text = f"{max(0.0, r['overlap']):.1f} mm" + (f" (mean {r['overlap_mean']:.1f})" if "overlap_mean" in r else "")
        return text + (f", {r['escaped']} escaped" if r.get("escaped") else "")
    return f"{r['overlap_voxels']:.2f} voxel" if "overlap_voxels" in r else "-"


def peer_text(row, result):
    texts = []
    for engine, r in result.get("peers", {}).items():
        texts.append(f"{engine} {r['failed']}" if "failed" in r else
                     f"{engine} {number(r['ms'] / result['unit'])} B, {overlap_text(r)}" +
                     (f" ({r['cut']})" if r["cut"] else ""))
    return "; ".join(texts + ([row["elsewhere"]] if "elsewhere" in row else [])) or "-"


def row_text(row, result):
    before = milliseconds(row["before_ms"]) if "before_ms" in row else f"{number(row['before'])} B" if row["before"] else "-"
    cells = [row["work"], peer_text(row, result or {}), before]
    if result is None:
        cells += ["not measured", "-", "-", "-", limit_text(row, "bound"), limit_text(row, "aim"), "-"]
    elif "failed" in result:
        cells += [result["failed"], "-", "-", "-", limit_text(row, "bound"), limit_text(row, "aim"), "-"]
    else:
        ms, unit = result["ms"], result["unit"]
        bound, aim = limit_ms(row, "bound", result), limit_ms(row, "aim", result)
        before_ms = row.get("before_ms") or (row["before"] * unit if row["before"] else None)
        met = "-" if bound is None else "aim" if aim and ms <= aim else "bound" if ms <= bound else f"no, {number(ms / bound)} x"
        if result.get("part"):
            before_ms, met = None, "-"
        cells += [milliseconds(ms), f"{number(ms / unit)} B" + (f" ({result['cut']})" if result["cut"] else ""),
                  f"{number(before_ms / ms)} x" if before_ms else "-", overlap_text(result), limit_text(row, "bound"),
                  limit_text(row, "aim"), met]
    return "| " + " | ".join(cells) + " |"


def table(store, names=()):
    """Of the named rows, or of all."""
    lines = ["| work | peer | before | now | in B | quicker | overlap | bound | aim | met |", "|" + "---|" * 10]
    lines += [row_text(row, store.get(row["name"])) for row in ROWS if not names or row["name"] in names]
    growth = [(n, store.get(f"boxes_balls_{n}", {})) for n in (200, 1000, 5000)]
    told = [f"{n:,} bodies: {number(1e3 * r['ms'] / n)} µs" for n, r in growth if "ms" in r]
    units = [r["unit"] for r in store.values() if "unit" in r]
    dates = sorted({r["date"] for r in store.values() if "date" in r})
    lines += ["", f"Time of a step per body: {', '.join(told) or 'not measured'} (bound: within 1.5 x of each other).",
              f"B was {min(units):.2f} to {max(units):.2f} ms, measured before and after each row, {' to '.join(dates[::max(1, len(dates) - 1)])}."
              if units else "B was not measured.", ""]
    return "\n".join(lines)


def write_page(store):
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    PAGE.write_text(before + BEGIN + "\n" + table(store) + "\n" + END + rest.split(END)[1], encoding="utf-8")


# ---- the run -----------------------------------------------------------------------------------------------------


def measure_row(bench, row):
    """Results by name: most rows have one, some two."""
    names = row.get("makes", [row["name"]])
    try:
        result = row["measure"](bench)
    except (Failed, KeyError, ValueError, OSError, ZeroDivisionError) as reason:
        return {name: {"failed": f"failed: {reason}"} for name in names}
    results = result if "makes" in row else {row["name"]: result}
    if "peers" in row:
        try:
            results[row["name"]]["peers"] = row["peers"](bench)
        except (Failed, KeyError, ValueError) as reason:
            results[row["name"]]["peers"] = {"Bullet": {"failed": f"failed: {reason}"}}
    return results


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--quick", action="store_true", help="under five minutes: rest as Bullet finds it, long scenes cut short")
    parser.add_argument("--write", action="store_true", help="write the table of docs/performance.md")
    parser.add_argument("--table", action="store_true", help="measure nothing; print (and write) what is in the store")
    parser.add_argument("--rows", nargs="+", choices=[r["name"] for r in ROWS], help="these alone")
    parser.add_argument("--build", default="build/release")
    options = parser.parse_args()

    # Quick results are no figures for the page: they are kept apart.
    file = STORE.with_name("peers_quick.json") if options.quick else STORE
    store = json.loads(file.read_text()) if file.exists() else {}
    if not options.table:
        bench = Bench(ROOT / options.build, options.quick)
        try:
            bench.measure_unit()
        except Failed as reason:
            sys.exit(f"bench_peers: B cannot be measured: {reason}")
        print(f"B = {bench.units[0]:.2f} ms", flush=True)
        fresh = {}
        for row in ROWS:
            wanted = row["name"] in options.rows if options.rows else not (options.quick and row.get("slow"))
            made = options.rows and set(row.get("makes", [])) & set(options.rows)
            if "made_by" in row or not (wanted or made):
                continue
            start = time.monotonic()
            results = measure_row(bench, row)
            # Before and after each row, as other programs' load on the memory comes and goes.
            try:
                bench.measure_unit()
            except Failed as reason:
                print(f"B could not be measured again: {reason}")
            unit = sum(bench.units[-2:]) / len(bench.units[-2:])
            fresh.update(results)
            for name, r in results.items():
                r["unit"], r["date"] = unit, datetime.date.today().isoformat()
                told = r.get("failed") or (f"{milliseconds(r['ms'])}, {number(r['ms'] / unit)} B, "
                                           f"overlap {overlap_text(r)} {r['cut']}")
                print(f"{name}: {told} ({time.monotonic() - start:.0f} s)", flush=True)
        print(f"B = {', '.join(f'{u:.2f}' for u in bench.units)} ms")
        store.update(fresh)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(store, indent=1))
    print("\n" + table(store, () if options.table else fresh))
    if options.write:
        write_page(store)


if __name__ == "__main__":
    main()
