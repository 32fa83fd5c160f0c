#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace mimbre {

/// The files within a ZIP archive, stored or deflated, archives beyond 4 GB (ZIP64) included.
class ZipFile {
 public:
  /// `bytes`: the whole archive; `name`: for messages. Throws InputError.
  ZipFile(std::string bytes, std::string name);

  bool has(std::string_view member) const;
  /// Names of all members, in the order of the archive. Throws InputError.
  std::vector<std::string> members() const;
  /// The bytes of a member. Throws InputError when there is none or it is damaged.
  std::string read(std::string_view member) const;

 private:
  struct Entry {
    std::string_view name;
    int method = 0;
    std::uint64_t compressed = 0, size = 0, offset = 0;
    std::uint32_t checksum = 0;
  };
  /// The first of the entries or the one named; false when there is none.
  bool find(std::string_view member, Entry& entry) const;
  [[noreturn]] void fail(const std::string& message) const;
  std::uint64_t number(std::uint64_t offset, int bytes) const;

  std::string bytes_, name_;
  std::uint64_t directory_ = 0, count_ = 0;
};

}  // namespace mimbre
