#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include "cloth.h"

namespace brim::peers {

namespace {

/// Passes over the links of the sheet in a step, as over the contacts of a pile.
constexpr int kIterations = 10;

btVector3 vector(const Vec3& v) { return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())}; }

/// A patch of position-based links, with diagonals, as stiff as they go.
class BulletCloth final : public SheetEngine {
 public:
  explicit BulletCloth(const ClothOnBall& c) : dt_(c.time_step), ball_(btScalar(c.radius)) {
    const btVector3 gravity(0, 0, btScalar(-9.81));
    world_.setGravity(gravity);
    world_.getWorldInfo().m_gravity = gravity;
    world_.getWorldInfo().air_density = 0;
    world_.getWorldInfo().m_sparsesdf.Initialize();
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, &ball_);
    info.m_startWorldTransform.setOrigin(vector(c.center));
    info.m_friction = btScalar(c.friction);
    fixed_ = std::make_unique<btRigidBody>(info);
    world_.addRigidBody(fixed_.get());
    const auto corner = [&](double x, double y) {
      return vector(Vec3(c.start + Vec3(0.5 * x * c.size_x, 0.5 * y * c.size_y, 0.0)));
    };
    sheet_.reset(btSoftBodyHelpers::CreatePatch(world_.getWorldInfo(), corner(-1, -1), corner(1, -1), corner(-1, 1),
                                                corner(1, 1), c.nodes_x, c.nodes_y, 0, true));
    sheet_->getCollisionShape()->setMargin(btScalar(0.5 * c.thickness));
    sheet_->m_cfg.piterations = kIterations;
    sheet_->m_cfg.kDF = btScalar(c.friction);
    sheet_->m_materials[0]->m_kLST = 1;
    sheet_->setTotalMass(btScalar(c.mass));
    sheet_->setActivationState(DISABLE_DEACTIVATION);
    world_.addSoftBody(sheet_.get());
  }
  ~BulletCloth() override {
    world_.removeSoftBody(sheet_.get());
    world_.removeRigidBody(fixed_.get());
  }

  void step() override { world_.stepSimulation(btScalar(dt_), 0); }
  std::vector<Vec3> nodes() const override {
    std::vector<Vec3> x;
    for (int i = 0; i < sheet_->m_nodes.size(); ++i) {
      const btVector3& p = sheet_->m_nodes[i].m_x;
      x.emplace_back(p.x(), p.y(), p.z());
    }
    return x;
  }

 private:
  double dt_;
  btSphereShape ball_;
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btSoftRigidDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::unique_ptr<btRigidBody> fixed_;
  std::unique_ptr<btSoftBody> sheet_;
};

}  // namespace

std::unique_ptr<SheetEngine> make_bullet_cloth(const ClothOnBall& cloth) {
  return std::make_unique<BulletCloth>(cloth);
}

}  // namespace brim::peers
