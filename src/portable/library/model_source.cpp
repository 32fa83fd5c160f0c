#include "portable/library/model_source.h"

#include <fmt/format.h>

#include <algorithm>

#include "model_file/text/kept_files.h"
#include "model_file/text/parse.h"
#include "spec/model_members.h"

namespace mimbre::portable {

std::vector<std::byte> source_bytes(const ModelSource& source) {
  archive::Writer to;
  to(source.text, source.file, source.directory, source.settings.size());
  for (const auto& [name, value] : source.settings) to(name, value);
  to(source.parameters.size());
  for (const model_file::DeclaredParameter& p : source.parameters)
    to(p.name, p.about, std::get<double>(p.value), p.min, p.max, p.integer, p.tunable, p.derived);
  to(source.simulation, source.files);
  return to.take();
}

ModelSource source_from_bytes(std::span<const std::byte> bytes) {
  archive::Reader from(bytes);
  ModelSource out;
  std::size_t settings = 0;
  from(out.text, out.file, out.directory, settings);
  for (std::size_t k = 0; k < settings; ++k) {
    std::string name;
    from(name);
    from(out.settings[name]);
  }
  std::size_t parameters = 0;
  from(parameters);
  for (std::size_t k = 0; k < parameters; ++k) {
    model_file::DeclaredParameter p;
    double value = 0;
    from(p.name, p.about, value, p.min, p.max, p.integer, p.tunable, p.derived);
    p.value = value;
    out.parameters.push_back(std::move(p));
  }
  from(out.simulation, out.files);
  return out;
}

ModelRead read_model(const ModelSource& source, const std::map<std::string, double>& parameters) {
  std::map<std::string, std::string> settings = source.settings;
  for (const auto& [name, value] : parameters) settings[name] = fmt::format("{:.17g}", value);
  std::vector<model_file::DeclaredParameter> declared;
  ModelRead out;
  const model_file::KeptFiles files(source.files);
  out.model = model_file::parse_by(files, source.text, source.file, source.directory, settings, nullptr, {},
                                   nullptr, &declared);
  out.parameters = fixed_parameters(declared);
  return out;
}

std::vector<model_file::DeclaredParameter> fixed_parameters(
    const std::vector<model_file::DeclaredParameter>& declared) {
  std::vector<model_file::DeclaredParameter> out;
  for (const bool integer : {false, true})
    for (const model_file::DeclaredParameter& p : declared)
      if (!p.tunable && p.integer == integer && std::holds_alternative<double>(p.value)) out.push_back(p);
  return out;
}

std::vector<std::pair<int, std::string>> output_channels(const std::vector<ChannelInfo>& channels,
                                                         int count) {
  const std::string signal = "signal.";
  std::vector<std::pair<int, std::string>> out;
  for (int k = 0; k < count; ++k) out.emplace_back(k, channels[static_cast<std::size_t>(k)].name);
  for (std::size_t k = out.size(); k < channels.size(); ++k) {
    const std::string& name = channels[k].name;
    if (name.starts_with(signal)) out.emplace_back(static_cast<int>(k), name.substr(signal.size()));
    if (name.starts_with("event.")) out.emplace_back(static_cast<int>(k), name);
  }
  for (std::size_t k = 0; k < channels.size() && count == 0; ++k)
    if (channels[k].name.starts_with("joint.") && channels[k].name.find(".position") != std::string::npos)
      out.emplace_back(static_cast<int>(k), channels[k].name);
  return out;
}

}  // namespace mimbre::portable
