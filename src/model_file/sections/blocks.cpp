#include "model_file/sections/blocks.h"

#include <fmt/format.h>

#include <cmath>

#include "spec/block_types.h"

namespace mimbre::model_file {
namespace {

/// A formula of time, inputs, signals and outputs.
std::optional<spec::Law> input_formula(Builder& builder, const Part& part, const Value& text) {
  auto law = read_formula(builder, part, {{text, variables_of(LawOf::time)}}, {"t"}, quantity::any);
  if (law) law->arguments.insert(law->arguments.begin(), spec::Source{});
  return law;
}

/// 0.
spec::Law nothing() { return {Formula::expression("0", {}), {}}; }

/// Numbers of a matrix: one, a row of them (`column`: which is a column), or rows.
std::optional<Eigen::MatrixXd> read_matrix(const Value& value, bool column = false) {
  if (value.is_scalar()) {
    const auto number = value.number(quantity::any);
    if (!number) return {};
    return Eigen::MatrixXd::Constant(1, 1, *number);
  }
  const auto rows = value.list();
  if (rows.empty()) return {};
  if (!rows.front().is_list()) {
    const auto numbers = value.numbers(1, 1000, quantity::any);
    if (!numbers) return {};
    const Eigen::Map<const Eigen::VectorXd> v(numbers->data(), std::ssize(*numbers));
    return column ? Eigen::MatrixXd(v) : Eigen::MatrixXd(v.transpose());
  }
  Eigen::MatrixXd m;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto numbers = rows[r].numbers(1, 1000, quantity::any);
    if (!numbers) return {};
    if (r == 0) m.resize(std::ssize(rows), std::ssize(*numbers));
    if (std::ssize(*numbers) != m.cols()) {
      rows[r].error(fmt::format("has {} numbers, the first row has {}", numbers->size(), m.cols()));
      return {};
    }
    m.row(static_cast<Eigen::Index>(r)) =
        Eigen::Map<const Eigen::RowVectorXd>(numbers->data(), std::ssize(*numbers));
  }
  return m;
}

void read_numbers(const BlockInfo& info, const Fields& fields, spec::Block& block) {
  for (const LawNumber& number : info.numbers) {
    const std::string key(number.key);
    double read = number.otherwise;
    // What has a word of its own.
    const bool said = key == "uniform" || (key == "falling" && !fields.has(key) && fields.has("rising"));
    if (const auto given = fields.get(key)) {
      if (const auto x = given->number(number.unit == "s" ? quantity::time : quantity::any)) {
        read = *x;
        if (!number.allows(read)) given->error(wrong_number(number, read));
      }
    } else if (std::isnan(read) && !said) {
      fields.error(fmt::format("'{}' is missing: {}{}", key, number.about, number.unit.empty() ? "" : ", s"));
      read = number.above >= 0 ? 1 : 0;
    }
    block.numbers.push_back(read);
  }
}

/// Matrices by their keys; those that may be left out are empty then.
void read_matrices(const BlockInfo& info, const Fields& fields, spec::Block& block) {
  for (const std::string_view name : info.matrices) {
    const std::string key(name);
    const bool optional = key == "D" || key == "initial";
    Eigen::MatrixXd m;
    if (const auto given =
            optional ? fields.get(key) : fields.need(key, key == "A" ? "[[0, 1], [-4, -1]]" : "[1, 2]"))
      m = read_matrix(*given, key == "B" || key == "initial").value_or(m);
    block.matrices.push_back(std::move(m));
  }
}

void read_inputs_of(Builder& builder, const Part& part, const Fields& fields, const Value& main,
                    const BlockInfo& info, spec::Block& block) {
  if (info.inputs == 0) return;
  const auto add = [&](const Value& text) {
    if (auto law = input_formula(builder, part, text)) block.inputs.push_back(std::move(*law));
  };
  if (main.is_list()) {
    for (const Value& each : main.list()) add(each);
  } else {
    add(main);
  }
  if (info.name == "pid") {
    if (const auto setpoint = fields.get("setpoint"))
      add(*setpoint);
    else
      block.inputs.push_back(nothing());
  }
}

std::vector<std::string> keys_of(const BlockInfo& info) {
  std::vector<std::string> keys{std::string(info.key), "every", "unit", "about"};
  for (const LawNumber& number : info.numbers)
    if (number.key != "uniform") keys.emplace_back(number.key);
  for (const std::string_view name : info.matrices) keys.emplace_back(name);
  if (info.name == "pid") keys.emplace_back("setpoint");
  if (info.name == "state_space") keys.emplace_back("outputs");
  if (info.name == "table") keys.insert(keys.end(), {"points", "interpolation"});
  return keys;
}

Function read_points_of(const Fields& fields) {
  const auto points = fields.need("points", "[[0, 0], [1, 2]]");
  int cubic = 0;
  if (const auto interpolation = fields.get("interpolation"))
    cubic = interpolation->choice({"linear", "cubic"}).value_or(0);
  const auto read = points ? read_points(*points, cubic == 0, quantity::any, quantity::any) : std::nullopt;
  if (!read) return {};
  return Function::table(read->first, read->second,
                         cubic ? Function::Interpolation::cubic : Function::Interpolation::linear);
}

}  // namespace

int block_of(const Tree& description) {
  if (description.kind != Tree::Kind::map) return -1;
  for (const BlockInfo& info : block_table)
    if (const Tree::Entry* entry = description.find(std::string(info.key))) {
      const bool two = info.key == "table" && entry->value->kind == Tree::Kind::list;
      return find_block(two ? "table_2d" : info.name);
    }
  return -1;
}

std::vector<std::string> output_names(const Tree& description) {
  std::vector<std::string> names;
  const Tree::Entry* outputs = description.find("state_space") ? description.find("outputs") : nullptr;
  if (outputs && outputs->value->kind == Tree::Kind::list)
    for (const auto& item : outputs->value->items) names.push_back(item->text);
  return names;
}

void read_block(Builder& builder, const Part& part, const Value& value, const std::string& name, int type,
                const std::vector<std::size_t>& signals) {
  const BlockInfo& info = block_table[static_cast<std::size_t>(type)];
  const Fields fields(value, keys_of(info));
  spec::Block block;
  block.name = name;
  block.mark = value.mark();
  block.type = std::string(info.name);
  const std::size_t errors = builder.errors.list.size();
  if (const auto every = fields.get("every")) block.every = every->positive(quantity::time).value_or(1);
  const auto main = fields.need(std::string(info.key), "angle");
  if (!main) return;
  read_inputs_of(builder, part, fields, *main, info, block);
  read_numbers(info, fields, block);
  read_matrices(info, fields, block);
  if (info.name == "table") block.function = read_points_of(fields);
  if (info.name == "noise") block.numbers.back() = main->choice({"normal", "uniform"}).value_or(0);
  if (info.name == "rate_limit" && !fields.has("falling")) block.numbers[1] = -block.numbers[0];
  if (builder.errors.list.size() > errors) return;
  const auto outputs = block.type == "state_space" ? block.matrices[2].rows() : 1;
  if (outputs != std::ssize(signals))
    return value.error(fmt::format("has {} outputs and {} names: outputs: [..] gives each of several its own",
                                   outputs, signals.size()));
  for (std::size_t k = 0; k < signals.size(); ++k) {
    spec::Signal& signal = builder.model.signals[signals[k]];
    signal.block = static_cast<int>(builder.model.blocks.size());
    signal.output = static_cast<int>(k);
  }
  builder.model.blocks.push_back(std::move(block));
}

}  // namespace mimbre::model_file
