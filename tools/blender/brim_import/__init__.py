"""Blender add-on: imports a run of brim (its folder's run.h5) with motion, colours and particles. See docs/blender.md."""

bl_info = {
    "name": "brim runs",
    "description": "Imports recorded runs of brim with their motion, colours and particles",
    "author": "the authors of brim",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "File > Import > brim run (run.h5)",
    "category": "Import-Export",
}

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import playback


class ImportRun(bpy.types.Operator, ImportHelper):
    """Import a run of brim. Its motion is read from run.h5 frame by frame and needs this add-on"""

    bl_idname = "import_scene.brim"
    bl_label = "Import brim run"
    bl_options = {"UNDO"}

    filename_ext = ".h5"
    filter_glob: StringProperty(default="*.h5", options={"HIDDEN"})
    particles: EnumProperty(
        name="Particles",
        items=(("SPHERES", "Spheres", "Every particle as a sphere of its radius"),
               ("SURFACE", "Surface of fluids", "Fluids as the surface around their particles, other particles as spheres")),
        default="SPHERES")
    stage: BoolProperty(name="Camera, light and ground", default=True,
                        description="Also set frame rate, camera, light and ground to suit the run")

    def execute(self, context):
        try:
            import h5py  # noqa: F401
        except ImportError:
            self.report({"ERROR"}, "Blender's Python has no h5py: docs/blender.md of brim says how to install it")
            return {"CANCELLED"}
        from . import importer, stage
        try:
            collection = importer.import_run(self.filepath, surface=self.particles == "SURFACE")
        except (OSError, KeyError) as error:
            self.report({"ERROR"}, f"{self.filepath} cannot be read as a run: {error}")
            return {"CANCELLED"}
        if self.stage:
            stage.set_stage(context.scene, playback.source_of(collection))
        return {"FINISHED"}


def menu_entry(self, _context):
    self.layout.operator(ImportRun.bl_idname, text="brim run (run.h5)")


def register():
    bpy.utils.register_class(ImportRun)
    bpy.types.TOPBAR_MT_file_import.append(menu_entry)
    playback.register()


def unregister():
    playback.unregister()
    bpy.types.TOPBAR_MT_file_import.remove(menu_entry)
    bpy.utils.unregister_class(ImportRun)
