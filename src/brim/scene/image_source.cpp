#include "brim/scene/image_source.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>

#include "brim/core/parallel.h"
#include "brim/io/volume_reader.h"
#include "brim/mesh/intensity_table.h"
#include "brim/scene/given_arrays.h"
#include "brim/scene/image_labels.h"
#include "brim/scene/limits.h"
#include "brim/scene/solid_store.h"

namespace brim {

namespace {

/// Voxels of contact along the longest extent of an image when the scene does not say.
constexpr double kVoxelsAcross = 48.0;
/// Least voxel size over the image's own finest step.
constexpr double kLeastOfImage = 0.5;
/// [bytes] a cell takes: its share, and what the field of distances and the search for pieces add.
constexpr double kBytesPerVoxel = 6.0;
/// And with a table by intensity: its mean.
constexpr double kBytesPerTable = 4.0;

VolumeInfo read_info(const Node& n) {
  const Node file = n.at("file");
  return file.placed([&] {
    VolumeInfo info;
    if (n.has("raw")) {
      const Node raw = n.at("raw");
      RawLayout layout;
      layout.size = raw.vec3("size").cast<int>();
      layout.spacing = raw.vec3("spacing");
      layout.type = *voxel_type(raw.string("type"));
      layout.big_endian = raw.boolean("big_endian");
      layout.skip = static_cast<std::size_t>(raw.integer("skip"));
      info = raw_volume_info(scene_path(file), layout);
    } else {
      info = named_volume(file, n.has("grid") ? n.string("grid") : "", n.has("series") ? n.string("series") : "");
    }
    if (const auto unit = n.number_if("unit")) info.unit = *unit;
    return info;
  });
}

/// Samples a shape as a scanner would: intensity 1 inside, 0 outside, linear over a voxel at the surface.
VoxelImage image_of_shape(const Node& n, double limit) {
  SolidStore store;
  const Solid solid = read_solid(n, limit, store);
  const double step = n.at("transform").number("scale") * n.number("image_spacing");
  const Aabb box = solid.shape->bounds().inflated(1.5 * step);
  VoxelImage image;
  const Vec3 size = (box.extent() / step).array().ceil() + 1.0;
  check_count(n.at("image_spacing"), size.prod(), sizeof(float), limit, "voxels");
  image.size = size.cast<int>();
  image.axes = step * Mat3::Identity();
  image.origin = box.lo;
  image.values.resize(image.count());
  parallel_for(static_cast<std::size_t>(image.size.z()), [&](std::size_t k) {
    float* out = image.values.data() + k * static_cast<std::size_t>(image.size.x()) * image.size.y();
    for (int j = 0; j < image.size.y(); ++j)
      for (int i = 0; i < image.size.x(); ++i)
        *out++ = static_cast<float>(std::clamp(
            0.5 - solid.shape->distance(image.origin + step * Vec3(i, j, static_cast<double>(k))) / step, 0.0, 1.0));
  });
  return image;
}

std::string place_text(const Vec3& x) { return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", x.x(), x.y(), x.z()); }

/// What "keep" says. @param image  the volume  @param scale  of the body: lengths are those of the file
void keep_pieces(const Node& keep, const VoxelImage& image, OccupancyGrid& grid, double scale) {
  if (keep.json().is_string()) {
    if (keep.string() == "largest") keep_largest_piece(grid);
  } else if (keep.has("seed")) {
    const Aabb box = image.box();
    const Vec3 seed = scale * keep.vec3("seed");
    if (!box.inflated(image.axes.colwise().norm().maxCoeff()).overlaps({seed, seed}))
      throw keep.at("seed").error(fmt::format("{} m lies outside the volume, which goes from {} to {} m",
                                              shown(keep.at("seed").json()), place_text(box.lo / scale),
                                              place_text(box.hi / scale)));
    keep_piece_at(grid, seed);
  } else {
    keep_pieces_above(grid, keep.number("above") * scale * scale * scale);
    if (std::none_of(grid.share.begin(), grid.share.end(), [](std::uint8_t s) { return s >= 128; }))
      throw keep.at("above").error(
          fmt::format("{:.3g} m³ is more than any piece has; nothing is left", keep.number("above")));
  }
}

/// Keys that may be tables by intensity.
constexpr const char* kTables[] = {"density", "young_modulus"};

bool is_table(const Node& n, const char* key) { return n.has(key) && n.at(key).json().is_object(); }

IntensityTable read_table(const Node& n) {
  IntensityTable table;
  for (std::size_t i = 0; i < n.size(); ++i) {
    const Node point = n.at(i);
    table.points.emplace_back(point.at(std::size_t{0}).number(), point.at(std::size_t{1}).number());
    if (i > 0 && !(table.points[i - 1].first < table.points[i].first))
      throw point.error(fmt::format("{} is not allowed; intensities must ascend, and {} stands before it",
                                    shown(point.json()), table.points[i - 1].first));
    if (!(table.points[i].second > 0.0))
      throw point.error(fmt::format("{} is not allowed; the second must be positive", shown(point.json())));
  }
  return table;
}

/// Share of matter by intensity, as "window" or "labels" says.
std::function<double(double)> share_of(const Node& n) {
  if (n.has("labels"))
    return [labels = n.at("labels").integers()](double v) {
      return std::find(labels.begin(), labels.end(), static_cast<int>(std::lround(v))) != labels.end() ? 1.0 : 0.0;
    };
  const Node given = n.at("window");
  const IntensityWindow window{given.at(std::size_t{0}).number(), given.at(std::size_t{1}).number()};
  return [window](double v) { return window.share(v); };
}

/// The error of a file of which no voxel is half filled.
InputError no_voxel_counts(const Node& n, const IntensitySummary& held) {
  if (n.has("labels"))
    return n.at("labels").error(fmt::format("no matter is left: no voxel has one of the labels {}; the image holds {}",
                                            shown(n.at("labels").json()), listed_labels(held)));
  return n.at("window").error(fmt::format(
      "no matter is left: no voxel is half filled by intensities of the window {}; the image holds {:.6g} to "
      "{:.6g}",
      shown(n.at("window").json()), held.least, held.most));
}

/// The error of a body of whose cells none is half filled, at the key that is the cause.
/// @param extent  [m] of the volume  @param cell  [m]
InputError nothing_left(const Node& n, const VolumeInfo& info, const Vec3& extent, double voxel_size, double cell) {
  if (n.has("file")) {
    const IntensitySummary held = summarize_intensities(info, share_of(n));
    if (!(held.fullest >= 0.5)) return no_voxel_counts(n, held);
  }
  const Node at = voxel_size == n.number("voxel_size") ? n.at("voxel_size") : n;
  if (voxel_size > extent.maxCoeff())
    return at.error(
        fmt::format("the voxels of the scene, {:.6g} m, are larger than the volume, {:.4g} x {:.4g} x {:.4g} m",
                    voxel_size, extent.x(), extent.y(), extent.z()));
  return at.error(
      fmt::format("no matter is left: no cell of {:.3g} m is half filled; the voxels of the scene, {:.6g} m, "
                  "are too large for this matter",
                  cell, voxel_size));
}

}  // namespace

void check_image_source(const Node& n) {
  if (n.has("file") == n.has("shape"))
    throw n.error(n.has("file") ? "both \"file\" and \"shape\" are given; give one"
                                : "the key \"file\" is missing; give \"file\" or \"shape\"");
  if (n.has("shape")) {
    for (const char* key : {"raw", "unit", "grid", "series", "window", "labels"})
      if (n.has(key))
        throw n.at(key).error(fmt::format("only a \"file\" has \"{}\"; the image here is made of a shape", key));
    if (!n.has("image_spacing"))
      throw n.error("the key \"image_spacing\" is missing; a shape becomes an image of voxels of this size, in metres");
    refuse_plane(n.at("shape"), "volume");
    for (const char* key : kTables)
      if (is_table(n, key))
        throw n.at(key).error("only a \"file\" has intensities for a table; the image here is made of a shape");
    check_shape(n.at("shape"));
    return;
  }
  for (const char* key : kTables)
    if (is_table(n, key)) read_table(n.at(key).at("table"));
  if (n.has("image_spacing"))
    throw n.at("image_spacing").error("a \"file\" has its own voxels; only \"shape\" takes an image_spacing");
  if (n.has("window") == n.has("labels"))
    throw n.error(n.has("window")
                      ? "both \"window\" and \"labels\" are given; give one"
                      : "the key \"window\" is missing; it says which intensities of the file are matter: [lo, hi] "
                        "(or \"labels\", of a segmentation)");
  if (n.has("labels")) return;
  if (n.at("window").at(std::size_t{0}).number() > n.at("window").at(std::size_t{1}).number())
    throw n.at("window").error(
        fmt::format("{} is not allowed; the first must be at most the second", shown(n.at("window").json())));
}

ImageSolid read_image_solid(const Node& n, double scale, double cells_per_voxel, double limit, double finest) {
  ImageSolid solid;
  VoxelImage image;
  IntensityWindow window;
  VolumeInfo info;
  Vec3 step;
  Aabb box;
  if (n.has("shape")) {
    image = image_of_shape(n, limit);
    step = Vec3::Constant(image.finest_step());
    box = image.box();
  } else {
    info = read_info(n);
    info.unit *= scale;
    if (n.has("window")) {
      window.lo = n.at("window").at(std::size_t{0}).number();
      window.hi = n.at("window").at(std::size_t{1}).number();
    }
    step = info.steps();
    VoxelImage empty;
    empty.size = info.size;
    empty.axes = info.unit * info.axes;
    box = empty.box();
  }
  solid.voxel_size = n.number("voxel_size");
  // Finer ones would show the image's own voxels as bumps.
  if (!(solid.voxel_size > 0.0))
    solid.voxel_size = std::max(box.extent().maxCoeff() / kVoxelsAcross, kLeastOfImage * step.minCoeff());
  solid.voxel_size = std::max(solid.voxel_size, finest);
  const double spacing = solid.voxel_size / cells_per_voxel;
  const Node size_node = n.number("voxel_size") > 0.0 ? n.at("voxel_size") : n;
  const auto tables =
      std::count_if(std::begin(kTables), std::end(kTables), [&](auto* key) { return is_table(n, key); });
  check_count(size_node, ((box.extent() / spacing).array() + 3.0).prod(),
              kBytesPerVoxel + kBytesPerTable * static_cast<double>(tables), limit, "cells");

  VolumeReadOptions options;
  bool joined = false;
  if (n.has("file")) {
    options.max_bytes = limit;
    // Whole voxels below a cell are joined while reading, as shares of matter, which can be averaged; intensities
    // cannot.
    for (int a = 0; a < 3; ++a)
      options.coarsen[a] = std::max(1, static_cast<int>(std::min(1e6, std::floor(spacing / step[a] * (1.0 + 1e-9)))));
    // A voxel of one of the labels is full, any other empty; between their centres the share goes over evenly.
    joined = n.has("labels") || (options.coarsen.array() > 1).any();
    if (joined) {
      options.transfer = share_of(n);
      window = {0.0, 1.0};
    }
    std::optional<ImageLabels> labels;
    if (n.has("labels")) {
      labels.emplace(n);
      options.transfer = [&](double v) { return labels->share(v); };
    }
    image = n.at("file").placed([&] { return read_volume(info, options); });
    if (labels) labels->check(info);
  } else {
    window = {0.0, 1.0};
  }
  solid.grid = n.placed([&] {
    try {
      return sample_occupancy(image, window, spacing);
    } catch (const NoMatter&) {
      throw nothing_left(n, info, box.extent(), solid.voxel_size, spacing);
    }
  });
  const auto on_cells = [&](const char* key) {
    const auto of_matter = [share = share_of(n), table = read_table(n.at(key).at("table"))](double v) {
      const double s = share(v);
      return s > 0.0 ? s * table.at(v) : 0.0;
    };
    if (!joined) return cell_means(image, solid.grid, of_matter);
    options.transfer = of_matter;
    const VoxelImage of_voxels = n.at("file").placed([&] { return read_volume(info, options); });
    return cell_means(of_voxels, solid.grid, [](double v) { return v; });
  };
  if (is_table(n, "density")) solid.density = on_cells("density");
  if (is_table(n, "young_modulus") && n.string("motion") == "deformable") solid.young = on_cells("young_modulus");
  keep_pieces(n.at("keep"), image, solid.grid, scale);
  if (n.boolean("center")) solid.grid.origin -= solid.grid.middle();
  return solid;
}

}  // namespace brim
