#!/usr/bin/env python3
"""Reads each C++ file that is named on standard input with the compiler, without those that a build compiles it with.

Where files are compiled together, or behind a header that was read before, one that forgets an include is not noticed.
A header is read as if nothing else were included. Flags are those of a build folder that was configured with
BRIM_UNITY=OFF and BRIM_PRECOMPILE=OFF; warnings are errors. What the seconds do not suffice for is left out, and said.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import shlex
import subprocess
import sys
import time


def commands(build):
    """File -> (arguments of its compiler without what they write, folder) from a build's compile_commands.json."""
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text(encoding="utf-8")):
        words, kept = shlex.split(entry["command"]), []
        words = words[1:] if pathlib.Path(words[0]).name == "ccache" else words
        file = os.path.realpath(os.path.join(entry["directory"], entry["file"]))
        skip = False
        for word in words:
            if skip or word in ("-c", "-MD") or os.path.realpath(os.path.join(entry["directory"], word)) == file:
                skip = False
            elif word in ("-o", "-MF", "-MT"):
                skip = True
            else:
                kept.append(word)
        found[file] = (kept, entry["directory"])
    return found


def nearest(file, known):
    """The file of a build whose path has most in common with a header's: its flags fit."""
    return max(known, key=lambda other: (len(os.path.commonpath([file, other])), other))


def read_alone(file, known):
    """What the compiler says against a file; empty where it says nothing, None where no build has it."""
    header = file.endswith(".h")
    if not header and file not in known:
        return None
    words, folder = known[nearest(file, known) if header else file]
    words = words + ["-Werror", "-fsyntax-only", *(["-x", "c++", "-"] if header else [file])]
    done = subprocess.run(words, cwd=folder, input=f'#include "{file}"\n', capture_output=True, text=True)
    return "" if done.returncode == 0 else done.stderr


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("-j", "--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--seconds", type=float, default=float("inf"))
    options = parser.parse_args()
    known = commands(options.build)
    files = [os.path.realpath(line.strip()) for line in sys.stdin if line.strip()]
    end, bad, left_out = time.monotonic() + options.seconds, 0, 0

    def read(file):
        return read_alone(file, known) if time.monotonic() < end else "late"

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for file, said in zip(files, pool.map(read, files)):
            if said == "late":
                left_out += 1
            elif said:
                bad += 1
                print(f"alone: {os.path.relpath(file)} cannot be compiled alone:\n{said[:2000]}")
    if left_out:
        print(f"alone: {left_out} of {len(files)} files were left out: the {options.seconds:g} s were over")
    if not bad:
        print(f"alone: {len(files) - left_out} files need no other")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
