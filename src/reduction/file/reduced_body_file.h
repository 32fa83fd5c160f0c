#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/hdf5.h"
#include "mimbre/diagnostics.h"
#include "mimbre/reduced_body.h"

/// What writing and reading a reduced body's file have in common. The layout is in
/// docs/reduced-body-format.md; arrays go through row-major buffers because HDF5 is row-major.
namespace mimbre::reduced_body_file {

constexpr const char* format = "mimbre-reduced-body-1";
/// In the order of BoundaryRotation.
inline const std::array<std::string, 3> rotations{"exponential", "successive", "infinitesimal"};

using Shape = std::vector<hsize_t>;
inline std::uint64_t element_count(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::uint64_t{1}, std::multiplies<>());
}

/// What goes wrong inside; save and load_reduced_body turn it into an InputError with the file's name.
struct FileProblem : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline hid_t checked(hid_t id, const std::string& problem) {
  if (id < 0) throw FileProblem(problem);
  return id;
}

inline hdf5::Handle opened(hid_t id, const std::string& problem) {
  return hdf5::Handle(checked(id, problem));
}

inline void throw_if_unsound(const ReducedBody& body, const std::string& prefix) {
  std::vector<Diagnostic> diagnostics;
  for (const std::string& message : check(body)) diagnostics.push_back({Mark{}, prefix + message});
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
}

}  // namespace mimbre::reduced_body_file
