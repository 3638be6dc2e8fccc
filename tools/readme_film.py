#!/usr/bin/python3
"""Makes the film of the README, docs/pictures/mixed_stack.webp, from scenes/mixed_stack.json by `brim run` and `brim render`.

  tools/readme_film.py                      runs the scene into out/readme_film, renders it and packs the film
  tools/readme_film.py --run out/demo       films a run that is there
  tools/readme_film.py --pictures FOLDER    packs pictures that are there

Pages of repositories show an animated WebP where they show a picture. Every second frame of the run is shown for 1/30 s, so that
it plays in its own time; the last stays for a second. Needs what `brim render` needs, and Pillow (Debian: python3-pil).
"""

import argparse
import pathlib
import shutil
import subprocess
import sys

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "docs/pictures/mixed_stack.webp"
WORK = ROOT / "out/readme_film"
STRIDE, SHOWN, LAST_SHOWN = 2, 33, 1000  # [frames], [ms], [ms]
LIMIT = 3_000_000  # [bytes] that a page may load at once


def rendered(run, brim):
    """Folder with a picture of every frame of a run."""
    film = WORK / "film.mp4"
    subprocess.run([brim, "render", run, "-o", film, "--size", "600x440", "--fps", "60", "--camera=-62,22,12.5"], check=True)
    pictures = film.with_suffix("")  # where pictures go without ffmpeg
    if film.exists():
        pictures.mkdir(exist_ok=True)
        subprocess.run([shutil.which("ffmpeg"), "-loglevel", "error", "-y", "-i", film, pictures / "frame_%05d.png"], check=True)
    return pictures


def main(arguments):
    parser = argparse.ArgumentParser(description="Makes the film of the README.")
    parser.add_argument("--run", type=pathlib.Path)
    parser.add_argument("--pictures", type=pathlib.Path)
    parser.add_argument("--brim", type=pathlib.Path, default=ROOT / "build/release/brim")
    options = parser.parse_args(arguments)
    pictures = options.pictures
    if not pictures:
        run = options.run or WORK / "run"
        if not options.run:
            subprocess.run([options.brim, "run", ROOT / "scenes/mixed_stack.json", "-o", run, "--force"], check=True)
        pictures = rendered(run, options.brim)
    files = sorted(pictures.glob("frame_*.png"))[::STRIDE]
    if not files:
        sys.exit(f"no pictures in {pictures}")
    first, *rest = (Image.open(file).convert("RGB") for file in files)
    first.save(OUT, save_all=True, append_images=rest, duration=[SHOWN] * len(rest) + [LAST_SHOWN], loop=0, quality=80, method=6)
    size = OUT.stat().st_size
    print(f"{OUT}: {len(files)} pictures, {size / 1e6:.2f} MB")
    return 0 if size < LIMIT else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
