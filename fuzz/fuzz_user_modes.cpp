#include "fe_files/user_modes_file.h"
#include "fuzz_bytes.h"

using namespace mimbre::fe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  SolidMesh mesh;
  mesh.nodes = Eigen::Matrix3Xd::Zero(3, 4);
  mesh.labels = {1, 2, 3, 4};
  read_text_or_refuse(data, size, [&](TextFile& file) { parse_user_modes(file, mesh); });
  return read_or_refuse(data, size,
                        [&](std::string bytes) { parse_user_modes_npz(std::move(bytes), "fuzz", mesh); });
}
