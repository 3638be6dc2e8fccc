#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "brim/core/error.h"
#include "pile.h"

namespace brim::peers {

namespace {

std::string text(const Vec3& v) { return fmt::format("{} {} {}", v.x(), v.y(), v.z()); }

/// The pile in MuJoCo's own words.
std::string write_xml(const Pile& pile, const std::string& solver) {
  std::string x = fmt::format(
      "<mujoco><option timestep='{}' gravity='0 0 -9.81' solver='{}' cone='elliptic'/>"
      "<size nconmax='{}' njmax='{}'/><default><geom friction='{} 0 0' condim='3'/></default><asset>",
      pile.time_step, solver, 16 * pile.solids.size(), 50 * pile.solids.size(), pile.friction);
  for (std::size_t s = 0; s < pile.shapes.size(); ++s)
    for (std::size_t p = 0; p < pile.shapes[s].size(); ++p) {
      if (pile.shapes[s][p].points.size() < 3) continue;
      x += fmt::format("<mesh name='m{}_{}' vertex='", s, p);
      for (const Vec3& v : pile.shapes[s][p].points) x += text(v) + " ";
      x += "'/>";
    }
  x += "</asset><worldbody><geom type='plane' size='5 5 1'/>";
  for (const Wall& w : pile.walls)
    x += fmt::format("<geom type='box' size='{}' pos='{}'/>", text(w.half), text(w.center));
  for (const Solid& b : pile.solids) {
    const Quat& r = b.rotation;
    x += fmt::format("<body pos='{}' quat='{} {} {} {}'><freejoint/><inertial pos='0 0 0' mass='{}' diaginertia='{}'/>",
                     text(b.position), r.w(), r.x(), r.y(), r.z(), b.mass, text(b.inertia));
    for (std::size_t p = 0; p < pile.shapes[b.shape].size(); ++p) {
      const Piece& piece = pile.shapes[b.shape][p];
      if (piece.box())
        x += fmt::format("<geom type='box' size='{}'/>", text(piece.half));
      else if (piece.ball())
        x += fmt::format("<geom type='sphere' size='{}'/>", piece.radius);
      else if (piece.capsule())
        x += fmt::format("<geom type='capsule' size='{}' fromto='{} {}'/>", piece.radius, text(piece.points[0]),
                         text(piece.points[1]));
      else
        x += fmt::format("<geom type='mesh' mesh='m{}_{}'/>", b.shape, p);
    }
    x += "</body>";
  }
  return x + "</worldbody></mujoco>";
}

class MujocoEngine final : public Engine {
 public:
  MujocoEngine(const Pile& pile, const std::string& solver) : solver_(solver) {
    const auto path = std::filesystem::temp_directory_path() / fmt::format("brim_peer_{}.xml", solver);
    std::ofstream(path) << write_xml(pile, solver);
    char message[1000] = "";
    model_.reset(mj_loadXML(path.c_str(), nullptr, message, sizeof message));
    std::filesystem::remove(path);
    if (!model_) throw InputError(fmt::format("MuJoCo: {}", message));
    data_.reset(mj_makeData(model_.get()));
  }

  std::string name() const override { return "MuJoCo, " + solver_; }
  void step() override { mj_step(model_.get(), data_.get()); }
  Placement placement() const override {
    Placement p;
    for (int b = 0; b < model_->njnt; ++b) {
      const double *q = data_->qpos + 7 * b, *v = data_->qvel + 6 * b;
      p.position.emplace_back(q[0], q[1], q[2]);
      p.rotation.push_back(Quat(q[3], q[4], q[5], q[6]).normalized());
      p.velocity.emplace_back(v[0], v[1], v[2]);
      p.spin.push_back(p.rotation.back() * Vec3(v[3], v[4], v[5]));  // MuJoCo's is in the body's frame
    }
    return p;
  }

 private:
  struct Free {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  std::string solver_;
  std::unique_ptr<mjModel, Free> model_;
  std::unique_ptr<mjData, Free> data_;
};

}  // namespace

std::unique_ptr<Engine> make_mujoco(const Pile& pile, const std::string& solver) {
  return std::make_unique<MujocoEngine>(pile, solver);
}

}  // namespace brim::peers
