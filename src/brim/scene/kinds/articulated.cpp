#include "brim/body/articulated/articulated_body.h"
#include "brim/scene/articulated/trees.h"
#include "brim/scene/kinds.h"

namespace brim {

BodyKind articulated_kind();

namespace {

void check_articulated(const Node& n) {
  const int sources = n.has("links") + n.has("chain") + n.has("urdf");
  if (sources != 1)
    throw n.error(fmt::format("{} of \"links\", \"chain\" and \"urdf\" are given; exactly one is needed", sources));
  if (n.string("base") == "fixed")
    for (const char* key : {"velocity", "angular_velocity"})
      if (n.vec3(key) != Vec3::Zero()) throw n.at(key).error("only a free base has a velocity");
  if (n.at("joints").size() > 0 && !n.has("urdf"))
    throw n.at("joints").error("\"joints\" changes the joints of \"urdf\"; links and chain have their own");
  if (n.has("chain") && n.at("chain").vec3("axis") == Vec3::Zero())
    throw n.at("chain").at("axis").error("[0, 0, 0] is no direction");
  if (n.has("links")) check_links(n);
}

class ArticulatedMaker final : public BodyMaker {
 public:
  ArticulatedMaker(const Node& n, const BuildContext& context) {
    model_ = n.has("links")   ? read_links(n, context)
             : n.has("chain") ? read_chain(n, context)
                              : read_urdf_tree(n, context);
    model_.self_collision = n.boolean("self_collision");
    const Node pairs = n.at("no_contact");
    for (std::size_t i = 0; i < pairs.size(); ++i)
      model_.no_contact.emplace_back(find_link(model_, pairs.at(i).at(std::size_t{0})),
                                     find_link(model_, pairs.at(i).at(std::size_t{1})));
  }

  std::unique_ptr<Body> body(const Placement& place) const override {
    ArticulatedModel model = model_;
    for (LinkModel& l : model.links) {
      if (l.parent >= 0) continue;
      JointModel& j = l.joint;
      const Vec3 offset = place.rotation * j.position;
      j.position = place.position + offset;
      j.rotation = place.rotation * j.rotation;
      if (j.kind != JointKind::Free) continue;
      j.velocity = place.velocity + place.angular_velocity.cross(offset);
      j.angular_velocity = place.angular_velocity;
    }
    return std::make_unique<ArticulatedBody>(std::move(model));
  }

 private:
  ArticulatedModel model_;
};

}  // namespace

BodyKind articulated_kind() {
  return {"articulated", check_articulated, [](const Node& n, const BuildContext& c) -> std::unique_ptr<BodyMaker> {
            return std::make_unique<ArticulatedMaker>(n, c);
          }};
}

}  // namespace brim
