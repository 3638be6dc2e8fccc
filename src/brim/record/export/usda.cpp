#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "brim/record/export/format.h"
#include "brim/record/export/motion.h"
#include "brim/record/export/output_file.h"

namespace brim::exporting {

namespace {

std::string tuple(const Vec3f& p) { return fmt::format("({}, {}, {})", p.x(), p.y(), p.z()); }

template <class List, class Text>
std::string joined(const List& list, Text text) {
  std::string out = "[";
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (i > 0) out += ", ";
    out += text(list[i]);
  }
  return out + "]";
}
std::string joined(const std::vector<Vec3f>& list) { return joined(list, tuple); }
std::string number(auto x) { return fmt::format("{}", x); }

/// Rows of the transposed matrix: USD multiplies row vectors from the left.
std::string matrix(const Placement& p) {
  const Mat3 r = p.rotation.toRotationMatrix();
  const Vec3& t = p.translation;
  std::string out = "( ";
  for (int a = 0; a < 3; ++a) out += fmt::format("({}, {}, {}, 0), ", r(0, a), r(1, a), r(2, a));
  return out + fmt::format("({}, {}, {}, 1) )", t.x(), t.y(), t.z());
}

/// Text in double quotes.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out + "\"";
}

/// USD as text: run.usda, z up, metres, one time code per recorded frame. Bodies that moved as rigid ones are a shape
/// and a sampled matrix, those of several rigid pieces an Xform with such a shape for each; all others have sampled
/// points, with velocities where the run has them; those that are removed a sampled visibility. Surfaces are Mesh,
/// lines BasisCurves, points Points; contacts are Points with force, friction and overlap as primvars.
class UsdaWriter : public Writer {
 public:
  explicit UsdaWriter(const Job& job) : job_(job) {}
  void frame(const Frame& frame) override { film_.add(job_, frame); }

  ItemPlace place(const Item& item) const override {
    ItemPlace place = {.file = "run.usda", .path = "/World/" + item.identifier};
    for (const ItemPiece& piece : item.pieces) place.pieces.push_back(place.path + "/" + piece.identifier);
    return place;
  }
  ItemPlace contacts_place() const override { return {.file = "run.usda", .path = "/World/contacts"}; }

  void finish() override {
    OutputFile file(job_.folder / "run.usda");
    const double rate = job_.run->frame_time() > 0.0 ? 1.0 / job_.run->frame_time() : 24.0;
    file.write(fmt::format(
        "#usda 1.0\n(\n    defaultPrim = \"World\"\n    doc = {}\n    endTimeCode = {}\n    framesPerSecond = {}\n"
        "    metersPerUnit = 1\n    startTimeCode = {}\n    timeCodesPerSecond = {}\n    upAxis = \"Z\"\n)\n\n"
        "def Xform \"World\"\n{{\n",
        quoted("Run of scene " + job_.run->scene_name() + " by brim " + job_.run->brim_version()), film_.indices.back(),
        rate, film_.indices.front(), rate));
    for (std::size_t i = 0; i < job_.items.size(); ++i)
      file.write(job_.items[i].pieces.empty() ? body(i) : assembly(i));
    file.write(contacts() + "}\n");
    file.close();
  }

 private:
  static constexpr const char* kPad = "        ";

  /// An attribute with one value per frame, or a plain one where there is only one.
  /// @param frames  of the values, among the exported ones; empty: no attribute
  template <class Text>
  std::string sampled(const std::string& name, const std::vector<std::size_t>& frames, Text text,
                      const std::string& metadata = "") const {
    if (frames.empty()) return "";
    if (frames.size() == 1) return fmt::format("{}{} = {}{}\n", kPad, name, text(0), metadata);
    // Metadata belong to the attribute's declaration, which has no value of its own here.
    std::string out = metadata.empty() ? "" : fmt::format("{}{}{}\n", kPad, name, metadata);
    out += fmt::format("{}{}.timeSamples = {{\n", kPad, name);
    for (std::size_t s = 0; s < frames.size(); ++s)
      out += fmt::format("{}    {}: {},\n", kPad, film_.indices[frames[s]], text(s));
    return out + kPad + "}\n";
  }

  std::string body(std::size_t i) const {
    const Item& item = job_.items[i];
    const Display& d = item.recorded->display;
    const auto& frames = film_.positions[i];
    const auto& samples = film_.samples[i];
    const char* type = d.kind == Display::Kind::Triangles ? "Mesh"
                       : d.kind == Display::Kind::Lines   ? "BasisCurves"
                                                          : "Points";
    std::string out = head(type, item.identifier, item.name);
    std::vector<std::int32_t> order;  // vertices as the prim lists them; empty: as recorded
    const bool changing = item.recorded->changing;
    if (d.kind == Display::Kind::Triangles) {
      out += surface(d, changing ? samples : std::vector<std::size_t>{0},
                     [&](std::size_t s) -> const std::vector<Triangle>& {
                       return changing ? film_.triangles[i][s] : d.triangles.items();
                     });
    }
    if (d.kind == Display::Kind::Lines) out += curves(d, order);
    if (d.kind != Display::Kind::Triangles)
      out += fmt::format("{}float[] widths = [{}] (\n{}    interpolation = \"constant\"\n{})\n", kPad,
                         static_cast<float>(2.0 * d.radius), kPad, kPad);
    out += fmt::format("{}color3f[] primvars:displayColor = [{}]\n", kPad, tuple(item.colour)) + visibility(i);
    if (frames.empty()) return out + "    }\n\n";
    const auto& v = film_.velocities[i];
    const bool moving = item.velocity != VelocitySource::None && !item.still;
    // Vertices with velocities of their own are never taken for a shape that moves as one.
    const bool rigid = item.velocity != VelocitySource::Nodes && item.velocity != VelocitySource::Map &&
                       d.kind != Display::Kind::Points && !changing;
    const auto motion = frames.size() > 1 && rigid ? find_rigid_motion(frames) : std::nullopt;
    const auto picked = [&](const std::vector<Vec3f>& x) {
      if (order.empty()) return joined(x);
      return joined(order, [&](std::int32_t n) { return tuple(x[static_cast<std::size_t>(n)]); });
    };
    if (motion) {
      out += extent({motion->local}) + fmt::format("{}point3f[] points = {}\n", kPad, picked(motion->local));
      out += placements(*motion, samples);
    } else {
      out += extent(frames) + sampled("point3f[] points", samples, [&](std::size_t s) { return picked(frames[s]); });
      if (moving) out += sampled("vector3f[] velocities", samples, [&](std::size_t s) { return picked(v[s]); });
    }
    return out + "    }\n\n";
  }

  static std::string head(const char* type, const std::string& identifier, const std::string& name) {
    return fmt::format(
        "    def {} \"{}\" (\n        customData = {{\n            string brim_name = {}\n"
        "        }}\n    )\n    {{\n",
        type, identifier, quoted(name));
  }

  std::string placements(const RigidMotion& motion, const std::vector<std::size_t>& samples) const {
    return sampled("matrix4d xformOp:transform", samples, [&](std::size_t s) { return matrix(motion.placements[s]); }) +
           fmt::format("{}uniform token[] xformOpOrder = [\"xformOp:transform\"]\n", kPad);
  }

  /// A body of several rigid pieces: an Xform with a Mesh for each, which moves as a whole.
  std::string assembly(std::size_t i) const {
    const Item& item = job_.items[i];
    std::string out = head("Xform", item.identifier, item.name) + visibility(i);
    for (const ItemPiece& piece : item.pieces) out += indented(part(i, piece));
    return out + "    }\n\n";
  }

  std::string part(std::size_t i, const ItemPiece& piece) const {
    const Item& item = job_.items[i];
    const std::vector<Triangle> triangles = cut(item.recorded->display.triangles, piece.vertices);
    std::string out =
        head("Mesh", piece.identifier, piece.name) +
        surface(item.recorded->display, {0}, [&](std::size_t) -> const std::vector<Triangle>& { return triangles; }) +
        fmt::format("{}color3f[] primvars:displayColor = [{}]\n", kPad, tuple(item.colour));
    const auto frames = cut(film_.positions[i], piece.vertices);
    const auto motion = frames.size() > 1 ? find_rigid_motion(frames) : std::nullopt;
    if (motion)
      out += extent({motion->local}) + fmt::format("{}point3f[] points = {}\n", kPad, joined(motion->local)) +
             placements(*motion, film_.samples[i]);
    else if (!frames.empty())
      out += extent(frames) +
             sampled("point3f[] points", film_.samples[i], [&](std::size_t s) { return joined(frames[s]); });
    return out + "    }\n";
  }

  /// Lines of a prim within a prim.
  static std::string indented(const std::string& text) {
    std::string out;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
      out.append("    ").append(text, at, end - at);
      at = end;
    }
    return out;
  }

  /// When a body that is removed, or comes back, is shown; values of this type are held, not interpolated. Without
  /// samples of frames in which it is gone its points hold too, so that no motion blur draws it.
  std::string visibility(std::size_t i) const {
    if (film_.always(i)) return "";
    return sampled("token visibility", film_.changes(i), [&, at = film_.changes(i)](std::size_t s) {
      return film_.present[i][at[s]] != 0 ? "\"inherited\"" : "\"invisible\"";
    });
  }

  /// @param samples  frames of the surfaces  @param at  triangles of a sample
  template <class At>
  std::string surface(const Display& d, const std::vector<std::size_t>& samples, At at) const {
    std::string out = fmt::format("{0}uniform token subdivisionScheme = \"none\"\n{0}uniform bool doubleSided = {1}\n",
                                  kPad, d.two_sided ? 1 : 0);
    out += sampled("int[] faceVertexCounts", samples,
                   [&](std::size_t f) { return joined(at(f), [](const Triangle&) { return std::string("3"); }); });
    return out + sampled("int[] faceVertexIndices", samples, [&](std::size_t f) {
             return joined(at(f), [](const Triangle& t) { return fmt::format("{}, {}, {}", t[0], t[1], t[2]); });
           });
  }

  static std::string curves(const Display& d, std::vector<std::int32_t>& order) {
    const auto list = chains(d.lines, d.vertices);
    for (const auto& chain : list) order.insert(order.end(), chain.begin(), chain.end());
    return fmt::format("{0}uniform token type = \"linear\"\n{0}int[] curveVertexCounts = {1}\n", kPad,
                       joined(list, [](const auto& chain) { return number(chain.size()); }));
  }

  /// Box of all frames together.
  static std::string extent(const std::vector<std::vector<Vec3f>>& frames) {
    Vec3f lo = Vec3f::Zero(), hi = Vec3f::Zero();
    bool any = false;
    for (const auto& frame : frames)
      for (const Vec3f& p : frame) {
        lo = any ? Vec3f(lo.cwiseMin(p)) : p;
        hi = any ? Vec3f(hi.cwiseMax(p)) : p;
        any = true;
      }
    return fmt::format("{}float3[] extent = [{}, {}]\n", kPad, tuple(lo), tuple(hi));
  }

  std::string contacts() const {
    const auto& list = film_.contacts;
    std::vector<std::size_t> frames(list.size());
    std::iota(frames.begin(), frames.end(), std::size_t{0});
    const std::string vertex = fmt::format(" (\n{0}    interpolation = \"vertex\"\n{0})", kPad);
    const auto vectors = [&](const std::string& name, Vec3f ContactSample::*member, const std::string& metadata) {
      return sampled(
          name, frames,
          [&](std::size_t f) { return joined(list[f], [&](const ContactSample& c) { return tuple(c.*member); }); },
          metadata);
    };
    return "    def Points \"contacts\"\n    {\n" + vectors("point3f[] points", &ContactSample::position, "") +
           vectors("vector3f[] primvars:force", &ContactSample::force, vertex) +
           vectors("vector3f[] primvars:friction", &ContactSample::friction, vertex) +
           sampled(
               "float[] primvars:overlap", frames,
               [&](std::size_t f) { return joined(list[f], [](const ContactSample& c) { return number(c.overlap); }); },
               vertex) +
           fmt::format("{}token visibility = \"invisible\"\n    }}\n", kPad);
  }

  const Job& job_;
  Film film_;
};

}  // namespace

std::unique_ptr<Writer> make_usda(const Job& job) { return std::make_unique<UsdaWriter>(job); }

}  // namespace brim::exporting
