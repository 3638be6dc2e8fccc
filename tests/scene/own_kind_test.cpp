#include "brim/scene/own_kind.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "../../examples/user_body/jelly.cpp"
#include "brim/body/own/own_body_check.h"
#include "brim/mesh/primitives.h"
#include "brim/scene/pairs/pair_report.h"
#include "brim/scene/pairs/pair_trial.h"
#include "brim/scene/scene.h"
#include "checkout_paths.h"

/// The example of docs/bodies/your_own.md, whose source is compiled into this test.
namespace brim::own_kind_test {
namespace {

const std::string kExample = std::string(BRIM_SOURCE_DIR) + "/examples/user_body/";

std::string read(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string message_of(const std::string& body) {
  try {
    parse_scene(R"({"brim": 1, "name": "s", "frames": 1, "bodies": [)" + body + "]}");
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(OwnKind, TheExampleIsShort) {
  const std::string text = read(kExample + "jelly.cpp");
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 60);
  EXPECT_GT(std::count(text.begin(), text.end(), '\n'), 20);
}

TEST(OwnKind, TheSceneOfTheExampleRuns) {
  const Scene scene = load_scene(kExample + "jelly.json");
  World world = build_world(scene);
  ASSERT_EQ(world.body(3).kind(), "jelly");
  double contacts = 0.0, error = 0.0;
  for (int step = 0; step < 24; ++step) {
    const StepReport r = world.step();
    ASSERT_TRUE(r.ok);
    contacts = std::max(contacts, static_cast<double>(r.contacts));
    error = std::max({error, r.momentum_error, r.angular_error});
    EXPECT_LT(r.worst_overlap, 1.0);
  }
  EXPECT_GT(contacts, 100.0);
  EXPECT_LT(error, 1e-9);
}

TEST(OwnKind, MeetsAPlaneARigidBallAndASoftBlock) {
  PairTable table = standard_pairs();
  table.add_kinds(read_pair_table(read(kExample + "pair.json"), "pair.json"));
  for (const char* lower : {"plane", "rigid", "finite_elements", "user_body"}) {
    const PairResult r = run_pair(table, table.find(lower), table.find("user_body"));
    EXPECT_TRUE(r.ok()) << pair_line(r);
  }
  EXPECT_THROW(table.add_kinds(standard_pairs()), InputError);
}

TEST(OwnKind, ItsKeysAreCheckedLikeAnyKinds) {
  EXPECT_EQ(message_of(R"({"kind": "jelly", "name": "j", "radius": 0.1})"), "no error");
  EXPECT_NE(message_of(R"({"kind": "jelly", "name": "j"})").find("\"radius\" is missing"), std::string::npos);
  EXPECT_NE(message_of(R"({"kind": "jelly", "name": "j", "radius": -1})").find("must be a number above 0"),
            std::string::npos);
  EXPECT_NE(
      message_of(R"({"kind": "jelly", "name": "j", "radius": 1, "stifness": 2})").find("did you mean \"stiffness\""),
      std::string::npos);
  EXPECT_NE(message_of(R"({"kind": "jellie", "name": "j"})").find("did you mean \"jelly\""), std::string::npos);
}

TEST(OwnKind, WhatTheWorldRefusesHasThePlaceOfTheEntry) {
  class Unset final : public OwnBody {  // says not where its matter is
   public:
    explicit Unset(OwnModel m) : OwnBody(std::move(m)) {}
    std::string_view kind() const override { return "unset"; }
    double distance(Coordinates, const Vec3& x) const override { return x.norm() - 0.1; }
  };
  add_body_kind("unset", "{}", [](const OwnEntry&) {
    OwnModel model;
    model.q = {0.0};
    model.surface = shapes::icosphere(0.1, 2);
    return std::make_unique<Unset>(std::move(model));
  });
  const Scene scene = parse_scene(R"({"brim": 1, "name": "s", "frames": 1, "bodies": [
    {"kind": "jelly", "name": "j", "radius": 0.1},
    {"kind": "unset", "name": "u"}]})",
                                  "mine.json");
  try {
    build_world(scene);
    FAIL() << "it has no deform";
  } catch (const InputError& e) {
    EXPECT_EQ(std::string(e.what()).find("mine.json:3: /bodies/1: body of kind 'unset': deform"), 0u) << e.what();
  }
}

TEST(OwnKind, NamesAndKeysThatAreTakenAreRefused) {
  const OwnMaker none = [](const OwnEntry&) { return std::unique_ptr<Body>(); };
  EXPECT_THROW(add_body_kind("rigid", "{}", none), InputError);
  EXPECT_THROW(add_body_kind("jelly", "{}", none), InputError);
  EXPECT_THROW(add_body_kind("other", "[]", none), InputError);
  EXPECT_THROW(add_body_kind("other", R"({"name": {"type": "string"}})", none), InputError);
}

TEST(OwnKind, HasTheResponseOfAnyBody) {
  const auto response = [](const std::string& key) {
    const World world = build_world(parse_scene(R"({"brim": 1, "name": "s", "frames": 1, "bodies": [
      {"kind": "jelly", "name": "j", "radius": 0.1)" +
                                                key + "}]}"));
    return world.body(0).part(0).material.response;
  };
  EXPECT_EQ(response(""), Response::Inherit);
  EXPECT_EQ(response(R"(, "response": "constraint")"), Response::Constraint);
  EXPECT_EQ(response(R"(, "response": "penalty")"), Response::Penalty);
  EXPECT_NE(message_of(R"({"kind": "jelly", "name": "j", "radius": 1, "response": "hard"})").find("response"),
            std::string::npos);
}

TEST(OwnKind, WhatAMakerDoesWronglyNamesItsKindAndThePlace) {
  const auto message = [](const char* name, const OwnMaker& make) {
    add_body_kind(name, R"({"size": {"type": "number"}})", make);
    try {
      build_world(parse_scene(R"({"brim": 1, "name": "s", "frames": 1, "bodies": [{"kind": ")" + std::string(name) +
                                  R"(", "name": "b", "size": 1}]})",
                              "mine.json"));
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  const std::string at = "mine.json:1: /bodies/0: the maker of kind ";
  const auto none = [](const OwnEntry&) { return std::unique_ptr<Body>(); };
  EXPECT_EQ(message("gives_none", none), at + "\"gives_none\" gave no body (nullptr)");
  EXPECT_EQ(message("raises", [](const OwnEntry&) -> std::unique_ptr<Body> { throw std::runtime_error("no file"); }),
            at + "\"raises\" raised \"no file\"");
  const auto misspelt = [&](const OwnEntry& e) { return e.number("sice"), none(e); };
  EXPECT_EQ(message("misspells", misspelt).find(at + "\"misspells\" reads the key \"sice\", which is not there"), 0u);
  const auto mistaken = [&](const OwnEntry& e) { return e.string("size"), none(e); };
  EXPECT_EQ(message("mistakes", mistaken), at + "\"mistakes\" reads the key \"size\" as a string, but it is 1");
}

TEST(OwnKind, KindsOfOtherHeadersAreRefused) {
  const OwnMaker none = [](const OwnEntry&) { return std::unique_ptr<Body>(); };
  try {
    add_body_kind("older", "{}", none, kOwnKindLayout + 1);
    FAIL() << "its layout is another";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("another version of brim"), std::string::npos);
  }
}

TEST(OwnKind, TheSchemaThatIsPrintedHasIt) {
  EXPECT_EQ(scene_schema_text().find("\"jelly\""), std::string::npos);
  EXPECT_NE(known_schema_text().find("\"jelly\""), std::string::npos);
}

TEST(OwnKind, TheExampleIsFoundGood) {
  const World world = build_world(load_scene(kExample + "jelly.json"));
  EXPECT_EQ(check_own_body(dynamic_cast<const OwnBody&>(world.body(3))), std::vector<std::string>());
}

}  // namespace
}  // namespace brim::own_kind_test
