#include "mimbre/model_bytes.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "base/hash64.h"
#include "spec/model_members.h"

namespace mimbre {
namespace {

static_assert(std::endian::native == std::endian::little);

/// Before the model. `format` changes whenever a list of members does.
struct ModelBytesHead {
  char magic[8] = {'m', 'i', 'm', 'b', 'r', 'e', 'M', '1'};
  std::uint64_t hash = 0;  ///< of what follows
};

std::uint64_t hash_of_model(std::span<const std::byte> bytes) {
  Hash64 hash;
  hash.add(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  return hash.value();
}

}  // namespace

std::vector<std::byte> model_bytes(const spec::Model& model) {
  std::vector<Diagnostic> refused;
  for (const spec::Element& element : model.elements)
    if (element.user)
      refused.push_back(
          {element.mark,
           fmt::format("'{}' has a force law of the user's own, which is code and cannot be written with the "
                       "model",
                       element.name)});
  for (const spec::Block& block : model.blocks)
    if (block.outside)
      refused.push_back(
          {block.mark, fmt::format("signal '{}' is computed by code from elsewhere, which cannot "
                                   "be written with the model",
                                   block.name)});
  if (!refused.empty()) throw InputError(std::move(refused));
  archive::Writer writer;
  writer(model);
  const std::vector<std::byte> body = writer.take();
  ModelBytesHead head;
  head.hash = hash_of_model(body);
  std::vector<std::byte> bytes(sizeof head + body.size());
  std::memcpy(bytes.data(), &head, sizeof head);
  std::memcpy(bytes.data() + sizeof head, body.data(), body.size());
  return bytes;
}

spec::Model model_from_bytes(std::span<const std::byte> bytes) {
  ModelBytesHead head;
  const ModelBytesHead expected;
  if (bytes.size() < sizeof head) throw InputError(Mark{}, "these bytes are not a model: they are too few");
  std::memcpy(&head, bytes.data(), sizeof head);
  if (std::memcmp(head.magic, expected.magic, sizeof head.magic) != 0)
    throw InputError(Mark{}, "these bytes are not a model");
  const std::span<const std::byte> body = bytes.subspan(sizeof head);
  if (head.hash != hash_of_model(body))
    throw InputError(Mark{}, "these bytes of a model are damaged, or of another version");
  archive::Reader reader(body);
  spec::Model model;
  reader(model);
  if (!reader.at_end()) throw InputError(Mark{}, "these bytes of a model are of another version");
  return model;
}

}  // namespace mimbre
