#!/usr/bin/env python3
"""Writes the tables of docs/scenes.md from schema/scene.schema.json and its list of scenes from scenes/; with --check only
says whether they are up to date."""
import json
import pathlib
import sys

from scene_file import read_scene

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "scenes.md"
MARK = "<!-- made by tools/scene_reference.py; change the schema, not this -->\n"
GALLERY = "<!-- scenes: made by tools/scene_reference.py; pictures by tools/scene_pictures.py -->\n"
PRESETS = "<!-- presets: made by tools/scene_reference.py -->\n"
PRESETS_END = "<!-- end of presets -->\n"
GALLERY_END = "<!-- end of scenes -->\n"


def resolve(schema, root):
    while "$ref" in schema:
        target = root
        for word in schema["$ref"].removeprefix("#/").split("/"):
            target = target[word]
        schema = {**target, **{k: v for k, v in schema.items() if k != "$ref"}}
    return schema


def type_text(given, root):
    """What a value may be, in a few words; things with a table of their own are links."""
    if "$ref" in given:
        name = given["$ref"].split("/")[-1]
        return f"[{name}](#{name})"
    schema = resolve(given, root)
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    if "enum" in schema:
        return " or ".join(f"`{json.dumps(v)}`" for v in schema["enum"]) if len(schema["enum"]) < 16 else "a word, see below"
    if "oneOf" in schema:
        return " or ".join(type_text(b, root) for b in schema["oneOf"])
    kind = schema.get("type", "value")
    if kind == "array":
        size = schema.get("minItems")
        count = f"{size} " if size is not None and size == schema.get("maxItems") else ""
        return f"list of {count}{type_text(schema.get('items', {}), root)}"
    bounds = []
    for key, sign in (("exclusiveMinimum", ">"), ("minimum", "≥"), ("exclusiveMaximum", "<"), ("maximum", "≤")):
        if key in schema:
            bounds.append(f"{sign} {schema[key]:g}")
    return " ".join([kind, ", ".join(bounds)]).strip()


def cell(text):
    return str(text).replace("|", "\\|").replace("\n", " ")


def table(schema, root, depth):
    lines = []
    inner = []
    lines += ["| key | what it may be | default | meaning |", "|---|---|---|---|"]
    required = set(schema.get("required", []))
    for key, given in schema.get("properties", {}).items():
        sub = resolve(given, root)
        default = "required" if key in required else f"`{json.dumps(sub['default'])}`" if "default" in sub else ""
        kind = type_text(given, root)
        if "$ref" not in given and sub.get("type") == "object" and sub.get("properties"):
            inner.append((key, sub))
        lines.append(f"| `{key}` | {cell(kind)} | {cell(default)} | {cell(sub.get('description', ''))} |")
    lines.append("")
    for key, sub in inner:
        lines += [f"{'#' * depth} `{key}` of the above", "", sub.get("description", ""), ""] + table(sub, root, depth + 1)
    return lines


def section(name, schema, root, depth):
    lines = [f"{'#' * depth} {name}", ""]
    if schema.get("description"):
        lines += [schema["description"], ""]
    if "oneOf" in schema:
        for branch in schema["oneOf"]:
            if "$ref" in branch:
                continue
            const = branch.get("properties", {}).get("kind", {}).get("const")
            title = f"`{const}`: " if const else ""
            lines += [f"**{title}**{branch.get('description', '')}" if title else branch.get("description", ""), ""]
            lines += table(branch, root, depth + 1)
        if all("$ref" in b for b in schema["oneOf"]):
            lines += ["One of " + ", ".join(type_text(b, root) for b in schema["oneOf"]) + ".", ""]
        return lines
    if "items" in schema:
        items = resolve(schema["items"], root)
        return lines + (table(items, root, depth + 1) if items.get("properties") else [])
    return lines + table(schema, root, depth + 1)


def reference(root):
    lines = section("scene", {**root, "description": root["description"]}, root, 3)
    for name, schema in root["$defs"].items():
        lines += section(name, schema, root, 3)
    metric = root["$defs"]["expectation"]["properties"]["metric"]
    lines += ["### metrics", "", "| metric | meaning |", "|---|---|"]
    for entry in metric["description"].split("; "):
        word, _, meaning = entry.partition(": ")
        lines.append(f"| `{word}` | {cell(meaning)} |")
    return "\n".join(lines).rstrip() + "\n"


def gallery():
    """Every scene with its picture, where tools/scene_pictures.py has made one."""
    lines = []
    for path in sorted((ROOT / "scenes").glob("*.json")):
        scene = read_scene(path)
        lines += [f"**[{path.stem}](../scenes/{path.name})**: {scene.get('description', '')}", ""]
        if (ROOT / "docs/pictures/scenes" / f"{path.stem}.png").exists():
            lines += [f"![{path.stem}](pictures/scenes/{path.stem}.png)", ""]
    return "\n".join(lines)


def number_text(value):
    """A number, or a table by intensity."""
    if isinstance(value, dict):
        return "by intensity " + ", ".join(f"{x:g}: {y:g}" for x, y in value["table"])
    return f"{value:g}"


def presets():
    """Every known material with its numbers and source."""
    lines = ["| preset | for | numbers | source |", "|---|---|---|---|"]
    for name, preset in json.loads((ROOT / "schema" / "presets.json").read_text(encoding="utf-8"))["presets"].items():
        groups = {}
        for kind, keys in preset.get("bodies", {}).items():
            groups.setdefault(json.dumps(keys), (keys, []))[1].append(kind)
        for group in ("material", "pair"):
            if group in preset:
                groups[group] = (preset[group], ["a material" if group == "material" else "a pair of materials"])
        for keys, users in groups.values():
            numbers = ", ".join(f"{key} {number_text(value)}" for key, value in keys.items())
            lines.append(f"| `{name}` | {', '.join(users)} | {numbers} | {cell(preset['source'])} |")
    return "\n".join(lines) + "\n"


def main():
    root = json.loads((ROOT / "schema" / "scene.schema.json").read_text(encoding="utf-8"))
    page = PAGE.read_text(encoding="utf-8")
    opening, second, rest = page.partition(PRESETS)
    _, third, rest = rest.partition(PRESETS_END)
    head, first, rest = rest.partition(GALLERY)
    _, end, rest = rest.partition(GALLERY_END)
    between, mark, _ = rest.partition(MARK)
    for line, found in ((PRESETS, second), (PRESETS_END, third), (GALLERY, first), (GALLERY_END, end), (MARK, mark)):
        if not found:
            sys.exit(f"{PAGE}: the line {line.strip()} is missing")
    head = opening + PRESETS + presets() + PRESETS_END + head
    text = head + GALLERY + "\n" + gallery() + GALLERY_END + between + MARK + "\n" + reference(root)
    if "--check" in sys.argv:
        if text != page:
            sys.exit("docs/scenes.md: not up to date with schema and scenes; run tools/scene_reference.py")
        return
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
