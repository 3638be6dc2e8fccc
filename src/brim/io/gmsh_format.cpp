#include <string>
#include <unordered_map>

#include "brim/io/tet_formats.h"

namespace brim {

namespace {

constexpr int kTet4 = 4, kTet10 = 11;

// Nodes of each element type, by Gmsh's number; 0 where it is not known here.
constexpr int kNodes[] = {0, 2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13};

class GmshParser {
 public:
  explicit GmshParser(FileCursor& file) : file_(file) {}

  RawTets parse() {
    find_section("$MeshFormat");
    const double version = file_.number<double>("the format version");
    binary_ = file_.number<int>("the file type") == 1;
    const int size = file_.number<int>("the size of a number");
    file_.line();
    if (binary_ && size != 8) file_.fail(fmt::format("numbers of {} bytes are not supported, only of 8", size));
    const bool v2 = version >= 2.0 && version < 3.0, v4 = version >= 4.1 && version < 5.0;
    if (!v2 && !v4)
      file_.fail(fmt::format("Gmsh format {} is not supported; save the mesh as version 2.2 or 4.1 ASCII", version));
    if (v4 && binary_) file_.fail("binary Gmsh 4.1 is not supported; save the mesh as ASCII, or as version 2.2");
    if (binary_) swapped_ = file_.binary<std::int32_t>(false, "the byte order mark") != 1;

    find_section("$Nodes");
    v2 ? nodes_2() : nodes_4();
    find_section("$Elements");
    v2 ? elements_2() : elements_4();
    if (file_.word() != "$EndElements") file_.fail("the file is truncated or damaged: $EndElements is missing");
    return std::move(raw_);
  }

 private:
  void find_section(std::string_view name) {
    while (file_.left() > 0) {
      std::string_view text = file_.line();
      while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
      if (text == name) return;
    }
    file_.fail(fmt::format("no {} section; not a Gmsh mesh, or truncated", name));
  }

  void add_point(std::int64_t tag, const Vec3& x) {
    if (!index_.try_emplace(tag, static_cast<std::int64_t>(raw_.points.size())).second)
      file_.fail(fmt::format("node {} is given twice", tag));
    raw_.points.push_back(x);
  }

  std::int64_t point(std::int64_t tag) const {
    const auto it = index_.find(tag);
    if (it == index_.end()) file_.fail(fmt::format("an element names node {}, which the file does not define", tag));
    return it->second;
  }

  Vec3 coordinates() {
    Vec3 x;
    for (int k = 0; k < 3; ++k)
      x[k] = binary_ ? file_.binary<double>(swapped_, "a coordinate") : file_.number<double>("a coordinate");
    return x;
  }

  std::int64_t integer(const char* what) {
    return binary_ ? file_.binary<std::int32_t>(swapped_, what) : file_.number<std::int64_t>(what);
  }

  void nodes_2() {
    const auto n = file_.number<std::size_t>("the number of nodes");
    file_.expect(n, binary_ ? 28 : 8, "nodes");
    file_.line();
    for (std::size_t i = 0; i < n; ++i) {
      const std::int64_t tag = integer("a node's number");
      add_point(tag, coordinates());
    }
  }

  void nodes_4() {
    const auto blocks = file_.number<std::size_t>("the number of node blocks");
    const auto n = file_.number<std::size_t>("the number of nodes");
    file_.expect(n, 8, "nodes");
    file_.line();
    for (std::size_t b = 0; b < blocks; ++b) {
      const int dimension = file_.number<int>("an entity's dimension");
      file_.number<std::int64_t>("an entity's number");
      const int parametric = file_.number<int>("the parametric flag");
      const auto count = file_.number<std::size_t>("the number of nodes of a block");
      file_.expect(count, 8, "nodes of a block");
      std::vector<std::int64_t> tags(count);
      for (std::int64_t& t : tags) t = file_.number<std::int64_t>("a node's number");
      for (const std::int64_t t : tags) {
        add_point(t, coordinates());
        for (int k = 0; k < (parametric ? dimension : 0); ++k) file_.number<double>("a parametric coordinate");
      }
    }
    if (raw_.points.size() != n) file_.fail(fmt::format("{} nodes are announced, {} are given", n, raw_.points.size()));
  }

  // The corners of one element; the rest of its nodes are passed over.
  void element(int type, int node_count) {
    const bool is_tet = type == kTet4 || type == kTet10;
    std::array<std::int64_t, 4> corners{};
    for (int k = 0; k < node_count; ++k) {
      const std::int64_t tag = integer("an element's node");
      if (is_tet && k < 4) corners[k] = point(tag);
    }
    if (is_tet) raw_.tets.push_back(corners);
  }

  int nodes_of(int type) const {
    const int n = type > 0 && type < static_cast<int>(std::size(kNodes)) ? kNodes[type] : 0;
    if (n == 0) file_.fail(fmt::format("element type {} is not known", type));
    return n;
  }

  void elements_2() {
    const auto n = file_.number<std::size_t>("the number of elements");
    file_.expect(n, 6, "elements");
    file_.line();
    for (std::size_t i = 0; i < n;) {
      if (!binary_) {
        file_.number<std::int64_t>("an element's number");
        const int type = file_.number<int>("an element's type");
        const int tags = file_.number<int>("the number of tags");
        for (int k = 0; k < tags; ++k) file_.number<std::int64_t>("a tag");
        element(type, nodes_of(type));
        ++i;
        continue;
      }
      const auto type = static_cast<int>(integer("an element's type"));
      const std::int64_t count = integer("the number of elements of a block");
      const std::int64_t tags = integer("the number of tags");
      if (count < 1 || tags < 0 || static_cast<std::size_t>(count) > n - i)
        file_.fail("a block of elements is damaged");
      const int nodes = nodes_of(type);
      for (std::int64_t e = 0; e < count; ++e, ++i) {
        integer("an element's number");
        for (std::int64_t k = 0; k < tags; ++k) integer("a tag");
        element(type, nodes);
      }
    }
  }

  void elements_4() {
    const auto blocks = file_.number<std::size_t>("the number of element blocks");
    file_.line();
    for (std::size_t b = 0; b < blocks; ++b) {
      file_.number<int>("an entity's dimension");
      file_.number<std::int64_t>("an entity's number");
      const int type = file_.number<int>("an element's type");
      const auto count = file_.number<std::size_t>("the number of elements of a block");
      file_.expect(count, 4, "elements of a block");
      const int nodes = nodes_of(type);
      for (std::size_t e = 0; e < count; ++e) {
        file_.number<std::int64_t>("an element's number");
        element(type, nodes);
      }
    }
  }

  FileCursor& file_;
  RawTets raw_;
  std::unordered_map<std::int64_t, std::int64_t> index_;  // node tag to place in points
  bool binary_ = false, swapped_ = false;
};

}  // namespace

RawTets parse_gmsh(FileCursor& file) { return GmshParser(file).parse(); }

}  // namespace brim
