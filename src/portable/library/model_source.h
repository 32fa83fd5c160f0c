#pragma once
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "mimbre/channels.h"
#include "mimbre/spec.h"
#include "model_file/text/parameters.h"

/// What a model was read from, as an FMU with the library inside takes it along: so it is read again, with
/// the parameters that an importer sets.
namespace mimbre::portable {

struct ModelSource {
  std::string text, file, directory;                      ///< as parse_model() takes them
  std::map<std::string, std::string> settings;            ///< that were replaced when the FMU was written
  std::vector<model_file::DeclaredParameter> parameters;  ///< with these: fixed_parameters()
  spec::Simulation simulation;                            ///< likewise
  std::vector<std::byte> files;                           ///< model_file::KeptFiles::bytes()
};

std::vector<std::byte> source_bytes(const ModelSource& source);
ModelSource source_from_bytes(std::span<const std::byte> bytes);

/// A model of these parameters, by name, and those in force. Throws InputError.
struct ModelRead {
  spec::Model model;
  std::vector<model_file::DeclaredParameter> parameters;  ///< fixed_parameters()
};
ModelRead read_model(const ModelSource& source, const std::map<std::string, double>& parameters);

/// Those that an FMU has as fixed ones: numbers that are not tunable, whole ones last.
std::vector<model_file::DeclaredParameter> fixed_parameters(
    const std::vector<model_file::DeclaredParameter>& declared);

/// The channels that are outputs, as of code: the model's outputs (the first `count` channels), its
/// signals and events; where it has no outputs, its joints' coordinates. With their names.
std::vector<std::pair<int, std::string>> output_channels(const std::vector<ChannelInfo>& channels, int count);

}  // namespace mimbre::portable
