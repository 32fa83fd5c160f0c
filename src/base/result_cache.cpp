#include "mimbre/result_cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "base/output_place.h"
#include "base/sha256.h"

namespace mimbre {

namespace fs = std::filesystem;

namespace {

constexpr const char* ending = ".result";
constexpr std::size_t digits = 64;  ///< of a key

/// An entry: a line with the digest of all that follows, a line with the length of the text, text, file.
std::string packed(const std::string& text, const std::string& file) {
  const std::string rest = fmt::format("{}\n", text.size()) + text + file;
  Sha256 digest;
  digest.add(rest);
  return digest.hex() + '\n' + rest;
}

struct Unpacked {
  std::string_view text, file;
};

std::optional<Unpacked> unpacked(std::string_view bytes) {
  if (bytes.size() <= digits || bytes[digits] != '\n') return {};
  const std::string_view rest = bytes.substr(digits + 1);
  Sha256 digest;
  digest.add(rest);
  if (digest.hex() != bytes.substr(0, digits)) return {};
  const std::size_t line = rest.find('\n') + 1;
  const std::size_t length = std::stoull(std::string(rest.substr(0, line)));
  return Unpacked{rest.substr(line, length), rest.substr(line + length)};
}

std::optional<std::string> read(const fs::path& path) {
  std::error_code failed;
  if (!fs::is_regular_file(path, failed)) return {};
  const std::uintmax_t size = fs::file_size(path, failed);
  if (failed) return {};
  std::string bytes(size, '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) return {};
  return bytes;
}

/// At once: what was there stays when it cannot be written.
bool write(const fs::path& path, std::string_view bytes) {
  const fs::path part = fmt::format("{}.{}.part", path.string(), getpid());
  std::error_code failed;
  {
    std::ofstream file(part, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) failed = std::make_error_code(std::errc::io_error);
  }
  if (!failed) fs::rename(part, path, failed);
  std::error_code ignored;
  if (failed) fs::remove(part, ignored);
  return !failed;
}

/// Whether a file of the folder is one of the cache's own, which may be removed.
bool is_own(const fs::path& path) {
  const std::string name = path.filename().string();
  const std::size_t key = std::min(name.find_first_not_of("0123456789abcdef"), name.size());
  const std::string_view rest = std::string_view(name).substr(key);
  return key == digits && (rest == ending || (rest.starts_with(ending) && rest.ends_with(".part")));
}

}  // namespace

ContentKey::ContentKey() : digest_(std::make_unique<Sha256>()) {}
ContentKey::~ContentKey() = default;
std::string ContentKey::hex() { return digest_->hex(); }

void ContentKey::add(std::string_view text) {
  digest_->add(fmt::format("{}:", text.size()));
  digest_->add(text);
}

void ContentKey::add_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return add("no file");
  std::vector<char> buffer(1 << 20);
  Sha256 digest;
  while (file.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) || file.gcount() > 0)
    digest.add({buffer.data(), static_cast<std::size_t>(file.gcount())});
  add("file");
  add(digest.hex());
}

void ContentKey::add_program() { add_file("/proc/self/exe"); }

fs::path ResultCache::user_folder() {
  const auto variable = [](const char* name) -> fs::path {
    const char* const value = std::getenv(name);
    return value ? value : "";
  };
  if (const fs::path own = variable("MIMBRE_CACHE"); !own.empty()) return own;
  if (const fs::path caches = variable("XDG_CACHE_HOME"); caches.is_absolute()) return caches / "mimbre";
  if (const fs::path home = variable("HOME"); !home.empty()) return home / ".cache" / "mimbre";
  return {};
}

fs::path ResultCache::entry(const std::string& key) const { return folder_ / (key + ending); }

std::optional<std::string> ResultCache::fetch(const std::string& key, const std::string& output) const {
  if (folder_.empty()) return {};
  const auto bytes = read(entry(key));
  const auto found = bytes ? unpacked(*bytes) : std::nullopt;
  if (!found) return {};
  try {
    write_whole(output, found->file);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("cannot write '{}': {}", output, error.what()));
  }
  std::error_code ignored;
  fs::last_write_time(entry(key), fs::file_time_type::clock::now(), ignored);
  return std::string(found->text);
}

void ResultCache::store(const std::string& key, const std::string& text, const std::string& path) const {
  if (folder_.empty()) return;
  const auto file = read(path);
  if (!file || file->size() + text.size() > limit_ / 2) return;
  std::error_code failed;
  fs::create_directories(folder_, failed);
  if (!failed && write(entry(key), packed(text, *file))) remove_oldest();
}

void ResultCache::remove_oldest() const {
  struct Kept {
    fs::file_time_type used;
    std::uintmax_t size;
    fs::path path;
  };
  std::vector<Kept> all;
  std::uintmax_t size = 0;
  std::error_code failed;
  for (fs::directory_iterator it(folder_, failed), end; !failed && it != end; it.increment(failed)) {
    std::error_code gone;  // by another program meanwhile
    if (!is_own(it->path()) || !it->is_regular_file(gone)) continue;
    Kept kept{it->last_write_time(gone), it->file_size(gone), it->path()};
    if (gone) continue;
    size += kept.size;
    all.push_back(std::move(kept));
  }
  std::sort(all.begin(), all.end(), [](const Kept& a, const Kept& b) { return a.used < b.used; });
  for (const Kept& kept : all) {
    if (size <= limit_) break;
    if (fs::remove(kept.path, failed)) size -= kept.size;
  }
}

}  // namespace mimbre
