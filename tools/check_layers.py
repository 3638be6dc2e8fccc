#!/usr/bin/env python3
"""Checks that every include obeys the layers, that no files include each other in a circle, and where third-party
headers may appear.

The rules are read from the documents, so that the documents cannot drift from the code:
  docs/architecture.md  a fenced block `layers`, lines `layer -> allowed allowed`. A layer may include itself and,
                        transitively, whatever the layers on its right may include.
  docs/dependencies.md  a fenced block `third-party`, lines `header -> layer layer`. `math+` stands for math and every layer
                        that may include it, `*` for all layers. A header that ends in `/` stands for all headers
                        below it. A third-party header that is not listed is an error.
"""

import argparse
import re
import sys
from pathlib import Path

INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)')
ARROW = re.compile(r"^([\w./+-]+)\s*->\s*(.*)$")
# Headers of the C++ and C library: no directory, no extension, or one of C's own and the system's.
STANDARD = re.compile(r"^(?:[a-z_0-9]+|(?:sys|arpa|netinet)/\w+\.h|(?:assert|errno|fcntl|math|signal|stddef|stdint|"
                      r"stdio|stdlib|string|time|spawn|unistd|poll|netdb|dlfcn|cxxabi|immintrin|emmintrin)\.h)$")


class RuleError(Exception):
    """The documents do not hold the rules in a form that can be read."""


def fenced_block(path, info):
    """The lines of the fenced block with that info string, as [(name, [words])]."""
    if not path.is_file():
        raise RuleError(f"{path}: missing; it must hold a fenced block ```{info}")
    match = re.search(rf"^```{re.escape(info)}[ \t]*\n(.*?)^```", path.read_text(encoding="utf-8"), re.M | re.S)
    if not match:
        raise RuleError(f"{path}: no fenced block ```{info}")
    rules = []
    for line in match.group(1).splitlines():
        line = line.split("#")[0].strip()
        if not line:
            continue
        arrow = ARROW.match(line)
        if not arrow:
            raise RuleError(f"{path}: in block {info}: cannot read '{line}', expected 'name -> name name'")
        rules.append((arrow.group(1), arrow.group(2).replace(",", " ").split()))
    if not rules:
        raise RuleError(f"{path}: block {info} is empty")
    return rules


def read_layers(path):
    """{layer: set of layers it may include}, closed transitively, each layer included in its own set."""
    direct = {}
    for layer, allowed in fenced_block(path, "layers"):
        if layer in direct:
            raise RuleError(f"{path}: layer {layer} is listed twice")
        direct[layer] = allowed
    for layer, allowed in direct.items():
        for other in allowed:
            if other not in direct:
                raise RuleError(f"{path}: layer {layer} allows {other}, which is not a layer")

    def reach(layer, seen):
        for other in direct[layer]:
            if other not in seen:
                seen.add(other)
                reach(other, seen)
        return seen

    closed = {}
    for layer in direct:
        below = reach(layer, set())
        if layer in below and layer not in direct[layer]:
            raise RuleError(f"{path}: layer {layer} reaches itself through other layers")
        closed[layer] = below | {layer}
    return closed


def read_third_party(path, layers):
    """[(header or directory, set of layers)]"""
    rules = []
    for header, words in fenced_block(path, "third-party"):
        allowed = set()
        for word in words:
            layer = word.removesuffix("+")
            if word == "*":
                allowed |= set(layers)
            elif layer not in layers:
                raise RuleError(f"{path}: {header} allows {layer}, which is not a layer")
            else:
                allowed |= {other for other in layers if layer in layers[other]} if word.endswith("+") else {layer}
        rules.append((header, allowed))
    return rules


def includes(path):
    """[(line number, quoted header or None, angled header or None)]"""
    found = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            found.append((number, match.group(1), match.group(2)))
    return found


def source_files(root):
    """[(path, layer)]: src/brim/<layer>/..., all of apps/ and python/ as layers of those names, and src/brim/brim.h as a
    layer by itself."""
    files = []
    for folder, layer_of in (("src/brim", None), ("apps", "apps"), ("python", "python")):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix in (".h", ".cpp", ".inl") and path.is_file():
                parts = path.relative_to(root / folder).parts
                files.append((path, layer_of or (parts[0] if len(parts) > 1 else path.stem)))
    return files


def third_party_problem(header, layer, rules):
    for name, allowed in rules:
        if header == name or (name.endswith("/") and header.startswith(name)):
            if layer in allowed:
                return None
            return f"<{header}> belongs to {' '.join(sorted(allowed))}, not to {layer}"
    if STANDARD.match(header):
        return None
    return f"<{header}> is not listed in docs/dependencies.md"


def find_cycle(graph):
    """One circle of files as a list that starts and ends with the same file, or None."""
    state = {}  # 1: on the path being walked, 2: done
    for start in sorted(graph):
        if start in state:
            continue
        state[start] = 1
        stack = [(start, iter(graph[start]))]
        while stack:
            node, rest = stack[-1]
            child = next(rest, None)
            if child is None:
                state[node] = 2
                stack.pop()
            elif state.get(child) == 1:
                path = [entry[0] for entry in stack]
                return path[path.index(child):] + [child]
            elif child not in state:
                state[child] = 1
                stack.append((child, iter(graph[child])))
    return None


def check(root):
    """All problems, one line each."""
    layers = read_layers(root / "docs/architecture.md")
    third_party = read_third_party(root / "docs/dependencies.md", layers)
    problems, graph = [], {}
    for path, layer in source_files(root):
        place = path.relative_to(root).as_posix()
        if layer not in layers:
            problems.append(f"{place}: is in no layer of docs/architecture.md")
            continue
        own = path.relative_to(root / "src").as_posix() if place.startswith("src/") else place
        graph[own] = []
        for number, quoted, angled in includes(path):
            header = quoted or angled
            if header.startswith("brim/"):
                graph[own].append(header)
                other = header.split("/")[1]
                if other not in layers:
                    problems.append(f"{place}:{number}: {header} is in no layer of docs/architecture.md")
                elif other not in layers[layer]:
                    problems.append(f"{place}:{number}: layer {layer} may not include {header}")
            elif angled:
                problem = third_party_problem(angled, layer, third_party)
                if problem:
                    problems.append(f"{place}:{number}: {problem}")
            elif place.startswith("src/"):
                problems.append(f'{place}:{number}: write "brim/<layer>/..." instead of "{quoted}"')
    graph = {node: [other for other in others if other in graph] for node, others in graph.items()}
    cycle = find_cycle(graph)
    if cycle:
        problems.append("circle of includes: " + " -> ".join(cycle))
    return problems, len(graph)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).resolve().parent.parent)
    root = parser.parse_args().root
    try:
        problems, count = check(root)
    except RuleError as error:
        print(error, file=sys.stderr)
        return 2
    for problem in problems:
        print(problem, file=sys.stderr)
    if not problems:
        print(f"layers: {count} files, all in order")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
