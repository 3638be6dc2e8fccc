#!/usr/bin/env python3
"""How often ./dev fuzz has run each of its targets.

  tools/fuzz_record.py add TARGET LOG [--seconds S]   adds what libFuzzer's log says to tests/fuzz/executions.tsv
  tools/fuzz_record.py totals                         executions and findings of each target, and of all together

A line of the record: target, commit (with + where its files were changed), executions, seconds, findings.
"""

import argparse
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RECORD = ROOT / "tests/fuzz/executions.tsv"
HEAD = "target\tcommit\texecutions\tseconds\tfindings"
WANTED, WANTED_EACH = 10_000_000, 100_000


def executions(log):
    """@return executions that a log tells of, and findings (0 or 1: libFuzzer ends at the first)"""
    final = re.findall(r"^stat::number_of_executed_units:\s*(\d+)", log, re.M)
    # A run that was ended from outside has its last line of progress instead: "#4096 pulse cov: ...".
    count = max((int(n) for n in final or re.findall(r"^#(\d+)\s", log, re.M)), default=0)
    return count, int(bool(re.search(r"^(SUMMARY: |==\d+== ?ERROR)", log, re.M)))


def commit():
    def git(*words):
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True).stdout.strip()
    return git("rev-parse", "--short=10", "HEAD") + ("+" if git("status", "--porcelain", "--", "src", "apps", "tests/fuzz/*.h") else "")


def add(record, target, log, seconds, at):
    count, findings = executions(log)
    text = record.read_text() if record.exists() else HEAD + "\n"
    record.write_text(text + f"{target}\t{at}\t{count}\t{seconds}\t{findings}\n")
    return count


def totals(record):
    """@return target: (executions, findings), in the order of their first lines"""
    sums = {}
    for line in record.read_text().splitlines()[1:] if record.exists() else []:
        target, _, count, _, findings = line.split("\t")
        before = sums.get(target, (0, 0))
        sums[target] = (before[0] + int(count), before[1] + int(findings))
    return sums


def report(sums, targets):
    lines = [f"{t:10} {sums.get(t, (0, 0))[0]:>12,} executions{'' if sums.get(t, (0, 0))[0] >= WANTED_EACH else f'  fewer than {WANTED_EACH:,}'}"
             f"{f'  {sums[t][1]} with a finding' if sums.get(t, (0, 0))[1] else ''}" for t in targets]
    whole = sum(s[0] for s in sums.values())
    return "\n".join([*lines, f"{'all':10} {whole:>12,} executions of {WANTED:,} that are wanted"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    adding = commands.add_parser("add")
    adding.add_argument("target")
    adding.add_argument("log", type=Path)
    adding.add_argument("--seconds", type=int, default=0)
    commands.add_parser("totals")
    o = parser.parse_args()
    if o.command == "add":
        count = add(RECORD, o.target, o.log.read_text(errors="replace"), o.seconds, commit())
        print(f"{o.target}: {count:,} executions")
    else:
        print(report(totals(RECORD), sorted(p.name for p in (ROOT / "tests/fuzz/inputs").iterdir())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
