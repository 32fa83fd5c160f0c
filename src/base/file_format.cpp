#include "base/file_format.h"

#include "base/hdf5.h"

namespace mimbre::hdf5 {

std::string file_format(const std::string& path) {
  const Quiet quiet;
  const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  if (!file.valid()) return {};
  const Handle attribute(H5Aopen(file.get(), "format", H5P_DEFAULT));
  if (!attribute.valid()) return {};
  const Handle type(H5Aget_type(attribute.get()));
  const Handle space(H5Aget_space(attribute.get()));
  if (H5Tget_class(type.get()) != H5T_STRING || H5Sget_simple_extent_npoints(space.get()) != 1) return {};
  if (H5Tis_variable_str(type.get()) > 0) {
    const Handle memory = string_type();
    char* text = nullptr;
    if (H5Aread(attribute.get(), memory.get(), &text) < 0 || !text) return {};
    std::string format(text);
    H5free_memory(text);
    return format;
  }
  std::string format(H5Tget_size(type.get()), '\0');
  if (format.size() > 1000 || H5Aread(attribute.get(), type.get(), format.data()) < 0) return {};
  return format.c_str();  // up to the first of the zeros that fill it
}

}  // namespace mimbre::hdf5
