#include "model_file/text/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace mimbre::model_file {
namespace {

/// A parameter as declared: its value's text, the words or range it may have.
struct Declaration {
  std::string what, about;
  const Tree* value = nullptr;
  std::vector<std::string> choices;
  bool name = false;  ///< of an item
  double min = -INFINITY;
  double max = INFINITY;
  bool integer = false;
  bool tunable = false;
};

bool good_name(const std::string& name) {
  return !name.empty() && name.size() <= 100 && !std::isdigit(static_cast<unsigned char>(name[0])) &&
         std::all_of(name.begin(), name.end(),
                     [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; });
}

/// Names that expressions use themselves.
bool reserved(const std::string& name) {
  static const std::vector<std::string> names{"pi", "true", "false"};
  return is_function_name(name) || is_variable_name(name) ||
         std::find(names.begin(), names.end(), name) != names.end();
}

/// " ('l' is a spring's length in laws)"
std::string meaning_in_laws(const std::string& name) {
  static const std::map<std::string, std::string> meanings{{"l", "a spring's length"},
                                                           {"x", "a joint's coordinate"},
                                                           {"v", "the rate of a length"},
                                                           {"t", "time"}};
  const auto found = meanings.find(name);
  return found == meanings.end() ? "" : fmt::format(" ('{}' is {} in laws)", name, found->second);
}

std::optional<Declaration> read_declaration(const Value& value) {
  Declaration result;
  result.what = value.what();
  if (value.is_scalar()) {
    result.value = &value.tree();
    return result;
  }
  const Fields fields(value, {"value", "name", "choices", "min", "max", "integer", "tunable", "about"});
  if (!value.is_map()) {
    if (value.is_null())
      value.error("has no value; for example 1.5, or {value: rigid, choices: [rigid, flexible]}");
    return {};
  }
  if (const auto name = fields.get("name")) {
    for (const char* other : {"value", "choices", "min", "max", "integer", "tunable"})
      if (fields.has(other)) name->error(fmt::format("a name has no '{}'", other));
    result.name = name->is_scalar();
    result.value = &name->tree();
    if (result.name) return result;
    name->error("the name of an item is needed, such as ground");
    return {};
  }
  if (const auto about = fields.get("about"); about && about->is_scalar()) result.about = about->tree().text;
  const auto given = fields.need("value", "1.5");
  if (!given) return {};
  if (!given->is_scalar()) {
    given->error("a number or a word is needed");
    return {};
  }
  result.value = &given->tree();
  if (const auto choices = fields.get("choices")) {
    for (const Value& choice : choices->list()) {
      if (!choice.is_scalar() || !good_name(choice.tree().text))
        choice.error("choices are words of letters from a to z and A to Z, digits and '_'");
      else
        result.choices.push_back(choice.tree().text);
    }
    if (fields.has("min") || fields.has("max") || fields.has("integer"))
      choices->error("words have no min, max or integer");
    if (result.choices.empty()) return {};
  }
  result.min = fields.number("min", -INFINITY, quantity::any);
  result.max = fields.number("max", INFINITY, quantity::any);
  if (const auto integer = fields.get("integer")) result.integer = integer->flag().value_or(false);
  if (const auto tunable = fields.get("tunable")) {
    result.tunable = tunable->flag().value_or(false);
    if (result.tunable && (!result.choices.empty() || result.integer))
      tunable->error("only a number can change during a run, no word and no whole number");
  }
  return result;
}

/// The value of a declared parameter from `text`; throws ExpressionError saying what would be right.
ParameterValue value_from_text(const Declaration& d, const std::string& text, const Scope& scope) {
  if (d.name) {
    const std::string word = evaluate_word(text, scope);
    if (word.empty() || word.size() > 200 || !std::all_of(word.begin(), word.end(), in_an_item_name))
      throw ExpressionError(fmt::format("'{}' is no name of an item", word.substr(0, 100)));
    return word;
  }
  if (!d.choices.empty()) {
    const std::string word = evaluate_word(text, scope);
    if (std::find(d.choices.begin(), d.choices.end(), word) == d.choices.end())
      throw ExpressionError(
          fmt::format("'{}' is not one of {}{}", word, joined(d.choices), did_you_mean(word, d.choices)));
    return word;
  }
  const double number = evaluate(text, scope, quantity::any);
  if (number < d.min || number > d.max || (d.integer && number != std::floor(number)))
    throw ExpressionError(fmt::format("{} is not {}", number, range_text(d.min, d.max, d.integer)));
  return number;
}

/// Whether an expression names a parameter. A word behind a number is its unit.
bool names_parameter(const std::string& text, const Scope& scope) {
  const auto in_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  char before = 0;
  for (std::size_t k = 0; k < text.size();) {
    std::size_t end = k;
    while (end < text.size() && in_word(text[end])) ++end;
    const bool starts = end > k && !std::isdigit(static_cast<unsigned char>(text[k]));
    if (starts && !std::isdigit(static_cast<unsigned char>(before)) && scope.find(text.substr(k, end - k)))
      return true;
    if (end == k) ++end;
    if (text[end - 1] != ' ') before = text[end - 1];
    k = end;
  }
  return false;
}

}  // namespace

std::string range_text(double min, double max, bool integer) {
  const std::string kind = integer ? "a whole number" : "a number";
  if (std::isfinite(min) && std::isfinite(max)) return fmt::format("{} from {} to {}", kind, min, max);
  if (std::isfinite(min)) return fmt::format("{} of at least {}", kind, min);
  if (std::isfinite(max)) return fmt::format("{} of at most {}", kind, max);
  return kind;
}

void read_parameters(const Value& section, const std::map<std::string, std::string>& given, Scope& scope,
                     std::vector<DeclaredParameter>* declared) {
  Errors& errors = *section.reading().errors;
  if (!section.is_map()) {
    if (!section.is_null()) section.error("names with values are needed, for example length: 1.5");
  }
  for (const auto& entry : section.tree().entries) {
    const std::string what = fmt::format("parameter '{}'", entry.key);
    if (!good_name(entry.key)) {
      errors.add(entry.mark,
                 fmt::format("{}: a parameter's name has letters from a to z and A to Z, digits and '_' only",
                             what));
      continue;
    }
    if (reserved(entry.key)) {
      errors.add(entry.mark, fmt::format("{}: the name is taken by expressions{}; choose another", what,
                                         meaning_in_laws(entry.key)));
      if (!is_variable_name(entry.key)) continue;  // else it is read, for what uses it
    }
    // Expressions may use the parameters above, so this scope is the one to read in.
    Reading reading = section.reading();
    reading.scope = &scope;
    const auto declaration = read_declaration(Value(reading, *entry.value, what));
    if (!declaration) {
      scope.values[entry.key] = 0.0;
      continue;
    }
    for (const std::string& word : declaration->choices)
      if (!scope.find_word(word)) {
        int count = 0;
        for (const Scope* s = &scope; s; s = s->outer) count += static_cast<int>(s->words.size());
        scope.words[word] = count + 1;
      }
    for (const std::string& word : declaration->choices) scope.chosen_by.emplace(word, entry.key);
    const auto replaced = given.find(entry.key);
    ParameterValue value = 0.0;
    if (!declaration->choices.empty()) value = declaration->choices.front();
    if (declaration->name) value = std::string("ground");
    try {
      value = value_from_text(*declaration, declaration->value->text, scope);
    } catch (const ExpressionError& e) {
      std::string words = e.what();
      for (const auto& later : section.tree().entries)
        if (words.starts_with(fmt::format("'{}' is not a parameter", later.key)))
          words = fmt::format("'{}' is not known yet; a parameter can only use those above it", later.key);
      errors.add(declaration->value->mark, fmt::format("{}: {}", what, words));
    }
    if (replaced != given.end()) {
      try {
        value = value_from_text(*declaration, replaced->second, scope);
      } catch (const ExpressionError& e) {
        errors.add({}, fmt::format("{} set to '{}': {}", what, replaced->second, e.what()));
      }
    }
    if (const double* number = std::get_if<double>(&value); number && declaration->tunable)
      scope.tunables[entry.key] = {*number, declaration->min, declaration->max, entry.mark};
    if (declared)
      declared->push_back({entry.key, declaration->about, value, declaration->min, declaration->max,
                           declaration->integer, declaration->tunable,
                           replaced == given.end() && names_parameter(declaration->value->text, scope)});
    scope.values[entry.key] = std::move(value);
  }
}

void report_unknown(const std::map<std::string, std::string>& given, const Scope& scope,
                    const Reading& reading) {
  std::vector<std::string> names;
  for (const auto& [name, value] : scope.values) names.push_back(name);
  for (const auto& [name, value] : given)
    if (!scope.values.contains(name))
      reading.errors->add({}, fmt::format("there is no parameter '{}' to set to '{}'{}; {}", name, value,
                                          did_you_mean(name, names),
                                          names.empty() ? "there are none" : "there are: " + joined(names)));
}

std::map<std::string, std::string> read_given(const Value& section) {
  std::map<std::string, std::string> result;
  if (!section.is_map()) {
    section.error("names with values are needed, for example {radius: 0.36}");
    return result;
  }
  for (const auto& entry : section.tree().entries) {
    const Value value(section.reading(), *entry.value, fmt::format("{}: {}", section.what(), entry.key));
    if (!value.is_scalar()) {
      value.error("a number or a word is needed");
      continue;
    }
    // A word stays as it is; an expression is evaluated here, among the model's parameters.
    const Scope& scope = *section.reading().scope;
    std::string word = value.tree().text;
    try {
      word = evaluate_word(word, scope);
    } catch (const ExpressionError&) {
      // No choice between words: then it is a number, or wrong and reported by who takes it.
    }
    if (!scope.find_word(word)) {
      try {
        word = fmt::format("{:.17g}", evaluate(value.tree().text, scope, quantity::any));
      } catch (const ExpressionError&) {
        // Left to who takes it, who knows what is needed.
      }
    }
    result[entry.key] = word;
  }
  return result;
}

void read_requirements(const Value& section) {
  for (const Value& item : section.list()) {
    const Fields fields(item, {"that", "message"});
    const auto that = fields.need("that", "\"stairs >= 0\"");
    const auto message = fields.need("message", "stairs go down");
    if (!that || !message) continue;
    const auto holds = that->number(quantity::any);
    const auto text = message->text();
    if (holds && text && *holds == 0) item.error(*text);
  }
}

}  // namespace mimbre::model_file
