#!/usr/bin/env python3
"""Runs scenes and renders one picture of each, docs/pictures/scenes/<scene>.png.

  tools/scene_pictures.py                       every scene in scenes/
  tools/scene_pictures.py bridge drape          these
  tools/scene_pictures.py --reuse bridge        from the run of last time, if it is there

How many frames to run and what to look at (frame, camera, slice) is in the table below; the rest run to their end and show
their last frame. Runs stay in out/pictures/. Pictures are written anew as small as PNG gets, 100 to 200 kB, by Pillow.
"""

import argparse
import pathlib
import subprocess
import sys
import time

import with_numpy

with_numpy.need("PIL")

from PIL import Image  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
SIZE = "960x540"
MOST = 200_000  # [bytes] of a picture as it is rendered; what is above is rounded

# scene: (frames to run, 0 for all; options of brim render). "--frame" counts from the end when negative.
LOOKS = {
    "arch": (20, ["--camera", "-75,14", "--contacts", "forces"]),
    "bounce": (0, ["--frame", "30"]),
    "box_stack": (120, []),
    "bridge": (60, ["--camera", "-70,16"]),
    "chain_drape": (100, []),
    "cloth_pour": (40, ["--surface", "all", "--colour", "water=#4f9fd0,cloth=#e2a03f"]),
    "constraint_stack": (60, ["--contacts", "forces"]),
    "ct_cloth": (40, ["--camera", "-62,20"]),
    "ct_head": (40, ["--camera", "-62,20,0.8"]),
    "dam_break": (30, ["--surface", "all", "--camera", "-68,20,4.2"]),
    "dam_large": (34, ["--surface", "all", "--camera", "-68,22,4.5"]),
    "dominoes": (0, ["--frame", "66", "--camera", "-62,18"]),
    "drape": (70, []),
    "edited_kinds": (0, ["--frame", "45"]),
    "folds": (371, ["--camera", "30,15"]),
    "grain_heap": (60, []),
    "grid_float": (120, []),
    "gripper": (120, []),
    "hanging_laundry": (60, ["--camera", "-62,12"]),
    "image_drop": (72, []),
    "impact_wall": (0, ["--frame", "12", "--camera", "-130,14"]),
    "incline_frictionless": (60, ["--camera", "-90,8", "--contacts", "forces"]),
    "incline_slide": (60, ["--camera", "-90,8", "--contacts", "forces"]),
    "incline_slip": (60, ["--camera", "-90,8", "--contacts", "forces"]),
    "incline_stick": (60, ["--camera", "-90,8", "--contacts", "forces"]),
    "joined_kinds": (40, ["--camera", "-62,16"]),
    "knot": (337, ["--camera", "30,35,0.9"]),
    "levels": (60, ["--camera", "-75,18", "--contacts", "voxels"]),
    "mass_ratio": (120, ["--contacts", "forces"]),
    "meshless_drop": (60, []),
    "mixed_stack": (40, ["--camera", "-62,24"]),
    "net_catch": (60, []),
    "overlap_start": (30, []),
    "pile": (57, ["--camera", "-62,72"]),
    "pool_block": (20, ["--surface", "all", "--colour", "water=#4f9fd0,block=#e2a03f"]),
    "pool_rack": (40, ["--camera", "-62,32"]),
    "real_meshes": (50, ["--frame", "32", "--camera", "-62,9"]),
    "rope_post": (90, []),
    "three_sheets": (50, []),
    "toys": (0, ["--frame", "92", "--camera", "-62,16"]),
    "water_drop": (60, ["--frame", "34"]),
    "stones": (360, ["--camera", "-62,42,2.6"]),
    "wind_field": (0, ["--frame", "200", "--camera", "-70,8"]),
    "wired_kinds": (30, ["--camera", "-62,10"]),
    "wrecking_ball": (100, ["--frame", "75", "--camera", "-35,18"]),
}


def lighter(picture):
    """The picture with its levels rounded to multiples of 3: none is off by more than 1 of 255, and a third of the bytes is saved."""
    return picture.convert("RGB").point([3 * ((level + 1) // 3) for level in range(256)] * 3)


def picture_of(brim, scene, runs, pictures, reuse, frames):
    """Runs and renders one scene; returns a line that says how it went. Raises CalledProcessError."""
    run, out = runs / scene.stem, pictures / f"{scene.stem}.png"
    start = time.monotonic()
    length, looks = LOOKS.get(scene.stem, (0, []))
    if not (reuse and (run / "summary.json").exists()):
        length = min((n for n in (frames, length) if n), default=0)
        subprocess.run([brim, "run", scene, "-o", run, "--force", "--quiet",
                        *(["--frames", str(length)] if length else [])], check=True, stdout=subprocess.DEVNULL)
    ran = time.monotonic()
    part = out.with_suffix(".part.png")
    try:
        subprocess.run([brim, "render", run, "-o", part, "--size", SIZE,
                        *([] if "--frame" in looks else ["--frame", "-1"]), *looks],
                       check=True)
        with Image.open(part) as picture:  # in true colours: a palette has few left for small bodies before a wide sky
            picture.convert("RGB").save(out, optimize=True)
            if out.stat().st_size > MOST:
                lighter(picture).save(out, optimize=True)
    finally:
        part.unlink(missing_ok=True)
    return (f"{scene.stem}: run {ran - start:.0f} s, picture {time.monotonic() - ran:.0f} s, "
            f"{out.stat().st_size / 1000:.0f} kB")


def main(arguments):
    parser = argparse.ArgumentParser(description="Runs scenes and renders one picture of each.")
    parser.add_argument("scenes", nargs="*", help="names of scenes; default all")
    parser.add_argument("--brim", default=ROOT / "build/release/brim", type=pathlib.Path)
    parser.add_argument("--reuse", action="store_true", help="render runs of last time again where they are there")
    parser.add_argument("--frames", type=int, help="at most so many frames, for a quick look")
    options = parser.parse_args(arguments)
    known = {path.stem: path for path in sorted((ROOT / "scenes").glob("*.json"))}
    unknown = [name for name in options.scenes if name not in known]
    if unknown:
        parser.error(f"no such scene: {', '.join(unknown)}; there are {', '.join(known)}")
    runs, pictures = ROOT / "out/pictures", ROOT / "docs/pictures/scenes"
    runs.mkdir(parents=True, exist_ok=True)
    pictures.mkdir(parents=True, exist_ok=True)
    bad = 0
    for name in options.scenes or known:
        try:
            print(picture_of(options.brim.resolve(), known[name], runs, pictures, options.reuse, options.frames),
                  flush=True)
        except subprocess.CalledProcessError as error:
            bad += 1
            print(f"{name}: {error.cmd[1]} failed with exit code {error.returncode}", file=sys.stderr, flush=True)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
