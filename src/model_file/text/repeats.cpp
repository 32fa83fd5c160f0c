#include "model_file/text/repeats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <unordered_map>

#include "model_file/text/scanning.h"

namespace mimbre::model_file {
namespace {

/// The values that an index takes, one after the other.
struct Index {
  std::string name;
  std::vector<ParameterValue> values;
};

bool in_a_name(char c) { return is_digit(c) || starts_name(c) || c == '.'; }

/// Behind the bracket that closes the one at `open`; npos where none does.
std::size_t closing(const std::string& text, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < text.size(); ++i) {
    if (text[i] == '(') ++depth;
    if (text[i] == ')' && --depth == 0) return i + 1;
  }
  return std::string::npos;
}

/// Whether anything in it is to be written out.
bool concerned(const Tree& tree) {
  if (tree.kind == Tree::Kind::scalar) return tree.text.find("$(") != std::string::npos;
  const auto entry = [](const Tree::Entry& e) {
    return e.key == "for" || e.key.find("$(") != std::string::npos || concerned(*e.value);
  };
  return std::any_of(tree.items.begin(), tree.items.end(),
                     [](const auto& item) { return concerned(*item); }) ||
         std::any_of(tree.entries.begin(), tree.entries.end(), entry);
}

class Writer {
 public:
  Writer(const Reading& reading, const std::string& instance) : reading_(reading), instance_(instance) {}

  std::shared_ptr<const Tree> section(const std::string& key, const std::shared_ptr<const Tree>& tree) {
    return write(tree, *reading_.scope, key);
  }

 private:
  using TreePointer = std::shared_ptr<const Tree>;

  TreePointer write(const TreePointer& tree, const Scope& scope, const std::string& what) {
    const bool repeated = &scope != reading_.scope;
    if (!repeated && !concerned(*tree)) return tree;
    auto made = std::make_shared<Tree>();
    made->kind = tree->kind;
    made->mark = tree->mark;
    made->text = tree->kind == Tree::Kind::scalar ? text(tree->text, tree->mark, scope, what) : "";
    for (const TreePointer& item : tree->items)
      each(*item, scope, what, [&](const Scope& inner) {
        grow(item->mark);
        made->items.push_back(write(without_for(item), inner, what));
      });
    std::unordered_map<std::string, int> lines;
    for (const Tree::Entry& entry : tree->entries)
      each(*entry.value, scope, fmt::format("{}: '{}'", what, entry.key), [&](const Scope& inner) {
        const std::string key = text(entry.key, entry.mark, inner, what);
        const auto [place, fresh] = lines.emplace(key, entry.mark.line);
        if (!fresh) return twice(key, entry, place->second, what);
        if (key != entry.key) reading_.errors->stands_for(full(key), full(entry.key), instance_);
        grow(entry.mark);
        made->entries.push_back(
            {key, entry.mark, write(without_for(entry.value), inner, fmt::format("{}: '{}'", what, key))});
      });
    for (const TreePointer& item : made->items) made->size += item->size;
    for (const Tree::Entry& entry : made->entries) made->size += entry.value->size;
    return made;
  }

  std::string full(const std::string& key) const { return instance_.empty() ? key : instance_ + "." + key; }

  void twice(const std::string& key, const Tree::Entry& entry, int line, const std::string& what) {
    const bool same = line == entry.mark.line;
    reading_.errors->add(
        entry.mark, same
                        ? fmt::format("{}: '{}' is repeated under one name; put an index in it, such as {}$i",
                                      what, key, key)
                        : fmt::format("{}: '{}' is given twice (first in line {}); remove or rename one",
                                      what, key, line));
  }

  void grow(const Mark& mark) {
    if (++count_ > reading_.limits->nodes)
      throw InputError(mark, fmt::format("more than {} values when all that is repeated is written out",
                                         reading_.limits->nodes));
  }

  /// Calls once for each combination of the indices under `for`; once where there is none.
  template <class Call>
  void each(const Tree& tree, const Scope& scope, const std::string& what, const Call& call) {
    const Tree::Entry* repeat = tree.kind == Tree::Kind::map ? tree.find("for") : nullptr;
    if (!repeat) return call(scope);
    Reading reading = reading_;
    reading.scope = &scope;
    combine(indices(Value(reading, *repeat->value, what + ": for")), 0, scope, call);
  }

  template <class Call>
  void combine(const std::vector<Index>& indices, std::size_t k, const Scope& scope, const Call& call) {
    if (k == indices.size()) return call(scope);
    Scope words;  // which can be compared with each other
    words.outer = &scope;
    int known = 0;
    for (const Scope* s = &scope; s; s = s->outer) known += static_cast<int>(s->words.size());
    for (const ParameterValue& value : indices[k].values)
      if (const auto* word = std::get_if<std::string>(&value); word && !words.find_word(*word))
        words.words[*word] = ++known;
    for (const ParameterValue& value : indices[k].values) {
      Scope inner;
      inner.outer = &words;
      inner.values[indices[k].name] = value;
      combine(indices, k + 1, inner, call);
    }
  }

  std::vector<Index> indices(const Value& value) {
    std::vector<Index> result;
    if (!value.is_map() || value.tree().entries.empty()) {
      value.error(
          "indices with what they run over are needed, for example {i: {from: 1, to: 9}} or {side: [left, "
          "right]}");
      return {{"", {}}};
    }
    for (const auto& entry : value.tree().entries) {
      const Value over(value.reading(), *entry.value, fmt::format("{}: {}", value.what(), entry.key));
      if (entry.key.empty() || !starts_name(entry.key[0]) || name_end(entry.key, 0) != entry.key.size())
        over.error(fmt::format(
            "'{}' is no name for an index; it has letters from a to z and A to Z, digits and '_' only",
            entry.key));
      else
        result.push_back({entry.key, over.is_list() ? listed(over) : range(over)});
    }
    return result;
  }

  std::vector<ParameterValue> range(const Value& value) {
    const Fields fields(value, {"from", "to", "by"});
    constexpr int largest = 1'000'000'000;
    const auto whole = [&](const char* key, const char* example) -> std::optional<int> {
      const auto given = fields.need(key, example);
      return given ? given->integer(-largest, largest) : std::nullopt;
    };
    if (!value.has_fields()) return {};
    const auto from = whole("from", "1"), to = whole("to", "9");
    int by = 1;
    if (const auto given = fields.get("by")) by = given->integer(-largest, largest).value_or(1);
    if (by == 0) fields.get("by")->error("is 0; the index would never come to its end");
    std::vector<ParameterValue> values;
    if (!from || !to || by == 0) return values;
    if ((std::int64_t{*to} - *from) / by > static_cast<std::int64_t>(reading_.limits->nodes)) {
      value.error(fmt::format("are more than {} values", reading_.limits->nodes));
      return values;
    }
    for (std::int64_t k = *from; by > 0 ? k <= *to : k >= *to; k += by)
      values.emplace_back(static_cast<double>(k));
    return values;
  }

  std::vector<ParameterValue> listed(const Value& value) {
    std::vector<ParameterValue> values;
    for (const Value& item : value.list()) {
      const auto word = item.word();
      if (!word) continue;
      try {
        values.emplace_back(evaluate(item.tree().text, *value.reading().scope, quantity::any));
      } catch (const ExpressionError&) {
        values.emplace_back(*word);
      }
    }
    return values;
  }

  /// `text` with the values of what stands behind each '$'.
  std::string text(const std::string& text, const Mark& mark, const Scope& scope, const std::string& what) {
    std::string result;
    for (std::size_t i = 0; i < text.size();) {
      const std::size_t dollar = text.find('$', i);
      result += text.substr(i, dollar - i);
      if (dollar == std::string::npos) break;
      std::size_t end = dollar + 1;
      std::string value = "$";
      try {
        if (end < text.size() && text[end] == '(') {
          end = closing(text, dollar + 1);
          if (end == std::string::npos)
            throw ExpressionError(fmt::format("'{}': the bracket behind '$' is not closed", text));
          value = value_of(text.substr(dollar + 2, end - dollar - 3), scope);
        } else if (end < text.size() && starts_name(text[end])) {
          end = name_end(text, end);
          const std::string name = text.substr(dollar + 1, end - dollar - 1);
          value = is_index(name, scope) ? to_text(*scope.find(name)) : "$" + name;
        }
      } catch (const ExpressionError& error) {
        reading_.errors->add(mark, fmt::format("{}: {}", what, error.what()));
        end = std::min(end, text.size());
      }
      // A negative number within an expression; at the end of a name, and alone, it stands as it is.
      const bool alone = dollar == 0 && end == text.size(), named = dollar > 0 && in_a_name(text[dollar - 1]);
      result += value.starts_with('-') && !alone && !named ? "(" + value + ")" : value;
      i = end;
    }
    return result;
  }

  bool is_index(const std::string& name, const Scope& scope) const {
    for (const Scope* s = &scope; s && s != reading_.scope; s = s->outer)
      if (s->values.contains(name)) return true;
    return false;
  }

  static std::string value_of(const std::string& expression, const Scope& scope) {
    const std::size_t first = expression.find_first_not_of(' ');
    if (first == std::string::npos) throw ExpressionError("'$()' is empty");
    if (expression.find('?') != std::string::npos && expression.find('$') == std::string::npos) {
      try {
        return to_text(evaluate(expression, scope, quantity::any));
      } catch (const ExpressionError&) {
        return evaluate_word(expression, scope);
      }
    }
    const std::string name = expression.substr(first, expression.find_last_not_of(' ') + 1 - first);
    if (const ParameterValue* value = scope.find(name)) return to_text(*value);
    return to_text(evaluate(expression, scope, quantity::any));
  }

  static TreePointer without_for(const TreePointer& tree) {
    if (tree->kind != Tree::Kind::map || !tree->find("for")) return tree;
    auto rest = std::make_shared<Tree>(*tree);
    std::erase_if(rest->entries, [](const Tree::Entry& entry) { return entry.key == "for"; });
    return rest;
  }

  const Reading& reading_;
  const std::string& instance_;
  std::size_t count_ = 0;
};

}  // namespace

std::shared_ptr<const Tree> written_out(const std::shared_ptr<const Tree>& tree, const Reading& reading,
                                        const std::string& instance) {
  static const std::vector<std::string> as_they_are{"mimbre",  "title",      "parameters",
                                                    "require", "subsystems", "include"};
  const auto stays = [&](const std::string& key) {
    return std::find(as_they_are.begin(), as_they_are.end(), key) != as_they_are.end();
  };
  if (std::none_of(tree->entries.begin(), tree->entries.end(),
                   [&](const Tree::Entry& entry) { return !stays(entry.key) && concerned(*entry.value); }))
    return tree;
  Writer writer(reading, instance);
  auto made = std::make_shared<Tree>(*tree);
  made->size = 1;
  for (Tree::Entry& entry : made->entries) {
    if (!stays(entry.key)) entry.value = writer.section(entry.key, entry.value);
    made->size += entry.value->size;
  }
  return made;
}

}  // namespace mimbre::model_file
