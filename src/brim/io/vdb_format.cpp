// Without OpenVDB such files are refused with the reason.
#ifdef BRIM_HAS_OPENVDB
#include <openvdb/openvdb.h>
#endif

#include "brim/core/error.h"
#include "brim/io/child_reader.h"
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
    file.open(false);  // at once: what is put off is copied beside, and read where nobody expects it
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

/// A grid and its active box, with a voxel of background around it.
struct OpenGrid {
  openvdb::GridBase::Ptr grid;
  openvdb::Coord first;
  Vec3i size;
};

OpenGrid open_box(const std::string& path, const std::string& wanted) {
  OpenGrid open{open_grid(path, wanted), {}, Vec3i::Zero()};
  const auto box = open.grid->evalActiveVoxelBoundingBox();
  if (box.empty()) throw InputError(fmt::format("{}: grid '{}' has no active voxels", path, open.grid->getName()));
  if (!open.grid->transform().isLinear())
    throw InputError(fmt::format("{}: grid '{}' is not on a regular lattice", path, open.grid->getName()));
  // Far from the border of 32 bits, so that a voxel more on each side has a place.
  constexpr int kMost = 1 << 30;
  for (int a = 0; a < 3; ++a)
    if (box.min()[a] < -kMost || box.max()[a] > kMost)
      throw InputError(fmt::format("{}: grid '{}' has voxels too far from its origin", path, open.grid->getName()));
  open.first = box.min().offsetBy(-1);
  for (int a = 0; a < 3; ++a) open.size[a] = box.max()[a] - box.min()[a] + 3;
  return open;
}

/// What the parent has to know of it.
struct GridHead {
  VoxelType type;
  bool level_set;
  Vec3i size;
  Vec3 origin;
  Mat3 axes;
};

GridHead head_of(const OpenGrid& open) {
  const openvdb::GridBase& grid = *open.grid;
  GridHead head;
  head.type = grid.isType<openvdb::DoubleGrid>()  ? VoxelType::Float64
              : grid.isType<openvdb::Int32Grid>() ? VoxelType::Int32
              : grid.isType<openvdb::Int64Grid>() ? VoxelType::Int64
                                                  : VoxelType::Float32;
  head.level_set = grid.getGridClass() == openvdb::GRID_LEVEL_SET;
  head.size = open.size;
  const auto at = [&](const openvdb::Coord& c) {
    const auto p = grid.transform().indexToWorld(c);
    return Vec3(p.x(), p.y(), p.z());
  };
  head.origin = at(open.first);
  for (int a = 0; a < 3; ++a) head.axes.col(a) = at(open.first.offsetBy(a == 0, a == 1, a == 2)) - head.origin;
  return head;
}

void put_slice(const OpenGrid& open, int k, ChildReader::Answer& answer) {
  std::vector<double> row(static_cast<std::size_t>(open.size.x()));
  open.grid->apply<GridTypes>([&](const auto& grid) {
    auto values = grid.getConstAccessor();
    for (int j = 0; j < open.size.y(); ++j) {
      for (int i = 0; i < open.size.x(); ++i)
        row[static_cast<std::size_t>(i)] = static_cast<double>(values.getValue(open.first.offsetBy(i, j, k)));
      answer.put(row.data(), row.size() * sizeof(double));
    }
  });
}

constexpr int kHead = -1;  // of questions; the others are slices

/// The library reads on behind the end of a damaged file until its processor time ends: a sound one of 1 MiB is open in
/// hundredths of a second.
ChildReader::Load load_of(const std::string& path) {
  constexpr double kOpening = 4.0;  // [s]
  ChildReader::Load load = ChildReader::load_of(path);
  load.opening = kOpening;
  return load;
}

/// Slices from the process that has the grid.
class VdbSlices final : public SliceSource {
 public:
  VdbSlices(const std::string& path, const std::string& wanted)
      : reader_(path, load_of(path),
                [path, wanted, open = OpenGrid()](int question, ChildReader::Answer& answer) mutable {
                  if (!open.grid) open = open_box(path, wanted);
                  if (question != kHead) return put_slice(open, question, answer);
                  answer.put(head_of(open));
                  answer.put_text(open.grid->getName());
                }) {}

  ChildReader::Received head() { return reader_.ask(kHead); }
  void read(int k, std::span<double> out) override { reader_.ask(k).get(out.data(), out.size_bytes()); }

 private:
  ChildReader reader_;
};

}  // namespace

VolumeInfo read_vdb_info(const std::string& path, const std::string& wanted) {
  const auto slices = std::make_shared<VdbSlices>(path, wanted);
  ChildReader::Received received = slices->head();
  const auto head = received.get<GridHead>();
  VolumeInfo info;
  info.path = info.data_path = path;
  info.format = fmt::format("OpenVDB, grid '{}'", received.get_text());
  info.type = head.type;
  info.encoding = VolumeInfo::Encoding::Slices;
  // Level sets are distances, negative inside: matter is where intensity is large.
  if (head.level_set) info.slope = -1.0;
  info.unit = 1.0;
  info.unit_given = true;
  info.size = head.size;
  info.origin = head.origin;
  info.axes = head.axes;
  info.slices = slices;
  return info;
}

#else

VolumeInfo read_vdb_info(const std::string& path, const std::string&) {
  throw InputError(path + ": this brim was built without OpenVDB and cannot read .vdb files (docs/dependencies.md)");
}

#endif

}  // namespace brim
