#!/usr/bin/env python3
"""Checks that every relative link in the Markdown files leads to a file, and to a heading where it names one."""

import argparse
import re
import sys
from pathlib import Path

LINK = re.compile(r"!?\[[^\]]*\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
FENCE = re.compile(r"^(```|~~~).*?^\1", re.M | re.S)
SKIPPED = {"build", "out", "node_modules", "dist"}


def prose(path):
    """The text without fenced blocks and inline code, where brackets mean something else."""
    text = FENCE.sub(lambda block: "\n" * block.group(0).count("\n"), path.read_text(encoding="utf-8"))
    return re.sub(r"`[^`\n]*`", "", text)


def anchors(path):
    """The anchors of the headings, by GitHub's rule: lower case, words joined by hyphens, marks dropped."""
    text = FENCE.sub("", path.read_text(encoding="utf-8"))
    titles = re.findall(r"^#{1,6}\s+(.*?)\s*#*$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def markdown_files(root):
    for path in sorted(root.rglob("*.md")):
        folders = path.relative_to(root).parts[:-1]
        if not any(name in SKIPPED or name.startswith(".") for name in folders):
            yield path


def check(root):
    """All broken links, one line each."""
    problems = []
    for path in markdown_files(root):
        for number, line in enumerate(prose(path).splitlines(), 1):
            for link in LINK.findall(line):
                if re.match(r"[a-z][a-z0-9+.-]*:", link):
                    continue
                name, _, anchor = link.partition("#")
                target = path.parent / name if name else path
                place = f"{path.relative_to(root)}:{number}"
                if not target.exists():
                    problems.append(f"{place}: {link}: no such file")
                elif anchor and target.suffix == ".md" and anchor not in anchors(target):
                    problems.append(f"{place}: {link}: no such heading")
    return problems


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).resolve().parent.parent)
    problems = check(parser.parse_args().root)
    for problem in problems:
        print(problem, file=sys.stderr)
    if not problems:
        print("links: all lead somewhere")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
