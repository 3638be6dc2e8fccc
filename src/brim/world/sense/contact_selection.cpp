#include "brim/world/sense/contact_selection.h"

#include <algorithm>

#include "brim/body/body.h"
#include "brim/core/error.h"
#include "brim/world/touch_rules.h"
#include "brim/world/world.h"

namespace brim {

namespace {

bool any_matches(const std::vector<std::string>& words, const std::string& name) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& w) { return name_matches(w, name); });
}

}  // namespace

ContactSelection::ContactSelection(const SensorModel& model, const World& world) : model_(model) {
  for (const auto* words : {&model.bodies, &model.with})
    for (const std::string& word : *words) {
      bool found = false;
      for (int b = 0; b < world.body_count() && !found; ++b) found = name_matches(word, world.body(b).name());
      if (!found) throw InputError(fmt::format("\"{}\" is not a body, nor a stem or pattern of names of some", word));
    }
  find_bodies(world);
  if (!model.region || !model.follows) return;
  for (std::size_t b = 0; b < own_.size(); ++b) try {
      if (own_[b] != 0) start_[bodies_[b]] = std::make_unique<StartPlaces>(*bodies_[b]);
    } catch (const InputError& e) {
      throw InputError(fmt::format("{}; \"follows\" must be false", e.what()));
    }
}

void ContactSelection::find_bodies(const World& world) {
  own_.clear(), other_.clear(), bodies_.clear(), body_of_.clear(), index_of_.clear();
  for (int b = 0; b < world.body_count(); ++b) {
    const Body& body = world.body(b);
    own_.push_back(any_matches(model_.bodies, body.name()));
    other_.push_back(model_.with.empty() || any_matches(model_.with, body.name()));
    bodies_.push_back(&body);
  }
  for (int p = 0; p < world.part_count(); ++p) {
    body_of_.push_back(world.part(p).body);
    index_of_.push_back(world.part(p).index);
  }
  std::erase_if(start_, [&](const auto& entry) { return std::ranges::find(bodies_, entry.first) == bodies_.end(); });
}

void ContactSelection::moved() {
  for (const auto& [body, places] : start_) places->moved();
}

bool ContactSelection::in_region(int body, int part, const Vec3& x) {
  if (!model_.region) return true;
  if (!model_.follows) return model_.region(x);
  const auto places = start_.find(bodies_[static_cast<std::size_t>(body)]);
  return places != start_.end() && model_.region(places->second->of(part, x));
}

bool ContactSelection::concerns(int a, int b) const {
  const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
  return (own_[i] != 0 && other_[j] != 0) || (own_[j] != 0 && other_[i] != 0);
}

ContactSelection::Side ContactSelection::side(const ContactSample& s) {
  const int a = body_of_[static_cast<std::size_t>(s.part_a)], b = body_of_[static_cast<std::size_t>(s.part_b)];
  const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
  const Vec3 x = s.position.cast<double>();
  const bool within = own_[i] != 0 && own_[j] != 0;
  if (own_[i] != 0 && other_[j] != 0 && in_region(a, index_of_[static_cast<std::size_t>(s.part_a)], x))
    return {1.0, a, b, within};
  if (own_[j] != 0 && other_[i] != 0 && in_region(b, index_of_[static_cast<std::size_t>(s.part_b)], x))
    return {-1.0, b, a, within};
  return {};
}

}  // namespace brim
