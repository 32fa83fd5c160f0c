#include "fe_files/stress_matrix.h"
#include "fuzz_bytes.h"

using namespace mimbre::fe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  SolidMesh mesh;
  mesh.nodes = Eigen::Matrix3Xd::Zero(3, 2);
  mesh.labels = {1, 2};
  FeMatrices matrices;
  matrices.dofs = {{0, 0}, {1, 2}, {1, 5}};
  read_text_or_refuse(data, size, [&](TextFile& file) { parse_stress_nodes(file, mesh); });
  return read_or_refuse(data, size, [&](std::string bytes) {
    parse_stress_matrix(std::move(bytes), "fuzz", {}, mesh, matrices, {}, {});
  });
}
