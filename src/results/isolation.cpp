#include "mimbre/isolation.h"

#include <cstdlib>
#include <string_view>

#include "base/file_format.h"
#include "base/rehearsal.h"
#include "mimbre/reduced_body.h"
#include "mimbre/results.h"
#include "mimbre/surface_mesh.h"

namespace mimbre {
namespace {

/// What can be rehearsed. In a process without a rehearsal program these make all checks.
struct Reading {
  const char* name;
  void (*read)(const std::string& path);
};
constexpr Reading readings[] = {
    {"body", [](const std::string& path) { load_reduced_body(path); }},
    {"format", [](const std::string& path) { hdf5::file_format(path); }},
    {"results", [](const std::string& path) { read_results(path); }},
    {"surface", [](const std::string& path) { read_surface_mesh(path); }},
};

}  // namespace

void isolate_reading(const std::string& program) { set_rehearsal_program(program); }

std::optional<int> rehearse_reading(int argc, const char* const* argv) {
  if (argc != 4 || argv[1] != std::string_view(rehearsal_option)) return {};
  const std::string path = argv[3];
  for (const Reading& reading : readings)
    if (argv[2] == std::string_view(reading.name))
      return play_rehearsal(rehearsal_bounds(path), [&] { reading.read(path); });
  return EXIT_FAILURE;
}

}  // namespace mimbre
