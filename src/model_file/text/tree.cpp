#include "model_file/text/tree.h"

#include <fmt/format.h>
#include <yaml.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <new>
#include <optional>
#include <sstream>
#include <string_view>
#include <unordered_set>

#include "mimbre/text.h"

namespace mimbre::model_file {
namespace {

/// Builds the tree from libyaml's events.
class TreeBuilder {
 public:
  TreeBuilder(const std::string& file, const Limits& limits, std::vector<Diagnostic>& errors)
      : file_(file), limits_(limits), errors_(errors) {}

  std::shared_ptr<const Tree> root;

  void take(const yaml_event_t& event) {
    switch (event.type) {
      case YAML_SCALAR_EVENT:
        return scalar(event);
      case YAML_ALIAS_EVENT:
        return alias(event);
      case YAML_SEQUENCE_START_EVENT:
        return open(Tree::Kind::list, event.start_mark, event.data.sequence_start.anchor);
      case YAML_MAPPING_START_EVENT:
        return open(Tree::Kind::map, event.start_mark, event.data.mapping_start.anchor);
      case YAML_SEQUENCE_END_EVENT:
      case YAML_MAPPING_END_EVENT:
        return close();
      default:  // of streams and documents
        return;
    }
  }

 private:
  struct Level {
    std::shared_ptr<Tree> tree;
    std::string anchor;
    std::string key;
    Mark key_mark;
    bool have_key = false;
    std::unordered_set<std::string> keys;
  };

  static std::string name_of(const yaml_char_t* anchor) {
    return anchor ? reinterpret_cast<const char*>(anchor) : "";
  }
  Mark place(const yaml_mark_t& mark) const {
    return {file_, static_cast<int>(mark.line) + 1, static_cast<int>(mark.column) + 1};
  }

  std::shared_ptr<Tree> make(Tree::Kind kind, const Mark& mark) const {
    auto tree = std::make_shared<Tree>();
    tree->kind = kind;
    tree->mark = mark;
    return tree;
  }

  /// A word without quotes that stands for nothing.
  static bool is_null(const yaml_event_t& event, const std::string& text) {
    return event.data.scalar.style == YAML_PLAIN_SCALAR_STYLE &&
           (text.empty() || text == "~" || text == "null" || text == "Null" || text == "NULL");
  }

  void scalar(const yaml_event_t& event) {
    std::string text(reinterpret_cast<const char*>(event.data.scalar.value), event.data.scalar.length);
    const Mark mark = place(event.start_mark);
    const bool null = is_null(event, text);
    auto tree = make(null ? Tree::Kind::null : Tree::Kind::scalar, mark);
    if (!null) tree->text = std::move(text);
    // What is not there has the place of the next item; people look at the key.
    if (null && !levels_.empty() && levels_.back().have_key) tree->mark = levels_.back().key_mark;
    add(tree, name_of(event.data.scalar.anchor), mark);
  }

  void alias(const yaml_event_t& event) {
    const std::string name = name_of(event.data.alias.anchor);
    const Mark mark = place(event.start_mark);
    for (const Level& level : levels_)
      if (level.anchor == name)
        throw InputError(mark, "an alias cannot stand inside the value that it names");
    const auto found = anchors_.find(name);
    if (found == anchors_.end())
      throw InputError(
          mark, fmt::format("nothing above is marked with '&{}', so that '*{}' names nothing", name, name));
    add(found->second, "", mark);
  }

  void open(Tree::Kind kind, const yaml_mark_t& mark, const yaml_char_t* anchor) {
    if (static_cast<int>(levels_.size()) >= limits_.depth)
      throw InputError(place(mark), fmt::format("nested deeper than {} levels", limits_.depth));
    levels_.push_back({});
    levels_.back().tree = make(kind, place(mark));
    levels_.back().anchor = name_of(anchor);
  }

  void close() {
    Level level = std::move(levels_.back());
    levels_.pop_back();
    for (const auto& item : level.tree->items) level.tree->size += item->size;
    for (const auto& entry : level.tree->entries) level.tree->size += entry.value->size;
    const Mark mark = level.tree->mark;
    add(level.tree, level.anchor, mark, true);
  }

  /// `counted`: what is in it has been.
  void add(const std::shared_ptr<const Tree>& tree, const std::string& anchor, const Mark& mark,
           bool counted = false) {
    if (!anchor.empty()) anchors_[anchor] = tree;
    // Counted where it is used, so that aliases of aliases cannot multiply unseen.
    if (tree->size > limits_.nodes || (nodes_ += counted ? 1 : tree->size) > limits_.nodes)
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
  std::map<std::string, std::shared_ptr<const Tree>> anchors_;
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

/// The character at a mark; 0: there is none.
char character_at(const std::string& text, const yaml_mark_t& mark) {
  std::size_t at = 0;
  for (std::size_t line = 0; line < mark.line && at != std::string::npos; ++line) {
    at = text.find('\n', at);
    if (at != std::string::npos) ++at;
  }
  // Columns count characters, whose further bytes are 10xxxxxx.
  const auto goes_on = [&](std::size_t k) {
    return k < text.size() && (static_cast<unsigned char>(text[k]) & 0xC0U) == 0x80;
  };
  for (std::size_t column = 0; column < mark.column && at < text.size(); ++column) do
      ++at;
    while (goes_on(at));
  return at < text.size() ? text[at] : '\0';
}

/// What libyaml complains of, for who does not know its grammar. `context`: what it was reading; `there`: the
/// character at which it stopped.
std::string in_plain_words(const std::string& problem, const std::string& context, char there) {
  constexpr const char* here = " (here or just above)";
  const auto has = [&](const char* part) { return problem.find(part) != std::string::npos; };
  const bool quoted = context.find("quoted scalar") != std::string::npos;
  if (quoted && has("end of stream")) return "a quote is opened and never closed";
  if (quoted && has("document indicator")) return "a quote is open where the document ends";
  if ((has("',' or ']'") || has("',' or '}'")) && (there == ']' || there == '}'))
    return fmt::format("a bracket is closed that is not the open one{}", here);
  if (has("',' or ']'")) return fmt::format("a '[' is not closed by ']'{}", here);
  if (has("',' or '}'")) return fmt::format("a '{{' is not closed by '}}'{}", here);
  if (has("expected key"))
    return fmt::format("the indentation of this line fits no key above it, or a bracket or quote is open{}",
                       here);
  if (has("expected '-' indicator"))
    return fmt::format("the indentation of this line fits no list above it, or its '- ' is missing{}", here);
  if (has("mapping values") || has("mapping keys") || has("expected ':'"))
    return fmt::format(
        "a key cannot stand here: wrong indentation, or a colon or its blank is missing in the line above{}",
        here);
  if (has("block sequence entries"))
    return "a list cannot begin here: its '- ' belongs into a line of its own, or into brackets";
  if (has("cannot start any token"))
    return "this character begins no value: put the text in quotes, or indent with spaces where it is a tab";
  if (has("unknown escape"))
    return "an unknown escape behind '\\' in a quote; write '\\\\' for one backslash";
  return fmt::format("{} (unbalanced brackets or quotes, or wrong indentation, here or just above)", problem);
}

/// libyaml's parser over a text.
class EventReader {
 public:
  explicit EventReader(const std::string& text) {
    if (!yaml_parser_initialize(&parser_)) throw std::bad_alloc();
    yaml_parser_set_encoding(&parser_, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&parser_, reinterpret_cast<const unsigned char*>(text.data()), text.size());
  }
  ~EventReader() {
    yaml_event_delete(&event_);
    yaml_parser_delete(&parser_);
  }
  EventReader(const EventReader&) = delete;
  EventReader& operator=(const EventReader&) = delete;

  /// The next event, until the one after; null at the end, and where the text is not YAML.
  const yaml_event_t* next() {
    yaml_event_delete(&event_);
    event_ = {};
    if (ended_ || failed_) return nullptr;
    if (!yaml_parser_parse(&parser_, &event_)) {
      failed_ = true;
      event_ = {};
      return nullptr;
    }
    ended_ = event_.type == YAML_STREAM_END_EVENT;
    return &event_;
  }
  bool failed() const { return failed_; }
  const yaml_parser_t& parser() const { return parser_; }

 private:
  yaml_parser_t parser_{};
  yaml_event_t event_{};
  bool ended_ = false, failed_ = false;
};

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

[[noreturn]] void throw_fault(const EventReader& reader, const std::string& text, const std::string& file) {
  const yaml_parser_t& p = reader.parser();
  if (p.error == YAML_MEMORY_ERROR) throw std::bad_alloc();
  if (p.error == YAML_READER_ERROR)
    throw InputError(place_of(text, std::min(p.problem_offset, text.size()), file),
                     fmt::format("not valid YAML: the character U+{:04X} cannot stand in a file; remove it",
                                 std::max(p.problem_value, 0)));
  if (const auto tab = indenting_tab(text))
    throw InputError({file, tab->first, tab->second},
                     "not valid YAML: a tab in the indentation; indent with spaces");
  const int line = static_cast<int>(p.problem_mark.line) + 1;
  throw InputError({file, line, static_cast<int>(p.problem_mark.column) + 1},
                   "not valid YAML: " +
                       in_plain_words(p.problem ? p.problem : "", p.context ? p.context : "",
                                      character_at(text, p.problem_mark)) +
                       joined_colon(text, line));
}

}  // namespace

std::shared_ptr<const Tree> parse_yaml(const std::string& text, const std::string& file, const Limits& limits,
                                       std::vector<Diagnostic>& errors) {
  if (text.size() > limits.bytes)
    throw InputError({file, 1, 1}, fmt::format("the file is larger than {} MiB", limits.bytes >> 20));
  // A mark of UTF-8 is no character of the first line; libyaml, told the encoding, does not skip it.
  constexpr std::string_view utf8_mark = "\xEF\xBB\xBF";
  if (text.starts_with(utf8_mark)) return parse_yaml(text.substr(utf8_mark.size()), file, limits, errors);
  if (text.starts_with("\x89HDF"))
    throw InputError({file, 0, 0},
                     "is an HDF5 file, such as results or a reduced body, and no model file (YAML)");
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") || text.find('\0') != std::string::npos)
    throw InputError({file, 1, 1}, "this is UTF-16, or no text at all; save the file as UTF-8");
  if (const std::size_t bad = first_not_utf8(text); bad != std::string::npos)
    throw InputError(place_of(text, bad, file),
                     fmt::format("the byte 0x{:02X} is no UTF-8; save the file as UTF-8",
                                 static_cast<unsigned char>(text[bad])));
  // Every value in brackets has one of these before it.
  const auto opens_value = [](char c) { return c == '[' || c == '{' || c == ','; };
  if (static_cast<std::size_t>(std::count_if(text.begin(), text.end(), opens_value)) > limits.nodes)
    throw InputError({file, 1, 1}, fmt::format("more than {} brackets and commas", limits.nodes));
  TreeBuilder builder(file, limits, errors);
  std::shared_ptr<const Tree> root;
  EventReader reader(text);
  while (const yaml_event_t* event = reader.next()) {
    if (event->type == YAML_DOCUMENT_START_EVENT && root) {
      const yaml_event_t* next = reader.next();
      if (!next) break;
      throw InputError(
          {file, static_cast<int>(next->start_mark.line) + 1, static_cast<int>(next->start_mark.column) + 1},
          "a second YAML document; a model file has only one");
    }
    builder.take(*event);
    if (event->type == YAML_DOCUMENT_END_EVENT) root = builder.root;
  }
  if (reader.failed()) throw_fault(reader, text, file);
  if (!root || root->kind == Tree::Kind::null)
    throw InputError({file, 1, 1}, "the file is empty; a model starts with 'mimbre: 1'");
  return root;
}

}  // namespace mimbre::model_file
