#include "fe_files/node_table.h"
#include "fuzz_bytes.h"

using namespace mimbre::fe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  SolidMesh mesh;
  mesh.nodes = Eigen::Matrix3Xd::Zero(3, 4);
  mesh.labels = {1, 2, 3, 4};
  read_text_or_refuse(data, size, [](TextFile& file) { parse_node_table(file); });
  return read_text_or_refuse(data, size, [&](TextFile& file) { parse_dof_table(file, mesh); });
}
