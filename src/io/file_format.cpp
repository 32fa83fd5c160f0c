#include "io/file_format.h"

#include "io/hdf5.h"

namespace mimbre::io {

std::string file_format(const std::string& path) {
  const hdf5::Quiet quiet;
  const hdf5::Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  if (!file.valid()) return {};
  const hdf5::Handle attribute(H5Aopen(file.get(), "format", H5P_DEFAULT));
  if (!attribute.valid()) return {};
  const hdf5::Handle type(H5Aget_type(attribute.get()));
  const hdf5::Handle space(H5Aget_space(attribute.get()));
  if (H5Tget_class(type.get()) != H5T_STRING || H5Sget_simple_extent_npoints(space.get()) != 1) return {};
  if (H5Tis_variable_str(type.get()) > 0) {
    const hdf5::Handle memory = hdf5::string_type();
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

bool is_reduced_body(const std::string& path) {
  return file_format(path).starts_with("mimbre-reduced-body-");
}

}  // namespace mimbre::io
