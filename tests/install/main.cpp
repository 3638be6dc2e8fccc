// Uses one inline and one compiled piece of the installed library.
#include <cstdio>

#include "brim/core/parallel.h"
#include "brim/mesh/tri_mesh.h"

int main() {
  const brim::ThreadLimit limit(2);
  brim::TriMesh mesh;
  for (int i = 0; i < 10'000; ++i) mesh.vertices.push_back(brim::Vec3(i, 0, 0));
  const double sum = brim::ordered_sum(mesh.vertices.size(), [&](std::size_t begin, std::size_t end) {
    double part = 0.0;
    for (std::size_t i = begin; i < end; ++i) part += mesh.vertices[i].x();
    return part;
  });
  std::printf("threads %d, sum %g\n", brim::thread_count(), sum);
  return brim::thread_count() == 2 && sum == 49'995'000.0 ? 0 : 1;
}
