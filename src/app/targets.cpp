#include "app/targets.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "mimbre/reduced_body.h"

namespace mimbre::app {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw std::runtime_error(fmt::format("cannot write '{}': {}", path, why));
}

/// Permissions alone do not decide that: a read-only disk or a folder of the system takes no file even of
/// root.
void require_room_for_files(const std::string& path, const fs::path& folder) {
  std::string probe = (folder / "mimbre-probe-XXXXXX").string();
  const int made = mkostemp(probe.data(), O_CLOEXEC);
  if (made < 0) {
    const int error = errno;
    std::error_code unknown;
    refuse(path, error == ENOENT && fs::is_directory(folder, unknown) ? "no files can be made in its folder"
                                                                      : std::strerror(error));
  }
  unlink(probe.c_str());
  close(made);
}

}  // namespace

void require_writable(const std::string& path) {
  std::error_code unknown;
  if (fs::is_directory(path, unknown)) refuse(path, "it is a folder");
  const bool exists = fs::exists(path, unknown);
  if (exists && access(path.c_str(), W_OK) != 0) refuse(path, std::strerror(errno));
  if (exists && !fs::is_regular_file(path, unknown)) return;                  // a device is written straight
  const fs::path folder = fs::weakly_canonical(path, unknown).parent_path();  // where links lead
  require_room_for_files(path, folder.empty() ? fs::path(".") : folder);
}

void require_writable_body(const std::string& path) {
  std::error_code unknown;
  if (fs::exists(path, unknown) && !fs::is_directory(path, unknown) && !fs::is_regular_file(path, unknown))
    refuse(path, "it is not a plain file");
  require_writable(path);
}

void require_different(const std::string& input, const std::string& output) {
  std::error_code one_is_missing, unknown;
  const auto place = [&](const std::string& path) {
    return fs::weakly_canonical(fs::absolute(path), unknown);
  };
  if (input == output || fs::equivalent(input, output, one_is_missing) ||
      (place(input) == place(output) && !unknown))
    throw UsageError(fmt::format("'{}' would be overwritten; choose another name for the output", input));
}

void require_not_read(const std::string& model, const LoadedModel& loaded, const std::string& output) {
  require_different(model, output);
  for (const std::string& file : loaded.other_files) require_different(file, output);
}

void require_no_body(const std::string& output) {
  if (is_reduced_body(output))
    throw UsageError(
        fmt::format("'{}' is a reduced body and would be overwritten; choose another name", output));
}

}  // namespace mimbre::app
