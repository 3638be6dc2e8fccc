#include "brim/scene/read_expectation.h"

#include "brim/scene/body_names.h"
#include "brim/world/shown_metric.h"

namespace brim {

Expectation read_expectation(const Node& n, const std::set<std::string>* bodies, double end) {
  Expectation e;
  e.metric = n.string("metric");
  const auto read_body = [&](const char* key, std::string& name) {
    if (!n.has(key)) return;
    name = n.string(key);
    if (bodies != nullptr) need_body(n.at(key), name, *bodies);
  };
  read_body("body", e.body);
  read_body("of", e.of);
  if (ShownMetric::knows(e.metric) && e.body.empty())
    throw n.error(fmt::format("{} is of one body; \"body\" must name it", e.metric));
  if (ShownMetric::needs_other(e.metric) != n.has("of"))
    throw n.error(fmt::format(
        "{} {}", e.metric,
        n.has("of") ? "takes no other body; \"of\" must not be given" : "is beside another body; \"of\" must name it"));
  const bool sensed = e.metric == "sensor";
  for (const char* key : {"sensor", "channel"})
    if (n.has(key) != sensed)
      throw n.error(fmt::format(
          "\"{}\" {}", key,
          sensed ? "is missing: the metric \"sensor\" is of a reading of one" : "is of the metric \"sensor\" alone"));
  if (sensed) {
    if (n.has("body")) throw n.at("body").error("it is not allowed beside \"sensor\"; a sensor has its bodies");
    e.reading = {n.string("sensor"), n.string("channel")};
    if (n.has("over")) e.over = {n.at("over").string("sensor"), n.at("over").string("channel")};
    e.take = n.string("take");
  }
  e.from = n.number("from");
  if (e.from > end * (1 + 1e-9))
    throw n.at("from").error(fmt::format("{} s is after the end of the run; must be at most {:.6g}", e.from, end));
  if (n.has("to")) e.to = n.number("to");
  if (e.to < e.from) throw n.at("to").error(fmt::format("{} s is before \"from\"; must be at least {}", e.to, e.from));
  if (!n.has("min") && !n.has("max")) throw n.error("no bound is given; \"min\", \"max\" or both are needed");
  if (n.has("min")) e.min = n.number("min");
  if (n.has("max")) e.max = n.number("max");
  if (e.min > e.max)
    throw n.at("min").error(fmt::format("{} is not allowed; must be at most \"max\", {}", e.min, e.max));
  if (n.has("known_miss")) e.known_miss = n.string("known_miss");
  if (n.has("known_worst")) {
    e.known_worst = n.number("known_worst");
    if (e.known_miss.empty()) throw n.at("known_worst").error("it is of a bound with \"known_miss\" alone");
    if (e.known_worst >= e.min && e.known_worst <= e.max)
      throw n.at("known_worst").error(fmt::format("{} is within the bound; must be outside of it", e.known_worst));
  }
  return e;
}

}  // namespace brim
