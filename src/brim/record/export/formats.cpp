#include <array>

#include "brim/record/export/format.h"

namespace brim::exporting {

std::span<const Format> formats() {
  static constexpr auto kFormats = std::to_array<Format>({
      {"vtk", "VTK XML, one file per body and frame and a .pvd collection: ParaView, VTK", false, make_vtk},
      {"vtu", "the same, elastic solids as their elements with stress and strain: ParaView, VTK", true, make_vtu},
      {"xdmf", "XDMF 3 with HDF5, one pair of files: ParaView, VisIt", false, make_xdmf},
      {"obj", "Wavefront OBJ, one file per frame: nearly everything", false, make_obj},
      {"ply", "binary PLY, one file per body and frame, with velocities: Houdini, Blender, MeshLab", false, make_ply},
      {"gltf", "binary glTF 2.0, one animated file: browsers, Blender, game engines", false, make_gltf},
      {"usda", "USD as text, one animated file: Houdini, Blender, Omniverse, Maya", false, make_usda},
      {"npz", "every recorded array, one file: NumPy", false, make_npz},
#ifdef BRIM_HAS_OPENVDB
      {"vdb", "OpenVDB, the density of every body, one file per frame: Houdini, Blender", true, make_vdb},
#endif
  });
  return kFormats;
}

}  // namespace brim::exporting
