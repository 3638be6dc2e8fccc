#include "brim/record/frame_display.h"

#include <algorithm>

#include "brim/body/changing_surface.h"
#include "brim/body/posed_display.h"
#include "brim/world/body_motion.h"

namespace brim {

namespace {

using h5::Type;

constexpr std::uint64_t kSurfaceRows = 4096;  // in a chunk
constexpr ListColumn kVertexColumns[] = {{"position", Type::Float32, 3}};
constexpr ListColumn kTriangleColumns[] = {{"corner", Type::Int32, 3}};

}  // namespace

FrameDisplay::FrameDisplay(h5::File& file, const RunTables& tables, bool create) : tables_(&tables) {
  using Extents = std::vector<std::uint64_t>;
  const auto set = [&](const std::string& path, Type type, const Extents& row, std::size_t bytes) {
    return create ? Column(file, path, type, row, frame_chunk(bytes)) : Column(file.open(path));
  };
  const std::size_t pieces = tables.piece_mesh.size(), n = tables.positions;
  rotation_ = set("/poses/rotation", Type::Float64, {pieces, 9}, 72 * pieces);
  translation_ = set("/poses/translation", Type::Float64, {pieces, 3}, 24 * pieces);
  positions_ = set("/display/positions", Type::Float32, {n, 3}, 12 * n);
  row_ = {std::vector<double>(9 * pieces), std::vector<double>(3 * pieces), std::vector<Vec3f>(n)};
  describe_xdmf();
  for (std::size_t b = 0; b < tables.bodies.size(); ++b) {
    if (!tables.bodies[b].changing) continue;
    const std::string at = "/display/" + std::to_string(b);
    if (create) file.group(at);
    const auto item = std::ranges::find(xdmf_.bodies, static_cast<int>(b), &XdmfModel::Item::index);
    surfaces_.push_back({b, static_cast<std::size_t>(item - xdmf_.bodies.begin()),
                         RaggedList(file, at + "/vertices", kVertexColumns, kSurfaceRows, create),
                         RaggedList(file, at + "/triangles", kTriangleColumns, kSurfaceRows, create)});
  }
  still_.resize(tables.bodies.size());
  still_set_ = file.open("/bodies/still");
  if (!still_.empty()) still_set_.read(still_.data(), still_.size(), 0, still_.size(), Type::Int64);
}

void FrameDisplay::describe_xdmf() {
  xdmf_.pieces = tables_->piece_mesh.size();
  xdmf_.positions = tables_->positions;
  for (std::size_t b = 0; b < tables_->bodies.size(); ++b) {
    const RecordedBody& body = tables_->bodies[b];
    const RunTables::Place& place = tables_->places[b];
    const bool lines = body.display.kind == Display::Kind::Lines;
    const std::size_t triangles = place.pieces > 0 ? 0 : body.display.triangles.size();
    if (place.pieces == 0)
      xdmf_.bodies.push_back({body.name, static_cast<int>(b), body.display.kind, body.display.vertices,
                              lines ? body.display.lines.size() : triangles,
                              static_cast<std::size_t>(std::max<std::int64_t>(place.first_position, 0)),
                              lines ? xdmf_.lines : xdmf_.triangles, body.changing});
    xdmf_.triangles += triangles;
    xdmf_.lines += body.display.lines.size();
  }
}

void FrameDisplay::add(const World& world) {
  place(world);
  rotation_.append(row_.rotation.data(), 1);
  translation_.append(row_.translation.data(), 1);
  positions_.append(row_.positions.data(), 1);
  add_surfaces(world);
  watch_still(world);
  empty_ = false;
}

void FrameDisplay::place(const World& world) {
  for (std::size_t b = 0; b < tables_->bodies.size(); ++b) {
    const RunTables::Place& place = tables_->places[b];
    const Body& body = world.body(static_cast<int>(b));
    if (world.removed(static_cast<int>(b))) {
      shrink(place, body);
      continue;
    }
    if (place.pieces > 0) {
      const PosedDisplay* posed = posed_display(body);
      for (std::size_t i = 0; i < place.pieces; ++i) {
        const Pose& pose = posed->piece(i).pose();
        double* const r = &row_.rotation[9 * (place.first_piece + i)];
        double* const t = &row_.translation[3 * (place.first_piece + i)];
        for (int a = 0; a < 9; ++a) r[a] = pose.rotation(a / 3, a % 3);
        for (int a = 0; a < 3; ++a) t[a] = pose.translation[a];
      }
    } else if (place.first_position >= 0) {
      body.display_positions(
          std::span(row_.positions).subspan(static_cast<std::size_t>(place.first_position), body.display().vertices));
    }
  }
}

/// Of a body that was removed all vertices lie at one point, so that no reader has anything to show.
void FrameDisplay::shrink(const RunTables::Place& place, const Body& body) {
  const Vec3 at = middle_of(body);
  for (std::size_t i = place.first_piece; i < place.first_piece + place.pieces; ++i) {
    std::fill_n(row_.rotation.begin() + static_cast<std::ptrdiff_t>(9 * i), 9, 0.0);
    std::copy_n(at.data(), 3, row_.translation.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  if (place.first_position >= 0)
    std::fill_n(row_.positions.begin() + static_cast<std::ptrdiff_t>(place.first_position), body.display().vertices,
                Vec3f(at.cast<float>()));
}

void FrameDisplay::add_surfaces(const World& world) {
  for (Surface& s : surfaces_) {
    if (world.removed(static_cast<int>(s.body)))
      vertices_.clear(), corners_.clear();
    else
      changing_surface(world.body(static_cast<int>(s.body)))->display_surface(vertices_, corners_);
    s.vertices.append_rows(0, vertices_.data(), vertices_.size());
    s.vertices.close_frame(vertices_.size());
    s.triangles.append_rows(0, corners_.data(), corners_.size());
    s.triangles.close_frame(corners_.size());
  }
}

std::vector<XdmfFrames::Rows> FrameDisplay::xdmf_rows(std::uint64_t first, std::uint64_t count) const {
  std::vector<XdmfFrames::Rows> all(xdmf_.bodies.size());
  for (const Surface& s : surfaces_)
    all[s.item] = {s.vertices.offsets(first, count), s.triangles.offsets(first, count), s.vertices.total(),
                   s.triangles.total()};
  return all;
}

void FrameDisplay::watch_still(const World& world) {
  if (empty_) first_ = row_;
  const auto same = [](const auto& a, const auto& b, std::size_t first, std::size_t size) {
    return std::equal(a.begin() + static_cast<std::ptrdiff_t>(first),
                      a.begin() + static_cast<std::ptrdiff_t>(first + size),
                      b.begin() + static_cast<std::ptrdiff_t>(first));
  };
  for (std::size_t b = 0; b < still_.size(); ++b) {
    if (still_[b] == 0) continue;
    const RunTables::Place& place = tables_->places[b];
    if (!world.removed(static_cast<int>(b)) &&
        same(row_.rotation, first_.rotation, 9 * place.first_piece, 9 * place.pieces) &&
        same(row_.translation, first_.translation, 3 * place.first_piece, 3 * place.pieces) &&
        (place.first_position < 0 ||
         same(row_.positions, first_.positions, static_cast<std::size_t>(place.first_position),
              tables_->bodies[b].display.vertices)))
      continue;
    still_[b] = 0;
    still_changed_ = true;
  }
}

void FrameDisplay::cut(std::uint64_t frames) {
  for (Column* c : {&rotation_, &translation_, &positions_}) c->cut(frames);
  for (Surface& s : surfaces_) {
    s.vertices.cut(frames);
    s.triangles.cut(frames);
  }
  empty_ = frames == 0;
  if (empty_) return;
  const auto first_row = [](const Column& c, void* row, std::size_t numbers, Type type) {
    if (numbers > 0) c.set().read(row, numbers, 0, 1, type);
  };
  first_ = row_;
  first_row(rotation_, first_.rotation.data(), first_.rotation.size(), Type::Float64);
  first_row(translation_, first_.translation.data(), first_.translation.size(), Type::Float64);
  first_row(positions_, first_.positions.data(), 3 * first_.positions.size(), Type::Float32);
}

void FrameDisplay::flush() {
  for (Column* c : {&rotation_, &translation_, &positions_}) c->flush();
  for (Surface& s : surfaces_) {
    s.vertices.flush();
    s.triangles.flush();
  }
  if (still_changed_) still_set_.overwrite(still_.data(), Type::Int64);
  still_changed_ = false;
}

}  // namespace brim
