#include "model_file/sections/blocks.h"

#include <fmt/format.h>

#include <cmath>

#include "model_file/sections/fmu_block.h"
#include "model_file/text/file_reader.h"
#include "spec/block_info.h"

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
    if (const auto given = fields.get(key)) {
      const auto x = given->number(number.unit == "s" ? quantity::time : quantity::any);
      read = x.value_or(number.above >= 0 ? 1 : 0);
      if (x && !number.allows(read)) given->error(wrong_number(number, read));
    }
    block.numbers.push_back(read);
  }
  if (info.complete) info.complete(block.numbers);
  for (std::size_t k = 0; k < block.numbers.size(); ++k) {
    const LawNumber& number = info.numbers[k];
    if (!std::isnan(block.numbers[k]) || fields.has(std::string(number.key))) continue;
    fields.error(
        fmt::format("'{}' is missing: {}{}", number.key, number.about, number.unit.empty() ? "" : ", s"));
    block.numbers[k] = number.above >= 0 ? 1 : 0;
  }
}

/// Matrices by their keys; those that may be left out are empty then.
void read_matrices(const BlockInfo& info, const Fields& fields, spec::Block& block) {
  const char* const example = info.inputs < 0 ? "[[0, 1], [-4, -1]]" : "[1, 2]";
  for (const BlockMatrix& matrix : info.matrices) {
    const std::string key(matrix.key);
    Eigen::MatrixXd m;
    if (const auto given = matrix.optional ? fields.get(key) : fields.need(key, example))
      m = read_matrix(*given, matrix.column).value_or(m);
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
  if (!info.second.empty()) {
    if (const auto second = fields.get(std::string(info.second)))
      add(*second);
    else
      block.inputs.push_back(nothing());
  }
}

/// Whether the number is the place of a word among those that stand at the type's key.
bool is_word(const BlockInfo& info, const LawNumber& number) {
  return !info.words.empty() && &number == &info.numbers.back();
}

std::vector<std::string> keys_of(const BlockInfo& info) {
  std::vector<std::string> keys{std::string(info.key), "every", "unit", "about"};
  for (const LawNumber& number : info.numbers)
    if (!is_word(info, number)) keys.emplace_back(number.key);
  for (const BlockMatrix& matrix : info.matrices) keys.emplace_back(matrix.key);
  if (!info.second.empty()) keys.emplace_back(info.second);
  if (info.outside) {
    const std::vector<std::string> further = fmu_keys();
    keys.insert(keys.end(), further.begin(), further.end());
  } else if (info.named_outputs) {
    keys.emplace_back("outputs");
  }
  if (info.points) keys.insert(keys.end(), {"points", "interpolation"});
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
  int found = -1;
  for (const BlockInfo* info : all_blocks()) {
    const Tree::Entry* entry = description.find(std::string(info->key));
    if (!entry || (info->list && entry->value->kind != Tree::Kind::list)) continue;
    if (info->list) return find_block(info->name);
    if (found < 0) found = find_block(info->name);
  }
  return found;
}

std::vector<std::string> output_names(const Tree& description) {
  std::vector<std::string> names;
  const int type = block_of(description);
  if (type >= 0 && block_info(type).outside) return fmu_output_names(description);
  const Tree::Entry* outputs =
      type >= 0 && block_info(type).named_outputs ? description.find("outputs") : nullptr;
  if (outputs && outputs->value->kind == Tree::Kind::list)
    for (const auto& item : outputs->value->items) names.push_back(item->text);
  return names;
}

void read_block(Builder& builder, const Part& part, const Value& value, const std::string& name, int type,
                const std::vector<std::size_t>& signals) {
  const BlockInfo& info = block_info(type);
  const Fields fields(value, keys_of(info));
  spec::Block block;
  block.name = name;
  block.mark = value.mark();
  block.type = std::string(info.name);
  const std::size_t errors = builder.errors.list.size();
  if (const auto every = fields.get("every")) block.every = every->positive(quantity::time).value_or(1);
  const auto main = fields.need(std::string(info.key), "angle");
  if (!main) return;
  if (info.outside) {
    for (const Value& text : builder.reader->fmu_block(builder, fields, block))
      if (auto law = input_formula(builder, part, text)) block.inputs.push_back(std::move(*law));
  } else {
    read_inputs_of(builder, part, fields, *main, info, block);
  }
  read_numbers(info, fields, block);
  read_matrices(info, fields, block);
  if (info.points) block.function = read_points_of(fields);
  if (!info.words.empty())
    block.numbers.back() = main->choice({info.words.begin(), info.words.end()}).value_or(0);
  if (builder.errors.list.size() > errors) return;
  const int outputs = output_count(block);
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
