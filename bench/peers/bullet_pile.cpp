#include <btBulletDynamicsCommon.h>

#include "pile.h"

namespace brim::peers {

namespace {

btVector3 vector(const Vec3& v) { return {btScalar(v.x()), btScalar(v.y()), btScalar(v.z())}; }
Vec3 vector(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

/// [m] by which Bullet inflates hulls, for its shallow-penetration test.
constexpr double kMargin = 0.001;

class BulletEngine final : public Engine {
 public:
  BulletEngine(const Pile& pile, bool sleep) : dt_(pile.time_step), sleep_(sleep) {
    world_.setGravity({0, 0, btScalar(-9.81)});
    add_fixed(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0)), Vec3::Zero(), pile.friction);
    for (const Wall& w : pile.walls) add_fixed(std::make_unique<btBoxShape>(vector(w.half)), w.center, pile.friction);
    std::vector<btCollisionShape*> shape;
    for (const auto& pieces : pile.shapes) shape.push_back(make_shape(pieces));
    for (const Solid& s : pile.solids) {
      btRigidBody::btRigidBodyConstructionInfo info(btScalar(s.mass), nullptr, shape[s.shape], vector(s.inertia));
      info.m_startWorldTransform.setOrigin(vector(s.position));
      info.m_startWorldTransform.setRotation(
          {btScalar(s.rotation.x()), btScalar(s.rotation.y()), btScalar(s.rotation.z()), btScalar(s.rotation.w())});
      info.m_friction = btScalar(std::sqrt(pile.friction));  // Bullet multiplies the two
      solid_.push_back(add(info));
      if (!sleep) solid_.back()->setActivationState(DISABLE_DEACTIVATION);
    }
  }

  ~BulletEngine() override {
    for (const auto& b : bodies_) world_.removeRigidBody(b.get());
  }

  std::string name() const override { return sleep_ ? "Bullet, asleep at rest" : "Bullet"; }
  void step() override { world_.stepSimulation(btScalar(dt_), 0); }
  Placement placement() const override {
    Placement p;
    for (const btRigidBody* b : solid_) {
      const btTransform& t = b->getWorldTransform();
      const btQuaternion r = t.getRotation();
      p.position.push_back(vector(t.getOrigin()));
      p.rotation.push_back(Quat(r.w(), r.x(), r.y(), r.z()).normalized());
      p.velocity.push_back(vector(b->getLinearVelocity()));
      p.spin.push_back(vector(b->getAngularVelocity()));
    }
    return p;
  }

 private:
  btRigidBody* add(const btRigidBody::btRigidBodyConstructionInfo& info) {
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    world_.addRigidBody(bodies_.back().get());
    return bodies_.back().get();
  }
  void add_fixed(std::unique_ptr<btCollisionShape> shape, const Vec3& at, double friction) {
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shape.get());
    info.m_startWorldTransform.setOrigin(vector(at));
    info.m_friction = btScalar(std::sqrt(friction));
    shapes_.push_back(std::move(shape));
    add(info);
  }
  btCollisionShape* keep(std::unique_ptr<btCollisionShape> shape) {
    shapes_.push_back(std::move(shape));
    return shapes_.back().get();
  }
  /// The shape of a piece in its own frame, and where that frame lies.
  std::pair<btCollisionShape*, btTransform> convex(const Piece& p) {
    btTransform at = btTransform::getIdentity();
    if (p.box()) return {keep(std::make_unique<btBoxShape>(vector(p.half))), at};
    if (p.ball()) return {keep(std::make_unique<btSphereShape>(btScalar(p.radius))), at};
    if (p.capsule()) {
      const Vec3 way = p.points[1] - p.points[0];
      const Quat turn = Quat::FromTwoVectors(Vec3::UnitY(), way);
      at.setOrigin(vector(Vec3(0.5 * (p.points[0] + p.points[1]))));
      at.setRotation({btScalar(turn.x()), btScalar(turn.y()), btScalar(turn.z()), btScalar(turn.w())});
      return {keep(std::make_unique<btCapsuleShape>(btScalar(p.radius), btScalar(way.norm()))), at};
    }
    auto hull = std::make_unique<btConvexHullShape>();
    for (const Vec3& x : p.points) hull->addPoint(vector(x), false);
    hull->recalcLocalAabb();
    hull->setMargin(btScalar(kMargin));
    return {keep(std::move(hull)), at};
  }
  btCollisionShape* make_shape(const std::vector<Piece>& pieces) {
    if (pieces.size() == 1 && !pieces[0].capsule()) return convex(pieces[0]).first;
    auto whole = std::make_unique<btCompoundShape>();
    for (const Piece& p : pieces) {
      const auto [shape, at] = convex(p);
      whole->addChildShape(at, shape);
    }
    return keep(std::move(whole));
  }

  double dt_;
  bool sleep_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<btRigidBody*> solid_;
};

}  // namespace

std::unique_ptr<Engine> make_bullet(const Pile& pile, bool sleep) {
  return std::make_unique<BulletEngine>(pile, sleep);
}

}  // namespace brim::peers
