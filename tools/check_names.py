#!/usr/bin/env python3
"""Checks that no two files of a layer use the same name in their unnamed namespaces, so that they can be compiled together,
and that each test, which may use any, has a namespace of its file's name.

Types, constants and aliases clash by their name, functions by their name and the types of their arguments. Formatting by
clang-format is taken for granted: what a namespace holds starts in the first column.
"""
import collections
import pathlib
import re
import sys

TYPE = re.compile(r"^(?:template <.*> )?(?:struct|class|union|enum(?: class)?) (\w+)(?: final)?(?: :| \{|;)")
ALIAS = re.compile(r"^(?:template <.*> )?using (\w+) =")
CONSTANTS = re.compile(r"\b(k[A-Z]\w*)(?:\[\w*\])*(?= =| ?\{)")
VARIABLE = re.compile(r"^(?:static |inline |thread_local |constexpr |const |std::|[A-Z])[\w:<>,&* ]*?\b(\w+)(?:\[\w*\])*(?: =| ?\{|;)")
FUNCTION = re.compile(r"^(?!return|if|for|while|switch|else|using|namespace|typedef|static_assert)[\w:<>,&*\[\]() ]*?[\w>&*] [&*]*(\w+)\((.*)$")


def argument_types(text):
    """Types of the arguments, names and defaults left out."""
    depth, piece, pieces = 0, "", []
    for c in text:
        depth += (c in "<([{") - (c in ">)]}")
        if depth < 0:
            break
        if c == "," and depth == 0:
            pieces.append(piece)
            piece = ""
        else:
            piece += c
    pieces.append(piece)
    types = []
    for p in pieces:
        p = re.sub(r" = .*", "", p.strip())
        types.append(re.sub(r"(?<=[\w>&*\]]) ?\b\w+$", "", p) if " " in p or "&" in p else p)
    return ", ".join(types)


def unnamed_names(path):
    """(name, line) of what the unnamed namespaces of a file declare; functions carry the types of their arguments."""
    inside, lines, out = False, path.read_text(encoding="utf-8").split("\n"), []
    for i, line in enumerate(lines):
        if line.startswith("namespace {"):
            inside = True
        elif line.startswith("}  // namespace"):
            inside = False
        elif inside and line and line[0] not in " }#/*":
            function = FUNCTION.match(line)
            if function and not TYPE.match(line) and " = " not in line.split("(")[0]:
                rest, k = function.group(2), i
                while rest.count("(") - rest.count(")") >= 0 and k + 1 < len(lines) and k < i + 12:
                    k += 1
                    rest += " " + lines[k].strip()
                out.append((f"{function.group(1)}({argument_types(rest)})", i + 1))
                continue
            found = TYPE.match(line) or ALIAS.match(line)
            names = [found.group(1)] if found else CONSTANTS.findall(line)
            if not names and VARIABLE.match(line):
                names = [VARIABLE.match(line).group(1)]
            out += [(name, i + 1) for name in names]
    return out


def layer_of(path, roots):
    for root in roots:
        if path.is_relative_to(root):
            inside = path.relative_to(root).parts
            return f"{root.name}/{inside[0]}" if len(inside) > 1 else root.name
    return str(path.parent)


def header_types(root):
    """Types of the library's headers: a second one of that name in an unnamed namespace would be ambiguous."""
    found = {}
    for path in sorted((root / "src/brim").rglob("*.h")):
        for i, line in enumerate(path.read_text(encoding="utf-8").split("\n")):
            declared = TYPE.match(line)
            if declared and not line.rstrip().endswith(";"):
                found[declared.group(1)] = (path, i + 1)
    return found


def clashes(root):
    """Lines that say which files of which layer clash in which name."""
    roots = [root / "src/brim", root / "apps"]
    found = collections.defaultdict(list)
    for base in roots:
        for path in sorted(base.rglob("*.cpp")):
            for name, line in unnamed_names(path):
                found[layer_of(path, roots), name].append((path, line))
    types = header_types(root)
    for (layer, name), places in sorted(found.items()):
        if name in types:
            places.append(types[name])
        files = {path for path, _ in places}
        # The same alias of the same type may be said twice.
        texts = {path.read_text(encoding="utf-8").split("\n")[line - 1] for path, line in places}
        if len(files) < 2 or (len(texts) == 1 and next(iter(texts)).startswith("using ")):
            continue
        yield f"{layer}: {name} in " + ", ".join(f"{path.relative_to(root)}:{line}" for path, line in places)


def tests_without_their_namespace(root):
    """Lines that say which tests have no namespace of their file's name."""
    for path in sorted((root / "tests").glob("*/*_test.cpp")):
        if f"::{path.stem} {{" not in path.read_text(encoding="utf-8"):
            yield f"{path.relative_to(root)}: its namespace should be brim::{path.stem}"


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
    root = root if root.is_dir() else root.parent.parent
    found = list(clashes(root))
    for line in found:
        print(f"names: {line}; give one of them another name")
    alone = list(tests_without_their_namespace(root))
    for line in alone:
        print(f"names: {line}")
    if not found and not alone:
        print("names: no two files of a layer clash")
    return 1 if found or alone else 0


if __name__ == "__main__":
    sys.exit(main())
