#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "compile/compiled.h"

namespace mimbre {

/// What a step needs of a model, in one block of memory on cache lines: Compiled at its beginning, its arrays
/// behind it. Its bytes, in which pointers are distances from its beginning, may be kept, sent or mapped, and
/// made an image again anywhere. It is read only, and any number of threads may read it.
class Image {
 public:
  /// A copy of what compile() has grown on the heap.
  explicit Image(const Compiled& grown);
  /// A copy of the bytes of another image made by the same program, in this process or in another one. The
  /// given spec has to be that model's and to live as long. Throws InputError
  /// when the bytes are not an image of this program, or are damaged.
  Image(std::span<const std::byte> bytes, const spec::Model* source);

  const Compiled& model() const { return *reinterpret_cast<const Compiled*>(memory_.get()); }
  /// Without the spec. Equal models have equal bytes.
  std::vector<std::byte> bytes() const;
  /// Of what is in the block, whichever build of the program made it.
  std::uint64_t hash() const;

 private:
  struct Free {
    void operator()(std::byte* memory) const;
  };
  std::unique_ptr<std::byte, Free> memory_;
  std::size_t size_ = 0;
  std::vector<std::size_t> pointers_;  ///< where in the block pointers into it are
};

}  // namespace mimbre
