#include "model_file/text/includes.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "model_file/text/file_reader.h"

namespace mimbre::model_file {
namespace {

namespace fs = std::filesystem;

/// Where a file is, however it is called.
std::string identity(const std::string& path) {
  std::error_code unknown;
  const fs::path real = fs::weakly_canonical(path, unknown);
  return unknown ? path : real.string();
}

/// What is not taken over from a file into the one that includes it.
bool of_the_file_itself(const std::string& key) {
  return key == "mimbre" || key == "title" || key == "include";
}

/// Of one model or template: which files are open, one within the other, and which have been taken.
struct Inclusion {
  Builder& builder;
  std::vector<std::string> open = {};
  std::set<std::string> taken = {};

  void error(const Mark& mark, const std::string& message) const { builder.errors.add(mark, message); }

  void add(Tree& to, const std::shared_ptr<const Tree>& entry) {
    const Reading reading{&builder.parts.front().scope, &builder.errors, &builder.limits};
    const Value value(reading, *entry, "include");
    if (!value.is_scalar() || value.tree().text.starts_with('$'))
      return value.error("the name of a file is needed, without parameters");
    if (!has_folder(builder, value)) return;
    const std::string path = path_of(builder, value.mark(), entry->text), real = identity(path);
    if (std::find(open.begin(), open.end(), real) != open.end())
      return value.error(
          fmt::format("'{}' includes itself{}", path, open.size() > 1 ? " by way of others" : ""));
    if (!taken.insert(real).second) return;
    const auto tree = read_tree_file(value, path, value.tree().text);
    if (!tree) return;
    if (tree->kind != Tree::Kind::map)
      return error(tree->mark, fmt::format("'{}' is included, but has no sections", path));
    open.push_back(real);
    merge(to, *resolved(tree));
    open.pop_back();
  }

  std::shared_ptr<const Tree> read_tree_file(const Value& value, const std::string& path,
                                             const std::string& called) {
    const auto read = builder.reader->yaml(builder, value, path);
    if (!read) return nullptr;
    builder.model.text += fmt::format("\n# {}:\n# ", called);
    for (const char c : read->text) builder.model.text += c == '\n' ? std::string("\n# ") : std::string(1, c);
    return read->tree;
  }

  /// What both have is put together: names with names, lists behind lists; no name twice.
  void merge(Tree& to, const Tree& from) {
    for (const Tree::Entry& entry : from.entries) {
      if (of_the_file_itself(entry.key)) continue;
      const auto at = std::find_if(to.entries.begin(), to.entries.end(),
                                   [&](const Tree::Entry& e) { return e.key == entry.key; });
      if (at == to.entries.end()) {
        to.entries.push_back(entry);
        continue;
      }
      const Tree &first = *at->value, &second = *entry.value;
      if (second.kind == Tree::Kind::null) continue;
      if (first.kind == Tree::Kind::null) {
        at->value = entry.value;
        continue;
      }
      auto both = std::make_shared<Tree>(first);
      if (first.kind == Tree::Kind::map && second.kind == Tree::Kind::map)
        for (const Tree::Entry& item : second.entries)
          if (const Tree::Entry* known = first.find(item.key))
            twice(item.key, item.mark, known->mark);
          else
            both->entries.push_back(item);
      else if (first.kind == Tree::Kind::list && second.kind == Tree::Kind::list)
        both->items.insert(both->items.end(), second.items.begin(), second.items.end());
      else
        twice(entry.key, entry.mark, at->mark);
      both->size += second.size;
      at->value = both;
    }
    to.size += from.size;
    if (to.size > builder.limits.nodes)
      throw InputError(from.mark,
                       fmt::format("more than {} values in all files together", builder.limits.nodes));
  }

  void twice(const std::string& key, const Mark& mark, const Mark& first) const {
    error(mark, fmt::format("'{}' is given twice (first in {}:{}); remove or rename one", key, first.file,
                            first.line));
  }

  std::shared_ptr<const Tree> resolved(const std::shared_ptr<const Tree>& tree) {
    const Tree::Entry* include = tree->kind == Tree::Kind::map ? tree->find("include") : nullptr;
    if (!include) return tree;
    if (open.size() > static_cast<std::size_t>(builder.limits.depth))
      throw InputError(include->mark,
                       fmt::format("files include each other more than {} deep", builder.limits.depth));
    auto all = std::make_shared<Tree>();
    all->kind = Tree::Kind::map;
    all->mark = tree->mark;
    const bool several = include->value->kind == Tree::Kind::list;
    for (const auto& one : several ? include->value->items : std::vector{include->value}) add(*all, one);
    merge(*all, *tree);
    for (const char* key : {"title", "mimbre"})
      if (const Tree::Entry* entry = tree->find(key)) all->entries.insert(all->entries.begin(), *entry);
    return all;
  }
};

std::shared_ptr<const Tree> templates_resolved(Builder& builder, const std::shared_ptr<const Tree>& tree) {
  const Tree::Entry* subsystems = tree->kind == Tree::Kind::map ? tree->find("subsystems") : nullptr;
  if (!subsystems || subsystems->value->kind != Tree::Kind::map) return tree;
  auto section = std::make_shared<Tree>(*subsystems->value);
  bool changed = false;
  for (Tree::Entry& entry : section->entries) {
    const auto resolved = with_includes(builder, entry.value);
    changed = changed || resolved != entry.value;
    entry.value = resolved;
  }
  if (!changed) return tree;
  auto result = std::make_shared<Tree>(*tree);
  for (Tree::Entry& entry : result->entries)
    if (entry.key == "subsystems") entry.value = section;
  return result;
}

}  // namespace

std::shared_ptr<const Tree> with_includes(Builder& builder, const std::shared_ptr<const Tree>& tree) {
  Inclusion inclusion{builder};
  inclusion.open.push_back(identity(tree->mark.file));
  return templates_resolved(builder, inclusion.resolved(tree));
}

std::shared_ptr<const Tree> read_tree(Builder& builder, const Value& value) {
  const auto name = value.word();
  if (!name || !has_folder(builder, value)) return nullptr;
  const std::string path = path_of(builder, value.mark(), *name);
  const auto [place, fresh] = builder.files.try_emplace(identity(path));
  if (!fresh) return place->second;
  const auto tree = Inclusion{builder}.read_tree_file(value, path, *name);
  if (tree) place->second = with_includes(builder, tree);
  return place->second;
}

}  // namespace mimbre::model_file
