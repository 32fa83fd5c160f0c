#include "fe_files/nastran.h"
#include "fuzz_bytes.h"

using namespace mimbre::fe;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  SolidMesh mesh;
  NastranGrids grids;
  read_text_or_refuse(data, size, [&](TextFile& file) {
    grids.read(file);
    mesh = grids.finish(file.mark());
  });
  return read_text_or_refuse(data, size, [&](TextFile& file) { parse_dmig(file, grids.matrices(), mesh); });
}
