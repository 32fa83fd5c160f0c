#include "base/file_format.h"

#include <filesystem>

#include "base/hdf5.h"
#include "base/rehearsal.h"
#include "mimbre/diagnostics.h"

namespace mimbre::hdf5 {
namespace {

std::string read_format(const std::string& path) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_file_locking(access.get(), false, true);
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()));
  if (!file.valid()) return {};
  const Handle attribute(H5Aopen(file.get(), "format", H5P_DEFAULT));
  if (!attribute.valid()) return {};
  const Handle type(H5Aget_type(attribute.get()));
  const Handle space(H5Aget_space(attribute.get()));
  if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) != 0 ||
      H5Sget_simple_extent_npoints(space.get()) != 1)
    return {};
  const std::size_t size = H5Tget_size(type.get());
  if (size > 1000) return {};
  std::string format(size, '\0');
  if (H5Aread(attribute.get(), type.get(), format.data()) < 0) return {};
  return format.c_str();  // up to the first of the zeros that fill it
}

}  // namespace

bool is_hdf5(const std::string& path) {
  const Quiet quiet;
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && H5Fis_hdf5(path.c_str()) > 0;
}

std::string file_format(const std::string& path) {
  if (!is_hdf5(path)) return {};
  const Quiet quiet;
  try {
    rehearse("format", path);
  } catch (const InputError&) {
    return {};
  }
  return read_format(path);
}

}  // namespace mimbre::hdf5
