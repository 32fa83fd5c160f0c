#include "base/checksums.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <iterator>
#include <optional>
#include <sstream>
#include <vector>

namespace mimbre::hdf5 {
namespace {

static_assert(std::endian::native == std::endian::little, "checksums are of little-endian numbers");

constexpr const char *attribute_name = "crc32", *parts_name = "crc32_of";
constexpr hsize_t block_bytes = 1 << 20;
constexpr int deepest = 8;
constexpr std::size_t longest_attribute = 1 << 16;
constexpr std::size_t longest_list = 50'000;  ///< HDF5 has no room for more in an attribute
/// A damaged header announces any size; what other tools pack shrinks a thousandfold at most, and a byte
/// becomes eight here.
constexpr double least_packing = 1e-4;

hid_t checked(hid_t result) {
  if (result < 0) throw std::runtime_error(last_error());
  return result;
}

/// In which values count: their own type where they are text.
Handle canonical(hid_t type) {
  switch (H5Tget_class(type)) {
    case H5T_FLOAT:
      return Handle(checked(H5Tcopy(H5T_IEEE_F64LE)));
    case H5T_INTEGER:
      return Handle(checked(H5Tcopy(H5T_STD_I64LE)));
    case H5T_STRING:
      if (H5Tis_variable_str(type) == 0) return Handle(checked(H5Tcopy(type)));
      [[fallthrough]];
    default:
      throw std::runtime_error("its type is not one that the file should hold");
  }
}

std::uint32_t checksum_of_dataset(hid_t data) {
  const Handle stored(checked(H5Dget_type(data))), type = canonical(stored.get());
  const Handle space(checked(H5Dget_space(data)));
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0) throw std::runtime_error(last_error());
  std::vector<hsize_t> count(static_cast<std::size_t>(std::max(rank, 1)), 1);
  if (rank > 0) H5Sget_simple_extent_dims(space.get(), count.data(), nullptr);
  double bytes_of_row = static_cast<double>(H5Tget_size(type.get()));
  for (std::size_t axis = 1; axis < count.size(); ++axis) bytes_of_row *= static_cast<double>(count[axis]);
  const hsize_t rows = count[0];
  if (rows == 0 || bytes_of_row == 0) return 0;
  hsize_t file_bytes = 0;
  const Handle file(checked(H5Iget_file_id(data)));
  checked(H5Fget_filesize(file.get(), &file_bytes));
  if (static_cast<double>(rows) * bytes_of_row * least_packing > static_cast<double>(file_bytes))
    throw std::runtime_error("it announces more than the file can hold");

  const hsize_t rows_at_once =
      std::clamp<hsize_t>(block_bytes / static_cast<hsize_t>(bytes_of_row), hsize_t{1}, rows);
  std::vector<char> block(static_cast<std::size_t>(rows_at_once) * static_cast<std::size_t>(bytes_of_row));
  std::vector<hsize_t> start(count.size(), 0);
  std::uint32_t crc = 0;
  for (start[0] = 0; start[0] < rows; start[0] += count[0]) {
    count[0] = std::min(rows_at_once, rows - start[0]);
    hid_t memory = H5S_ALL, selection = H5S_ALL;
    Handle memory_space;
    if (rank > 0) {
      checked(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr));
      memory_space = Handle(checked(H5Screate_simple(rank, count.data(), nullptr)));
      memory = memory_space.get();
      selection = space.get();
    }
    checked(H5Dread(data, type.get(), memory, selection, H5P_DEFAULT, block.data()));
    crc =
        crc32(crc, block.data(), static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(bytes_of_row));
  }
  return crc;
}

std::uint32_t add_attribute(std::uint32_t crc, hid_t object, const std::string& name) {
  const Handle attribute(checked(H5Aopen(object, name.c_str(), H5P_DEFAULT)));
  const Handle stored(checked(H5Aget_type(attribute.get()))), type = canonical(stored.get());
  const Handle space(checked(H5Aget_space(attribute.get())));
  if (H5Sget_simple_extent_npoints(space.get()) != 1 || H5Tget_size(type.get()) > longest_attribute)
    throw std::runtime_error(fmt::format("its attribute '{}' is not one value", name));
  std::vector<char> value(H5Tget_size(type.get()));
  checked(H5Aread(attribute.get(), type.get(), value.data()));
  crc = crc32(crc, name.data(), name.size());
  return crc32(crc, value.data(), value.size());
}

/// In the order of their names.
std::vector<std::string> names_of_attributes(hid_t object) {
  std::vector<std::string> names;
  const auto take = [](hid_t, const char* name, const H5A_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  checked(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, take, &names));
  std::sort(names.begin(), names.end());
  return names;
}
std::vector<std::string> names_in(hid_t group) {
  std::vector<std::string> names;
  const auto take = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  checked(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, take, &names));
  std::sort(names.begin(), names.end());
  return names;
}

/// What a group's checksum is of: attributes, and what lies in it as /NAME.
std::vector<std::string> parts_of(hid_t group) {
  std::vector<std::string> parts;
  for (const std::string& name : names_of_attributes(group))
    if (name != attribute_name && name != parts_name) parts.push_back(name);
  for (const std::string& name : names_in(group)) parts.push_back('/' + name);
  return parts;
}

std::uint32_t checksum_of_group(hid_t group, const std::vector<std::string>& parts) {
  std::uint32_t crc = 0;
  for (const std::string& part : parts) {
    if (!part.starts_with('/'))
      crc = add_attribute(crc, group, part);
    else if (has_link(group, part.substr(1)))
      crc = crc32(crc, part.data(), part.size());
    else
      throw std::runtime_error(fmt::format("it lacks '{}'", part.substr(1)));
  }
  return crc;
}

void write_attribute(hid_t object, const char* name, hid_t file_type, hid_t memory_type, const void* value) {
  if (H5Aexists(object, name) > 0) checked(H5Adelete(object, name));
  const Handle space(checked(H5Screate(H5S_SCALAR)));
  const Handle attribute(checked(H5Acreate2(object, name, file_type, space.get(), H5P_DEFAULT, H5P_DEFAULT)));
  checked(H5Awrite(attribute.get(), memory_type, value));
}

/// The words of its text.
std::vector<std::string> kept_parts(hid_t group) {
  const Handle attribute(checked(H5Aopen(group, parts_name, H5P_DEFAULT)));
  const Handle type(checked(H5Aget_type(attribute.get()))), space(checked(H5Aget_space(attribute.get())));
  if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) != 0 ||
      H5Sget_simple_extent_npoints(space.get()) != 1 || H5Tget_size(type.get()) > longest_attribute)
    throw std::runtime_error("what its checksum is of cannot be read");
  std::string text(H5Tget_size(type.get()), '\0');
  checked(H5Aread(attribute.get(), type.get(), text.data()));
  std::istringstream words(text.substr(0, text.find('\0')));
  return {std::istream_iterator<std::string>(words), {}};
}

bool is_dataset(hid_t object) { return H5Iget_type(object) == H5I_DATASET; }

std::uint32_t checksum_of(hid_t object) {
  return is_dataset(object) ? checksum_of_dataset(object) : checksum_of_group(object, kept_parts(object));
}

std::optional<std::uint32_t> kept_checksum(hid_t object) {
  if (H5Aexists(object, attribute_name) <= 0) return {};
  const Handle attribute(checked(H5Aopen(object, attribute_name, H5P_DEFAULT)));
  const Handle space(checked(H5Aget_space(attribute.get())));
  std::uint32_t checksum = 0;
  if (H5Sget_simple_extent_npoints(space.get()) != 1 ||
      H5Aread(attribute.get(), H5T_NATIVE_UINT32, &checksum) < 0)
    throw std::runtime_error("its checksum cannot be read");
  return checksum;
}

/// Calls visit(object, path) for all that lies in the group, groups before what they hold, until it returns
/// false. False then.
bool visit_below(hid_t group, const std::string& path, int depth,
                 const std::function<bool(hid_t, const std::string&)>& visit) {
  for (const std::string& name : names_in(group)) {
    if (!is_own(group, name)) continue;  // readers do not follow it, either
    const std::string below = path.empty() ? name : path + '/' + name;
    Handle object = open_dataset(group, name);
    if (!object.valid()) object = Handle(H5Gopen2(group, name.c_str(), H5P_DEFAULT));
    if (!object.valid()) continue;
    if (!visit(object.get(), below)) return false;
    if (!is_dataset(object.get()) && depth < deepest && !visit_below(object.get(), below, depth + 1, visit))
      return false;
  }
  return true;
}

/// Of an object that has one; what cannot be read to compute it is damaged.
bool is_sound(hid_t object) {
  try {
    const auto kept = kept_checksum(object);
    return !kept || *kept == checksum_of(object);
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace

std::uint32_t crc32(std::uint32_t before, const void* bytes, std::size_t size) {
  return static_cast<std::uint32_t>(::crc32_z(before, static_cast<const Bytef*>(bytes), size));
}

void seal(hid_t object) {
  if (is_dataset(object)) return seal(object, checksum_of_dataset(object));
  const std::vector<std::string> parts = parts_of(object);
  const std::string text = fmt::format("{}", fmt::join(parts, " "));
  if (text.empty() || text.size() > longest_list) return;
  const Handle type = text_type(text.size());
  write_attribute(object, parts_name, type.get(), type.get(), text.data());
  seal(object, checksum_of_group(object, parts));
}

void seal(hid_t object, std::uint32_t checksum) {
  write_attribute(object, attribute_name, H5T_STD_U32LE, H5T_NATIVE_UINT32, &checksum);
}

void seal_below(hid_t group) {
  visit_below(group, "", 0, [](hid_t object, const std::string&) {
    seal(object);
    return true;
  });
}

std::string first_damaged(hid_t file) {
  const Quiet quiet;
  std::string damaged;
  const Handle root(checked(H5Gopen2(file, "/", H5P_DEFAULT)));
  try {
    visit_below(root.get(), "", 0, [&](hid_t object, const std::string& path) {
      if (!is_sound(object)) damaged = fmt::format("{} '{}'", is_dataset(object) ? "dataset" : "group", path);
      return damaged.empty();
    });
  } catch (const std::runtime_error&) {
    return "one of its groups";
  }
  if (damaged.empty() && !is_sound(root.get())) damaged = "group '/'";
  return damaged;
}

std::string damage_message(const std::string& object) {
  return fmt::format(
      "is damaged: {} does not hold what was written (attribute 'crc32'; where it was changed on purpose, "
      "remove that attribute)",
      object);
}

void remove_checksums(const std::string& path) {
  const Quiet quiet;
  const Handle file(checked(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT)));
  const Handle root(checked(H5Gopen2(file.get(), "/", H5P_DEFAULT)));
  const auto remove = [](hid_t object, const std::string&) {
    if (H5Aexists(object, attribute_name) > 0) checked(H5Adelete(object, attribute_name));
    return true;
  };
  remove(root.get(), "/");
  visit_below(root.get(), "", 0, remove);
}

}  // namespace mimbre::hdf5
