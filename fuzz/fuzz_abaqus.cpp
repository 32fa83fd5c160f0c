#include "fe_files/matrix_files.h"
#include "fuzz_bytes.h"

using namespace mimbre::fe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  SolidMesh mesh;
  mesh.nodes = Eigen::Matrix3Xd::Zero(3, 4);
  mesh.labels = {1, 2, 3, 4};
  const std::vector<Dof> rows = {{0, 0}, {0, 1}, {1, 0}, {1, 1}};
  read_text_or_refuse(data, size, [&](TextFile& file) {
    const bool labelled = abaqus_is_labelled(file);
    labelled ? parse_abaqus_labelled(file, mesh) : parse_abaqus_coordinates(file, rows);
  });
  return read_text_or_refuse(data, size, [](TextFile& file) { count_abaqus_rows(file); });
}
