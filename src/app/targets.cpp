#include "app/targets.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "app/common.h"
#include "mimbre/reduced_body.h"

namespace mimbre::app {

namespace fs = std::filesystem;

void require_writable(const std::string& path) {
  const auto need = [&](const fs::path& place, int mode) {
    if (access(place.c_str(), mode) != 0)
      throw std::runtime_error(fmt::format("cannot write '{}': {}", path, std::strerror(errno)));
  };
  std::error_code unknown;
  if (fs::is_directory(path, unknown))
    throw std::runtime_error(fmt::format("cannot write '{}': it is a folder", path));
  const bool exists = fs::exists(path, unknown);
  if (exists) need(path, W_OK);
  if (exists && !fs::is_regular_file(path, unknown)) return;                  // a device is written straight
  const fs::path folder = fs::weakly_canonical(path, unknown).parent_path();  // where links lead
  need(folder.empty() ? fs::path(".") : folder, W_OK | X_OK);
}

void require_writable_body(const std::string& path) {
  require_writable(path);
  std::error_code unknown;
  if (fs::exists(path, unknown) && !fs::is_regular_file(path, unknown))
    throw std::runtime_error(fmt::format("cannot write '{}': it is not a plain file", path));
}

void write_body_file(const std::function<void()>& write) {
  try {
    write();
  } catch (const InputError& unwritten) {
    throw Failure(unwritten.what());
  }
}

void require_different(const std::string& input, const std::string& output) {
  std::error_code one_is_missing;
  if (input == output || fs::equivalent(input, output, one_is_missing))
    throw UsageError(fmt::format("'{}' would be overwritten; choose another name for the output", input));
}

void require_no_body(const std::string& output) {
  if (is_reduced_body(output))
    throw UsageError(
        fmt::format("'{}' is a reduced body and would be overwritten; choose another name", output));
}

}  // namespace mimbre::app
