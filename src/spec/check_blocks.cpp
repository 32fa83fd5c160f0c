#include <algorithm>
#include <cmath>

#include "spec/block_types.h"
#include "spec/checked_item.h"

/// Blocks and events.
namespace mimbre::checks {
namespace {

std::string shape(const Eigen::MatrixXd& m) { return fmt::format("{} x {}", m.rows(), m.cols()); }

/// Whether a matrix has that shape, or nothing where it may be left out.
bool has_shape(const CheckedItem& item, const char* name, const Eigen::MatrixXd& m, Eigen::Index rows,
               Eigen::Index columns, bool optional = false) {
  if (m.rows() == rows && m.cols() == columns) return true;
  if (optional && m.size() == 0) return true;
  item.error(fmt::format("{} is {}; it has to be {} x {} here", name, shape(m), rows, columns));
  return false;
}

void check_transfer_function(const CheckedItem& item, const spec::Block& block) {
  const auto &numerator = block.matrices[0], &denominator = block.matrices[1];
  for (const auto& [name, m] : {std::pair("numerator", &numerator), std::pair("denominator", &denominator)})
    if (m->rows() != 1 || m->cols() == 0) {
      item.error(fmt::format("{} is {}; a row of coefficients is needed, that of the highest power first",
                             name, shape(*m)));
      return;
    }
  const auto degree = [](const Eigen::MatrixXd& p) {
    Eigen::Index zeros = 0;
    while (zeros < p.cols() && p(0, zeros) == 0) ++zeros;
    return p.cols() - zeros - 1;  // −1: all are 0
  };
  const Eigen::Index above = degree(numerator), below = degree(denominator);
  if (below < 0)
    item.error("denominator is 0");
  else if (above > below)
    item.error(
        fmt::format("the numerator is of degree {}, above {} of the denominator: that would be a "
                    "derivative; add poles to the denominator",
                    above, below));
  else if (below > most_block_states)
    item.error(fmt::format("the denominator is of degree {}, more than {}", below, most_block_states));
}

void check_state_space(const CheckedItem& item, const spec::Block& block) {
  const Eigen::MatrixXd &A = block.matrices[0], &B = block.matrices[1], &C = block.matrices[2],
                        &D = block.matrices[3], &initial = block.matrices[4];
  const auto n = A.rows(), m = static_cast<Eigen::Index>(block.inputs.size());
  if (n < 1 || n > most_block_states)
    return item.error(fmt::format("A has {} rows; 1 to {} states are possible", n, most_block_states));
  if (C.rows() < 1 || C.rows() > most_block_outputs)
    return item.error(
        fmt::format("C has {} rows; 1 to {} outputs are possible", C.rows(), most_block_outputs));
  has_shape(item, "A", A, n, n);
  has_shape(item, "B", B, n, m);
  has_shape(item, "C", C, C.rows(), n);
  has_shape(item, "D", D, C.rows(), m, true);
  if (initial.size() != 0 && initial.size() != n)
    item.error(fmt::format("initial has {} numbers; there are {} states", initial.size(), n));
}

void check_table_2d(const CheckedItem& item, const spec::Block& block) {
  const Eigen::MatrixXd &x = block.matrices[0], &y = block.matrices[1], &values = block.matrices[2];
  for (const auto& [name, m] : {std::pair("x", &x), std::pair("y", &y)}) {
    if (m->rows() != 1 || m->cols() < 2)
      return item.error(fmt::format("{} is {}; a row of two places or more is needed", name, shape(*m)));
    for (Eigen::Index k = 1; k < m->cols(); ++k)
      if (!((*m)(0, k) > (*m)(0, k - 1)))
        return item.error(
            fmt::format("{} does not ascend: {} comes after {}", name, (*m)(0, k), (*m)(0, k - 1)));
  }
  has_shape(item, "values", values, x.cols(), y.cols());
}

/// Numbers that are right one by one.
void check_together(const CheckedItem& item, const spec::Block& block, BlockType type) {
  const std::vector<double>& n = block.numbers;
  if (type == BlockType::pid) {
    if (n[2] != 0 && !(n[3] > 0))
      item.error("kd needs a filter, the time constant over which it sees a rate: 'filter', some steps long");
    if (!(n[4] < n[5])) item.error(fmt::format("lower is {}, not below upper, {}", n[4], n[5]));
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) item.error("has no gain: kp, ki or kd");
  }
  if (type == BlockType::hysteresis && !(n[1] < n[0]))
    item.error(fmt::format("falls_at is {}, not below rises_at, {}", n[1], n[0]));
  if (type == BlockType::noise && n[2] != std::floor(n[2])) item.error("seed is no whole number");
  if (type == BlockType::delay && block.every > 0) {
    const double instants = n[0] / block.every;
    if (std::abs(instants - std::round(instants)) > 1e-6 * instants)
      item.error(fmt::format("time is {}, no whole number of 'every', {}", n[0], block.every));
  }
}

void check_block(const spec::Model& model, const CheckedItem& item, const spec::Block& block) {
  const int row = find_block(block.type);
  if (row < 0) {
    std::string known;
    for (const BlockInfo& info : block_table)
      known += fmt::format("{}'{}'", known.empty() ? "" : ", ", info.name);
    return item.error(fmt::format("there is no block '{}'; there are {}", block.type, known));
  }
  const BlockInfo& info = block_table[static_cast<std::size_t>(row)];
  const auto type = static_cast<BlockType>(row);
  item.not_negative("every", block.every);
  if (!info.continuous && !(block.every > 0))
    item.error(fmt::format("a block '{}' is sampled: 'every' is missing, s", block.type));
  const int inputs = static_cast<int>(block.inputs.size());
  if (info.inputs >= 0 && inputs != info.inputs)
    return item.error(
        fmt::format("a block '{}' has {} inputs, {} are given", block.type, info.inputs, inputs));
  if (info.inputs < 0 && (inputs < 1 || inputs > most_block_inputs))
    return item.error(fmt::format("has {} inputs; 1 to {} are possible", inputs, most_block_inputs));
  for (const spec::Law& law : block.inputs) {
    if (law.formula.is_zero()) item.error("has an input without a formula");
    check_law(model, item, law, 0);
  }
  if (block.numbers.size() != info.numbers.size())
    return item.error(fmt::format("a block '{}' has {} numbers, {} are given", block.type,
                                  info.numbers.size(), block.numbers.size()));
  bool good = true;
  for (std::size_t k = 0; k < info.numbers.size(); ++k)
    if (const LawNumber& number = info.numbers[k]; !number.allows(block.numbers[k])) {
      item.error(fmt::format("{} {}", number.key, wrong_number(number, block.numbers[k])));
      good = false;
    }
  if (block.matrices.size() != info.matrices.size())
    return item.error(fmt::format("a block '{}' has {} matrices, {} are given", block.type,
                                  info.matrices.size(), block.matrices.size()));
  for (std::size_t k = 0; k < info.matrices.size(); ++k)
    good = item.finite(std::string(info.matrices[k]), block.matrices[k]) && good;
  if (!good) return;
  if (type == BlockType::transfer_function) check_transfer_function(item, block);
  if (type == BlockType::state_space) check_state_space(item, block);
  if (type == BlockType::table_2d) check_table_2d(item, block);
  if (type == BlockType::table && block.function.is_zero()) item.error("has no points");
  check_together(item, block, type);
}

}  // namespace

void check_blocks(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.blocks.size(); ++k)
    check_block(model, CheckedItem(errors, "signal", model.blocks[k].name, model.blocks[k].mark, k),
                model.blocks[k]);
}

void check_events(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.events.size(); ++k) {
    const spec::Event& event = model.events[k];
    const CheckedItem item(errors, "event", event.name, event.mark, k);
    if (event.when.formula.is_zero()) item.error("has no formula that could cross zero");
    check_law(model, item, event.when, 0);
    item.enumerator("direction", event.direction, 3);
    for (const spec::Event::Set& set : event.sets) {
      item.index("set: input", set.input, model.inputs.size(), "inputs");
      if (set.value.formula.is_zero()) item.error("sets an input without saying to what");
      check_law(model, item, set.value, 0);
    }
  }
}

}  // namespace mimbre::checks
