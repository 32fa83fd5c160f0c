#pragma once
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

namespace mimbre {

/// A block of memory into which arrays (base/array.h) that this thread copies go, one behind the other, for
/// as long as the space lives. Without memory it only counts how much they would need. It knows where in the
/// block pointers into the block are, so that it may be moved.
///
/// Bytes that belong to no member of what is copied are what they happen to be, or zero in a `plain` space:
/// there equal objects have equal bytes.
class ImageSpace {
 public:
  static constexpr std::size_t alignment = 64;  ///< of the block and of each array in it

  /// The memory, if any, is aligned, zero and large enough.
  explicit ImageSpace(std::byte* memory = nullptr, bool plain = false)
      : memory_(memory), plain_(plain), outer_(current_) {
    current_ = this;
  }
  ~ImageSpace() { current_ = outer_; }
  ImageSpace(const ImageSpace&) = delete;
  ImageSpace& operator=(const ImageSpace&) = delete;

  /// Where the next so many bytes are, or nullptr without memory.
  void* take(std::size_t bytes) {
    const std::size_t at = used_;
    used_ += (bytes + alignment - 1) / alignment * alignment;
    return memory_ ? memory_ + at : nullptr;
  }
  std::size_t used() const { return used_; }
  bool plain() const { return plain_; }

  /// Records that a pointer into the block lies here, in the block.
  void note_pointer(const void* where) {
    pointers_.push_back(static_cast<std::size_t>(static_cast<const std::byte*>(where) - memory_));
  }
  /// Their places, bytes from the beginning of the block.
  std::vector<std::size_t> take_pointers() { return std::move(pointers_); }

  /// The one that this thread copies into, or nullptr.
  static ImageSpace* current() { return current_; }

 private:
  static inline thread_local ImageSpace* current_ = nullptr;
  std::byte* memory_;
  bool plain_;
  std::size_t used_ = 0;
  std::vector<std::size_t> pointers_;
  ImageSpace* outer_;
};

/// Sets the bytes of an object that belong to none of its members to zero. Not for types with a std::array of
/// structs followed by padding: g++ 12 takes such an array for empty.
template <class T>
void clear_padding(T& object) {
  if constexpr (!std::is_arithmetic_v<T> && !std::is_enum_v<T>) {
    struct Mask {
      unsigned char byte[sizeof(T)];
      Mask() {
        T all{};
        all.~T();
        std::memset(static_cast<void*>(&all), 0xff, sizeof all);
        __builtin_clear_padding(&all);
        std::memcpy(byte, &all, sizeof all);
        new (&all) T{};
      }
    };
    static const Mask mask;
    auto* bytes = reinterpret_cast<unsigned char*>(&object);
    for (std::size_t k = 0; k < sizeof(T); ++k) bytes[k] &= mask.byte[k];
  }
}

}  // namespace mimbre
