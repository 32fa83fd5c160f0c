#include "base/output_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace mimbre {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::error_code& error) { throw std::runtime_error(error.message()); }
void check(const std::error_code& error) {
  if (error) fail(error);
}

/// Both names at once where the system can do that; else one after the other. 0, or the error.
int exchange_names(const fs::path& made, const fs::path& older) {
#ifdef RENAME_EXCHANGE
  if (renameat2(AT_FDCWD, made.c_str(), AT_FDCWD, older.c_str(), RENAME_EXCHANGE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
#endif
  const fs::path aside = made.string() + ".older";
  if (std::rename(older.c_str(), aside.c_str()) != 0) return errno;
  if (std::rename(made.c_str(), older.c_str()) == 0)
    return std::rename(aside.c_str(), made.c_str()) == 0 ? 0 : errno;
  const int error = errno;
  return std::rename(aside.c_str(), older.c_str()) == 0 ? error : errno;
}

/// Everything below a folder onto the disk; a system that cannot do so leaves that to itself.
void put_on_disk(int folder) {
#ifdef __linux__
  syncfs(folder);
#else
  static_cast<void>(folder);
#endif
}

/// `frames` → `frames.part-PID`; what a killed program left has the same beginning.
std::string part_beginning(const std::string& target) { return target + ".part-"; }

}  // namespace

OutputFolder::OutputFolder(const std::string& target, const std::function<bool(const std::string&)>& replaces)
    : replaces_(replaces) {
  std::error_code error;
  fs::path place = fs::weakly_canonical(fs::absolute(target, error), error);
  check(error);
  if (!place.has_filename()) place = place.parent_path();  // "frames/"
  target_ = place.string();
  existed_ = fs::exists(place, error);
  if (existed_ && !fs::is_directory(place, error)) throw std::runtime_error("it is a file");
  if (existed_) {
    if ((fs::current_path(error).string() + '/').starts_with(target_ + '/'))
      throw std::runtime_error("the working folder lies in it; name a folder of its own");
    for (fs::directory_iterator entry(place, error), end; !error && entry != end; entry.increment(error))
      if (entry->is_directory(error) && !error)
        throw std::runtime_error(
            fmt::format("it holds the folder '{}', which would go; name a folder of its own",
                        entry->path().filename().string()));
    check(error);
    if (access(target_.c_str(), W_OK | X_OK) != 0) fail({errno, std::generic_category()});
  } else {
    fs::create_directories(place.parent_path(), error);
    check(error);
  }
  remove_left_over();
  path_ = part_beginning(target_) + std::to_string(getpid());
  if (!fs::create_directory(path_, error)) {
    if (!error) error = std::make_error_code(std::errc::file_exists);
    fail(error);
  }
  pending_ = true;
  lock_ = open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ >= 0) flock(lock_, LOCK_EX | LOCK_NB);
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (pending_) fs::remove_all(path_, ignored);
  if (lock_ >= 0) close(lock_);
}

/// Folders of programs that were killed while they wrote: nobody locks them.
void OutputFolder::remove_left_over() const {
  const fs::path beginning = part_beginning(target_);
  std::error_code ignored;
  for (fs::directory_iterator entry(beginning.parent_path(), ignored), end; !ignored && entry != end;
       entry.increment(ignored)) {
    const std::string name = entry->path().filename().string(), begin = beginning.filename().string();
    if (!name.starts_with(begin) || name.size() == begin.size() ||
        name.find_first_not_of("0123456789", begin.size()) != std::string::npos)
      continue;
    const int folder = open(entry->path().c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder < 0) continue;
    std::error_code gone;
    if (flock(folder, LOCK_EX | LOCK_NB) == 0) fs::remove_all(entry->path(), gone);
    close(folder);
  }
}

/// Files of others get a name in both folders: whichever stands, they are there. False when one cannot.
bool OutputFolder::others_follow(const std::string& from, const std::string& to) const {
  std::error_code error;
  for (fs::directory_iterator entry(from, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (replaces_(name)) continue;
    std::error_code unlinked;
    fs::create_hard_link(entry->path(), fs::path(to) / name, unlinked);
    if (unlinked && unlinked != std::errc::file_exists) return false;
  }
  return !error;
}

void OutputFolder::commit() {
  if (!pending_) return;
  std::error_code error;
  if (!existed_) {
    if (std::rename(path_.c_str(), target_.c_str()) != 0)
      throw std::runtime_error(errno == ENOTEMPTY || errno == EEXIST ? "another program has made it meanwhile"
                                                                     : std::strerror(errno));
    pending_ = false;
    return;
  }
  if (!others_follow(target_, path_))
    throw std::runtime_error("other files in it cannot be taken along; name a folder of its own");
  fs::permissions(path_, fs::status(target_, error).permissions(), error);
  if (lock_ >= 0) put_on_disk(lock_);
  if (const int failed = exchange_names(path_, target_); failed != 0)
    throw std::runtime_error(std::strerror(failed));
  // Now the older folder has the other name, and goes; with what came into it meanwhile it stays.
  pending_ = others_follow(path_, target_);
}

}  // namespace mimbre
