#include <gtest/gtest.h>

#include "brim/map/composed_map.h"
#include "brim/raster/volume_layer.h"
#include "support/worlds.h"

/// A user's own body on particles of volume, with one coordinate.
namespace brim::volume_layer_user_test {
namespace {

/// ∂x_i/∂q = z_i e_z × x_i.
class TwistMap final : public Map {
 public:
  void reset(std::span<const Vec3> x) { x_.assign(x.begin(), x.end()); }
  std::size_t points() const override { return x_.size(); }
  void apply(std::span<const double> v, std::span<Vec3> u) const override {
    for (std::size_t i = 0; i < x_.size(); ++i) u[i] = v[0] * column(i);
  }
  void apply_transpose(std::span<const Vec3> f, std::span<double> Q) const override {
    for (std::size_t i = 0; i < x_.size(); ++i) Q[0] += column(i).dot(f[i]);
  }
  void add_block_diagonal(std::span<const Mat3> K, std::size_t first, BlockDiagonal& D) const override {
    for (std::size_t i = 0; i < x_.size(); ++i) D.block(first)(0, 0) += column(i).dot(K[i] * column(i));
  }

 private:
  Vec3 column(std::size_t i) const { return x_[i].z() * Vec3::UnitZ().cross(x_[i]); }
  std::vector<Vec3> x_;
};

/// A user's own body: a bar with one coordinate, its twist about z per metre. Particles at radius and height follow.
class TwistingBar final : public Body {
 public:
  TwistingBar() {
    for (int k = -10; k <= 10; ++k)
      for (int j = -3; j <= 3; ++j)
        for (int i = -3; i <= 3; ++i) rest_.push_back(0.05 * Vec3(i, j, k));
    volume_.assign(rest_.size(), 0.05 * 0.05 * 0.05), mass_.assign(rest_.size(), 0.125), radius_ = {0.0};
    x_ = rest_;
    layer_.set(x_, volume_, mass_, radius_);
  }
  std::string_view kind() const override { return "twisting_bar"; }
  std::size_t q_size() const override { return 1; }
  std::size_t v_size() const override { return 1; }
  void initial_state(std::span<double> q, std::span<double> v) const override { q[0] = v[0] = 0.0; }
  void update(double, std::span<const double> q, std::span<const double>) override {
    for (std::size_t i = 0; i < x_.size(); ++i)
      x_[i] = Eigen::AngleAxisd(q[0] * rest_[i].z(), Vec3::UnitZ()) * rest_[i];
    layer_.set(x_, volume_, mass_, radius_);
    twist_ = q[0];
  }
  void advance(double dt, std::span<double> q, std::span<const double> v) const override { q[0] += dt * v[0]; }
  void add_forces(const Environment&, std::span<double> Q) const override { Q[0] -= 5.0 * twist_; }
  void apply_mass(std::span<const double> x, std::span<double> y) const override { y[0] += inertia() * x[0]; }
  void apply_stiffness(std::span<const double> x, std::span<double> y) const override { y[0] -= 5.0 * x[0]; }
  std::vector<int> block_sizes() const override { return {1}; }
  void add_system_diagonal(std::size_t first, BlockDiagonal& D) const override {
    D.block(first)(0, 0) += inertia() + dt_ * dt_ * 50.0;
  }
  PartInfo part(int) const override {
    PartInfo p;
    p.voxel_size = 0.05, p.areal_mass = 100.0;
    return p;
  }
  Aabb bounds(int) const override { return layer_.centers().inflated(0.05); }
  Vec3 mean_velocity(int, std::span<const double>) const override { return Vec3::Zero(); }
  double relative_speed_bound(int, std::span<const double> v) const override { return 0.3 * std::abs(v[0]); }
  void presence(int, double h, double w, const Aabb& region, std::vector<TileKey>& out) const override {
    layer_.presence(h, w, region, out);
  }
  void rasterize(int, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const override {
    layer_.rasterize(h, w, tiles, out);
  }
  void make_map(int, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;
  double mass() const override { return 0.125 * static_cast<double>(x_.size()); }
  double potential_energy(const Environment&) const override { return 2.5 * twist_ * twist_; }
  Vec3 linear_momentum(std::span<const double>) const override { return Vec3::Zero(); }
  Vec3 angular_momentum(std::span<const double>) const override { return Vec3::Zero(); }
  const Display& display() const override { return display_; }
  void display_positions(std::span<Vec3f>) const override {}

  std::vector<Vec3> rest_, x_;

 private:
  double inertia() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < rest_.size(); ++i)
      sum += mass_[i] * rest_[i].head<2>().squaredNorm() * rest_[i].z() * rest_[i].z();
    return sum;
  }
  std::vector<double> volume_, mass_, radius_;
  VolumeLayer layer_;
  Display display_;
  double twist_ = 0.0;
};

void TwistingBar::make_map(int, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                           std::unique_ptr<Map>& map) const {
  auto particles = std::make_unique<TwistMap>();
  particles->reset(x_);
  auto composed = std::make_unique<ComposedMap>();
  composed->assign(layer_.weights(points, sources, LayerWeights::Affine), std::move(particles));
  map = std::move(composed);
}

TEST(VolumeLayerOfAUser, ABallThatPushesTheTopOfABarTwistsIt) {
  WorldOptions o = testing::options_at(0.05);
  o.environment.gravity.setZero();
  World w(o);
  auto bar = std::make_unique<TwistingBar>();
  bar->set_name("bar");
  const int b = w.add(std::move(bar));
  // Towards −x beside the axis, at the top: the torque about z is positive for y > 0.
  testing::Start s;
  s.x = Vec3(0.35, 0.12, 0.45), s.v = Vec3(-1, 0, 0);
  const int ball = w.add(testing::ball("ball", s, 0.0, 0.1, 500.0));
  double least = 0.0, most = 0.0;
  for (int i = 0; i < 60; ++i) {
    w.step();
    least = std::min(least, w.q(b)[0]), most = std::max(most, w.q(b)[0]);
  }
  EXPECT_GT(most, 0.05) << least;
  EXPECT_GT(testing::velocity(w, ball).x(), -0.9) << "the bar answers";
}

}  // namespace
}  // namespace brim::volume_layer_user_test
