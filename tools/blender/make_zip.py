#!/usr/bin/env python3
"""Makes the add-on that Blender installs (Edit > Preferences > Add-ons > Install): tools/blender/make_zip.py [OUT.zip]."""

import pathlib
import sys
import zipfile

ADDON = pathlib.Path(__file__).resolve().parent / "brim_import"


def main(arguments):
    out = pathlib.Path(arguments[0] if arguments else "out/brim_blender.zip")
    out.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for source in sorted(ADDON.glob("*.py")):  # run_file.py is a link to tools/run_file.py; its text goes in
            archive.writestr(f"{ADDON.name}/{source.name}", source.read_text(encoding="utf-8"))
    print(out)


if __name__ == "__main__":
    main(sys.argv[1:])
