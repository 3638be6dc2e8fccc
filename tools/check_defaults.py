#!/usr/bin/env python3
"""Checks that the defaults which the pages of kinds tell are those of the schema of scenes.

Looked at are the tables of docs/bodies/NAME.md with a column "default". What a cell tells is compared where it is a number, true,
false, a word of the schema, "none" or "required"; a formula, and what a C++ option has where scenes have another ("0; 0.005 in
scenes" tells both), is left alone. A key that the kind does not have must be a name in brim's headers, as the tables of some
pages are of C++ options.
"""
import json
import re
import sys
from pathlib import Path

ABSENT = object()


def rows(text):
    """(line, cells of the head, cells) of each row of a table with a column "default"."""
    head = None
    for number, line in enumerate(text.splitlines(), 1):
        if not line.startswith("|"):
            head = None
            continue
        cells = [c.strip() for c in line.strip().strip("|").split("|")]
        if head is None:
            head = cells
        elif "default" in head and len(cells) == len(head) and not set(cells[0]) <= set("-: "):
            yield number, head, cells


def told(words, schema):
    """The default that some words of a page tell, or nothing where they cannot be compared."""
    words = words.strip()
    scenes = re.search(r"(\S+) in scenes\b", words)
    if scenes:
        words = scenes[1]
    elif "in scenes" in words:
        return None
    number = re.fullmatch(r"(-?[\d.]+(?:e-?\d+)?)(?::.*)?", words)
    if number:
        return float(number[1])
    word = words.strip("`")
    if word in ("true", "false"):
        return word == "true"
    if word in ("none", "required", "needed"):
        return "required" if word == "needed" else word
    return word if word in schema.get("enum", ()) else None


def agree(value, schema, required):
    default = schema.get("default", ABSENT)
    if value == "required":
        return required
    if value == "none":
        return default in (ABSENT, [], {}) and not required
    if default is ABSENT:
        return "default" not in schema and not required  # the reader of the scene has it: the description says so
    return default == value


def problems_of(page, name, kind, headers):
    """Lines about a page's tables. @param kind  the schema of the kind  @param headers  names in brim's headers"""
    properties, required = kind.get("properties", {}), kind.get("required", [])
    for line, head, cells in rows(page):
        keys = re.findall(r"`([\w.]+)`", cells[0])
        for key in keys:
            for word in key.strip(".").split("."):
                if key not in properties and word not in headers:
                    yield f"{name}:{line}: `{key}` is no key of this kind and no name in brim's headers"
        either = re.search(r"`\s+or\s+`", cells[0])  # one of several keys must be there
        words = cells[head.index("default")].split(", ")
        if either or len(words) != len(keys):
            continue
        for key, said in zip(keys, words):
            value = told(said, properties.get(key, {}))
            if key in properties and value is not None and not agree(value, properties[key], key in required):
                default = properties[key].get("default", "required" if key in required else "none")
                yield f"{name}:{line}: `{key}` is said to be {said} by default; the schema of scenes has {json.dumps(default)}"


def problems(root):
    schema = json.loads((root / "schema/scene.schema.json").read_text(encoding="utf-8"))["$defs"]
    headers = set()
    for path in root.glob("src/brim/**/*.h"):
        headers.update(re.findall(r"\w+", path.read_text(encoding="utf-8")))
    for page in sorted((root / "docs/bodies").glob("*.md")):
        if page.stem in schema:
            yield from problems_of(page.read_text(encoding="utf-8"), page.relative_to(root), schema[page.stem], headers)


def main():
    found = list(problems(Path(__file__).resolve().parent.parent))
    for problem in found:
        print(f"defaults: {problem}")
    if found:
        sys.exit(1)
    print("defaults: pages of kinds tell those of the schema")


if __name__ == "__main__":
    main()
