#pragma once

#include <functional>

#include "brim/body/meshless/held_matter.h"
#include "brim/body/meshless/sample_elements.h"
#include "brim/body/volume/carried_body.h"
#include "brim/mesh/occupancy.h"

namespace brim {

/// Points of a meshless solid at rest, in the body's own frame.
struct MeshlessModel {
  std::vector<Vec3> frames;             ///< [m] X_k, three coordinates each
  double reach = 0.0;                   ///< [m] of a frame's shape function
  std::vector<Vec3> samples;            ///< [m] integration points of the elastic energy
  std::vector<double> sample_volume;    ///< [m³]
  std::vector<Vec3> particles;          ///< [m] of the material, for mass and density
  std::vector<double> particle_volume;  ///< [m³]
  TriMesh surface;                      ///< for display
};

/// Frames on a cubic lattice of the given spacing that fill a solid, eight samples per frame, and particles of cells.
/// @param distance  signed distance to the solid, [m]
/// @param cell      [m] of the particles, about a voxel of contact
/// @throws InputError  when the spacing leaves fewer than four frames
MeshlessModel fill_with_frames(const std::function<double(const Vec3&)>& distance, const Aabb& box, double spacing,
                               double cell);

/// Deformable solid without a mesh (paper, section 5.4): frames whose smooth shape functions (moving least squares)
/// move all matter, elastic energy at samples, density by the volume layer. Tests: tests/body/carried_body_test.cpp
class MeshlessBody final : public CarriedBody {
 public:
  /// @param held  matter that moves with frames which the options fix or move
  /// @throws InputError  when a number is out of range or the points do not make a body
  MeshlessBody(const MeshlessModel& model, const Quat& rotation, const Vec3& position, ElasticOptions options,
               std::span<const HeldRegion> held = {});

  std::string_view kind() const override { return "meshless"; }
  double elastic_energy() const override { return elements_.energy(x_) + held_.energy(x_); }
  const SampleElements& elements() const { return elements_; }
  StressField stress_field() const override;
  void show(std::span<const double> value, std::span<float> out) const override;

 protected:
  void add_inner() override {
    elements_.add(x_, force_, stiffness_);
    held_.add(x_, force_, stiffness_);
  }

 private:
  struct Parts {
    std::vector<Vec3> frames;
    Carriage carriage;
    CarriedSurface surface;
    ShapeFunctions shape;
    std::vector<double> volume;
    HeldMatter held;
  };
  static Parts build(const MeshlessModel& model, const Quat& rotation, const Vec3& position,
                     const ElasticOptions& options, std::span<const HeldRegion> held);
  MeshlessBody(Parts parts, const ElasticOptions& options);

  SampleElements elements_;
  HeldMatter held_;
};

}  // namespace brim
