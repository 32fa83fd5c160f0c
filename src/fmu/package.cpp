#include "fmu/package.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include "base/sha256.h"
#include "base/zip_file.h"
#include "fmu/compile_sources.h"
#include "mimbre/diagnostics.h"

namespace mimbre::fmu {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t largest_file = std::uintmax_t{1} << 31;
constexpr std::size_t largest_member = std::size_t{1} << 31, most_members = 20000;

/// Names of this platform's folder: of FMI 3, and of FMI 2.
#if defined(__linux__) && defined(__x86_64__)
constexpr const char *platform = "x86_64-linux", *old_platform = "linux64";
#elif defined(__linux__) && defined(__aarch64__)
constexpr const char *platform = "aarch64-linux", *old_platform = "linux64";
#elif defined(__APPLE__) && defined(__aarch64__)
constexpr const char *platform = "aarch64-darwin", *old_platform = "darwin64";
#else
constexpr const char *platform = "x86_64-darwin", *old_platform = "darwin64";
#endif
#if defined(__APPLE__)
constexpr const char* library_ending = ".dylib";
#else
constexpr const char* library_ending = ".so";
#endif

/// Whether a member of an archive stays in the folder that it is written to.
bool stays_inside(const std::string& name) {
  if (name.empty() || name.front() == '/' || name.find('\\') != std::string::npos ||
      name.find('\0') != std::string::npos || name.find(':') != std::string::npos)
    return false;
  for (const fs::path& part : fs::path(name))
    if (part == "..") return false;
  return true;
}

/// Files of documentation and of further standards are not looked at.
bool is_used(const std::string& name) {
  return name.back() != '/' && (name == "modelDescription.xml" || name.starts_with("resources/") ||
                                name.starts_with("binaries/") || name.starts_with("sources/"));
}

std::string file_content(const std::string& file) {
  std::error_code status;
  if (!fs::exists(file, status)) throw InputError({file, 0, 0}, "there is no such file");
  if (!fs::is_regular_file(file, status))
    throw InputError({file, 0, 0}, "is not a file: an FMU is a ZIP archive that ends in .fmu");
  if (const auto size = fs::file_size(file, status); status || size > largest_file)
    throw InputError({file, 0, 0}, "is too large: an FMU of up to 2 GiB is read");
  std::ifstream in(file, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad() || !in) throw InputError({file, 0, 0}, "cannot be read");
  return bytes;
}

/// All of this process; they go at its end.
struct Packages {
  std::mutex guard;
  std::map<std::string, std::shared_ptr<const Package>> by_digest;
};
Packages& packages() {
  static Packages all;
  return all;
}

}  // namespace

std::shared_ptr<const Package> Package::open(const std::string& file) {
  std::string bytes = file_content(file);
  Sha256 hash;
  hash.add(bytes);
  const std::string digest = hash.hex();
  Packages& all = packages();
  const std::lock_guard guard(all.guard);
  if (const auto known = all.by_digest.find(digest); known != all.by_digest.end()) return known->second;
  std::shared_ptr<const Package> made(new Package(file, std::move(bytes), digest));
  return all.by_digest[digest] = std::move(made);
}

Package::Package(std::string file, std::string bytes, std::string digest)
    : file_(std::move(file)), digest_(std::move(digest)), bytes_(std::move(bytes)), owner_(getpid()) {
  const ZipFile zip(bytes_, file_);
  const std::vector<std::string> members = zip.members();
  if (members.size() > most_members) refuse(fmt::format("has {} members", members.size()));
  std::set<std::string> names;
  for (const std::string& name : members) {
    if (!stays_inside(name))
      refuse(fmt::format("has a member '{}', which would be written outside of its folder", name));
    if (is_used(name) && !names.insert(name).second) refuse(fmt::format("has two members '{}'", name));
  }
  if (!zip.has("modelDescription.xml")) refuse("is no FMU: it has no modelDescription.xml");
  description_ = read_description(zip.read("modelDescription.xml"), file_);
}

Package::~Package() {
  // A copy of this process, made by fork, does not own the folder.
  if (unpacked_.folder.empty() || getpid() != owner_) return;
  std::error_code ignored;
  fs::remove_all(unpacked_.folder, ignored);
}

void Package::refuse(const std::string& why) const { throw InputError({file_, 0, 0}, why); }

const Package::Unpacked& Package::unpacked() const {
  const std::lock_guard guard(guard_);
  if (unpacked_.binary.empty()) unpack();
  return unpacked_;
}

void Package::unpack() const {
  const ZipFile zip(bytes_, file_);
  const std::vector<std::string> members = zip.members();
  const auto has = [&](const std::string& name) {
    return std::find(members.begin(), members.end(), name) != members.end();
  };
  std::string library;
  for (const char* folder : {platform, old_platform})
    if (const std::string name =
            fmt::format("binaries/{}/{}{}", folder, description_.identifier, library_ending);
        library.empty() && has(name))
      library = name;
  const bool sources = std::any_of(members.begin(), members.end(),
                                   [](const std::string& m) { return m.starts_with("sources/"); });
  if (library.empty() && !sources) {
    std::set<std::string> platforms;
    for (const std::string& m : members)
      if (m.starts_with("binaries/") && m.find('/', 9) != std::string::npos)
        platforms.insert(m.substr(9, m.find('/', 9) - 9));
    refuse(
        platforms.empty()
            ? std::string("has neither a library nor sources")
            : fmt::format("has no library binaries/{}/{}{} for this platform, only for {}, and no sources to "
                          "compile; export it for {}",
                          description_.version == 3 ? platform : old_platform, description_.identifier,
                          library_ending, fmt::join(platforms, ", "), platform));
  }
  if (unpacked_.folder.empty()) {
    std::string name = (fs::temp_directory_path() / "mimbre-fmu-XXXXXX").string();
    if (!mkdtemp(name.data())) refuse(fmt::format("cannot be unpacked: no folder can be made as '{}'", name));
    unpacked_.folder = name;
  }
  const fs::path folder = unpacked_.folder;
  std::size_t total = 0;
  const std::string library_folder = library.substr(0, library.find_last_of('/') + 1);
  for (const std::string& name : members) {
    const bool wanted = name.starts_with("resources/") ||
                        (library.empty() ? name.starts_with("sources/") : name.starts_with(library_folder));
    if (!wanted) continue;
    const fs::path path = folder / name;
    std::error_code status;
    if (name.back() == '/') {
      fs::create_directories(path, status);
      continue;
    }
    fs::create_directories(path.parent_path(), status);
    const std::string content = zip.read(name);
    total += content.size();
    if (total > largest_member) refuse("unpacks to more than 2 GiB");
    std::ofstream out(path, std::ios::binary);
    out << content;
    out.close();
    if (!out) refuse(fmt::format("'{}' cannot be written to '{}'", name, path.string()));
  }
  std::error_code status;
  if (fs::is_directory(folder / "resources", status)) unpacked_.resources = (folder / "resources").string();
  if (description_.version == 2 && unpacked_.resources.empty()) {
    // FMI 2 cannot state that there are none.
    fs::create_directories(folder / "resources", status);
    unpacked_.resources = (folder / "resources").string();
  }
  unpacked_.binary =
      library.empty() ? compile_sources(folder.string(), description_, file_) : (folder / library).string();
  bytes_ = {};
}

}  // namespace mimbre::fmu
