#pragma once
#include <bit>
#include <cstdint>
#include <string_view>

namespace mimbre {

/// FNV-1a (Fowler, Noll, Vo) of bytes and numbers that come in pieces, by words of eight bytes where there
/// are so many: quick, against accidents only.
class Hash64 {
 public:
  void add(std::string_view bytes) {
    add_word(bytes.size());
    std::uint64_t word = 0;
    int filled = 0;
    for (const char c : bytes) {
      word = (word << 8) | static_cast<unsigned char>(c);
      if (++filled < 8) continue;
      add_word(word);
      word = 0;
      filled = 0;
    }
    add_word(word);
  }
  /// Both zeros are the same.
  void add(double number) { add_word(std::bit_cast<std::uint64_t>(number + 0.0)); }
  void add(std::uint64_t word) { add_word(word); }
  std::uint64_t value() const { return value_; }

 private:
  void add_word(std::uint64_t word) {
    value_ = (value_ ^ word) * 0x100000001b3u;
    value_ ^= value_ >> 29;  // high bits come down, which multiplication alone never does
  }
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace mimbre
