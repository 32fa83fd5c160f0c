#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

/// Results that took long, found again by what they were made of.
namespace mimbre {

/// The key of a result: a digest of all that it depends on.
class ContentKey {
 public:
  void add(std::string_view text);
  /// The file's bytes, wherever it lies; or that there is none.
  void add_file(const std::filesystem::path& path);
  /// The running program itself: another build may come to other results.
  void add_program();
  std::string hex();
  ContentKey();
  ~ContentKey();

 private:
  std::unique_ptr<class Sha256> digest_;
};

/// A folder of results, one file each: a description (any text) and the bytes of the file that was
/// made. Nothing that is wrong with the folder or an entry is an error: such an entry is not there, and what
/// cannot be kept is not kept.
class ResultCache {
 public:
  static constexpr std::uintmax_t default_limit = std::uintmax_t{2} << 30;  ///< bytes

  /// `limit`: of the entries together; the least recently used go first. Nothing is kept in an empty folder
  /// name.
  explicit ResultCache(std::filesystem::path folder, std::uintmax_t limit = default_limit)
      : folder_(std::move(folder)), limit_(limit) {}

  /// $MIMBRE_CACHE, else mimbre in $XDG_CACHE_HOME or ~/.cache; empty when none of them is set.
  static std::filesystem::path user_folder();

  /// Writes the entry's file to `output` and returns its text; nothing, and no file, when there is no sound
  /// entry. Throws std::runtime_error when `output` cannot be written.
  std::optional<std::string> fetch(const std::string& key, const std::string& output) const;
  /// Keeps the file at `path` and a text about it.
  void store(const std::string& key, const std::string& text, const std::string& path) const;

 private:
  std::filesystem::path entry(const std::string& key) const;
  void remove_oldest() const;

  std::filesystem::path folder_;
  std::uintmax_t limit_;
};

}  // namespace mimbre
