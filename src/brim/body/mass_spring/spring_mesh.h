#pragma once

#include <array>
#include <vector>

#include "brim/body/particles/spring_elements.h"
#include "brim/mesh/tri_mesh.h"

namespace brim {

/// Lines between points: a net, a truss.
struct LineMesh {
  std::vector<Vec3> vertices;                      ///< [m]
  std::vector<std::array<std::int32_t, 2>> lines;  ///< vertex indices
};

/// Rectangular net in the plane z = 0, centred: strings along x and y, nx by ny meshes. Vertex (i, j) is i + (nx+1) j.
/// @throws InputError  when a size is not positive or a count is below 1
LineMesh square_net(int nx, int ny, double lx, double ly);

/// Springs and masses of a body from its cells: tetrahedra, triangles or lines, of measure m in m³, m² or m. Each edge
/// of a cell is a spring,
///   k = Y Σ m / L²                                         (Van Gelder, Approximate simulation of elastic membranes by
///                                                           triangulated spring meshes, 1998)
/// over the cells at the edge; each cell gives its mass in equal shares to its corners. For a line k = Y / L.
/// On equilateral triangles Y is exactly Young's modulus of the sheet, with Poisson's ratio 1/3; springs of a solid
/// always have 1/4, and match Y up to a factor that depends on the mesh (docs/bodies/mass_spring.md).
struct SpringMesh {
  std::vector<Spring> springs;  ///< sorted by their ends
  std::vector<double> mass;     ///< [kg] per vertex
  double measure = 0.0;         ///< of all cells, [m³, m² or m]
};

/// @param stiffness  Y [Pa, N/m or N]  @param density  [kg/m³, kg/m² or kg/m]
/// @throws InputError  when a cell has no measure or names a missing vertex, or a vertex is in no cell
SpringMesh make_springs(const TetMesh& mesh, double stiffness, double density);
SpringMesh make_springs(const TriMesh& mesh, double stiffness, double density);
SpringMesh make_springs(const LineMesh& mesh, double stiffness, double density);

}  // namespace brim
