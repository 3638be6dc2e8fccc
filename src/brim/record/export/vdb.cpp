// Without OpenVDB the format is left out of the registry.
#ifdef BRIM_HAS_OPENVDB

#include <openvdb/openvdb.h>

#include <algorithm>

#include "brim/core/error.h"
#include "brim/record/export/format.h"

namespace brim::exporting {

namespace {

constexpr std::size_t kBatch = 512;  // tiles rasterized together: 6 MB

/// Box of everything finite: what of an endless body is worth writing, with a tile around it.
Aabb finite_box(const World& world) {
  Aabb box;
  for (int p = 0; p < world.part_count(); ++p) {
    const PartRef part = world.part(p);
    const Aabb b = world.body(part.body).bounds(part.index);
    if (world.removed(part.body)) continue;
    if (b.lo.allFinite() && b.hi.allFinite() && !b.empty()) box.extend(b);
  }
  if (box.empty()) return {Vec3::Constant(-1.0), Vec3::Constant(1.0)};
  return box;
}

/// OpenVDB: frame_00012.vdb with one FloatGrid per body, named as the body's files are in other formats; values are
/// the densities that contact sees, on the nodes of brim's grid. Parts of a body add up, to 1 at most.
class VdbWriter : public Writer {
 public:
  explicit VdbWriter(const Job& job) : job_(job) { openvdb::initialize(); }

  void frame(const Frame& frame) override {
    const World& world = job_.world_at(frame.index);
    const Aabb box = finite_box(world);
    openvdb::GridPtrVec grids;
    for (const Item& item : job_.items) grids.push_back(body(world, item, box));
    const std::string path = (job_.folder / numbered("frame", frame.index, "vdb")).string();
    try {
      openvdb::io::File file(path);
      openvdb::MetaMap about;
      about.insertMeta("time", openvdb::DoubleMetadata(frame.time));
      about.insertMeta("creator", openvdb::StringMetadata("brim"));
      file.write(grids, about);
      file.close();
    } catch (const openvdb::Exception& error) {
      throw InputError(fmt::format("{}: cannot be written: {}", path, error.what()));
    }
  }

  ItemPlace place(const Item& item) const override { return {.file = pattern("frame", "vdb"), .path = item.file_name}; }

 private:
  double voxel_size(const World& world, int body) const {
    if (job_.voxel_size > 0.0) return job_.voxel_size;
    double own = 0.0, any = world.options().voxel_size;
    for (int p = 0; p < world.part_count(); ++p) {
      const PartRef part = world.part(p);
      const double h = world.body(part.body).part(part.index).voxel_size;
      if (h > 0.0 && part.body == body && (own == 0.0 || h < own)) own = h;
      if (h > 0.0 && (any == 0.0 || h < any)) any = h;
    }
    return own > 0.0 ? own : any > 0.0 ? any : 0.05;
  }

  openvdb::FloatGrid::Ptr body(const World& world, const Item& item, const Aabb& box) {
    const double h = voxel_size(world, item.body), ramp = world.options().ramp_voxels * h;
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setName(item.file_name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(h));
    for (int p = 0; p < world.part_count(); ++p) {
      const PartRef part = world.part(p);
      if (part.body != item.body || world.removed(part.body)) continue;
      const Body& b = world.body(part.body);
      tiles_.clear();
      b.presence(part.index, h, ramp, b.bounds(part.index).inflated(ramp).intersection(box.inflated(kTileSize * h)),
                 tiles_);
      sort_unique(tiles_);
      for (std::size_t first = 0; first < tiles_.size(); first += kBatch) {
        const auto batch = std::span(tiles_).subspan(first, std::min(kBatch, tiles_.size() - first));
        if (blocks_.size() < batch.size()) blocks_.resize(batch.size());
        world.density(p, h, batch, std::span(blocks_).first(batch.size()));
        for (std::size_t t = 0; t < batch.size(); ++t) add(batch[t], blocks_[t], *grid);
      }
    }
    grid->pruneGrid();
    return grid;
  }

  /// A tile of brim is a leaf of OpenVDB: both have 8³ nodes that start at multiples of 8.
  static void add(const TileKey& tile, const DensityBlock& block, openvdb::FloatGrid& grid) {
    static_assert(openvdb::FloatGrid::TreeType::LeafNodeType::DIM == kTileSize);
    bool empty = true;
    for (int n = 0; n < kBlockNodes && empty; ++n) empty = block.rho[n] <= 0.0;
    if (empty) return;
    const openvdb::Coord origin(tile.x * kTileSize, tile.y * kTileSize, tile.z * kTileSize);
    auto* leaf = grid.tree().touchLeaf(origin);
    for (int k = 0; k < kTileSize; ++k)
      for (int j = 0; j < kTileSize; ++j)
        for (int i = 0; i < kTileSize; ++i) {
          const auto rho = static_cast<float>(block.rho[block_index(i + kHalo, j + kHalo, k + kHalo)]);
          if (rho <= 0.0f) continue;
          const openvdb::Coord at = origin.offsetBy(i, j, k);
          leaf->setValueOn(at, std::min(1.0f, leaf->getValue(at) + rho));
        }
  }

  const Job& job_;
  std::vector<TileKey> tiles_;
  std::vector<DensityBlock> blocks_;
};

}  // namespace

std::unique_ptr<Writer> make_vdb(const Job& job) { return std::make_unique<VdbWriter>(job); }

}  // namespace brim::exporting

#endif
