#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "live/mailbox.h"
#include "mimbre/real_time.h"

namespace mimbre::live {

/// Channels that viewers want to see: places among Simulation::channels().
struct Choice {
  static constexpr int most = 2048;  ///< of all viewers
  int count = 0;
  std::array<int, most> channels{};
};

/// What the viewers are shown of an instant.
struct Picture {
  ResultsRow row;          ///< its channels are empty
  double clock = 0;        ///< s
  std::int64_t steps = 0;  ///< made so far
  double load = 0;         ///< computation of the last step over its length
  Choice choice;
  std::array<double, Choice::most> values{};  ///< of the choice
  std::vector<double> inputs;
};

/// What of a picture differs from viewer to viewer, and of the loop.
struct PictureMarks {
  bool paused = false, recording = false, failed = false, ended = false, playing = false, control = false;
  std::uint32_t choice = 0;  ///< counts the viewer's choices
};

/// The bytes of a picture (docs/live-protocol.md) with the channels that a viewer chose; not-a-number where
/// the picture does not have one yet.
std::string encoded(const Picture& picture, const std::vector<int>& channels, const PictureMarks& marks);

/// Makes pictures in the loop, some hundred a second, for the thread that shows them.
class PictureMaker : public RealTimePart {
 public:
  PictureMaker(Simulation& simulation, double period);

  void after(Simulation& simulation, const StepReport& report, bool output) override;
  void timed(const StepTiming& timing) override;
  void rests(Simulation& simulation) override;
  void moved(Simulation& simulation) override;

  // Of the thread that shows them.
  void choose(const Choice& choice);
  const Picture& read(bool& news) { return pictures_.read(news); }

 private:
  static Picture example(Simulation& simulation);
  void make(Simulation& simulation);

  const double period_;       ///< s of the clock, of a step
  const std::int64_t every_;  ///< steps
  std::int64_t steps_ = 0;
  double load_ = 0;
  Newest<Picture> pictures_;
  Newest<Choice> choices_;
};

}  // namespace mimbre::live
