#!/usr/bin/env python3
"""Checks that the documentation can be found: from docs/index.md every page of docs/ is at most two clicks away, and every
kind of body that the schema of scenes knows has a page in docs/bodies, which the front page names."""
import json
import re
import sys
from pathlib import Path

CLICKS = 2
LINK = re.compile(r"\]\(([^)#\s]+\.md)(?:#[^)]*)?\)")


def links(page):
    """Pages that a page leads to."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    return {(page.parent / target).resolve() for target in LINK.findall(text) if "://" not in target}


def distances(front):
    """{page: clicks from the front page}"""
    found = {front.resolve(): 0}
    edge = [front.resolve()]
    while edge:
        page = edge.pop(0)
        for target in sorted(links(page)):
            if target.is_file() and target not in found:
                found[target] = found[page] + 1
                edge.append(target)
    return found


def kinds(schema):
    """Words for "kind" of an entry of "bodies"."""
    for branch in schema["$defs"]["body"]["oneOf"]:
        yield branch["$ref"].split("/")[-1]


def problems(root):
    docs = root / "docs"
    clicks = distances(docs / "index.md")
    for page in sorted(docs.rglob("*.md")):
        if page.resolve() not in clicks:
            yield f"{page.relative_to(root)}: cannot be reached from docs/index.md"
        elif clicks[page.resolve()] > CLICKS:
            yield f"{page.relative_to(root)}: {clicks[page.resolve()]} clicks from docs/index.md; {CLICKS} are allowed"
    front = links(docs / "index.md")
    for kind in kinds(json.loads((root / "schema" / "scene.schema.json").read_text(encoding="utf-8"))):
        page = docs / "bodies" / f"{kind}.md"
        if not page.is_file():
            yield f"the kind {kind} has no page {page.relative_to(root)}"
        elif page.resolve() not in front:
            yield f"{page.relative_to(root)}: docs/index.md does not name it"


def main():
    found = list(problems(Path(__file__).resolve().parent.parent))
    for problem in found:
        print(f"pages: {problem}")
    if found:
        sys.exit(1)
    print("pages: all within two clicks, and one for every kind")


if __name__ == "__main__":
    main()
