#include "model_file/text/kept_files.h"

#include <fmt/format.h>

#include "spec/model_members.h"

namespace mimbre::model_file {
namespace {

void write_tree(archive::Writer& to, const Tree& tree) {
  to(tree.kind, tree.mark.line, tree.mark.column, tree.text, tree.size, tree.items.size(),
     tree.entries.size());
  for (const auto& item : tree.items) write_tree(to, *item);
  for (const Tree::Entry& entry : tree.entries) {
    to(entry.key, entry.mark.line, entry.mark.column);
    write_tree(to, *entry.value);
  }
}

std::shared_ptr<const Tree> read_kept_tree(archive::Reader& from, const std::string& file) {
  auto tree = std::make_shared<Tree>();
  std::size_t items = 0, entries = 0;
  tree->mark.file = file;
  from(tree->kind, tree->mark.line, tree->mark.column, tree->text, tree->size, items, entries);
  for (std::size_t k = 0; k < items; ++k) tree->items.push_back(read_kept_tree(from, file));
  for (std::size_t k = 0; k < entries; ++k) {
    Tree::Entry entry;
    entry.mark.file = file;
    from(entry.key, entry.mark.line, entry.mark.column);
    entry.value = read_kept_tree(from, file);
    tree->entries.push_back(std::move(entry));
  }
  return tree;
}

template <class T, class Write>
void write_map(archive::Writer& to, const std::map<std::string, T>& map, const Write& write) {
  to(map.size());
  for (const auto& [path, value] : map) {
    to(path);
    write(value);
  }
}
template <class T, class Read>
void read_map(archive::Reader& from, std::map<std::string, T>& map, const Read& read) {
  std::size_t size = 0;
  from(size);
  for (std::size_t k = 0; k < size; ++k) {
    std::string path;
    from(path);
    read(path, map[path]);
  }
}

template <class T>
const T& kept(const std::map<std::string, T>& map, const std::string& path) {
  const auto found = map.find(path);
  if (found == map.end())
    throw InputError(Mark{},
                     fmt::format("'{}' is not among the files that were read when the model was kept", path));
  return found->second;
}

}  // namespace

std::vector<std::byte> KeptFiles::bytes() const {
  archive::Writer to;
  write_map(to, yaml_, [&](const Yaml& yaml) {
    to(yaml.text);
    write_tree(to, *yaml.tree);
  });
  write_map(to, bodies_, [&](const auto& body) { to(body); });
  write_map(to, surfaces_, [&](const auto& surface) { to(surface); });
  write_map(to, tyres_,
            [&](const TyreProperties& tyre) { to(tyre.numbers, tyre.unloaded_radius, tyre.doubtful); });
  write_map(to, roads_, [&](const RoadGrid& road) { to(road); });
  return to.take();
}

KeptFiles::KeptFiles(std::span<const std::byte> bytes) {
  archive::Reader from(bytes);
  read_map(from, yaml_, [&](const std::string& path, Yaml& yaml) {
    from(yaml.text);
    yaml.tree = read_kept_tree(from, path);
  });
  read_map(from, bodies_, [&](const std::string&, auto& body) { from(body); });
  read_map(from, surfaces_, [&](const std::string&, auto& surface) { from(surface); });
  read_map(from, tyres_, [&](const std::string&, TyreProperties& tyre) {
    from(tyre.numbers, tyre.unloaded_radius, tyre.doubtful);
  });
  read_map(from, roads_, [&](const std::string&, RoadGrid& road) { from(road); });
}

std::shared_ptr<const Tree> KeptFiles::model(const std::string&, const std::string& name, const Limits&,
                                             std::vector<Diagnostic>&) const {
  return kept(yaml_, name).tree;
}

std::optional<FileReader::Yaml> KeptFiles::yaml(Builder&, const Value& value, const std::string& path) const {
  const auto found = yaml_.find(path);
  if (found != yaml_.end()) return found->second;
  value.error(fmt::format("'{}' is not among the files that were read when the model was kept", path));
  return {};
}

std::shared_ptr<const ReducedBody> KeptFiles::reduced_body(const std::string& path) const {
  return kept(bodies_, path);
}
std::shared_ptr<const SurfaceMesh> KeptFiles::surface(const std::string& path) const {
  return kept(surfaces_, path);
}
TyreProperties KeptFiles::tyre(const std::string& path) const { return kept(tyres_, path); }
RoadGrid KeptFiles::road(const std::string& path) const { return kept(roads_, path); }

std::vector<Value> KeptFiles::fmu_block(Builder&, const Fields& fields, spec::Block&) const {
  fields.error("is computed by an FMU, which is not kept with a model");
  return {};
}

}  // namespace mimbre::model_file
