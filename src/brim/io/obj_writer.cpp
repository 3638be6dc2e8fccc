#include "brim/io/obj_writer.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <string>

#include "brim/core/error.h"

namespace brim {

void write_obj(const std::filesystem::path& path, const TriMesh& mesh) {
  std::string text = "# surface, lengths in metres\n";
  const auto out = std::back_inserter(text);
  for (const Vec3& x : mesh.vertices) fmt::format_to(out, "v {} {} {}\n", x.x(), x.y(), x.z());
  for (const Triangle& t : mesh.triangles) fmt::format_to(out, "f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);

  // Written beside its place, then moved there in one step.
  std::filesystem::path part = path;
  part += ".part";
  std::ofstream file(part, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(part, path, error);
  if (!file || error) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    throw InputError(fmt::format("{}: cannot write the file", path.string()));
  }
}

}  // namespace brim
