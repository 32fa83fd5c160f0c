#include "compile/image.h"

#include <cstring>
#include <new>
#include <string_view>

#include "base/hash64.h"
#include "mimbre/build.h"
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

constexpr std::align_val_t alignment{ImageSpace::alignment};
static_assert(alignof(Compiled) <= ImageSpace::alignment);

std::byte* zeroed(std::size_t size) {
  auto* memory = static_cast<std::byte*>(::operator new(size, alignment));
  std::memset(memory, 0, size);
  return memory;
}

/// Of the bytes of an image: then come the places of the pointers, then the block. Layouts differ by program.
struct Header {
  char magic[8] = {'m', 'i', 'm', 'b', 'r', 'e', 'I', '1'};
  std::uint64_t program = 0, hash = 0, pointers = 0, size = 0;
};

std::uint64_t program() {
  Hash64 hash;
  const BuildInfo& build = build_info();
  hash.add(build.version + '\n' + build.compiler + '\n' + build.instructions);
  // What lies in its arrays may change while it stays as long as it was.
  for (const std::size_t size :
       {sizeof(Compiled), sizeof(BodyData), sizeof(FrameData), sizeof(FlexibleData), sizeof(AncfElement),
        sizeof(AncfSpatialElement), sizeof(LoopData), sizeof(DriveData), sizeof(ElementData), sizeof(LawData),
        sizeof(SensorData), sizeof(RoadData), sizeof(FunctionData), sizeof(SignalsData::Sampled),
        sizeof(MotionSubspace), sizeof(PathEntry), sizeof(MassPlace)})
    hash.add(static_cast<double>(size));
  return hash.value();
}

std::uint64_t hash_of(std::span<const std::byte> bytes) {
  Hash64 hash;
  hash.add(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  return hash.value();
}

}  // namespace

void Image::Free::operator()(std::byte* memory) const { ::operator delete(memory, alignment); }

Image::Image(const Compiled& grown) {
  {
    // Only to know how much it is.
    ImageSpace space;
    space.take(sizeof(Compiled));
    const Compiled copy(grown);
    size_ = space.used();
  }
  memory_.reset(zeroed(size_));
  ImageSpace space(memory_.get());
  new (space.take(sizeof(Compiled))) Compiled(grown);
  pointers_ = space.take_pointers();
}

Image::Image(std::span<const std::byte> bytes, const spec::Model* source) {
  Header header;
  if (bytes.size() < sizeof header)
    throw InputError(Mark{}, "these bytes are not the image of a model: they are too few");
  const Header expected;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0)
    throw InputError(Mark{}, "these bytes are not the image of a model");
  if (header.program != program())
    throw InputError(Mark{}, "this image of a model was made by another build of the program");
  const std::span<const std::byte> rest = bytes.subspan(sizeof header);
  if (header.pointers > rest.size() / sizeof(std::size_t) ||
      header.size != rest.size() - header.pointers * sizeof(std::size_t) || header.size < sizeof(Compiled) ||
      header.hash != hash_of(rest))
    throw InputError(Mark{}, "this image of a model is damaged");
  size_ = header.size;
  pointers_.resize(header.pointers);
  std::memcpy(pointers_.data(), rest.data(), header.pointers * sizeof(std::size_t));
  memory_.reset(zeroed(size_));
  std::memcpy(memory_.get(), rest.data() + header.pointers * sizeof(std::size_t), size_);
  for (const std::size_t at : pointers_) {
    std::size_t distance = 0;
    std::memcpy(&distance, memory_.get() + at, sizeof distance);
    const std::byte* pointer = memory_.get() + distance;
    std::memcpy(memory_.get() + at, &pointer, sizeof pointer);
  }
  reinterpret_cast<Compiled*>(memory_.get())->source = source;
}

std::vector<std::byte> Image::bytes() const {
  const std::unique_ptr<std::byte, Free> memory(zeroed(size_));
  ImageSpace space(memory.get(), true);
  auto* root = new (space.take(sizeof(Compiled))) Compiled(model());
  clear_padding(*root);
  root->source = nullptr;
  for (const std::size_t at : space.take_pointers()) {
    const std::byte* pointer = nullptr;
    std::memcpy(&pointer, memory.get() + at, sizeof pointer);
    const auto distance = static_cast<std::size_t>(pointer - memory.get());
    std::memcpy(memory.get() + at, &distance, sizeof distance);
  }
  const std::size_t head = sizeof(Header) + pointers_.size() * sizeof(std::size_t);
  std::vector<std::byte> out(head + size_);
  std::memcpy(out.data() + sizeof(Header), pointers_.data(), head - sizeof(Header));
  std::memcpy(out.data() + head, memory.get(), size_);
  Header header;
  header.program = program();
  header.pointers = pointers_.size();
  header.size = size_;
  header.hash = hash_of(std::span(out).subspan(sizeof header));
  std::memcpy(out.data(), &header, sizeof header);
  return out;
}

std::uint64_t Image::hash() const {
  const std::vector<std::byte> all = bytes();
  return hash_of(std::span(all).subspan(sizeof(Header)));
}

}  // namespace mimbre
