"""Scenes and tables of brim as data: JSON in which comments are allowed."""

import json
import pathlib
import re

STRING_OR_COMMENT = re.compile(r'("(?:[^"\\]|\\.)*")|//[^\n]*|/\*.*?\*/', flags=re.S)


def read_scene(path):
    text = pathlib.Path(path).read_text(encoding="utf-8")
    return json.loads(STRING_OR_COMMENT.sub(lambda match: match.group(1) or "", text))
