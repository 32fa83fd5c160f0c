#pragma once
#include <hdf5.h>

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

/// Small helpers over HDF5's C interface: handles that close themselves, and errors as text instead of
/// prints.
namespace mimbre::hdf5 {

/// While it lives, HDF5 does not print its errors; the caller's setting is restored afterwards.
class Quiet {
 public:
  Quiet() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Quiet() { H5Eset_auto2(H5E_DEFAULT, print_, data_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

/// Owns one HDF5 identifier of any kind. Invalid when what made it failed.
class Handle {
 public:
  Handle() = default;
  explicit Handle(hid_t id) : id_(id) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Handle() { reset(); }
  hid_t get() const { return id_; }
  bool valid() const { return id_ >= 0; }
  /// False when closing, which may write, went wrong.
  bool reset() { return !valid() || H5Idec_ref(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

 private:
  hid_t id_ = H5I_INVALID_HID;
};

/// What went wrong in the call that just failed: the operating system's words where HDF5 quotes them, else
/// the description nearest to the cause.
inline std::string last_error() {
  std::string cause;
  const auto take_first = [](unsigned depth, const H5E_error2_t* error, void* text) -> herr_t {
    if (depth == 0 && error->desc) *static_cast<std::string*>(text) = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_first, &cause);
  const std::string quoted = "error message = '";
  if (const auto at = cause.find(quoted); at != std::string::npos) {
    const auto from = at + quoted.size();
    return cause.substr(from, cause.find('\'', from) - from);
  }
  return cause.empty() ? "unknown HDF5 error" : cause;
}

/// A new file in memory, called `name`: on a disk that is full HDF5 can neither write a file nor close it
/// well.
inline Handle create_in_memory(const std::string& name, hid_t creation) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_fapl_core(access.get(), 1 << 20, false);
  return Handle(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, creation, access.get()));
}

/// The bytes of an open file as they are when it is closed. Throws std::runtime_error.
inline std::string image(hid_t file) {
  if (H5Fflush(file, H5F_SCOPE_LOCAL) < 0) throw std::runtime_error(last_error());
  const ssize_t size = H5Fget_file_image(file, nullptr, 0);
  if (size < 0) throw std::runtime_error(last_error());
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (H5Fget_file_image(file, bytes.data(), bytes.size()) < 0) throw std::runtime_error(last_error());
  return bytes;
}

/// Whether `parent` has the link `name`, of any kind.
inline bool has_link(hid_t parent, const std::string& name) {
  return H5Lexists(parent, name.c_str(), H5P_DEFAULT) > 0;
}

/// A link to what lies in this file: others would pull in what the user of the file can read.
inline bool is_own(hid_t parent, const std::string& name) {
  H5L_info_t info{};
  return H5Lget_info(parent, name.c_str(), &info, H5P_DEFAULT) >= 0 && info.type == H5L_TYPE_HARD;
}

/// A group of this file itself; not valid where there is none.
inline Handle open_group(hid_t parent, const std::string& name) {
  return is_own(parent, name) ? Handle(H5Gopen2(parent, name.c_str(), H5P_DEFAULT)) : Handle();
}

/// Whether values of a dataset are stored where it announces some: in its own header all of them, as the
/// library reads on beyond them; of chunks one at least, as it reads beyond the value that stands for those
/// that are not there. (A run that was killed has announced rows whose chunks are not there yet.)
inline bool has_values(hid_t dataset, H5D_layout_t layout) {
  const Handle type(H5Dget_type(dataset)), space(H5Dget_space(dataset));
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  const auto stored = static_cast<double>(H5Dget_storage_size(dataset));
  if (layout == H5D_CHUNKED) return count == 0 || stored > 0;
  return layout == H5D_CONTIGUOUS ||
         (layout == H5D_COMPACT && count >= 0 &&
          static_cast<double>(count) * static_cast<double>(H5Tget_size(type.get())) <= stored);
}

/// A dataset whose data lie in this file itself; not valid where there is none.
inline Handle open_dataset(hid_t parent, const std::string& name) {
  if (!is_own(parent, name)) return {};
  Handle data(H5Dopen2(parent, name.c_str(), H5P_DEFAULT));
  if (!data.valid()) return {};
  const Handle properties(H5Dget_create_plist(data.get()));
  if (!properties.valid() || H5Pget_external_count(properties.get()) != 0) return {};
  return has_values(data.get(), H5Pget_layout(properties.get())) ? std::move(data) : Handle();
}

/// Whether a file of so many bytes can hold so many values of the dataset. A damaged header can announce any
/// size; what other tools pack shrinks a thousandfold at most.
inline bool can_hold(double file_bytes, hid_t dataset, double values) {
  const Handle properties(H5Dget_create_plist(dataset)), type(H5Dget_type(dataset));
  const double ratio = H5Pget_nfilters(properties.get()) > 0 ? 1100 : 1;
  return values * static_cast<double>(H5Tget_size(type.get())) <= ratio * file_bytes;
}

/// The type of UTF-8 text of fixed length, filled up with zeros. Texts of any length would lie in a heap with
/// pointers into it, which damaged files turn against the reader.
inline Handle text_type(std::size_t bytes) {
  Handle type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.get(), std::max<std::size_t>(bytes, 1));
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

/// Texts one after another, each filled up with zeros to the longest one.
struct PackedTexts {
  std::size_t length = 1;  ///< bytes of each
  std::string bytes;
};
inline PackedTexts packed(std::span<const std::string> texts) {
  PackedTexts result;
  for (const std::string& text : texts) result.length = std::max(result.length, text.size());
  for (const std::string& text : texts) {
    result.bytes += text;
    result.bytes.append(result.length - text.size(), '\0');
  }
  return result;
}

}  // namespace mimbre::hdf5
