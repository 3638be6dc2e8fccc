#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "brim/body/own/own_body.h"
#include "caller_thread.h"

namespace brim::python {

/// A body whose author methods are in Python and work on whole arrays of points: deform, inverse_deform (or their
/// former names place, rest), distance, energy, and optionally jacobian, force and update (brim.OwnBody in
/// brim/own_body.py defines each). Each call of the world is passed to the thread that steps it (CallerThread), so that
/// Python is entered once per part and never from within brim's parallel loops. Tests: python/tests/own_body_test.py
class ArrayBody final : public OwnBody {
 public:
  /// @param author  object with the methods
  /// @throws InputError
  ArrayBody(OwnModel model, pybind11::object author, std::shared_ptr<CallerThread> caller);
  ~ArrayBody() override;

  std::string_view kind() const override { return kind_; }

  Vec3 deform(Coordinates q, const Vec3& X) const override;
  Vec3 inverse_deform(Coordinates q, const Vec3& x) const override;
  double distance(Coordinates q, const Vec3& x) const override;
  double energy(Coordinates q) const override;
  Eigen::VectorXd energy_force(Coordinates q) const override;
  void deform_all(Coordinates q, std::span<const Vec3> X, std::span<Vec3> x) const override;
  void inverse_deform_all(Coordinates q, std::span<const Vec3> x, std::span<Vec3> X) const override;
  void jacobian_all(Coordinates q, std::span<const Vec3> X, DenseMap& J) const override;

  /// Tells the author the time, where it has a method update(t), before anything else is asked.
  void update(double time, std::span<const double> q, std::span<const double> v) override;
  void advance(double dt, std::span<double> q, std::span<const double> v) const override;
  void finish_step(double time, double dt, std::span<double> q, std::span<double> v) override;
  double relative_speed_bound(int p, std::span<const double> v) const override;
  void rasterize(int p, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const override;
  void make_map(int p, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                std::unique_ptr<Map>& map) const override;
  double potential_energy(const Environment& env) const override;

 protected:
  bool errors_are_named() const override { return true; }

 private:
  std::string kind_;
  pybind11::object author_;
  std::string deform_, inverse_;  // names of the author's methods
  bool has_jacobian_ = false, has_force_ = false, has_update_ = false;
  std::shared_ptr<CallerThread> caller_;
};

}  // namespace brim::python
