#include "array_body.h"

#include <algorithm>

#include "arrays.h"
#include "brim/math/ramp.h"
#include "interpreter_lock.h"

namespace brim::python {

namespace {

py::array_t<double> coordinates_of(OwnBody::Coordinates q) { return array_of(q); }

/// What a method of the author answered, checked. @throws InputError  naming the method
DoubleArray answer(const py::object& author, const char* method, const py::object& given,
                   std::initializer_list<py::ssize_t> shape) {
  const DoubleArray a = DoubleArray::ensure(given);
  const auto fail = [&](const std::string& what) {
    std::string wanted;
    for (const py::ssize_t n : shape) wanted += (wanted.empty() ? "" : ", ") + std::to_string(n);
    const auto kind = py::str(py::type::of(author).attr("__name__")).cast<std::string>();
    throw InputError(
        fmt::format("{}.{}: {}; must be an array of finite numbers, shape ({})", kind, method, what, wanted));
  };
  if (!a) {
    PyErr_Clear();
    fail("gave what is no array of numbers");
  }
  if (static_cast<std::size_t>(a.ndim()) != shape.size() || !std::equal(shape.begin(), shape.end(), a.shape()))
    fail("gave shape " + shape_text(a));
  for (py::ssize_t i = 0; i < a.size(); ++i)
    if (!std::isfinite(a.data()[i])) fail("gave a value that is not finite");
  return a;
}

/// Rows of vectors from an answer of deform.
void take_rows(const DoubleArray& a, std::span<Vec3> x) { std::copy_n(a.data(), 3 * x.size(), x.front().data()); }

}  // namespace

ArrayBody::ArrayBody(OwnModel model, py::object author, std::shared_ptr<CallerThread> caller)
    : OwnBody(std::move(model)),
      kind_(py::str(py::type::of(author).attr("__name__")).cast<std::string>()),
      author_(std::move(author)),
      caller_(std::move(caller)) {
  const auto has = [&](const char* name) { return py::hasattr(author_, name) && !author_.attr(name).is_none(); };
  // The author's own of the two names, so that errors name what was written.
  const py::object base = py::module_::import("brim").attr("OwnBody"), type = py::type::of(author_);
  const auto own = [&](const char* name) { return py::hasattr(type, name) && !type.attr(name).is(base.attr(name)); };
  deform_ = own("place") && !own("deform") ? "place" : "deform";
  inverse_ = own("rest") && !own("inverse_deform") ? "rest" : "inverse_deform";
  has_jacobian_ = has("jacobian");
  has_force_ = has("force");
  has_update_ = has("update");
}

ArrayBody::~ArrayBody() {
  const Locked lock;
  author_ = py::object();
}

Vec3 ArrayBody::deform(Coordinates q, const Vec3& X) const {
  Vec3 x;
  deform_all(q, std::span(&X, 1), std::span(&x, 1));
  return x;
}

Vec3 ArrayBody::inverse_deform(Coordinates q, const Vec3& x) const {
  Vec3 X;
  inverse_deform_all(q, std::span(&x, 1), std::span(&X, 1));
  return X;
}

double ArrayBody::distance(Coordinates q, const Vec3& x) const {
  double d = 0.0;
  caller_->call([&] {
    const py::object given = author_.attr("distance")(coordinates_of(q), array_of(std::span(&x, 1)));
    d = answer(author_, "distance", given, {1}).data()[0];
  });
  return d;
}

double ArrayBody::energy(Coordinates q) const {
  double E = 0.0;
  caller_->call([&] { E = answer(author_, "energy", author_.attr("energy")(coordinates_of(q)), {}).data()[0]; });
  return E;
}

Eigen::VectorXd ArrayBody::energy_force(Coordinates q) const {
  if (!has_force_) return OwnBody::energy_force(q);
  Eigen::VectorXd f(static_cast<Eigen::Index>(q.size()));
  caller_->call([&] {
    const DoubleArray a =
        answer(author_, "force", author_.attr("force")(coordinates_of(q)), {static_cast<py::ssize_t>(q.size())});
    std::copy_n(a.data(), q.size(), f.data());
  });
  return f;
}

void ArrayBody::deform_all(Coordinates q, std::span<const Vec3> X, std::span<Vec3> x) const {
  if (X.empty()) return;
  caller_->call([&] {
    const DoubleArray a =
        answer(author_, deform_.c_str(), author_.attr(deform_.c_str())(coordinates_of(q), array_of(X)),
               {static_cast<py::ssize_t>(X.size()), 3});
    take_rows(a, x);
  });
}

void ArrayBody::inverse_deform_all(Coordinates q, std::span<const Vec3> x, std::span<Vec3> X) const {
  if (x.empty()) return;
  caller_->call([&] {
    const DoubleArray a =
        answer(author_, inverse_.c_str(), author_.attr(inverse_.c_str())(coordinates_of(q), array_of(x)),
               {static_cast<py::ssize_t>(x.size()), 3});
    take_rows(a, X);
  });
}

void ArrayBody::jacobian_all(Coordinates q, std::span<const Vec3> X, DenseMap& J) const {
  if (X.empty()) return;
  const auto n = static_cast<py::ssize_t>(q.size());
  caller_->call([&] {
    if (has_jacobian_) {
      const DoubleArray a = answer(author_, "jacobian", author_.attr("jacobian")(coordinates_of(q), array_of(X)),
                                   {static_cast<py::ssize_t>(X.size()), 3, n});
      const double* from = a.data();
      for (std::size_t p = 0; p < X.size(); ++p)
        for (int i = 0; i < 3; ++i)
          for (py::ssize_t k = 0; k < n; ++k) J.row(p)(i, k) = *from++;
      return;
    }
    std::vector<double> moved(q.begin(), q.end());
    std::vector<Vec3> up(X.size()), down(X.size());
    py::array at_rest = array_of(X);
    at_rest.attr("setflags")(py::arg("write") = false);  // one for all: what works in place is told
    const py::object deform = author_.attr(deform_.c_str());
    const auto take = [&](std::span<Vec3> x) {
      take_rows(answer(author_, deform_.c_str(), deform(coordinates_of(moved), at_rest),
                       {static_cast<py::ssize_t>(x.size()), 3}),
                x);
    };
    for (std::size_t k = 0; k < q.size(); ++k) {
      const double d = place_step(k);
      moved[k] = q[k] + d;
      take(up);
      moved[k] = q[k] - d;
      take(down);
      for (std::size_t p = 0; p < X.size(); ++p)
        J.row(p).col(static_cast<Eigen::Index>(k)) = (up[p] - down[p]) / (2.0 * d);
      moved[k] = q[k];
    }
  });
}

void ArrayBody::update(double time, std::span<const double> q, std::span<const double> v) {
  caller_->call([&] {
    if (has_update_) author_.attr("update")(time);
    OwnBody::update(time, q, v);
  });
}

void ArrayBody::advance(double dt, std::span<double> q, std::span<const double> v) const {
  caller_->call([&] { OwnBody::advance(dt, q, v); });
}

void ArrayBody::finish_step(double time, double dt, std::span<double> q, std::span<double> v) {
  caller_->call([&] { OwnBody::finish_step(time, dt, q, v); });
}

double ArrayBody::relative_speed_bound(int p, std::span<const double> v) const {
  double bound = 0.0;
  caller_->call([&] { bound = OwnBody::relative_speed_bound(p, v); });
  return bound;
}

void ArrayBody::rasterize(int, double h, double w, std::span<const TileKey> tiles, std::span<DensityBlock> out) const {
  if (tiles.empty()) return;
  // All nodes of all tiles in one array.
  std::vector<Vec3> nodes;
  nodes.reserve(tiles.size() * kBlockNodes);
  for (const TileKey& tile : tiles) {
    const Vec3 origin = block_origin(tile, h);
    for (int k = 0; k < kBlockSize; ++k)
      for (int j = 0; j < kBlockSize; ++j)
        for (int i = 0; i < kBlockSize; ++i) nodes.push_back(origin + h * Vec3(i, j, k));
  }
  caller_->call([&] {
    const DoubleArray a =
        answer(author_, "distance", author_.attr("distance")(coordinates_of(coordinates()), array_of(nodes)),
               {static_cast<py::ssize_t>(nodes.size())});
    const double* d = a.data();
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      std::fill(std::begin(out[t].source), std::end(out[t].source), 0);
      for (double& rho : out[t].rho) rho = ramp(*d++, w);
    }
  });
}

void ArrayBody::make_map(int p, std::span<const Vec3> points, std::span<const std::int32_t> sources,
                         std::unique_ptr<Map>& map) const {
  caller_->call([&] { OwnBody::make_map(p, points, sources, map); });
}

double ArrayBody::potential_energy(const Environment& env) const {
  double E = 0.0;
  caller_->call([&] { E = OwnBody::potential_energy(env); });
  return E;
}

}  // namespace brim::python
