#include "portable/library/library_code.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "mimbre/diagnostics.h"
#include "mimbre/model_bytes.h"
#include "mimbre/run_option.h"
#include "mimbre/simulation.h"
#include "portable/code_parts.h"
#include "portable/library/library_text.h"
#include "portable/library/record_source.h"
#include "portable/library/runtime_options.h"
#include "portable/program.h"
#include "portable/write_tables.h"

namespace mimbre::portable {
namespace {

/// What is asked for in place of what the model has, as if its file asked for it.
void ask_for(const RunOptions& options, spec::Simulation& given) {
  const spec::Simulation before = given, none;
  for (const RunOption& option : run_option_table())
    std::visit(
        [&](const auto& m) {
          if (m.asked && options.*m.asked) given.*m.in_model = *(options.*m.asked);
        },
        option.member);
  given.integrator = integrator_in_force(before, options);
  // What the file has of another integrator, or of steps that are made anew, has no effect.
  for (const RunOption& option : run_option_table())
    if (!option.of.empty() && !option.belongs_to(given.integrator))
      std::visit([&](const auto& m) { given.*m.in_model = none.*m.in_model; }, option.member);
  if (given.fixed_cost) {
    given.substeps = none.substeps;
    given.energy_tolerance = none.energy_tolerance;
  }
}

/// The model with the method that a run with these options takes.
spec::Model with_method(const Model& model, const RunOptions& options) {
  spec::Model spec = model.spec();
  resolve_method(spec.simulation, options);  // names what does not go together
  ask_for(options, spec.simulation);
  for (const auto& [name, value] : options.inputs) {
    const auto input = std::find_if(spec.inputs.begin(), spec.inputs.end(),
                                    [&](const spec::Input& i) { return i.name == name; });
    if (input == spec.inputs.end())
      throw InputError({spec.file, 0, 0}, fmt::format("there is no input '{}'", name));
    input->start = std::clamp(value, input->min, input->max);
  }
  return spec;
}

void refuse_blocks(const spec::Model& model) {
  std::vector<Diagnostic> reasons;
  for (const spec::Block& block : model.blocks)
    if (block.outside)
      reasons.push_back({block.mark, fmt::format("signal '{}' is computed by code from elsewhere, which an "
                                                 "FMU cannot take along: leave it to the importer, by an "
                                                 "input and an output",
                                                 block.name)});
  if (!reasons.empty()) throw InputError(std::move(reasons));
}

std::vector<GeneratedVariable> inputs_of(const Simulation& simulation) {
  std::vector<GeneratedVariable> out;
  for (std::size_t k = 0; k < simulation.inputs().size(); ++k) {
    const spec::Input& input = simulation.inputs()[k];
    GeneratedVariable v;
    v.name = input.name;
    v.unit = input.unit;
    v.start = simulation.input_value(static_cast<int>(k));
    v.min = input.min;
    v.max = input.max;
    v.tunable = input.tunable;
    out.push_back(std::move(v));
  }
  return out;
}

/// Fixed ones, whole ones last.
std::vector<GeneratedParameter> parameters_of(const std::optional<ModelSource>& source) {
  std::vector<GeneratedParameter> out;
  if (!source) return out;
  for (const model_file::DeclaredParameter& p : source->parameters)
    out.push_back({p.name, p.about, std::get<double>(p.value), p.min, p.max, p.integer, p.derived});
  return out;
}

/// What an output shows at once is not known: all inputs may be in it.
GeneratedVariable output_of(const Simulation& simulation, int channel, const std::string& name) {
  const ChannelInfo& info = simulation.channels()[static_cast<std::size_t>(channel)];
  GeneratedVariable v;
  v.name = name;
  v.unit = info.unit;
  v.meaning = info.meaning;
  v.by_time = v.by_state = v.by_acceleration = true;
  for (std::size_t i = 0; i < simulation.inputs().size(); ++i) v.inputs.push_back(static_cast<int>(i));
  return v;
}

/// Words of eight bytes: a compiler reads them several times as fast as bytes.
std::string table_of(const std::vector<std::byte>& bytes) {
  std::string text;
  for (std::size_t first = 0; first < bytes.size(); first += 8) {
    std::uint64_t word = 0;
    for (std::size_t k = 0; k < 8 && first + k < bytes.size(); ++k)
      word |= std::uint64_t{std::to_integer<unsigned char>(bytes[first + k])} << (8 * k);
    text += fmt::format("{:#x},{}", word, first % 64 == 56 ? "\n" : "");
  }
  return text;
}

}  // namespace

GeneratedCode library_code(const std::shared_ptr<const Model>& model, const RunOptions& options,
                           const std::string& name, const std::map<std::string, std::string>& settings) {
  check_identifier(name);
  if (name.starts_with("mimbre_"))
    throw InputError(Mark{},
                     fmt::format("the name '{}' begins like those of the library: take another one", name));
  spec::Model spec = with_method(*model, options);
  refuse_blocks(spec);
  const Simulation simulation(Model::compile(spec), runtime_options());
  // States of another integrator would have another size.
  if (spec.simulation.integrator == spec::Simulation::Integrator::automatic)
    spec.simulation.integrator = simulation.method().integrator;
  const std::vector<std::byte> bytes = model_bytes(spec);
  std::optional<ModelSource> source = source_of(model->spec(), settings);
  if (source && source->parameters.empty()) source.reset();
  const std::vector<std::byte> texts = source ? source_bytes(*source) : std::vector<std::byte>();
  GeneratedCode out;
  out.name = name;
  out.step = simulation.step_size();
  out.events = static_cast<int>(std::ssize(simulation.events()));
  out.varies = true;
  out.inputs = inputs_of(simulation);
  out.parameters = parameters_of(source);
  std::vector<int> channels;
  for (const auto& [channel, called] : output_channels(simulation.channels(), simulation.output_count())) {
    channels.push_back(channel);
    out.outputs.push_back(output_of(simulation, channel, called));
  }
  const std::string upper = upper_case(name);
  out.bytes = static_cast<long>(state_bytes(simulation));
  out.header = fmt::format(
      "/* {0}, moved by mimbre's library. */\n"
      "#define {1}_STEP {2} /* s */\n",
      comment(model->spec().title.empty() ? name : model->spec().title), upper, literal(out.step));
  out.header += named(library_header_text, name);
  out.source = fmt::format("#include \"{}.h\"\n\n", name);
  for (const auto& [size, called, block] :
       {std::tuple("SIZE", "bytes", &bytes), {"SOURCE", "source", &texts}}) {
    out.source += fmt::format("#define {}_{} {}ul\n", name, size, block->size());
    out.source += fmt::format("static const unsigned long long {}_{}[] = {{\n{}}};\n", name, called,
                              block->empty() ? "0" : table_of(*block));
  }
  out.source += table(name + "_channels", channels) + named(library_source_text, name);
  return out;
}

}  // namespace mimbre::portable
