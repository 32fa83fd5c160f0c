#include "mimbre/diagnostics.h"
#include "spec/block_info.h"
#include "spec/model_builder_parts.h"

/// Blocks and events by names.
namespace mimbre {
namespace {

/// The numbers of a type, with its defaults where they are not given. What is given may be NaN: the checks of
/// the whole model say so.
std::vector<double> numbers_of_block(const Addition& addition, const BlockInfo& info,
                                     const build::Block& given) {
  std::vector<double> numbers = numbers_by_key(addition, info.name, info.numbers, given.numbers);
  if (info.complete) info.complete(numbers);
  require_numbers(addition, info.numbers, numbers, given.numbers);
  return numbers;
}

std::vector<Eigen::MatrixXd> matrices_of(const Addition& addition, const BlockInfo& info,
                                         const build::Block& given) {
  std::vector<std::string> known;
  std::vector<Eigen::MatrixXd> matrices;
  for (const BlockMatrix& matrix : info.matrices) {
    known.emplace_back(matrix.key);
    const auto found = given.matrices.find(known.back());
    if (found == given.matrices.end() && !matrix.optional)
      addition.refuse(fmt::format("matrices: '{}' is missing", matrix.key));
    matrices.push_back(found == given.matrices.end() ? Eigen::MatrixXd() : found->second);
  }
  for (const auto& [name, value] : given.matrices)
    require_known(addition, "matrices", info.name, name, known);
  return matrices;
}

}  // namespace

void ModelBuilder::add_block(const std::string& name, const build::Block& given) {
  Addition addition(*impl_, impl_->signals, name);
  const int type = find_block(given.type);
  if (type < 0) {
    std::vector<std::string> known;
    for (const BlockInfo* info : all_blocks()) known.emplace_back(info->name);
    addition.refuse(fmt::format("there is no block '{}'{}; there are {}", given.type,
                                did_you_mean(given.type, known), listed(known)));
  }
  const BlockInfo& info = block_info(type);
  spec::Block block;
  block.name = name;
  block.type = given.type;
  block.every = given.every;
  block.function = given.function;
  block.outside = given.outside;
  block.numbers = numbers_of_block(addition, info, given);
  block.matrices = matrices_of(addition, info, given);
  std::vector<std::string> formulas = given.inputs;
  if (!info.second.empty() && formulas.size() == 1) formulas.emplace_back("0");
  const std::vector<std::string> outputs = given.outputs.empty() ? std::vector{name} : given.outputs;
  const int wanted = output_count(block);
  if (wanted != std::ssize(outputs))
    addition.refuse(fmt::format("has {} outputs and {} names of them", wanted, outputs.size()));
  for (const std::string& output : outputs)
    if (output != name && impl_->signals.index.contains(output))
      addition.refuse(fmt::format("there is a signal '{}' already", output));
  block.inputs = addition.formulas("inputs", formulas, given.of);
  spec::Model& model = impl_->model;
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    spec::Signal signal;
    signal.name = outputs[k];
    signal.unit = given.unit;
    signal.block = static_cast<int>(model.blocks.size());
    signal.output = static_cast<int>(k);
    if (outputs[k] == name)
      addition.commit(impl_->signals, model.signals.size());
    else
      impl_->signals.index[outputs[k]] = static_cast<int>(model.signals.size());
    model.signals.push_back(std::move(signal));
  }
  model.blocks.push_back(std::move(block));
}

void ModelBuilder::add_event(const std::string& name, const build::Event& given) {
  Addition addition(*impl_, impl_->events, name);
  spec::Event event;
  event.name = name;
  event.direction = given.direction;
  event.stop = given.stop;
  std::vector<std::string> formulas{given.when};
  for (const auto& [input, value] : given.set) {
    event.sets.push_back({addition.find(impl_->inputs, "set", input), {}});
    formulas.push_back(value);
  }
  std::vector<spec::Law> laws = addition.formulas("when and set", formulas, given.of);
  event.when = std::move(laws.front());
  for (std::size_t k = 0; k < event.sets.size(); ++k) event.sets[k].value = std::move(laws[k + 1]);
  addition.commit(impl_->events, impl_->model.events.size());
  impl_->model.events.push_back(std::move(event));
}

}  // namespace mimbre
