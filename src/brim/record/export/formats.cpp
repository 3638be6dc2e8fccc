#include <array>

#include "brim/record/export/format.h"

namespace brim::exporting {

std::span<const Format> formats() {
  static constexpr auto kFormats = std::to_array<Format>({
      {"vtk", "VTK XML, one file per body and frame and a .pvd collection: ParaView, VTK", false, true, make_vtk},
      {"vtu", "the same, elastic solids as their elements with stress and strain: ParaView, VTK", true, true, make_vtu},
      {"xdmf", "XDMF 3 with HDF5, one pair of files: ParaView, VisIt", false, true, make_xdmf},
      {"obj", "Wavefront OBJ, one file per frame: nearly everything", false, false, make_obj},
      {"ply", "binary PLY, one file per body and frame, with velocities: Houdini, Blender, MeshLab", false, true,
       make_ply},
      {"gltf", "binary glTF 2.0, one animated file: browsers, Blender, game engines", false, false, make_gltf},
      {"usda", "USD as text, one animated file: Houdini, Blender, Omniverse, Maya", false, true, make_usda},
      {"npz", "every recorded array, one file: NumPy", false, false, make_npz},
#ifdef BRIM_HAS_OPENVDB
      {"vdb", "OpenVDB, the density of every body, one file per frame: Houdini, Blender", true, false, make_vdb},
#endif
  });
  return kFormats;
}

}  // namespace brim::exporting
