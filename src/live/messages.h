#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "live/input_board.h"
#include "mimbre/real_time.h"
#include "mimbre/real_time_recorder.h"

/// The texts of the protocol (docs/live-protocol.md).
namespace mimbre::live {

/// Channels that a viewer is shown at first: the model's first outputs.
std::vector<int> shown_at_first(const Simulation& simulation);

/// `/scene`. Made where the simulation may be used: before the loop runs.
std::string scene_text(Simulation& simulation, const RealTimeLoop& loop, const RealTimeRecorder* recorder);

/// `/status`, and with `say` the message.
std::string status_text(const RealTimeLoop& loop, const RealTimeRecorder* recorder, std::size_t viewers,
                        bool say);

/// `/inputs`: what was set since the simulation was put where it began, by the inputs' names.
struct InputHistory {
  std::vector<double> times, values;
};
std::string inputs_text(const std::vector<spec::Input>& inputs, const std::vector<InputHistory>& histories);

/// What a viewer asks for.
struct Asked {
  std::string what;                            ///< `do`
  std::vector<int> channels;                   ///< of channels
  bool on = false;                             ///< take, on
  std::vector<std::pair<int, double>> values;  ///< of inputs
  std::string name;                            ///< of snapshots
  std::optional<InputTracks> tracks;           ///< of play
};
/// Throws InputError that names the mistake.
Asked understood(const std::string& text, const std::vector<spec::Input>& inputs, int channels);

// Messages to a viewer.
std::string hello_text(int viewer, bool control, const std::vector<int>& channels);
std::string control_text(bool yours, bool taken);
std::string asked_text(int viewer);
std::string channels_text(const std::vector<int>& channels, std::uint32_t choice);
std::string snapshots_text(const std::vector<std::string>& names);
std::string recording_text(bool on, const std::string& file);
std::string played_text(bool on);
std::string error_text(const std::string& message);

}  // namespace mimbre::live
