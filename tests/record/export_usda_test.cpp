// No reader of USD is in Debian: the text is held to its grammar by the strict parser below, written from the
// specification of the crate's text form, and then to the formula of tests/support/made_run.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

#include "brim/record/export/export.h"
#include "support/made_run.h"
#include "support/moving_run.h"
#include "support/removing_run.h"

namespace brim::export_usda_test {
namespace {

namespace fs = std::filesystem;
using testing::MadeRun;

struct Attribute {
  std::string type;
  std::vector<double> value;                      ///< numbers in order, flattened
  std::map<double, std::vector<double>> samples;  ///< by time code
  std::map<double, std::string> words;            ///< likewise, of texts; a plain one at time 0
  bool uniform = false;
};
struct Prim {
  std::string type, name;
  std::map<std::string, Attribute> attributes;
  std::vector<Prim> children;
};

/// Reads the part of USD's text form that exports use; anything else is a failure.
class Parser {
 public:
  explicit Parser(std::string text) : text_(std::move(text)) {}

  std::map<std::string, std::string> metadata;  ///< of the layer

  Prim parse() {
    if (!text_.starts_with("#usda 1.0\n")) fail("the first line");
    at_ = 10;
    expect("(");
    while (!next_is(")")) {
      const std::string key = word();
      expect("=");
      metadata[key] = next_is("\"") ? string() : word();
    }
    expect(")");
    expect("def");
    Prim root = prim();
    skip();
    if (at_ != text_.size()) fail("the end");
    return root;
  }

 private:
  [[noreturn]] void fail(const std::string& wanted) {
    const auto line = std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n') + 1;
    throw std::runtime_error(fmt::format("line {}: {} was expected, not \"{}\"", line, wanted, text_.substr(at_, 40)));
  }
  void skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }
  bool next_is(const std::string& token) {
    skip();
    return text_.compare(at_, token.size(), token) == 0;
  }
  void expect(const std::string& token) {
    if (!next_is(token)) fail(token);
    at_ += token.size();
  }
  bool take(const std::string& token) {
    if (!next_is(token)) return false;
    at_ += token.size();
    return true;
  }
  std::string word() {
    skip();
    std::size_t end = at_;
    while (end < text_.size() &&
           (std::isalnum(static_cast<unsigned char>(text_[end])) || std::strchr("_:.+-[]", text_[end])))
      ++end;
    if (end == at_) fail("a word");
    const std::string w = text_.substr(at_, end - at_);
    at_ = end;
    return w;
  }
  std::string string() {
    expect("\"");
    std::string out;
    for (; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      if (text_[at_] == '\n') fail("the end of the text");
      if (text_[at_] == '\\') ++at_;
      out += text_[at_];
    }
    expect("\"");
    return out;
  }
  double number() {
    skip();
    const char* begin = text_.c_str() + at_;
    char* end = nullptr;
    const double x = std::strtod(begin, &end);
    if (end == begin) fail("a number");
    at_ += static_cast<std::size_t>(end - begin);
    return x;
  }
  /// Numbers, texts, tuples and lists of them; separated by commas, none after the last. @param text  the last one
  void value(std::vector<double>& out, std::string& text) {
    for (const auto& [open, close] : {std::pair{"(", ")"}, {"[", "]"}}) {
      if (!take(open)) continue;
      if (take(close)) return;
      do value(out, text);
      while (take(","));
      expect(close);
      return;
    }
    if (next_is("\""))
      text = string();
    else
      out.push_back(number());
  }
  void metadata_block() {
    if (!take("(")) return;
    while (!take(")")) {
      const std::string key = word();
      expect("=");
      if (take("{")) {
        while (!take("}")) {
          word(), word();
          expect("=");
          string();
        }
      } else if (key == "interpolation") {
        const std::string how = string();
        if (how != "constant" && how != "vertex") fail("an interpolation");
      } else
        fail("metadata");
    }
  }
  Prim prim() {
    Prim p;
    p.type = word();
    p.name = string();
    if (p.name.empty() || std::isdigit(static_cast<unsigned char>(p.name[0]))) fail("an identifier");
    for (const char c : p.name)
      if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') fail("an identifier");
    metadata_block();
    expect("{");
    while (!take("}")) {
      if (take("def")) {
        p.children.push_back(prim());
        continue;
      }
      const bool uniform = take("uniform");
      const std::string type = word();
      std::string name = word();
      const bool sampled = name.ends_with(".timeSamples");
      if (sampled) name.resize(name.size() - std::string_view(".timeSamples").size());
      Attribute& a = p.attributes[name];
      if (!a.type.empty() && (a.type != type || !sampled)) fail("an attribute that is not there yet");
      a.type = type;
      a.uniform = uniform;
      if (sampled) {
        expect("=");
        expect("{");
        while (!take("}")) {
          const double time = number();
          expect(":");
          value(a.samples[time], a.words[time]);
          if (!take(",")) {
            expect("}");
            break;
          }
        }
      } else if (take("=")) {
        value(a.value, a.words[0]);
      }
      metadata_block();
    }
    return p;
  }

  std::string text_;
  std::size_t at_ = 0;
};

std::vector<double> flat(int body, int frame) {
  std::vector<double> x;
  for (int i = 0; i < MadeRun::vertices(body); ++i) {
    const Vec3f p = MadeRun::at(body, i, frame);
    x.insert(x.end(), p.data(), p.data() + 3);
  }
  return x;
}

void expect_near(const std::vector<double>& a, const std::vector<double>& b, const std::string& what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 3e-6) << what << " " << i;
}

class Usda : public ::testing::Test {
 protected:
  Prim read(const std::string& frames) { return read(made_.folder(), frames); }
  Prim read(const std::string& folder, const std::string& frames) {
    const RunReader run(folder);
    const fs::path out = made_.path / ("frames " + frames);
    export_run(run, {.format = "usda", .folder = out.string(), .frames = frames});
    std::ostringstream text;
    text << std::ifstream(out / "run.usda").rdbuf();
    Parser parser(text.str());
    Prim root = parser.parse();
    metadata_ = parser.metadata;
    return root;
  }
  MadeRun made_{7};
  std::map<std::string, std::string> metadata_;
};

TEST_F(Usda, IsWellFormedAndSaysItsUnitsAndTimes) {
  const Prim root = read("1:5:2");
  EXPECT_EQ(root.type, "Xform");
  EXPECT_EQ(root.name, metadata_.at("defaultPrim"));
  EXPECT_EQ(metadata_.at("upAxis"), "Z");
  EXPECT_EQ(metadata_.at("metersPerUnit"), "1");
  EXPECT_EQ(metadata_.at("startTimeCode"), "1");
  EXPECT_EQ(metadata_.at("endTimeCode"), "5");
  EXPECT_EQ(std::stod(metadata_.at("timeCodesPerSecond")), 10.0);
  EXPECT_EQ(metadata_.at("doc"), "Run of scene made \"by\" hand by brim 0.1.0");
  std::vector<std::string> prims;
  for (const Prim& p : root.children) prims.push_back(p.type + " " + p.name);
  EXPECT_EQ(prims, (std::vector<std::string>{"Mesh floor", "Mesh ball", "Mesh ball_1", "BasisCurves rod",
                                             "Points grains", "Points contacts"}));
}

TEST_F(Usda, HoldsThePositionsOfEveryFrame) {
  const Prim root = read("1:5:2");
  expect_near(root.children[0].attributes.at("points").value, flat(0, 0), "floor");
  for (const int f : {1, 3, 5}) {
    SCOPED_TRACE(f);
    // The ball turns and rises as one: local points under a row-vector matrix.
    const auto& ball = root.children[1].attributes;
    const std::vector<double>& m = ball.at("xformOp:transform").samples.at(f);
    const std::vector<double>& local = ball.at("points").value;
    ASSERT_EQ(m.size(), 16u);
    std::vector<double> x;
    for (std::size_t i = 0; i + 2 < local.size(); i += 3)
      for (std::size_t c = 0; c < 3; ++c)
        x.push_back(local[i] * m[c] + local[i + 1] * m[4 + c] + local[i + 2] * m[8 + c] + m[12 + c]);
    expect_near(x, flat(1, f), "ball");
    for (const int b : {2, 3, 4})
      expect_near(root.children[static_cast<std::size_t>(b)].attributes.at("points").samples.at(f), flat(b, f),
                  root.children[static_cast<std::size_t>(b)].name);
    EXPECT_EQ(root.children[4].attributes.at("velocities").samples.at(f)[2], 1.0);
    const auto& contacts = root.children[5].attributes;
    const auto n = static_cast<std::size_t>(std::min(f, 2));
    EXPECT_EQ(contacts.at("points").samples.at(f).size(), 3 * n);
    EXPECT_EQ(contacts.at("primvars:force").samples.at(f)[2], -f);
    EXPECT_EQ(contacts.at("primvars:overlap").samples.at(f), std::vector<double>(n, 0.25));
  }
  EXPECT_EQ(root.children[1].attributes.at("faceVertexIndices").value,
            (std::vector<double>{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}));
  EXPECT_EQ(root.children[3].attributes.at("curveVertexCounts").value, std::vector<double>{4});
  EXPECT_EQ(root.children[3].attributes.at("widths").value, std::vector<double>{0.25});
}

TEST_F(Usda, OneFrameNeedsNoSamples) {
  const Prim root = read("5");
  expect_near(root.children[2].attributes.at("points").value, flat(2, 5), "ball.1");
  EXPECT_TRUE(root.children[2].attributes.at("points").samples.empty());
  EXPECT_EQ(root.children[5].attributes.at("primvars:force").value, (std::vector<double>{0, 0, -5, 0, 0, -5}));
}

/// Points of a prim under its matrix at a time code: rows from the left.
std::vector<double> placed(const Prim& prim, double frame) {
  const std::vector<double>& local = prim.attributes.at("points").value;
  const std::vector<double>& m = prim.attributes.at("xformOp:transform").samples.at(frame);
  std::vector<double> x;
  for (std::size_t i = 0; i + 2 < local.size(); i += 3)
    for (std::size_t c = 0; c < 3; ++c)
      x.push_back(local[i] * m[c] + local[i + 1] * m[4 + c] + local[i + 2] * m[8 + c] + m[12 + c]);
  return x;
}

TEST_F(Usda, LinksAreMeshesOfTheirOwnThatMoveAsAWhole) {
  const testing::MovingRun moving;
  const RunReader run(moving.folder());
  const auto number = std::ranges::find(run.bodies(), "arm", &RecordedBody::name) - run.bodies().begin();
  const Prim all = read(moving.folder(), ":");
  const Prim& arm = *std::ranges::find(all.children, "arm", &Prim::name);
  EXPECT_EQ(arm.type, "Xform");
  ASSERT_EQ(arm.children.size(), 2u);
  std::size_t triangles = 0;
  for (const Prim& link : arm.children) {
    EXPECT_EQ(link.type, "Mesh");
    const auto& corners = link.attributes.at("faceVertexIndices").value;
    EXPECT_LT(*std::ranges::max_element(corners), static_cast<double>(link.attributes.at("points").value.size() / 3));
    triangles += corners.size() / 3;
  }
  EXPECT_EQ(triangles, run.triangles(static_cast<int>(number), 0).size());
  for (std::int64_t f = 0; f < run.frames(); ++f) {
    std::vector<double> x, wanted;
    for (const Prim& link : arm.children)
      for (const double c : placed(link, static_cast<double>(f))) x.push_back(c);
    for (const Vec3f& p : run.positions(static_cast<int>(number), f))
      wanted.insert(wanted.end(), p.data(), p.data() + 3);
    expect_near(x, wanted, fmt::format("frame {}", f));
  }
}

// USD interpolates points between samples: one in the frame of the removal would have motion blur draw every grain on
// its way to the centre.
TEST_F(Usda, BodiesThatAreRemovedBecomeInvisibleAndHoldTheirLastPlace) {
  const testing::RemovingRun removing;
  const auto prim = [](const Prim& root, const std::string& name) -> const Prim& {
    return *std::ranges::find(root.children, name, &Prim::name);
  };
  const Prim all = read(removing.folder(), ":");
  EXPECT_FALSE(prim(all, "floor").attributes.contains("visibility"));
  for (const std::string name : testing::RemovingRun::kNames) {
    SCOPED_TRACE(name);
    const auto& a = prim(all, name).attributes;
    ASSERT_TRUE(a.contains("visibility"));
    EXPECT_EQ(a.at("visibility").type, "token");
    EXPECT_EQ(a.at("visibility").words, (std::map<double, std::string>{{0, "inherited"}, {3, "invisible"}}));
    for (const char* moving : {"points", "velocities", "xformOp:transform", "faceVertexIndices"})
      if (a.contains(moving) && !a.at(moving).samples.empty()) {
        EXPECT_EQ(a.at(moving).samples.size(), 3u) << moving;
        EXPECT_EQ(a.at(moving).samples.rbegin()->first, 2) << moving;
        EXPECT_FALSE(a.at(moving).samples.rbegin()->second.empty()) << moving;
      }
  }
  for (const char* name : {"grains", "rope", "hoop"}) {
    const auto& a = prim(all, name).attributes;
    ASSERT_TRUE(a.contains("velocities")) << name;
    EXPECT_EQ(a.at("velocities").samples.size(), a.at("points").samples.size()) << name;
  }
  const Prim none = read(removing.folder(), "3:4");
  EXPECT_EQ(prim(none, "hoop").attributes.at("visibility").words.at(0), "invisible");
  EXPECT_FALSE(prim(none, "hoop").attributes.contains("points"));
}

}  // namespace
}  // namespace brim::export_usda_test
