#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "brim/core/error.h"
#include "brim/mesh/mass_properties.h"
#include "brim/mesh/voxel_image.h"

namespace brim {

/// Volume fraction of matter in the cubic cells of a regular grid: an image as a solid, at the resolution of contact.
/// Cell (i, j, k) has its centre at origin + spacing (i, j, k). The outermost cells are empty.
struct OccupancyGrid {
  Vec3 origin = Vec3::Zero();  ///< [m] centre of cell (0, 0, 0)
  double spacing = 0.0;        ///< [m]
  Vec3i cells = Vec3i::Zero();
  std::vector<std::uint8_t> share;  ///< 0 empty to 255 full, shape (nz, ny, nx), x fastest

  std::size_t index(int i, int j, int k) const {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(cells.x()) *
               (static_cast<std::size_t>(j) + static_cast<std::size_t>(cells.y()) * static_cast<std::size_t>(k));
  }
  Vec3 center(int i, int j, int k) const { return origin + spacing * Vec3(i, j, k); }
  /// Box of the cells with matter, [m]. Empty when there are none.
  Aabb matter_box() const;
  /// Middle of the matter's extents, [m]: along each axis midway between the outermost places where the fullest cell of
  /// a layer is half full, between centres; without such, of the box of all cells with matter.
  Vec3 middle() const;
};

/// No cell of a volume is half filled.
struct NoMatter : InputError {
  using InputError::InputError;
};

/// Samples the matter of an image on cells along its frame's axes. Each cell is the mean of at least 2x2x2 trilinear
/// values mapped through the window, two or more per image voxel: antialiased, and with sub-voxel accuracy if the
/// window spans the image's own ramp.
/// @param spacing    [m] of the cells
/// @param max_cells  largest number of cells
/// @throws InputError  when the grid would exceed max_cells  @throws NoMatter
/// Same bits for any number of threads.  Tests: tests/mesh/occupancy_test.cpp
OccupancyGrid sample_occupancy(const VoxelImage& image, const IntensityWindow& window, double spacing,
                               std::size_t max_cells = std::size_t{1} << 30);

/// Mean of a function of the intensities over each cell of a grid, at the samples of sample_occupancy; zero outside the
/// image. For a material quantity the function is share(I) times quantity(I), and the result is the mean over the whole
/// cell: mass is the cell's volume times such a density.
/// @param image  the same frame as the grid's
/// @return shape (nz, ny, nx); the outermost cells are 0
/// Same bits for any number of threads.
std::vector<float> cell_means(const VoxelImage& image, const OccupancyGrid& grid,
                              const std::function<double(double)>& of);
/// Such means for the cells of joined_cells. @param values  of the grid's cells
std::vector<float> joined_means(const OccupancyGrid& grid, std::span<const float> values, int factor);

/// The same matter in cells `factor` times as wide, by averaging; one ring of empty cells stays around.
OccupancyGrid joined_cells(const OccupancyGrid& grid, int factor);
/// The same with factor 2, single-threaded: a level of a pyramid (box filter).
OccupancyGrid halved_cells(const OccupancyGrid& grid);
/// The same matter with additional rings of empty cells.
OccupancyGrid widened_cells(const OccupancyGrid& grid, int rings);

/// Empties all cells except those of the largest piece (cells at least half filled, connected across faces) and their
/// neighbours. @return number of pieces before
std::size_t keep_largest_piece(OccupancyGrid& grid);
/// Likewise keeps only the piece nearest to a point, by the centres of its filled cells. @param seed  [m]
std::size_t keep_piece_at(OccupancyGrid& grid, const Vec3& seed);
/// Likewise removes all pieces smaller than a volume. @param volume  [m³] of cells at least half filled
std::size_t keep_pieces_above(OccupancyGrid& grid, double volume);

/// Volume, mass, centre and inertia of the matter; each cell a cube of constant density.
/// @throws InputError  when there is none
MassProperties mass_properties(const OccupancyGrid& grid, double density);

/// The same for matter of varying density.
/// @param density  [kg/m³] of each whole cell (cell_means); cells without matter are ignored
MassProperties mass_properties(const OccupancyGrid& grid, std::span<const float> density);

/// The level surface at half filling, for display: closed, outward. The grid is reduced by integer factors until it has
/// at most max_nodes nodes.
TriMesh display_surface(const OccupancyGrid& grid, std::size_t max_nodes = 1'000'000);

}  // namespace brim
