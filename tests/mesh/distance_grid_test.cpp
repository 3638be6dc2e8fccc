#include "brim/mesh/distance_grid.h"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>

#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/mesh/distance.h"
#include "brim/mesh/isosurface.h"
#include "brim/mesh/primitives.h"
#include "brim/mesh/topology.h"
#include "mesh/data.h"

namespace brim::distance_grid_test {
namespace {

DistanceGridOptions spacing(double h, SurfaceTreatment treatment = SurfaceTreatment::Closed) {
  DistanceGridOptions o;
  o.spacing = h;
  o.treatment = treatment;
  return o;
}

std::string message_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TriMesh without_top(const TriMesh& mesh, double z) {
  TriMesh open = mesh;
  std::erase_if(open.triangles, [&](const Triangle& t) {
    return mesh.vertices[t[0]].z() > z && mesh.vertices[t[1]].z() > z && mesh.vertices[t[2]].z() > z;
  });
  return open;
}

TEST(DistanceGrid, ReproducesLinearAndQuadraticFields) {
  // Trilinear weights reproduce a plane, Catmull-Rom also a paraboloid (away from the border).
  const std::uint64_t seed = 41;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  const Aabb box{Vec3(-1, -1, -1), Vec3(1, 2, 1)};
  const auto plane = [](const Vec3& p) { return 0.3 * p.x() - 0.5 * p.y() + 0.8 * p.z() + 0.1; };
  const auto bowl = [](const Vec3& p) { return p.x() * p.x() + 0.5 * p.x() * p.y() - p.z() * p.z(); };
  const DistanceGrid a = sample_distance(box, 0.1, plane), b = sample_distance(box, 0.1, bowl);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = random.in(box), q = random.in(box.inflated(-0.1));
    EXPECT_NEAR(a.value(p), plane(p), 1e-6);
    EXPECT_NEAR(a.value(p, Interpolation::Trilinear), plane(p), 1e-6);
    EXPECT_NEAR(b.value(q), bowl(q), 1e-6);
  }
}

TEST(DistanceGrid, NodesHoldTheExactDistanceInTheBandAndAboutItBeyond) {
  const TriMesh mesh = shapes::blob(6, 0.4, 3);
  const SurfaceTree tree(mesh);
  const DistanceGrid g = make_distance_grid(mesh, spacing(0.03));
  std::size_t n = 0;
  for (int k = 0; k < g.nodes().z(); ++k)
    for (int j = 0; j < g.nodes().y(); ++j)
      for (int i = 0; i < g.nodes().x(); ++i, ++n) {
        const Vec3 p = g.origin() + g.spacing() * Vec3(i, j, k);
        const double d = tree.signed_distance(p);
        if (n % 97 == 0) {
          ASSERT_NEAR(std::abs(d), closest_brute_force(mesh, p).distance, 1e-12);
        }

        ASSERT_EQ(g.values()[n] < 0, d < 0);
        if (std::abs(d) <= 0.12) {
          ASSERT_NEAR(g.values()[n], d, 1e-7);
        } else {
          ASSERT_GE(std::abs(g.values()[n]), std::abs(d) - 1e-7);
          ASSERT_LE(std::abs(g.values()[n]), std::abs(d) * 1.02 + 1e-7);
        }
      }
}

TEST(DistanceGrid, TricubicIsNearerToASphereThanTrilinear) {
  const std::uint64_t seed = 43;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  const auto exact = [](const Vec3& p) { return p.norm() - 1.0; };
  const DistanceGrid g = sample_distance({Vec3::Constant(-1.5), Vec3::Constant(1.5)}, 0.1, exact);
  double linear = 0.0, cubic = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = random.in({Vec3::Constant(-1), Vec3::Constant(1)}).normalized() * random(0.8, 1.2);
    linear = std::max(linear, std::abs(g.value(p, Interpolation::Trilinear) - exact(p)));
    cubic = std::max(cubic, std::abs(g.value(p, Interpolation::Tricubic) - exact(p)));
  }
  EXPECT_LT(linear, 0.1 * 0.1 / 4.0 * 1.3);  // h²/8 per curved direction, radius 0.8
  EXPECT_LT(cubic, 0.1 * linear);
}

/// Root of the mean square of what values within 1.5 spacings of a surface miss, [spacings].
double miss_near(const Aabb& box, double h, const std::function<double(const Vec3&)>& exact) {
  test::Random random(47);
  const DistanceGrid g = sample_distance(box.inflated(0.2), h, exact);
  double sum = 0.0;
  int n = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vec3 p = random.in(box);
    const double d = exact(p), miss = g.value(p) - d;
    if (std::abs(d) < 1.5 * h) sum += miss * miss, ++n;
  }
  return std::sqrt(sum / n) / h;
}

TEST(DistanceGrid, TellsEdgesAndWhatIsRound) {
  const Vec3 half(0.51, 0.43, 0.37);
  const Mat3 turn = Eigen::AngleAxisd(0.5, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const auto box = [&](const Vec3& p) {
    const Vec3 q = (turn * p).cwiseAbs() - half;
    return q.cwiseMax(0.0).norm() + std::min(0.0, q.maxCoeff());
  };
  EXPECT_LT(miss_near({Vec3::Constant(-0.8), Vec3::Constant(0.8)}, 0.05, box), 0.014);  // Catmull-Rom: 0.0275
  // A tube of six spacings: where it is bent as much, it must not be taken for a kink.
  const auto torus = [](const Vec3& p) { return std::hypot(std::hypot(p.x(), p.y()) - 0.9, p.z()) - 0.3; };
  EXPECT_LT(miss_near({Vec3(-1.3, -1.3, -0.4), Vec3(1.3, 1.3, 0.4)}, 0.05, torus), 7e-4);
}

TEST(DistanceGrid, ValuesAreContinuousFromCellToCell) {
  const std::uint64_t seed = 48;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  // Where interpolation takes turns with the distance to the triangles themselves, values jump by its error
  // (ExactCells).
  DistanceGrid g = make_distance_grid(shapes::gear(8, 0.5, 0.35, 0.3, 0.1), spacing(0.05));
  g.set_exact_cells(nullptr);
  const double e = 1e-9;
  for (int i = 0; i < 2000; ++i) {
    Vec3 p = random.in(g.box().inflated(-0.01));
    const int k = i % 3;
    p[k] = g.origin()[k] + g.spacing() * std::round((p[k] - g.origin()[k]) / g.spacing());
    EXPECT_NEAR(g.value(p + e * Vec3::Unit(k)), g.value(p - e * Vec3::Unit(k)), 1e-7);
  }
}

TEST(DistanceGrid, OutsideItsBoxNeverClaimsMoreThanTheDistance) {
  const std::uint64_t seed = 53;
  SCOPED_TRACE(seed);
  test::Random random(seed);
  const SurfaceTree tree(shapes::star(5, 0.5, 0.2, 0.1));
  const DistanceGrid g = make_distance_grid(tree.mesh(), spacing(0.03));
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = random.in(g.box().inflated(2.0));
    if (!g.box().overlaps({p, p})) {
      // Tricubic values on the border of the box may exceed the distance by the interpolation's error.
      EXPECT_LE(g.value(p), tree.closest(p).distance + 0.05 * g.spacing());
      EXPECT_GT(g.value(p), 0.5 * tree.closest(p).distance);
    }
  }
}

TEST(DistanceGrid, OpenSurfacesAreRefusedUnlessTheirTreatmentIsChosen) {
  const TriMesh open = without_top(shapes::icosphere(1.0, 4), 0.9);
  const std::string said = message_of([&] { make_distance_grid(open, spacing(0.1)); });
  EXPECT_NE(said.find(std::to_string(inspect(open).boundary_edges) + " boundary edges"), std::string::npos) << said;
  EXPECT_NE(said.find("winding_number"), std::string::npos) << said;
  EXPECT_NE(said.find("thickness"), std::string::npos) << said;

  // The winding number closes the hole near the missing cap: the volume of a sphere less about half a cap.
  const double sphere = 4.0 / 3.0 * std::numbers::pi;
  const MassProperties m =
      mass_properties(make_distance_grid(open, spacing(0.05, SurfaceTreatment::WindingNumber)), 1.0);
  EXPECT_NEAR(m.volume / sphere, 1.0, 0.02);

  // As a sheet it is a shell of its area times the thickness, plus half a tube along its rim.
  DistanceGridOptions o = spacing(0.03, SurfaceTreatment::Thickness);
  o.thickness = 0.2;
  double rim = 0.0;
  for (const Edge& e : boundary_edges(open.triangles)) rim += (open.vertices[e[0]] - open.vertices[e[1]]).norm();
  const double shell = surface_area(open) * o.thickness + rim * std::numbers::pi * 0.01 / 2.0;
  EXPECT_NEAR(mass_properties(make_distance_grid(open, o), 1.0).volume / shell, 1.0, 0.02);
}

TEST(DistanceGrid, TreatmentsAgreeOnAClosedSurface) {
  const TriMesh mesh = shapes::blob(12, 0.5, 4);
  const DistanceGrid a = make_distance_grid(mesh, spacing(0.04)),
                     b = make_distance_grid(mesh, spacing(0.04, SurfaceTreatment::WindingNumber));
  ASSERT_EQ(a.values().size(), b.values().size());
  for (std::size_t n = 0; n < a.values().size(); ++n) {
    ASSERT_EQ(a.values()[n] < 0, b.values()[n] < 0);
    ASSERT_NEAR(a.values()[n], b.values()[n], 0.25 * 0.04);
  }
  EXPECT_NEAR(mass_properties(a, 1.0).volume / enclosed_volume(mesh), 1.0, 0.01);
}

TEST(DistanceGrid, WindingNumberDropsSurfacesInsideTheSolid) {
  // Two overlapping spheres: the nearest sheet misleads pseudonormals, and is seen; the union has no inner surface.
  TriMesh two = shapes::icosphere(0.5, 4);
  const TriMesh other = two;
  for (const Vec3& x : other.vertices) two.vertices.push_back(x + Vec3(0.4, 0, 0));
  const auto shift = static_cast<std::int32_t>(other.vertices.size());
  for (const Triangle& t : other.triangles) two.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
  EXPECT_NE(message_of([&] { make_distance_grid(two, spacing(0.05)); }).find("passes through itself"),
            std::string::npos);
  const DistanceGrid g = make_distance_grid(two, spacing(0.04, SurfaceTreatment::WindingNumber));
  EXPECT_NEAR(g.value({-0.1, 0, 0}), -0.4, 0.01);  // on the sheet of the second sphere, deep in the first
  EXPECT_NEAR(g.value({0.2, 0, 0}), -std::sqrt(0.25 - 0.04), 0.02);
}

TEST(DistanceGrid, RefusesAbsurdSizesWithAnAdvice) {
  const TriMesh mesh = shapes::box({1, 1, 1});
  EXPECT_NE(message_of([&] { make_distance_grid(mesh, spacing(1e-7)); }).find("use a spacing of about"),
            std::string::npos);
  EXPECT_THROW(make_distance_grid(mesh, spacing(0.0)), InputError);
  EXPECT_THROW(make_distance_grid(mesh, spacing(-1.0)), InputError);
  EXPECT_THROW(make_distance_grid(mesh, spacing(std::nan(""))), InputError);
  EXPECT_THROW(make_distance_grid(mesh, spacing(0.1, SurfaceTreatment::Thickness)), InputError);
  TriMesh inside_out = mesh;
  for (Triangle& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_THROW(make_distance_grid(inside_out, spacing(0.1)), InputError);
  EXPECT_THROW(make_distance_grid(inside_out, spacing(0.1, SurfaceTreatment::WindingNumber)), InputError);
  EXPECT_THROW(make_distance_grid(TriMesh{}, spacing(0.1)), InputError);
}

TEST(DistanceGrid, HasTheSameBitsForAnyNumberOfThreads) {
  const TriMesh mesh = without_top(shapes::blob(3, 0.5, 4), 0.3);
  for (const SurfaceTreatment t : {SurfaceTreatment::WindingNumber, SurfaceTreatment::Thickness}) {
    DistanceGridOptions o = spacing(0.06, t);
    o.thickness = 0.15;
    std::vector<float> one;
    {
      const ThreadLimit limit(1);
      one = make_distance_grid(mesh, o).values();
    }
    EXPECT_EQ(one, make_distance_grid(mesh, o).values());
  }
}

TEST(Isosurface, OfASphereIsClosedAndConvergesAtSecondOrder) {
  double last = 0.0;
  for (const int n : {16, 32, 64}) {
    const DistanceGrid g = sample_distance({Vec3::Constant(-1.3), Vec3::Constant(1.3)}, 2.6 / n,
                                           [](const Vec3& p) { return (p - Vec3(0.013, 0.007, 0.003)).norm() - 1.0; });
    const TriMesh m = isosurface({g.origin(), g.spacing(), g.nodes(), g.values()});
    const MeshReport r = inspect(m);
    EXPECT_TRUE(r.closed() && r.oriented() && r.manifold()) << r.summary();
    const double error = 1.0 - r.volume / (4.0 / 3.0 * std::numbers::pi);
    if (last > 0.0) {
      EXPECT_NEAR(last / error, 4.0, 0.6);
    }
    last = error;
  }
}

TEST(DistanceGrid, HoldsTheBunnyInSpiteOfItsHoles) {
  const auto path = test::data_file("stanford-bunny.obj");
  if (path.empty()) GTEST_SKIP() << "no test data";
  const TriMesh bunny = weld(test::read_plain_obj(path), 0.0);
  const Aabb box = bounds(bunny.vertices);
  EXPECT_THROW(make_distance_grid(bunny, spacing(0.02 * box.extent().x())), InputError);
  const DistanceGrid g = make_distance_grid(bunny, spacing(0.02 * box.extent().x(), SurfaceTreatment::WindingNumber));
  // Its holes lie in its flat base: the volume is that of the surface closed by fans from its middle.
  EXPECT_NEAR(mass_properties(g, 1.0).volume / std::abs(enclosed_volume(bunny)), 1.0, 0.03);
}

TEST(DistanceGrid, HoldsMessyMeshesAsSheetsAndByTheirWindingNumber) {
  int found = 0;
  for (const char* name : {"teapot.obj", "suzanne.obj"}) {
    const auto path = test::data_file(name);
    if (path.empty()) continue;
    ++found;
    SCOPED_TRACE(name);
    const TriMesh mesh = weld(test::read_plain_obj(path), 0.0);
    const Aabb box = bounds(mesh.vertices);
    const double h = box.extent().maxCoeff() / 40;
    EXPECT_THROW(make_distance_grid(mesh, spacing(h)), InputError);
    DistanceGridOptions o = spacing(h, SurfaceTreatment::Thickness);
    o.thickness = 2 * h;
    // A sheet's volume is about area times thickness, less where it folds, doubles or ends.
    const double sheet = mass_properties(make_distance_grid(mesh, o), 1.0).volume / (surface_area(mesh) * o.thickness);
    EXPECT_GT(sheet, 0.7);
    EXPECT_LT(sheet, 1.1);
    // As a solid it fills a fair share of its box, and no more than the box.
    const double solid =
        mass_properties(make_distance_grid(mesh, spacing(h, SurfaceTreatment::WindingNumber)), 1.0).volume;
    EXPECT_GT(solid / box.extent().prod(), 0.2);
    EXPECT_LT(solid / box.extent().prod(), 0.7);
  }
  if (found == 0) GTEST_SKIP() << "no test data";
}

}  // namespace
}  // namespace brim::distance_grid_test
