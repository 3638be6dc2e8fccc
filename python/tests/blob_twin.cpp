// The Blob of own_body_test.py in C++, as a plugin: the two must move alike. It goes by the former names, place and
// rest, which must go on working.
#include <brim/body/own/own_body.h>
#include <brim/mesh/primitives.h>
#include <brim/scene/own_kind.h>

namespace {

using brim::Vec3;

class Blob final : public brim::OwnBody {
 public:
  explicit Blob(brim::OwnModel model) : OwnBody(std::move(model)) {}
  std::string_view kind() const override { return "blob_twin"; }

  Vec3 place(Coordinates q, const Vec3& X) const override { return c(q) + s(q).cwiseProduct(X); }
  Vec3 rest(Coordinates q, const Vec3& x) const override { return (x - c(q)).cwiseQuotient(s(q)); }
  double distance(Coordinates q, const Vec3& x) const override {
    const Vec3 X = rest(q, x);
    return (std::sqrt(X.x() * X.x() + X.y() * X.y() + X.z() * X.z()) - 0.3) * s(q).minCoeff();
  }
  double energy(Coordinates q) const override {
    const Vec3 e = s(q) - Vec3::Ones();
    return 2e3 * (e.x() * e.x() + e.y() * e.y() + e.z() * e.z());
  }

 private:
  static Vec3 c(Coordinates q) { return Vec3(q[0], q[1], q[2]); }
  static Vec3 s(Coordinates q) { return Vec3(q[3], q[4], q[5]); }
};

const bool added = brim::add_body_kind("blob_twin", "{}", [](const brim::OwnEntry& entry) {
  brim::OwnModel model;
  const Vec3& c = entry.place.position;
  model.q = {c.x(), c.y(), c.z(), 1, 1, 1};
  model.surface = brim::shapes::icosphere(0.3);
  model.voxel_size = entry.number("voxel_size");
  model.material = entry.material;
  return std::make_unique<Blob>(std::move(model));
});

}  // namespace
