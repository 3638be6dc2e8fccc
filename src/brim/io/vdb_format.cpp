// Without OpenVDB such files are refused with the reason.
#ifdef BRIM_HAS_OPENVDB
#include <openvdb/openvdb.h>
#endif

#include "brim/core/error.h"
#include "brim/io/volume_formats.h"

namespace brim {

#ifdef BRIM_HAS_OPENVDB

namespace {

using GridTypes = openvdb::TypeList<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid, openvdb::Int64Grid>;

bool is_scalar(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>() || grid.isType<openvdb::Int32Grid>() ||
         grid.isType<openvdb::Int64Grid>();
}

/// The grid of the wanted name; without one that called "density", or the first of numbers.
openvdb::GridBase::Ptr open_grid(const std::string& path, const std::string& wanted) {
  openvdb::initialize();
  try {
    openvdb::io::File file(path);
    file.open();
    std::string chosen, present;
    for (auto name = file.beginName(); name != file.endName(); ++name) {
      const auto grid = file.readGridMetadata(name.gridName());
      present += fmt::format("{}'{}' ({})", present.empty() ? "" : ", ", name.gridName(), grid->valueType());
      const bool better = wanted.empty() ? chosen.empty() || name.gridName() == "density" : name.gridName() == wanted;
      if (is_scalar(*grid) && better) chosen = name.gridName();
    }
    if (chosen.empty())
      throw InputError(fmt::format("{}: no grid of numbers{}; there are: {}", path,
                                   wanted.empty() ? "" : fmt::format(" called '{}'", wanted),
                                   present.empty() ? "none" : present));
    return file.readGrid(chosen);
  } catch (const openvdb::Exception& error) {
    throw InputError(fmt::format("{}: not an OpenVDB file that can be read: {}", path, error.what()));
  }
}

/// Slices of a grid's active box, with a voxel of background around it.
class VdbSlices final : public SliceSource {
 public:
  VdbSlices(openvdb::GridBase::Ptr grid, const openvdb::Coord& first, const Vec3i& size)
      : grid_(std::move(grid)), first_(first), size_(size) {}

  void read(int k, std::span<double> out) override {
    grid_->apply<GridTypes>([&](const auto& grid) {
      auto values = grid.getConstAccessor();
      std::size_t at = 0;
      for (int j = 0; j < size_.y(); ++j)
        for (int i = 0; i < size_.x(); ++i) out[at++] = static_cast<double>(values.getValue(first_.offsetBy(i, j, k)));
    });
  }

 private:
  openvdb::GridBase::Ptr grid_;
  openvdb::Coord first_;
  Vec3i size_;
};

}  // namespace

VolumeInfo read_vdb_info(const std::string& path, const std::string& wanted) {
  const openvdb::GridBase::Ptr grid = open_grid(path, wanted);
  const auto box = grid->evalActiveVoxelBoundingBox();
  if (box.empty()) throw InputError(fmt::format("{}: grid '{}' has no active voxels", path, grid->getName()));
  if (!grid->transform().isLinear())
    throw InputError(fmt::format("{}: grid '{}' is not on a regular lattice", path, grid->getName()));
  VolumeInfo info;
  info.path = info.data_path = path;
  info.format = fmt::format("OpenVDB, grid '{}'", grid->getName());
  info.type = grid->isType<openvdb::DoubleGrid>()  ? VoxelType::Float64
              : grid->isType<openvdb::Int32Grid>() ? VoxelType::Int32
              : grid->isType<openvdb::Int64Grid>() ? VoxelType::Int64
                                                   : VoxelType::Float32;
  info.encoding = VolumeInfo::Encoding::Slices;
  // Level sets are distances, negative inside: matter is where intensity is large.
  if (grid->getGridClass() == openvdb::GRID_LEVEL_SET) info.slope = -1.0;
  info.unit = 1.0;
  info.unit_given = true;
  const openvdb::Coord first = box.min().offsetBy(-1);
  const openvdb::Coord size = box.dim().offsetBy(2);
  info.size = {size.x(), size.y(), size.z()};
  const auto at = [&](const openvdb::Coord& c) {
    const auto p = grid->transform().indexToWorld(c);
    return Vec3(p.x(), p.y(), p.z());
  };
  info.origin = at(first);
  for (int a = 0; a < 3; ++a) info.axes.col(a) = at(first.offsetBy(a == 0, a == 1, a == 2)) - info.origin;
  info.slices = std::make_shared<VdbSlices>(grid, first, info.size);
  return info;
}

#else

VolumeInfo read_vdb_info(const std::string& path, const std::string&) {
  throw InputError(path + ": this brim was built without OpenVDB and cannot read .vdb files (docs/dependencies.md)");
}

#endif

}  // namespace brim
