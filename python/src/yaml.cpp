#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <optional>

#include "bindings.h"
#include "model_file/text/expression.h"
#include "model_file/text/tree.h"

/// YAML as model files have it, for other files that are read in Python: the same bounds, messages, numbers.
namespace mimbre::python {
namespace {

using model_file::Tree;

/// (kind, line, column, content): of a map keys with their places, and values.
nb::object to_python(const Tree& tree) {
  nb::list content;
  switch (tree.kind) {
    case Tree::Kind::null:
      return nb::make_tuple("null", tree.mark.line, tree.mark.column, nb::none());
    case Tree::Kind::scalar:
      return nb::make_tuple("scalar", tree.mark.line, tree.mark.column, tree.text);
    case Tree::Kind::list:
      for (const auto& item : tree.items) content.append(to_python(*item));
      return nb::make_tuple("list", tree.mark.line, tree.mark.column, content);
    case Tree::Kind::map:
      for (const Tree::Entry& entry : tree.entries)
        content.append(
            nb::make_tuple(entry.key, entry.mark.line, entry.mark.column, to_python(*entry.value)));
      return nb::make_tuple("map", tree.mark.line, tree.mark.column, content);
  }
  return nb::none();
}

nb::object parse(const std::string& text, const std::string& file) {
  std::vector<Diagnostic> errors;
  const auto tree = model_file::parse_yaml(text, file, {}, errors);
  if (!errors.empty()) throw InputError(std::move(errors));
  return to_python(*tree);
}

/// The number that an expression of a model file is, or nothing where it is none.
std::optional<double> number(const std::string& text, bool seconds) {
  try {
    return model_file::evaluate(text, {},
                                seconds ? model_file::quantity::time : model_file::quantity::number);
  } catch (const model_file::ExpressionError&) {
    return {};
  }
}

}  // namespace

void bind_yaml(nb::module_& module) {
  module.def("yaml", &parse, nb::arg("text"), nb::arg("file"));
  module.def("number", &number, nb::arg("text"), nb::arg("seconds") = false);
}

}  // namespace mimbre::python
