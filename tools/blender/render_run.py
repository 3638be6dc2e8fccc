"""Imports a run of brim and renders it, without a window:

    blender --background --python tools/blender/render_run.py -- RUN --render OUT.png --frame -1
"""

import argparse
import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import brim_import  # noqa: E402
from brim_import import importer, playback, stage  # noqa: E402


def arguments(words):
    parser = argparse.ArgumentParser(prog="blender --background --python render_run.py --", description=__doc__)
    parser.add_argument("run", help="a run's folder or its run.h5")
    parser.add_argument("--render", metavar="OUT", help="a picture (.png), a film (.mp4), or a folder of pictures of all frames")
    parser.add_argument("--save", metavar="FILE.blend", help="also save the scene")
    parser.add_argument("--frame", type=int, default=-1, help="of a picture, from 0; negative counts from the end")
    parser.add_argument("--step", type=int, default=1, help="of films and folders: every STEP-th frame")
    parser.add_argument("--size", default="1280x720", metavar="WxH", help="pixels")
    parser.add_argument("--samples", type=int, default=64, help="of Cycles, a pixel")
    parser.add_argument("--camera", default=f"{stage.AZIMUTH},{stage.ELEVATION}", metavar="A,E[,D]",
                        help="azimuth from +x towards +y and elevation [degrees], distance [m]")
    parser.add_argument("--surface", action="store_true", help="fluids as the surface around their particles")
    parser.add_argument("--colour", default="", metavar="NAME=#rrggbb,...", help="colours of bodies and their numbered copies")
    return parser.parse_args(words)


def main(words):
    wanted = arguments(words)
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    brim_import.register()
    colours = dict(pair.split("=") for pair in wanted.colour.split(",") if pair)
    collection = importer.import_run(wanted.run, wanted.surface, colours)
    source, scene = playback.source_of(collection), bpy.context.scene
    out = os.path.abspath(wanted.render) if wanted.render else ""
    single = out.lower().endswith(".png")
    frame = wanted.frame % source.frames if wanted.frame < 0 else min(wanted.frame, source.frames - 1)
    stage.set_stage(scene, source, tuple(int(n) for n in wanted.size.split("x")),
                    tuple(float(n) for n in wanted.camera.split(",")), [frame] if single else None)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = wanted.samples, False
    scene.cycles.sample_clamp_indirect, scene.cycles.caustics_refractive = 3.0, False  # few samples: no fireflies
    scene.frame_set(frame if single else 0)
    if wanted.save:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(wanted.save))
    if not out:
        return
    scene.frame_step = wanted.step
    scene.render.filepath = out if single or out.lower().endswith(".mp4") else os.path.join(out, "")
    if out.lower().endswith(".mp4"):
        scene.render.image_settings.file_format = "FFMPEG"
        scene.render.ffmpeg.format, scene.render.ffmpeg.codec = "MPEG4", "H264"
    bpy.ops.render.render(write_still=single, animation=not single)


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
