#include "base/output_place.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

namespace mimbre {
namespace {

namespace fs = std::filesystem;

constexpr int most_links = 40;
constexpr int most_names = 1000;
/// Of what still grows; a user who makes private files (umask 077) has others.
constexpr mode_t growing_mode = S_IRWXU;
constexpr std::size_t longest_stem = 180;  ///< of 255 bytes that a name may have

[[noreturn]] void fail(int error) { throw std::runtime_error(std::strerror(error)); }

/// Where the links lead, though nothing may stand there yet.
fs::path followed(fs::path path) {
  std::error_code error;
  for (int k = 0; fs::is_symlink(path, error); ++k) {
    if (k == most_links) fail(ELOOP);
    const fs::path to = fs::read_symlink(path, error);
    if (error) throw std::runtime_error(error.message());
    path = path.parent_path() / to;  // `to` alone when it is absolute
  }
  return path;
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

/// `run.h5` → `run.part-PID.h5`: the ending shows what the file is.
fs::path part_name(const fs::path& target, int attempt) {
  const std::string again = attempt > 0 ? fmt::format("-{}", attempt) : std::string();
  return target.parent_path() / fmt::format("{}.part-{}{}{}", target.stem().string().substr(0, longest_stem),
                                            getpid(), again, target.extension().string());
}

/// A new file; nothing that stands there, be it a link, is touched. -1 and errno when it cannot be made.
int create(const fs::path& path, mode_t mode) {
  return open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
}

/// Of this open file against all others, in this process too; goes when the file is closed. False when it is
/// held elsewhere; a file system without locks has none to hold.
bool lock(int descriptor) {
#ifdef F_OFD_SETLK
  struct flock whole {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  return fcntl(descriptor, F_OFD_SETLK, &whole) == 0 || (errno != EAGAIN && errno != EACCES);
#else
  static_cast<void>(descriptor);
  return true;
#endif
}

bool same_file(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

bool same_content(const struct stat& a, const struct stat& b) {
#ifdef __APPLE__
  const timespec &t = a.st_mtimespec, &u = b.st_mtimespec;
#else
  const timespec &t = a.st_mtim, &u = b.st_mtim;
#endif
  return same_file(a, b) && a.st_size == b.st_size && t.tv_sec == u.tv_sec && t.tv_nsec == u.tv_nsec;
}

/// Whether the path leads to what the process has open, as /dev/stdout does: written straight.
bool leads_to_open_file(const std::string& path) {
  return path.starts_with("/dev/std") || path.starts_with("/dev/fd/") || path.starts_with("/proc/");
}

/// Puts a file or folder onto the disk. 0, or the error; a file system that cannot do so has none.
int put_on_disk(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  const int error = fsync(descriptor) == 0 ? 0 : errno;
  close(descriptor);
  return error == EINVAL || error == EROFS || error == ENOTSUP ? 0 : error;
}

/// While it lives, no other program commits into the folder.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder)
      : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
    while (descriptor_ >= 0 && flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
    }
  }
  ~FolderLock() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

/// The message for a second writer.
constexpr const char* busy = "another program is writing it";

}  // namespace

OutputPlace::OutputPlace(const std::string& target) : shown_(target) {
  const bool open_file = leads_to_open_file(target);
  target_ = open_file ? target : followed(target).string();
  existed_ = stat(target_.c_str(), &before_) == 0;
  if (!existed_ && errno != ENOENT) fail(errno);
  if (existed_ && S_ISDIR(before_.st_mode)) fail(EISDIR);
  plain_ = !existed_ || (!open_file && S_ISREG(before_.st_mode));
  if (!plain_) {
    path_ = target_;
    return;
  }
  if (existed_) {
    lock_ = open(target_.c_str(), O_RDWR | O_CLOEXEC);
    if (lock_ < 0) fail(errno);
    if (!lock(lock_)) {
      close(lock_);
      throw std::runtime_error(busy);
    }
  }
  int made = -1;
  for (int k = 0; made < 0 && k < most_names; ++k) {
    path_ = part_name(target_, k).string();
    made = create(path_, existed_ ? growing_mode : 0666);
    if (made < 0 && errno != EEXIST) break;
  }
  if (made < 0) {
    const int error = errno;
    if (lock_ >= 0) close(lock_);
    std::error_code unknown;
    if (error == ENOENT && fs::is_directory(folder_of(target_), unknown))
      throw std::runtime_error("no files can be made in its folder");
    fail(error);
  }
  fstat(made, &own_);
  fchmod(made, growing_mode);
  lock(made);
  (existed_ ? own_lock_ : lock_) = made;  // for the time when it is the target
  pending_ = true;
}

OutputPlace::~OutputPlace() {
  struct stat now {};
  if (pending_ && stat(path_.c_str(), &now) == 0 && same_file(now, own_)) unlink(path_.c_str());
  if (lock_ >= 0) close(lock_);
  if (own_lock_ >= 0) close(own_lock_);
}

bool OutputPlace::unchanged() const {
  struct stat now {};
  const bool exists = stat(target_.c_str(), &now) == 0;
  if (path_ == target_) return exists && same_file(now, own_);
  return existed_ ? exists && same_content(now, before_) : !exists;
}

/// Owner (only where that may be) and mode of the older file, or the mode of any new one.
void OutputPlace::adopt_mode() const {
  if (!existed_) {
    chmod(path_.c_str(), own_.st_mode & 07777u);
    return;
  }
  const bool owner_kept = (before_.st_uid == own_.st_uid && before_.st_gid == own_.st_gid) ||
                          chown(path_.c_str(), before_.st_uid, before_.st_gid) == 0;
  // Another owner does not inherit the right to run as the old one.
  chmod(path_.c_str(), before_.st_mode & (owner_kept ? 07777u : 0777u));
}

void OutputPlace::write(std::string_view bytes) const { write_bytes(path_, bytes); }

void write_bytes(const std::string& path, std::string_view bytes) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (!file) fail(errno);
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  const int error = errno;
  // Closing writes the last of it, and may find the disk full.
  if (std::fclose(file) != 0 || !written) fail(written ? errno : error);
}

void OutputPlace::show() {
  if (!pending_ || existed_) return;
  // A link never takes the place of anything.
  if (link(path_.c_str(), target_.c_str()) == 0) {
    unlink(path_.c_str());
    path_ = target_;
    adopt_mode();
  } else if (errno == EEXIST) {
    throw std::runtime_error(busy);
  }
  // Else there are no links here, and the file stays beside its target until it is whole.
}

void OutputPlace::commit() {
  if (!pending_) return;
  pending_ = false;
  const FolderLock alone(folder_of(target_));
  if (!unchanged())
    throw std::runtime_error(
        path_ == target_
            ? "another program has removed or replaced it meanwhile"
            : fmt::format("another program has written it meanwhile; this one's is kept in '{}'", path_));
  if (path_ == target_) return;
  adopt_mode();
  // Else a power cut soon after could leave the new name with nothing behind it, and the older file gone.
  int error = existed_ ? put_on_disk(path_) : 0;
  if (error == 0 && std::rename(path_.c_str(), target_.c_str()) != 0) error = errno;
  if (error == 0) {
    if (existed_) put_on_disk(folder_of(target_).string());
    if (own_lock_ >= 0) close(std::exchange(own_lock_, -1));
    return;
  }
  const std::string why = std::strerror(error);
  std::error_code unknown;
  throw std::runtime_error(
      fs::exists(path_, unknown) ? fmt::format("{}; what was written is kept in '{}'", why, path_) : why);
}

std::string OutputPlace::keep() noexcept {
  if (!pending_) return path_;
  pending_ = false;
  if (path_ == target_) return shown_;
  adopt_mode();
  // A link never takes the place of anything.
  if (existed_ || link(path_.c_str(), target_.c_str()) != 0) return path_;
  unlink(path_.c_str());
  return shown_;
}

namespace {

/// The process in the name of a part of that target; 0 where it is none.
pid_t owner_of(const std::string& name, const fs::path& target) {
  const std::string before = target.stem().string().substr(0, longest_stem) + ".part-",
                    after = target.extension().string();
  if (name.size() <= before.size() + after.size() || !name.starts_with(before) || !name.ends_with(after))
    return 0;
  const char* at = name.data() + before.size();
  const char* const end = name.data() + name.size() - after.size();
  pid_t owner = 0;
  int attempt = 0;
  const auto number = [&](int& value) {
    const auto [next, error] = std::from_chars(at, end, value);
    at = next;
    return error == std::errc();
  };
  if (!number(owner) || owner <= 0) return 0;
  if (at != end && (*at++ != '-' || !number(attempt))) return 0;
  return at == end ? owner : 0;
}

/// Holds a file that nobody writes; −1 where somebody may.
int hold_abandoned(const fs::path& part, pid_t owner) {
  if (owner == getpid() || kill(owner, 0) == 0 || errno != ESRCH) return -1;
#ifdef F_OFD_SETLK
  const int descriptor = open(part.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return -1;
  struct flock whole {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  struct stat found {};
  if (fstat(descriptor, &found) == 0 && S_ISREG(found.st_mode) && fcntl(descriptor, F_OFD_SETLK, &whole) == 0)
    return descriptor;
  close(descriptor);
#endif
  return -1;
}

}  // namespace

std::string target_of_part(const std::string& part) {
  constexpr std::string_view mark = ".part-";
  const fs::path path(part);
  const std::string name = path.filename().string();
  const std::size_t at = name.rfind(mark);
  if (at == std::string::npos) return {};
  const std::size_t end = std::min(name.find_first_not_of("0123456789-", at + mark.size()), name.size());
  const fs::path target = path.parent_path() / (name.substr(0, at) + name.substr(end));
  return owner_of(name, target) > 0 ? target.string() : std::string();
}

bool is_kept(const std::string& part, const std::string& target) {
  struct stat of_part {
  }, of_target{};
  if (stat(part.c_str(), &of_part) != 0 || stat(target.c_str(), &of_target) != 0) return true;
  // An empty one was left before it had its mode, and has nothing to lose.
  if (of_part.st_size == 0) return false;
  return (of_part.st_mode & 07777u) != growing_mode || (of_target.st_mode & 07777u) == growing_mode;
}

void remove_abandoned_parts(const std::string& target,
                            const std::function<bool(const std::string& part)>& superseded) {
  const fs::path file = followed(target);
  std::error_code error;
  std::vector<std::pair<fs::path, pid_t>> parts;
  for (fs::directory_iterator at(folder_of(file), error), end; !error && at != end; at.increment(error))
    if (const pid_t owner = owner_of(at->path().filename().string(), file); owner > 0)
      parts.emplace_back(at->path(), owner);
  for (const auto& [part, owner] : parts) {
    const int descriptor = hold_abandoned(part, owner);
    if (descriptor < 0) continue;
    struct Closes {
      int descriptor;
      ~Closes() { close(descriptor); }
    } const closes{descriptor};
    if (superseded(part.string())) unlink(part.c_str());
  }
}

void write_whole(const std::string& target, std::string_view bytes) {
  OutputPlace place(target);
  place.write(bytes);
  place.commit();
}

}  // namespace mimbre
