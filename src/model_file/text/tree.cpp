#include "model_file/text/tree.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <sstream>
#include <unordered_set>

#include "mimbre/text.h"

namespace mimbre::model_file {
namespace {

/// Builds the tree from yaml-cpp's events. The parser recurses once per nested value and calls this first, so
/// that throwing here bounds its stack too.
class TreeBuilder : public YAML::EventHandler {
 public:
  TreeBuilder(const std::string& file, const Limits& limits, std::vector<Diagnostic>& errors)
      : file_(file), limits_(limits), errors_(errors) {}

  std::shared_ptr<const Tree> root;

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    auto tree = make(Tree::Kind::null, mark);
    // yaml-cpp places what is not there at the next item; people look at the key.
    if (!levels_.empty() && levels_.back().have_key) tree->mark = levels_.back().key_mark;
    add(tree, anchor, mark);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    if (anchor >= anchors_.size() || !anchors_[anchor])
      throw InputError(place(mark), "an alias cannot stand inside the value that it names");
    add(anchors_[anchor], 0, mark);
  }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                const std::string& value) override {
    auto tree = make(Tree::Kind::scalar, mark);
    tree->text = value;
    add(tree, anchor, mark);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(Tree::Kind::list, mark, anchor);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(Tree::Kind::map, mark, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Level {
    std::shared_ptr<Tree> tree;
    YAML::anchor_t anchor = 0;
    std::string key;
    Mark key_mark;
    bool have_key = false;
    std::unordered_set<std::string> keys;
  };

  Mark place(const YAML::Mark& mark) const { return {file_, mark.line + 1, mark.column + 1}; }

  std::shared_ptr<Tree> make(Tree::Kind kind, const YAML::Mark& mark) const {
    auto tree = std::make_shared<Tree>();
    tree->kind = kind;
    tree->mark = place(mark);
    return tree;
  }

  void open(Tree::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (static_cast<int>(levels_.size()) >= limits_.depth)
      throw InputError(place(mark), fmt::format("nested deeper than {} levels", limits_.depth));
    levels_.push_back({});
    levels_.back().tree = make(kind, mark);
    levels_.back().anchor = anchor;
  }

  void close() {
    Level level = std::move(levels_.back());
    levels_.pop_back();
    for (const auto& item : level.tree->items) level.tree->size += item->size;
    for (const auto& entry : level.tree->entries) level.tree->size += entry.value->size;
    const Mark mark = level.tree->mark;
    add(level.tree, level.anchor, YAML::Mark::null_mark(), &mark);
  }

  void add(const std::shared_ptr<const Tree>& tree, YAML::anchor_t anchor, const YAML::Mark& yaml_mark,
           const Mark* known = nullptr) {
    const Mark mark = known ? *known : place(yaml_mark);
    if (anchor) {
      if (anchors_.size() <= anchor) anchors_.resize(anchor + 1);
      anchors_[anchor] = tree;
    }
    // Counted where it is used, so that aliases of aliases cannot multiply unseen.
    if (tree->size > limits_.nodes || (nodes_ += known ? 1 : tree->size) > limits_.nodes)
      throw InputError(mark, fmt::format("more than {} values", limits_.nodes));
    if (levels_.empty()) {
      root = tree;
      return;
    }
    Level& level = levels_.back();
    if (level.tree->kind == Tree::Kind::list) {
      level.tree->items.push_back(tree);
    } else if (!level.have_key) {
      if (tree->kind != Tree::Kind::scalar) throw InputError(mark, "a key must be a word");
      level.key = tree->text;
      level.key_mark = mark;
      level.have_key = true;
    } else {
      level.have_key = false;
      if (level.keys.insert(level.key).second) {
        level.tree->entries.push_back({level.key, level.key_mark, tree});
      } else if (errors_.size() < limits_.errors) {
        const int first = level.tree->find(level.key)->mark.line;
        errors_.push_back(
            {level.key_mark,
             fmt::format("'{}' is given twice (first in line {}); remove or rename one", level.key, first)});
      }
    }
  }

  const std::string& file_;
  const Limits& limits_;
  std::vector<Diagnostic>& errors_;
  std::vector<Level> levels_;
  std::vector<std::shared_ptr<const Tree>> anchors_;
  std::size_t nodes_ = 0;
};

/// Line and column of a byte, from 1.
Mark place_of(const std::string& text, std::size_t at, const std::string& file) {
  const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  const std::size_t before = at == 0 ? std::string::npos : text.rfind('\n', at - 1);
  const std::size_t start = before == std::string::npos ? 0 : before + 1;
  return {file, static_cast<int>(line) + 1, static_cast<int>(at - start) + 1};
}

/// Line and column of the first tab that stands before anything else in its line.
std::optional<std::pair<int, int>> indenting_tab(const std::string& text) {
  int line = 1;
  for (std::size_t start = 0; start < text.size(); ++line) {
    const std::size_t first = text.find_first_not_of(' ', start);
    if (first == std::string::npos) break;
    if (text[first] == '\t') return std::pair(line, static_cast<int>(first - start) + 1);
    const std::size_t end = text.find('\n', start);
    if (end == std::string::npos) break;
    start = end + 1;
  }
  return {};
}

/// What yaml-cpp complains of, for who does not know its grammar.
std::string in_plain_words(const std::string& message) {
  constexpr const char* here = " (here or just above)";
  if (message == "end of map not found")
    return fmt::format("the indentation of this line fits no key above it, or a bracket or quote is open{}",
                       here);
  if (message == "end of sequence not found")
    return fmt::format("the indentation of this line fits no list above it, or its '- ' is missing{}", here);
  if (message == "end of sequence flow not found") return fmt::format("a '[' is not closed by ']'{}", here);
  if (message == "end of map flow not found") return fmt::format("a '{{' is not closed by '}}'{}", here);
  if (message == "illegal flow end")
    return fmt::format("a bracket is closed that is not the open one{}", here);
  if (message == "illegal map value")
    return fmt::format(
        "a key cannot stand here: wrong indentation, or a colon or its blank is missing in the line above{}",
        here);
  return fmt::format("{} (unbalanced brackets or quotes, or wrong indentation, here or just above)", message);
}

/// A hint where the line or the one above has `key:value` without a blank.
std::string joined_colon(const std::string& text, int line) {
  std::istringstream lines(text);
  std::string content;
  for (int k = 1; k <= line && std::getline(lines, content); ++k) {
    if (k + 1 < line) continue;
    const std::size_t first = content.find_first_not_of(" -"), colon = content.find(':');
    if (first == std::string::npos || colon == std::string::npos || colon + 1 >= content.size()) continue;
    const auto in_name = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
    const std::string key = content.substr(first, std::max(first, colon) - first);
    if (!key.empty() && std::all_of(key.begin(), key.end(), in_name) &&
        !std::isspace(static_cast<unsigned char>(content[colon + 1])))
      return fmt::format("; line {} needs a blank behind '{}:'", k, key);
  }
  return {};
}

}  // namespace

std::shared_ptr<const Tree> parse_yaml(const std::string& text, const std::string& file, const Limits& limits,
                                       std::vector<Diagnostic>& errors) {
  if (text.size() > limits.bytes)
    throw InputError({file, 1, 1}, fmt::format("the file is larger than {} MiB", limits.bytes >> 20));
  if (text.starts_with("\x89HDF"))
    throw InputError({file, 0, 0},
                     "is an HDF5 file, such as results or a reduced body, and no model file (YAML)");
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") || text.find('\0') != std::string::npos)
    throw InputError({file, 1, 1}, "this is UTF-16, or no text at all; save the file as UTF-8");
  if (const std::size_t bad = first_not_utf8(text); bad != std::string::npos)
    throw InputError(place_of(text, bad, file),
                     fmt::format("the byte 0x{:02X} is no UTF-8; save the file as UTF-8",
                                 static_cast<unsigned char>(text[bad])));
  // Every value in brackets has one of these before it. yaml-cpp holds all of a bracket's words in memory, a
  // hundredfold, before it hands out the first.
  const auto opens_value = [](char c) { return c == '[' || c == '{' || c == ','; };
  if (static_cast<std::size_t>(std::count_if(text.begin(), text.end(), opens_value)) > limits.nodes)
    throw InputError({file, 1, 1}, fmt::format("more than {} brackets and commas", limits.nodes));
  TreeBuilder builder(file, limits, errors);
  try {
    // The end of the document is marked, or yaml-cpp would take a quote that is never closed for closed by
    // the end.
    std::istringstream stream(text + (text.ends_with('\n') ? "...\n" : "\n...\n"));
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder) || !builder.root || builder.root->kind == Tree::Kind::null)
      throw InputError({file, 1, 1}, "the file is empty; a model starts with 'mimbre: 1'");
    const auto root = builder.root;
    if (parser.HandleNextDocument(builder))
      throw InputError(builder.root->mark, "a second YAML document; a model file has only one");
    return root;
  } catch (const YAML::Exception& error) {
    if (const auto tab = indenting_tab(text))
      throw InputError({file, tab->first, tab->second},
                       "not valid YAML: a tab in the indentation; indent with spaces");
    const int line = std::max(error.mark.line, 0) + 1;
    throw InputError({file, line, std::max(error.mark.column, 0) + 1},
                     "not valid YAML: " + in_plain_words(error.msg) + joined_colon(text, line));
  }
}

}  // namespace mimbre::model_file
