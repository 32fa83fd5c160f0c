#include "live/input_board.h"

#include <algorithm>

namespace mimbre::live {

InputBoard::InputBoard(const Simulation& simulation) {
  for (std::size_t k = 0; k < simulation.inputs().size(); ++k) wanted_.push_back(std::make_unique<Wanted>());
}

InputBoard::~InputBoard() {
  tidy();
  delete tracks_;
  while (InputTracks** const next = to_play_.front()) {
    delete *next;
    to_play_.pop();
  }
}

void InputBoard::set(int input, double value) {
  Wanted& w = *wanted_[static_cast<std::size_t>(input)];
  w.value.store(value, std::memory_order_relaxed);
  const std::uint32_t version = version_.load(std::memory_order_relaxed) + 1;  // which nobody else writes
  w.version.store(version, std::memory_order_release);
  version_.store(version, std::memory_order_release);
}

bool InputBoard::play(std::unique_ptr<InputTracks> tracks) {
  tidy();
  if (!to_play_.push(tracks.get())) return false;
  tracks.release();
  return true;
}

void InputBoard::tidy() {
  while (InputTracks** const old = played_.front()) {
    delete *old;
    played_.pop();
  }
}

void InputBoard::put(Simulation& simulation, int input, double value) {
  if (simulation.input_value(input) == value) return;
  simulation.set_input(input, value);
  // One that goes there in a straight line is not there yet.
  const spec::Input& info = simulation.inputs()[static_cast<std::size_t>(input)];
  changes_.push({simulation.time(), input, std::clamp(value, info.min, info.max)});
}

/// The simulation begins, or was put elsewhere: what is being played begins again there.
void InputBoard::tell_all(Simulation& simulation) {
  since_ = simulation.time();
  if (tracks_)
    for (InputTrack& track : *tracks_) track.next = 0;
  changes_.push({simulation.time(), -1, 0});
  for (int k = 0; k < static_cast<int>(wanted_.size()); ++k)
    changes_.push({simulation.time(), k, simulation.input_value(k)});
  told_ = true;
}

void InputBoard::take_played(Simulation& simulation) {
  while (InputTracks** const next = to_play_.front()) {
    // Without room to give the old ones back they are kept for now.
    if (tracks_ && !played_.push(tracks_)) return;
    tracks_ = *next;
    to_play_.pop();
    since_ = simulation.time();
    playing_ = tracks_ != nullptr;
    if (tracks_) begun_.fetch_add(1, std::memory_order_release);
  }
}

void InputBoard::before(Simulation& simulation) {
  if (!told_) tell_all(simulation);
  if (const std::uint32_t version = version_.load(std::memory_order_acquire); version != taken_) {
    taken_ = version;
    for (int k = 0; k < static_cast<int>(wanted_.size()); ++k) {
      Wanted& w = *wanted_[static_cast<std::size_t>(k)];
      const std::uint32_t of_this = w.version.load(std::memory_order_acquire);
      if (of_this == w.taken) continue;
      w.taken = of_this;
      // Versions go round.
      if (static_cast<std::int32_t>(of_this - since_version_) <= 0) continue;
      put(simulation, k, w.value.load(std::memory_order_relaxed));
    }
  }
  take_played(simulation);
  if (!playing_.load(std::memory_order_relaxed)) return;
  bool over = true;
  // Times are sums of steps: what is due within a millionth of one is due.
  const double now = simulation.time() - since_ + 1e-6 * simulation.step_size();
  for (InputTrack& track : *tracks_) {
    const std::size_t due = track.next;
    while (track.next < track.times.size() && track.times[track.next] <= now) ++track.next;
    // Until the next point others, as events, may set it.
    if (track.next > due) put(simulation, track.input, track.values[track.next - 1]);
    over = over && track.next == track.times.size();
  }
  if (over) playing_ = false;
}

void InputBoard::rests(Simulation& simulation) { take_played(simulation); }

void InputBoard::moved(Simulation& simulation) {
  since_version_ = dropped_.load(std::memory_order_acquire);
  take_played(simulation);
  tell_all(simulation);
}

}  // namespace mimbre::live
