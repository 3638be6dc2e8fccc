#include <nlohmann/json.hpp>
#include <numbers>

#include "brim/core/error.h"
#include "brim/record/export/format.h"
#include "brim/record/export/motion.h"
#include "brim/record/export/output_file.h"
#include "brim/record/export/shading.h"

namespace brim::exporting {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kCrease = 38.0 * std::numbers::pi / 180.0;  // as in the viewer
constexpr std::size_t kMostTargets = 1000;                   // per deforming body; programs keep them all in memory

// Words of the format.
constexpr int kFloat = 5126, kUnsignedInt = 5125;
constexpr int kPoints = 0, kLines = 1, kTriangles = 4;

/// The buffer of the file and the accessors into it.
class Buffer {
 public:
  /// @param bounds  with least and largest value, which the format wants of positions and times
  template <class T>
  int add(const std::vector<T>& values, int component, const char* type, std::size_t columns, bool bounds = false) {
    static_assert(sizeof(T) % 4 == 0);
    const std::size_t bytes = values.size() * sizeof(T);
    Json accessor = {
        {"bufferView", views_.size()}, {"componentType", component}, {"count", bytes / (4 * columns)}, {"type", type}};
    if (bounds) {
      const auto* x = reinterpret_cast<const float*>(values.data());
      std::vector<float> lo(x, x + columns), hi = lo;
      for (std::size_t i = columns; i < bytes / 4; ++i) {
        lo[i % columns] = std::min(lo[i % columns], x[i]);
        hi[i % columns] = std::max(hi[i % columns], x[i]);
      }
      accessor["min"] = lo;
      accessor["max"] = hi;
    }
    views_.push_back({{"buffer", 0}, {"byteOffset", data_.size()}, {"byteLength", bytes}});
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
    if (data_.size() > 0xf0000000u)
      throw InputError("the glTF file would pass 4 GiB, which the format cannot hold; export fewer frames or bodies");
    accessors_.push_back(std::move(accessor));
    return static_cast<int>(accessors_.size()) - 1;
  }
  int add_points(const std::vector<Vec3f>& x, bool bounds) { return add(x, kFloat, "VEC3", 3, bounds); }

  Json accessors_ = Json::array(), views_ = Json::array();
  std::string data_;
};

std::vector<Vec3f> difference(const std::vector<Vec3f>& a, const std::vector<Vec3f>& b) {
  std::vector<Vec3f> d(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) d[i] = a[i] - b[i];
  return d;
}

/// Binary glTF 2.0: run.glb, one animation. Bodies that moved as rigid ones are a mesh and a moving node; every frame
/// of any other body is a morph target; bodies of several rigid pieces are a node with a moving one for each. A root
/// node turns z up into the format's y up. Vertices are doubled along creases and carry normals. Points and lines have
/// no thickness in this format; contacts and velocities are left out.
class GltfWriter : public Writer {
 public:
  explicit GltfWriter(const Job& job) : job_(job) {}
  void frame(const Frame& frame) override { film_.add(job_, frame); }

  ItemPlace place(const Item& item) const override {
    ItemPlace place = {.file = "run.glb", .path = item.name};
    if (item.recorded->changing) {
      for (std::size_t at = 0; (at = place.path.find('%', at)) != std::string::npos; at += 2)
        place.path.insert(at, "%");
      place.path += "_%05d";
    }
    for (const ItemPiece& piece : item.pieces) place.pieces.push_back(piece.name);
    return place;
  }

  void finish() override {
    const float half = std::sqrt(0.5f);
    Json children = Json::array();
    nodes_.push_back({{"name", "brim"}, {"rotation", {-half, 0, 0, half}}});
    for (std::size_t i = 0; i < job_.items.size(); ++i) {
      if (job_.items[i].recorded->changing) {
        for (std::size_t s = 0; s < film_.samples[i].size(); ++s)
          if (!film_.triangles[i][s].empty()) children.push_back(changing(i, s));
        continue;
      }
      if (film_.samples[i].empty() || film_.positions[i].front().empty()) continue;
      children.push_back(body(i));
    }
    if (!children.empty()) nodes_[0]["children"] = children;
    Json root = {{"asset", {{"version", "2.0"}, {"generator", "brim " + job_.run->brim_version()}}},
                 {"scene", 0},
                 {"scenes", {{{"name", job_.run->scene_name()}, {"nodes", {0}}}}},
                 {"nodes", nodes_}};
    for (const auto& [name, list] : {std::pair<const char*, const Json&>{"meshes", meshes_},
                                     {"materials", materials_},
                                     {"accessors", buffer_.accessors_},
                                     {"bufferViews", buffer_.views_}})
      if (!list.empty()) root[name] = list;
    if (!buffer_.data_.empty()) root["buffers"] = {{{"byteLength", buffer_.data_.size()}}};
    if (!channels_.empty()) root["animations"] = {{{"name", "run"}, {"channels", channels_}, {"samplers", samplers_}}};
    write(root);
  }

 private:
  void material(const Item& item) {
    materials_.push_back({{"name", item.name},
                          {"doubleSided", true},
                          {"pbrMetallicRoughness",
                           {{"baseColorFactor", {item.colour[0], item.colour[1], item.colour[2], 1}},
                            {"metallicFactor", 0},
                            {"roughnessFactor", 0.5}}}});
  }

  /// One frame of a surface that changes: a mesh of its own, whose node has size only while that frame lasts.
  std::size_t changing(std::size_t i, std::size_t sample) {
    const Item& item = job_.items[i];
    const std::size_t f = film_.samples[i][sample];
    if (sample == 0 || materials_.empty() || materials_.back()["name"] != item.name) material(item);
    const std::size_t node = nodes_.size();
    const std::string name = numbered(item.name, film_.indices[f], "frame");
    const std::string plain = name.substr(0, name.rfind('.'));
    Json about = {{"name", plain}, {"mesh", meshes_.size()}};
    mesh(item, plain, {film_.positions[i][sample]}, film_.triangles[i][sample]);
    if (film_.times.size() > 1) {
      std::vector<std::pair<std::size_t, bool>> when;
      if (f > 0) when.push_back({0, false});
      when.push_back({f, true});
      if (f + 1 < film_.times.size()) when.push_back({f + 1, false});
      show(about, when);
    }
    nodes_.push_back(std::move(about));
    return node;
  }

  /// A body as a node, with its pieces, if it has several, as nodes below it. @return number of the node
  std::size_t body(std::size_t i) {
    const Item& item = job_.items[i];
    const auto& frames = film_.positions[i];
    material(item);
    Json node = {{"name", item.name}}, pieces = Json::array();
    for (const ItemPiece& piece : item.pieces) {
      Json below = {{"name", piece.name}};
      shape(below, i, piece.name, cut(frames, piece.vertices), cut(item.recorded->display.triangles, piece.vertices));
      pieces.push_back(nodes_.size());
      nodes_.push_back(std::move(below));
    }
    if (item.pieces.empty())
      shape(node, i, item.name, frames, item.recorded->display.triangles);
    else
      node["children"] = pieces;
    if (!film_.always(i)) {
      std::vector<std::pair<std::size_t, bool>> when;
      for (const std::size_t f : film_.changes(i)) when.push_back({f, film_.present[i][f] != 0});
      show(node, when);
    }
    nodes_.push_back(std::move(node));
    return nodes_.size() - 1;
  }

  /// Gives the node that is added next a mesh and its motion.
  void shape(Json& node, std::size_t i, const std::string& name, const std::vector<std::vector<Vec3f>>& frames,
             const std::vector<Triangle>& triangles) {
    node["mesh"] = meshes_.size();
    if (const auto motion = find_rigid_motion(frames)) {
      mesh(job_.items[i], name, {motion->local}, triangles);
      place(node, *motion, i);
      return;
    }
    mesh(job_.items[i], name, frames, triangles);
    if (frames.size() > 1) morph(i);
  }

  /// A mesh with the first frame as its shape and the others as morph targets.
  void mesh(const Item& item, const std::string& name, const std::vector<std::vector<Vec3f>>& frames,
            const std::vector<Triangle>& triangles) {
    const Display& d = item.recorded->display;
    if (frames.size() > kMostTargets)
      throw InputError(
          fmt::format("body \"{}\" deforms over {} frames; glTF takes at most {} here: export fewer with "
                      "--frames first:last:stride",
                      item.name, frames.size(), kMostTargets));
    Json attributes, primitive, targets = Json::array();
    const bool surface = !triangles.empty();
    const SplitMesh split = surface ? split_at_creases(frames.front(), triangles, kCrease) : SplitMesh();
    std::vector<Vec3f> x0, n0, x, n;
    for (std::size_t f = 0; f < frames.size(); ++f) {
      if (surface)
        shade(split, frames[f], x, n);
      else
        x = frames[f];
      Json to = {{"POSITION", buffer_.add_points(f == 0 ? x : difference(x, x0), true)}};
      if (surface) to["NORMAL"] = buffer_.add_points(f == 0 ? n : difference(n, n0), false);
      if (f == 0) {
        attributes = to;
        x0 = x, n0 = n;
      } else
        targets.push_back(to);
    }
    primitive = {{"attributes", attributes}, {"material", materials_.size() - 1}};
    primitive["mode"] = surface ? kTriangles : d.lines.empty() ? kPoints : kLines;
    if (surface)
      primitive["indices"] = buffer_.add(split.triangles, kUnsignedInt, "SCALAR", 1);
    else if (!d.lines.empty())
      primitive["indices"] = buffer_.add(d.lines, kUnsignedInt, "SCALAR", 1);
    Json mesh = {{"name", name}, {"primitives", Json::array()}};
    if (!targets.empty()) {
      primitive["targets"] = targets;
      mesh["weights"] = std::vector<int>(targets.size(), 0);
    }
    mesh["primitives"].push_back(primitive);
    meshes_.push_back(std::move(mesh));
  }

  /// Places a node, over time where it moves.
  void place(Json& node, const RigidMotion& motion, std::size_t i) {
    std::vector<Vec3f> where;
    std::vector<std::array<float, 4>> turn;
    for (const Placement& p : motion.placements) {
      const Eigen::Vector4f q = p.rotation.coeffs().cast<float>();
      where.push_back(p.translation.cast<float>());
      turn.push_back({q[0], q[1], q[2], q[3]});
    }
    node["translation"] = {where[0].x(), where[0].y(), where[0].z()};
    node["rotation"] = turn[0];
    if (where.size() < 2) return;
    const int times = times_of(i);
    channel("translation", times, buffer_.add_points(where, false), "LINEAR");
    channel("rotation", times, buffer_.add(turn, kFloat, "VEC4", 4), "LINEAR");
  }

  /// One target after another takes over. Bodies that are there in all frames have as many targets, and share weights.
  void morph(std::size_t i) {
    const std::size_t samples = film_.samples[i].size();
    const bool shared = samples == film_.times.size();
    int weights = shared ? weights_ : -1;
    if (weights < 0) {
      std::vector<float> list(samples * (samples - 1), 0.0f);
      for (std::size_t s = 1; s < samples; ++s) list[s * (samples - 1) + s - 1] = 1.0f;
      weights = buffer_.add(list, kFloat, "SCALAR", 1);
      if (shared) weights_ = weights;
    }
    channel("weights", times_of(i), weights, "LINEAR");
  }

  /// Gives the node that is added next its size in some frames, and none in others.
  void show(Json& node, const std::vector<std::pair<std::size_t, bool>>& when) {
    std::vector<std::size_t> frames;
    std::vector<Vec3f> sizes;
    for (const auto& [frame, shown] : when) {
      frames.push_back(frame);
      sizes.push_back(Vec3f::Constant(shown ? 1.0f : 0.0f));
    }
    const int times = add_times(frames);
    channel("scale", times, buffer_.add_points(sizes, false), "STEP");
    if (!when.front().second) node["scale"] = {0, 0, 0};
  }

  /// Times of the samples of an item, in the run.
  int times_of(std::size_t i) {
    if (film_.samples[i].size() < film_.times.size()) return add_times(film_.samples[i]);
    if (times_ < 0) times_ = add_times(film_.samples[i]);
    return times_;
  }
  int add_times(const std::vector<std::size_t>& frames) {
    std::vector<float> times;
    for (const std::size_t f : frames) times.push_back(static_cast<float>(film_.times[f]));
    return buffer_.add(times, kFloat, "SCALAR", 1, true);
  }

  /// Animates a quantity of the node that is added next.
  void channel(const char* path, int times, int values, const char* interpolation) {
    channels_.push_back({{"sampler", samplers_.size()}, {"target", {{"node", nodes_.size()}, {"path", path}}}});
    samplers_.push_back({{"input", times}, {"output", values}, {"interpolation", interpolation}});
  }

  void write(const Json& root) const {
    std::string text = root.dump(-1, ' ', false, Json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::string& data = buffer_.data_;  // every array is a whole number of four bytes
    OutputFile file(job_.folder / "run.glb");
    const auto word = [&file](std::size_t n) { file.write_number(static_cast<std::uint32_t>(n)); };
    file.write("glTF");
    word(2);
    word(12 + 8 + text.size() + (data.empty() ? 0 : 8 + data.size()));
    word(text.size());
    file.write("JSON");
    file.write(text);
    if (!data.empty()) {
      word(data.size());
      file.write(std::string_view("BIN\0", 4));
      file.write(data);
    }
    file.close();
  }

  const Job& job_;
  Film film_;
  Buffer buffer_;
  Json nodes_ = Json::array(), meshes_ = Json::array(), materials_ = Json::array(), channels_ = Json::array(),
       samplers_ = Json::array();
  int times_ = -1, weights_ = -1;
};

}  // namespace

std::unique_ptr<Writer> make_gltf(const Job& job) { return std::make_unique<GltfWriter>(job); }

}  // namespace brim::exporting
