#include "model_file/sections/kept_reductions.h"

#include <list>
#include <mutex>
#include <string_view>
#include <type_traits>
#include <unordered_map>

#include "spec/model_members.h"

namespace mimbre::model_file {
namespace {

/// Appends values bit by bit; sizes before what may have several. The structures are taken apart by all of
/// their members, so that a new one is not forgotten.
class Content {
 public:
  std::string take() { return std::move(bytes_); }

  template <class... Values>
  void operator()(const Values&... values) {
    (add(values), ...);
  }

 private:
  template <class T>
  void add(const T& x) requires std::is_arithmetic_v<T> || std::is_enum_v<T> {
    bytes_.append(reinterpret_cast<const char*>(&x), sizeof x);
  }
  void add(const std::string& x) {
    add(x.size());
    bytes_ += x;
  }
  template <class Derived>
  void add(const Eigen::PlainObjectBase<Derived>& x) {
    add(x.size());
    bytes_.append(reinterpret_cast<const char*>(x.data()),
                  static_cast<std::size_t>(x.size()) * sizeof(double));
  }
  template <class T>
  void add(const std::vector<T>& x) {
    add(x.size());
    for (const T& item : x) add(item);
  }
  template <class T, std::size_t n>
  void add(const std::array<T, n>& x) {
    for (const T& item : x) add(item);
  }
  void add(const fe::Material& x) {
    const auto& [young, poisson, density] = x;
    (*this)(young, poisson, density);
  }
  void add(const fe::Section& x) {
    const auto& [area, Iy, Iz, J, shear_y, shear_z, reach_y, reach_z, torsion_modulus, round] = x;
    (*this)(area, Iy, Iz, J, shear_y, shear_z, reach_y, reach_z, torsion_modulus, round);
  }
  void add(const fe::BeamElement& x) {
    const auto& [nodes, offsets, y_direction, section, material, theory, bar] = x;
    (*this)(nodes, offsets, y_direction, section, material, theory, bar);
  }
  void add(const fe::Mesh& x) {
    const auto& [nodes, elements] = x;
    (*this)(nodes, elements);
  }
  void add(const fe::BoundaryDof& x) {
    const auto& [node, rotation, direction, name] = x;
    (*this)(node, rotation, direction, name);
  }
  void add(const fe::NodeFrame& x) {
    const auto& [name, node, rotation] = x;
    (*this)(name, node, rotation);
  }
  void add(const fe::ReductionOptions& x) {
    const auto& [clamped, fixed, boundary, modes, damping, axial_modes, stiffening, published, turn, sections,
                 mass] = x;
    (*this)(clamped, fixed, boundary, modes, damping, axial_modes, stiffening, published, turn, sections,
            mass);
  }

  std::string bytes_;
};

constexpr std::size_t most_bytes = std::size_t{64} << 20, most_bodies = 256;

std::size_t size_of(const ReducedBody& body) {
  archive::Writer writer;
  writer(body);
  return writer.take().size();
}

struct Kept {
  struct Entry {
    std::string content;
    std::shared_ptr<const ReducedBody> body;
    std::size_t bytes;
  };
  std::mutex mutex;
  std::list<Entry> entries;  ///< used last first
  std::unordered_map<std::string_view, std::list<Entry>::iterator> by_content;
  std::size_t bytes = 0;
};

Kept& kept() {
  static Kept all;
  return all;
}

}  // namespace

std::string content_of(const FlexibleDescription& d, const std::string& name) {
  Content content;
  content(name, d.line_radius, d.kind, d.normal, d.mesh, d.options, d.frames);
  return content.take();
}

std::shared_ptr<const ReducedBody> find_reduced(const std::string& content) {
  Kept& all = kept();
  const std::lock_guard lock(all.mutex);
  const auto found = all.by_content.find(content);
  if (found == all.by_content.end()) return nullptr;
  all.entries.splice(all.entries.begin(), all.entries, found->second);
  return found->second->body;
}

void keep_reduced(const std::string& content, const std::shared_ptr<const ReducedBody>& body) {
  const std::size_t bytes = 2 * content.size() + size_of(*body);
  Kept& all = kept();
  const std::lock_guard lock(all.mutex);
  if (bytes > most_bytes / 4 || all.by_content.contains(content)) return;
  all.entries.push_front({content, body, bytes});
  all.bytes += bytes;
  all.by_content.emplace(all.entries.front().content, all.entries.begin());
  while (all.bytes > most_bytes || all.entries.size() > most_bodies) {
    const Kept::Entry& last = all.entries.back();
    all.bytes -= last.bytes;
    all.by_content.erase(last.content);
    all.entries.pop_back();
  }
}

}  // namespace mimbre::model_file
