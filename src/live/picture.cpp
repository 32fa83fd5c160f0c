#include "live/picture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "live/host.h"

namespace mimbre::live {
namespace {

constexpr double pictures_a_second = 125;

/// Little-endian whatever the machine.
class Bytes {
 public:
  template <class Unsigned>
  void put(Unsigned value) {
    for (std::size_t k = 0; k < sizeof value; ++k)
      text_.push_back(static_cast<char>(value >> (8 * k) & 0xff));
  }
  void single(double value) { put(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }
  void precise(double value) { put(std::bit_cast<std::uint64_t>(value)); }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

}  // namespace

std::string encoded(const Picture& p, const std::vector<int>& channels, const PictureMarks& marks) {
  const auto bit = [](bool on, int k) { return static_cast<unsigned>(on) << k; };
  Bytes bytes;
  bytes.put<std::uint8_t>(1);
  bytes.put(static_cast<std::uint8_t>(bit(marks.paused, 0) | bit(marks.recording, 1) | bit(marks.failed, 2) |
                                      bit(marks.ended, 3) | bit(marks.playing, 4) | bit(marks.control, 5)));
  bytes.put(static_cast<std::uint16_t>(channels.size()));
  bytes.put(static_cast<std::uint32_t>(p.inputs.size()));
  bytes.precise(p.row.time);
  bytes.precise(p.clock);
  bytes.put(static_cast<std::uint64_t>(p.steps));
  bytes.single(p.load);
  bytes.put(marks.choice);
  for (Eigen::Index body = 0; body < p.row.poses.cols(); ++body)
    for (int k = 0; k < 3; ++k) bytes.precise(p.row.poses(k, body));
  for (Eigen::Index body = 0; body < p.row.poses.cols(); ++body)
    for (int k = 3; k < 7; ++k) bytes.single(p.row.poses(k, body));
  for (const double amplitude : p.row.modes) bytes.single(amplitude);
  const auto begin = p.choice.channels.begin(), end = begin + p.choice.count;
  for (const int channel : channels) {
    const auto at = std::find(begin, end, channel);
    bytes.single(at == end ? std::numeric_limits<double>::quiet_NaN()
                           : p.values[static_cast<std::size_t>(at - begin)]);
  }
  for (const double input : p.inputs) bytes.single(input);
  return bytes.take();
}

Picture PictureMaker::example(Simulation& simulation) {
  Picture p;
  simulation.picture(p.row);
  p.inputs.resize(simulation.inputs().size());
  return p;
}

PictureMaker::PictureMaker(Simulation& simulation, double period)
    : period_(period),
      every_(std::max<std::int64_t>(std::llround(1 / (pictures_a_second * period)), 1)),
      pictures_(example(simulation)) {
  make(simulation);
}

void PictureMaker::choose(const Choice& choice) {
  choices_.place() = choice;
  choices_.publish();
}

void PictureMaker::make(Simulation& simulation) {
  Picture& p = pictures_.place();
  simulation.picture(p.row);
  p.clock = 1e-9 * static_cast<double>(clock_now());
  p.steps = steps_;
  p.load = load_;
  bool news = false;
  p.choice = choices_.read(news);
  for (int k = 0; k < p.choice.count; ++k) {
    const auto at = static_cast<std::size_t>(k);
    p.values[at] = simulation.value({p.choice.channels[at]});
  }
  for (std::size_t k = 0; k < p.inputs.size(); ++k) p.inputs[k] = simulation.input_value(static_cast<int>(k));
  pictures_.publish();
}

void PictureMaker::after(Simulation& simulation, const StepReport&, bool output) {
  ++steps_;
  if (output && steps_ % every_ == 0) make(simulation);
}

void PictureMaker::timed(const StepTiming& timing) { load_ = timing.computation / period_; }

void PictureMaker::rests(Simulation& simulation) { make(simulation); }

void PictureMaker::moved(Simulation& simulation) { make(simulation); }

}  // namespace mimbre::live
