#!/usr/bin/env python3
"""Runs scenes and holds each to its expect block: ./dev scenes [NAME...].

    tools/run_scenes.py                     every file of scenes/, the tables of pairs and the examples, two at a time
    tools/run_scenes.py bounce box_stack    these alone
    tools/run_scenes.py --fast              those of scenes/fast.txt
    tools/run_scenes.py --list              names, one a line

Prints a line for each when it ends: its processor time, the bounds that are met, those that are missed as their known_miss says, and
those that surprise. Exit code 1 where a bound is missed that is not known to be, where a known miss holds, and where a run
does not come to its end. Each run uses one thread; results lie in out/scenes/NAME. Scenes of scenes/starts.txt are run from several
starts, and the median of what is chaotic in them is held to its bound.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time

from scene_file import read_scene

ROOT = pathlib.Path(__file__).resolve().parent.parent
FAST = ROOT / "scenes" / "fast.txt"
STARTS = ROOT / "scenes" / "starts.txt"
PAIRS = ROOT / "scenes" / "pairs"
PAIR_TABLES = {"penalty": ["--response", "penalty"], "constraint": ["--response", "constraint"],
               "rest": ["--world", "rest"], "fine": ["--world", "fine"], "levels": ["--world", "levels"]}
PAIR_TABLES |= {f"user_{table}": PAIR_TABLES[table] for table in ("penalty", "constraint")}
USER_KIND = ["--with", "examples/user_body/pair.json", "--only", "user_body"]  # on every kind, with the example's plugin


def names_in(path):
    """The first word of each line that is no comment."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return [line.split()[0] for line in lines if line.strip() and not line.startswith("#")]


def starts_in(path=STARTS):
    """{name: (options of brim sweep, metrics that are judged by their median)}"""
    words = [line.split() for line in path.read_text(encoding="utf-8").splitlines() if line.strip() and not line.startswith("#")]
    return {w[0]: (w[1:w.index("median")], set(w[w.index("median") + 1:])) for w in words}


def needs_data(path):
    return "${BRIM_DATA}" in path.read_text(encoding="utf-8")


def jobs(brim, out, plugin, pair_steps=0):
    """Everything there is to run: {name: (command, scene, or nothing for a table of pairs)}."""
    all_jobs, starts = {}, starts_in()
    for path in sorted((ROOT / "scenes").glob("*.json")):
        command = scene_command(brim, path, out / path.stem, [])
        if path.stem in starts:
            command = [brim, "sweep", str(path), "-o", str(out / path.stem), "--force", "--quiet", "--jobs", "1", *starts[path.stem][0]]
        all_jobs[path.stem] = (command, path)
    for path in sorted((ROOT / "examples").glob("*/*.json")):
        if "bodies" in read_scene(path):
            all_jobs[path.stem] = (scene_command(brim, path, out / path.stem, ["--plugin", str(plugin)]), path)
    steps = ["--steps", str(pair_steps)] if pair_steps else []
    for table, options in PAIR_TABLES.items():
        user = ["--plugin", str(plugin), *USER_KIND] if table.startswith("user_") else []
        all_jobs[f"pairs_{table}"] = ([brim, "pairs", "--json", "--threads", "1", *user, *options, *steps], None)
    return all_jobs


def scene_command(brim, path, folder, more):
    return [brim, "run", str(path), "-o", str(folder), "--force", "--check", "--quiet", "--threads", "1", *more]


def judge(summary):
    """Of a run's summary: ([met], [known misses], [surprises]), each in words."""
    met, known, surprises = [], [], []
    for e in summary["expect"]:
        value = "nothing" if e.get("value") is None else f"{e['value']:.4g}"
        bounds = " ".join(f"{k} {e[k]:g}" for k in ("min", "max") if k in e)
        text = f"{e['metric']}{' of ' + e['body'] if 'body' in e else ''} is {value}, {bounds}"
        if e["ok"] and "known_miss" in e:
            surprises.append(f"holds, and is marked as a known miss: {text} ({e['known_miss']})")
        elif e["ok"]:
            met.append(text)
        elif e.get("worse"):
            surprises.append(f"worse than {e['known_worst']:g}: {text} ({e['known_miss']})")
        elif "known_miss" in e:
            known.append(f"{text} ({e['known_miss']})")
        else:
            surprises.append(f"missed: {text}" + ("" if e.get("reached", True) else "; the run ended before its window"))
    if summary["end"] != "completed":
        surprises.append(f"the run {summary['end']}")
    return met, known, surprises


def over_starts(summaries, by_median):
    """The summaries of several starts as that of one run: of the metrics that are named the median, of others what is worst."""
    joined = {"end": next((s["end"] for s in summaries if s["end"] != "completed"), "completed"), "expect": []}
    for of_each in zip(*(s["expect"] for s in summaries)):
        e = dict(max(of_each, key=lambda x: (bool(x.get("worse")), not x["ok"])))
        values = [x["value"] for x in of_each if x.get("value") is not None]
        if e["metric"] in by_median and len(values) == len(of_each):
            value = statistics.median(values)
            e["value"] = value
            e["ok"] = e.get("min", value) <= value <= e.get("max", value)
            worst = e.get("known_worst", value)
            e["worse"] = not e["ok"] and (value < worst if worst < e.get("min", worst) else value > worst)
            e["metric"] += f" (median of {len(values)}, {min(values):.4g} to {max(values):.4g})"
        joined["expect"].append(e)
    return joined


def judge_pairs(figures, misses, cut_short=False):
    """Of the figures of brim pairs and {"a on b": why} of those that are known to fail, in the end or at once."""
    met, known, surprises = [], [], []
    for pair in figures["pairs"]:
        if not pair["run"]:
            continue
        name = f"{pair['upper']} on {pair['lower']}"
        if pair["ok"] and name in misses and not cut_short:
            surprises.append(f"{name} holds, and is marked as a known miss ({misses[name]})")
        elif pair["ok"]:
            met.append(name)
        elif name in misses:
            known.append(f"{name} ({misses[name]})")
        else:
            surprises.append(f"{name} is missed: {'; '.join(pair.get('failures', []))}")
    return met, known, surprises


def finish(command, limit):
    """Runs a command. @return (exit code, or nothing where it did not end in time; processor seconds; output; errors)"""
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        child = subprocess.Popen(command, cwd=ROOT, stdout=output, stderr=errors)
        late = threading.Timer(limit, child.kill)
        late.start()
        _, status, used = os.wait4(child.pid, 0)
        in_time = late.is_alive()
        late.cancel()
        output.seek(0), errors.seek(0)
        code = os.waitstatus_to_exitcode(status) if in_time else None
        child.returncode = code
        return code, used.ru_utime + used.ru_stime, output.read(), errors.read()


def run(name, command, path, out, limit):
    """(name, seconds of processor time, met, known, surprises)"""
    starts = starts_in()
    if name in starts:
        shutil.rmtree(out / name, ignore_errors=True)  # starts that are not asked for any more
    code, seconds, output, errors = finish(command, limit)
    if code is None:
        return name, seconds, [], [], [f"did not end within {limit:.0f} s"]
    if code not in (0, 1):
        return name, seconds, [], [], [f"ended with {code}: {errors.strip()[-300:]}"]
    try:
        if path is None:
            misses = read_scene(PAIRS / "known_misses.json")[name.removeprefix("pairs_")]
            return name, seconds, *judge_pairs(json.loads(output), misses, "--steps" in command)
        if name not in starts:
            return name, seconds, *judge(json.loads((out / name / "summary.json").read_text(encoding="utf-8")))
        summaries = [json.loads(p.read_text(encoding="utf-8")) for p in sorted((out / name).glob("*/summary.json"))]
        if code or not summaries:
            return name, seconds, [], [], [f"a start did not come to its end: {errors.strip()[-300:]}"]
        return name, seconds, *judge(over_starts(summaries, starts[name][1]))
    except (OSError, ValueError, KeyError) as error:
        return name, seconds, [], [], [f"its figures cannot be read: {error!r}; {errors.strip()[-300:]}"]


def line(name, seconds, met, known, surprises):
    return f"{name:<24} {seconds:8.1f} s {len(met):4} met {len(known):4} known {len(surprises):4} UNEXPECTED" \
        if surprises else f"{name:<24} {seconds:8.1f} s {len(met):4} met {len(known):4} known"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--brim", default=str(ROOT / "build/release/brim"))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/scenes")
    parser.add_argument("--fast", action="store_true", help="those of scenes/fast.txt")
    parser.add_argument("--list", action="store_true", help="print the names and end")
    parser.add_argument("--jobs", type=int, default=2, help="scenes at once, each on one thread")
    parser.add_argument("--pair-steps", type=int, default=0, help="tables of pairs with so many steps: known misses may hold then")
    parser.add_argument("--limit", type=float, default=3600.0, help="[s] for one scene")
    options = parser.parse_args()

    plugin = pathlib.Path(options.brim).parent / "examples/jelly.so"
    everything = jobs(options.brim, options.out, plugin, options.pair_steps)
    wanted = options.names or (names_in(FAST) if options.fast else list(everything))
    unknown = [n for n in wanted if n not in everything]
    if unknown:
        sys.exit(f"no such scene: {', '.join(unknown)}; --list says what there is")
    if options.list:
        print("\n".join(wanted))
        return 0
    skipped = [n for n in wanted if everything[n][1] and needs_data(everything[n][1]) and not os.environ.get("BRIM_DATA")]
    order = names_in(ROOT / "scenes" / "slow.txt")
    todo = sorted((n for n in wanted if n not in skipped), key=lambda n: order.index(n) if n in order else len(order))

    start = time.monotonic()
    bad, details = 0, []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        running = [pool.submit(run, n, *everything[n], options.out, options.limit) for n in todo]
        for outcome in concurrent.futures.as_completed(running):
            name, _, _, known, surprises = result = outcome.result()
            print(line(*result), flush=True)
            details += [f"  {name}: known miss: {k}" for k in known] + [f"  {name}: {s}" for s in surprises]
            bad += bool(surprises)
    for text in details:
        print(text)
    for name in skipped:
        print(f"  {name}: left out: it needs data; set BRIM_DATA to their folder")
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{len(todo)} run in {time.monotonic() - start:.0f} s ({used.ru_utime + used.ru_stime:.0f} s of processor time), "
          f"{bad} with something unexpected")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
