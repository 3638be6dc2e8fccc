#!/usr/bin/env python3
"""Checks that what pages and comments name is there: files, tests of a gtest filter, commands of `./dev` and of brim with their
options, scenes by name, options of tools, programs of the build.

Looked at are the Markdown files and the comments of the sources. A name with a place to fill in (NAME, <x>, *, {}) is left
alone, and so is the changelog, which speaks of the past.
"""
import argparse
import fnmatch
import pathlib
import re
import sys

import run_scenes

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ("src", "apps", "tests", "tools", "docs", "scenes", "schema", "bench", "examples", "cmake", "viewer")
SOURCES = ("src", "apps", "tests", "bench", "examples", "tools")
SKIPPED = {"build", "out", "node_modules", "dist", "CHANGELOG.md"}
FILE = re.compile(r"(?<![\w./<-])((?:\.\./)*(?:%s|brim)/[\w./<>*{}-]*\.(?:md|h|cpp|py|json|txt|cmake|tsx?|mjs|in))(?!\w)" % "|".join(FOLDERS))
FILTER = re.compile(r"(?:test_(\w+) +--)?gtest_filter=(?:'([^']+)'|\"([^\"]+)\"|([\w.*?:/-]+))")
SHORT_FILTER = re.compile(r"`((?:\.\.\.[\w*]+:?)+)`")  # `...SameBits:...BitForBit`: ends of names
DEV = re.compile(r"(?<![\w/])\./dev ([a-z][a-z_]*)")
BRIM = re.compile(r"(?:`|^\s*|[;&|] *|build/release/)brim ([a-z][a-z-]*)\b", re.M)
CALL = r"([^\n`|;&#>)]*)"  # the words of a command that follow its name
BRIM_CALL = re.compile(r"(?<![\w./-])(?:build/release/)?brim ([a-z]+)(?= )" + CALL)
DEV_CALL = re.compile(r"(?<![\w/])\./dev ([a-z]+)(?= )" + CALL)
TOOL_CALL = re.compile(r"tools/(\w+)\.py(?= )" + CALL)
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
SCENE_TEST = re.compile(r"\bScene_([a-z]\w*)")
PROGRAM = re.compile(r"build/release/(bench|tests)/(\w+)")
TEST = re.compile(r"^(?:TEST|TEST_F|TEST_P|TYPED_TEST)\((\w+),\s*(\w+)\)", re.M)
COMMENT = {".h": re.compile(r"//.*"), ".cpp": re.compile(r"//.*"), ".py": re.compile(r"\"\"\".*?\"\"\"|#.*", re.S)}
PLACE = re.compile(r"[<>*{}]|NAME|LAYER|FILE\b|FORMAT")


def files(root, patterns):
    for pattern in patterns:
        for path in sorted(root.glob(pattern)):
            if not SKIPPED.intersection(path.relative_to(root).parts) and not any(
                    part.startswith(".") for part in path.relative_to(root).parts):
                yield path


class Known:
    """What there is to be named."""

    def __init__(self, root):
        self.root = root
        self.tests = {}  # layer: names
        for path in files(root, ["tests/**/*.cpp"]):
            layer = path.relative_to(root / "tests").parts[0]
            self.tests.setdefault(layer, set()).update(".".join(pair) for pair in TEST.findall(path.read_text(encoding="utf-8")))
        dev = root / "dev"
        self.dev = set(re.findall(r"^cmd_(\w+)\(\)", dev.read_text(encoding="utf-8"), re.M)) if dev.exists() else set()
        self.dev_options = set(OPTION.findall(dev.read_text(encoding="utf-8"))) if dev.exists() else set()
        self.tools = {}  # name: options
        for path in files(root, ["tools/*.py", "tools/validate/*.py"]):
            name = "validate" if path.parent.name == "validate" else path.stem
            self.tools.setdefault(name, set()).update(OPTION.findall(path.read_text(encoding="utf-8")))
        self.brim = {}  # command: options
        shared = {"--help", "--plugin", "--version"}
        for path in files(root, ["apps/cli/*.cpp"]):
            text = path.read_text(encoding="utf-8")
            commands, options = re.findall(r"add_subcommand\(\"([\w-]+)\"", text), OPTION.findall(text)
            for command in commands:
                self.brim.setdefault(command, set()).update(options)
            if not commands:
                shared.update(options)
        for options in self.brim.values():
            options |= shared
        self.scenes = {path.stem for path in files(root, ["scenes/*.json", "examples/*/*.json"])}
        self.scenes |= {f"pairs_{table}" for table in run_scenes.PAIR_TABLES}

    def file(self, name, beside):
        return any((base / name).exists() for base in (self.root, self.root / "src", self.root / "viewer", beside))

    def missing_patterns(self, text, layer=None):
        """Patterns of a filter that no test of the layer (of any) answers to; what comes after a minus is left out of a run,
        not in it."""
        wanted = text.split("-")[0]
        tests = self.tests.get(layer, ()) if layer else set().union(*self.tests.values())
        return [p for p in wanted.split(":") if p and not any(fnmatch.fnmatchcase(t, p) for t in tests)]

    def program(self, folder, name):
        if folder == "bench":
            return (self.root / "bench" / f"{name}.cpp").exists() or name == "peers"
        return (self.root / "tests" / name.removeprefix("test_")).is_dir()


def problems_in(text, known, beside):
    """(offset, words) of each name that leads nowhere."""
    for m in FILE.finditer(text):
        if not PLACE.search(m[1]) and not known.file(m[1], beside):
            yield m.start(), f"{m[1]}: no such file"
    for m in FILTER.finditer(text):
        for pattern in known.missing_patterns(m[2] or m[3] or m[4], m[1]):
            yield m.start(), f"{pattern}: no test of that name" + (f" in tests/{m[1]}" if m[1] else "")
    for m in SHORT_FILTER.finditer(text):
        for pattern in known.missing_patterns(m[1].replace("...", "*").replace("*:", ":")):
            yield m.start(), f"{pattern}: no test of that name"
    for m in DEV.finditer(text):
        if m[1] not in known.dev:
            yield m.start(), f"./dev {m[1]}: no such command"
    for m in BRIM.finditer(text):
        if m[1] not in known.brim:
            yield m.start(), f"brim {m[1]}: no such command"
    for m in BRIM_CALL.finditer(text):
        for option in OPTION.findall(m[2]):
            if m[1] in known.brim and option not in known.brim[m[1]]:
                yield m.start(), f"brim {m[1]} {option}: no such option"
    for m in DEV_CALL.finditer(text):
        options = known.dev_options | known.tools.get({"scenes": "run_scenes", "pictures": "scene_pictures"}.get(m[1], m[1]), set())
        for option in OPTION.findall(m[2]):
            if m[1] in known.dev and m[1] not in ("test", "bench") and option not in options:
                yield m.start(), f"./dev {m[1]} {option}: no such option"
        for word in re.findall(r"(?<=\s)[a-z]+_\w+(?=\s|$)", m[2]) if m[1] in ("scenes", "pictures") else ():
            if word not in known.scenes:
                yield m.start(), f"./dev {m[1]} {word}: no such scene"
    for m in TOOL_CALL.finditer(text):
        for option in OPTION.findall(m[2]):
            if option not in known.tools.get(m[1], {option}):
                yield m.start(), f"tools/{m[1]}.py {option}: no such option"
    for m in SCENE_TEST.finditer(text):
        if m[1] not in known.scenes:
            yield m.start(), f"Scene_{m[1]}: no such scene"
    for m in PROGRAM.finditer(text):
        if not PLACE.search(m[0]) and not known.program(m[1], m[2]):
            yield m.start(), f"{m[0]}: no such program is built"


def fenced_or_code(text):
    """A page with all but fenced blocks and code in it blanked: prose may say "brim lets"."""
    kept = [" " if c != "\n" else c for c in text]
    for m in re.finditer(r"^```.*?^```|`[^`\n]+`", text, re.M | re.S):
        kept[m.start():m.end()] = text[m.start():m.end()]
    return "".join(kept)


def check(root):
    """All names that lead nowhere, one line each."""
    known = Known(root)
    found = []
    for path in files(root, ["*.md", "docs/**/*.md", "viewer/*.md"]):
        text = path.read_text(encoding="utf-8")
        for at, words in problems_in(fenced_or_code(text), known, path.parent):
            found.append(f"{path.relative_to(root)}:{text.count(chr(10), 0, at) + 1}: {words}")
    for path in files(root, [f"{folder}/**/*{suffix}" for folder in SOURCES for suffix in COMMENT]):
        if path.name.endswith("_test.py"):
            continue
        text = path.read_text(encoding="utf-8")
        for comment in COMMENT[path.suffix].finditer(text):
            for at, words in problems_in(comment[0], known, path.parent):
                found.append(f"{path.relative_to(root)}:{text.count(chr(10), 0, comment.start() + at) + 1}: {words}")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=pathlib.Path, default=ROOT)
    found = check(parser.parse_args().root)
    for line in found:
        print(line, file=sys.stderr)
    if not found:
        print("references: all that pages and comments name is there")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
