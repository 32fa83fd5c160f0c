#pragma once
#include <Eigen/Core>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mimbre/diagnostics.h"
#include "model_file/text/expression.h"
#include "model_file/text/limits.h"
#include "model_file/text/tree.h"

namespace mimbre::model_file {

/// Collects mistakes while reading goes on. Throws InputError with all of them once there are
/// `limits.errors`. What is wrong in a template, or in what is repeated, is reported once, with where it is.
class Errors {
 public:
  explicit Errors(const Limits& limits) : limits_(limits) {}
  void add(const Mark& mark, const std::string& message);
  void throw_if_any() const;
  /// `name`, of an instance: messages that differ by it alone, at one place, are one.
  void instance(const std::string& name) { common_[name] = ""; }
  /// `name`, of one of many items that are written once as `pattern`, in `instance` (empty: the model).
  void stands_for(const std::string& name, const std::string& pattern, const std::string& instance) {
    common_[name] = instance.empty() ? pattern : pattern.substr(instance.size() + 1);
  }
  std::vector<Diagnostic> list;

 private:
  /// A mistake in what is there several times: its place in `list`, the words that all have in common, where
  /// it is.
  struct Several {
    std::size_t index;
    std::string words;
    std::vector<std::string> where;
    std::set<std::string> places;
  };
  bool merged(const Mark& mark, const std::string& message);
  std::string in_common(const std::string& message, std::string& where) const;

  const Limits& limits_;
  std::map<std::string, std::string>
      common_;  ///< what names of instances and of repeated items have in common
  std::vector<Several> several_;
};

/// What reading a value needs beside the value: the parameters in sight and where mistakes go.
struct Reading {
  const Scope* scope = nullptr;
  Errors* errors = nullptr;
  const Limits* limits = nullptr;
};

/// A YAML value, and how messages call it ("body 'arm': mass"). A reader that fails records why and returns
/// nothing.
class Value {
 public:
  Value(const Reading& reading, const Tree& tree, std::string what)
      : reading_(&reading), tree_(&tree), what_(std::move(what)) {}

  const Tree& tree() const { return *tree_; }
  const std::string& what() const { return what_; }
  const Mark& mark() const { return tree_->mark; }
  const Reading& reading() const { return *reading_; }
  bool is_map() const { return tree_->kind == Tree::Kind::map; }
  bool is_list() const { return tree_->kind == Tree::Kind::list; }
  bool is_scalar() const { return tree_->kind == Tree::Kind::scalar; }
  bool is_null() const { return tree_->kind == Tree::Kind::null; }
  /// Fields can be read from it: nothing at all counts as no fields, so that missing ones are reported.
  bool has_fields() const { return is_map() || is_null(); }

  void error(const std::string& message) const;

  // Numbers are SI; where they may have a unit, it is one of `of`.
  std::optional<double> number(const Quantity& of = quantity::number) const;
  std::optional<double> positive(const Quantity& of = quantity::number) const;      ///< > 0
  std::optional<double> not_negative(const Quantity& of = quantity::number) const;  ///< ≥ 0
  std::optional<int> integer(int smallest, int largest) const;
  std::optional<bool> flag() const;
  /// A text with `$name` and `condition ? word : word` done.
  std::optional<std::string> word() const;
  /// A text for people, where only `$name` is replaced.
  std::optional<std::string> text() const;
  /// A word that is one of `choices`: its index.
  std::optional<int> choice(const std::vector<std::string>& choices) const;
  std::optional<Eigen::Vector3d> triple(const Quantity& of = quantity::number) const;
  std::optional<Eigen::Vector3d> direction() const;  ///< a triple of length > 0, made a unit vector
  std::optional<std::vector<double>> numbers(std::size_t fewest, std::size_t most,
                                             const Quantity& of = quantity::number) const;
  std::vector<Value> list() const;  ///< empty, with an error, when it is no list

 private:
  const Reading* reading_;
  const Tree* tree_;
  std::string what_;
};

/// The entries of a map whose keys are known.
class Fields {
 public:
  /// Records an error when `value` is no map, and one per unknown key.
  Fields(const Value& value, std::initializer_list<const char*> known);
  Fields(const Value& value, const std::vector<std::string>& known);

  /// Nothing where the key is absent or its value empty.
  std::optional<Value> get(const std::string& key) const;
  /// Records an error where it is absent; `example` shows what would be right.
  std::optional<Value> need(const std::string& key, const std::string& example) const;
  bool has(const std::string& key) const { return get(key).has_value(); }
  const Value& value() const { return value_; }
  void error(const std::string& message) const { value_.error(message); }

  double number(const std::string& key, double fallback, const Quantity& of = quantity::number) const;

 private:
  Value value_;
};

/// Whether names of items may have it: letters, digits, '_', '-', '.', what is beyond ASCII.
bool in_an_item_name(char c);
/// True for names that items may have; records an error otherwise.
bool check_name(const Reading& reading, const std::string& name, const Mark& mark, const std::string& kind);

std::string joined(const std::vector<std::string>& words);
std::string to_text(const Eigen::Vector3d& v);

}  // namespace mimbre::model_file
