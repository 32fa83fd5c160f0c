#pragma once
#include <hdf5.h>

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
  void reset() {
    if (id_ >= 0) H5Idec_ref(id_);
    id_ = H5I_INVALID_HID;
  }

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

/// The type of a string of any length, UTF-8.
inline Handle string_type() {
  Handle type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

}  // namespace mimbre::hdf5
