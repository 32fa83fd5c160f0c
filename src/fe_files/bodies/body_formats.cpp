#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>

#include "fe_files/text.h"
#include "mimbre/fe_import.h"

namespace mimbre::fe {

BodyFormat body_format(const std::string& path) {
  const std::string ending = lower(std::filesystem::path(path).extension().string());
  if (ending == ".h5" || ending == ".hdf5") return BodyFormat::h5;
  if (ending == ".fem") return BodyFormat::fem;
  if (ending == ".sid" || ending == ".sid_fem") return BodyFormat::sid;
  throw std::invalid_argument(
      fmt::format("'{}': its ending is none of reduced bodies: .h5, .fem, .sid", path));
}

ImportedBody read_body(const std::string& path) {
  switch (body_format(path)) {
    case BodyFormat::fem:
      return read_mbdyn_fem(path);
    case BodyFormat::sid:
      return read_sid(path);
    case BodyFormat::h5:
      break;
  }
  return {load_reduced_body(path), {}};
}

void write_body(const ReducedBody& body, const std::string& path, BodyFormat format) {
  switch (format) {
    case BodyFormat::fem:
      return write_mbdyn_fem(body, path);
    case BodyFormat::sid:
      return write_sid(body, path);
    case BodyFormat::h5:
      return save(body, path);
  }
}

}  // namespace mimbre::fe
