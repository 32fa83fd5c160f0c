// What a page calls (web/src/pageSolver.ts): one model in motion. Functions that may fail return a negative
// number, and the reason is in mimbre_text().
#include <array>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "live/picture.h"
#include "mimbre/model.h"
#include "mimbre/model_bytes.h"
#include "mimbre/simulation.h"
#include "mimbre/timings.h"

#define MIMBRE_EXPORT(name) extern "C" __attribute__((export_name(#name)))

namespace {

using namespace mimbre;

constexpr std::size_t places = 16;  ///< for snapshots; the last one is the beginning

struct Run {
  explicit Run(spec::Model given) : model(Model::compile(std::move(given))), simulation(model) {
    simulation.picture(picture.row);
    picture.inputs.resize(simulation.inputs().size());
    saved.fill(simulation.save());
  }
  std::shared_ptr<const Model> model;
  Simulation simulation;
  StepReport last;
  live::Picture picture;
  std::vector<int> channels;
  std::array<Simulation::Snapshot, places + 1> saved;
  Timings computation, latency;
};

std::unique_ptr<Run> run;
std::string text, bytes;
std::vector<double> numbers;

std::vector<double> histogram_edges() {
  std::vector<double> edges;
  for (int k = 0; k <= 60; ++k) edges.push_back(1e-6 * std::pow(10, 0.1 * k));
  return edges;
}

}  // namespace

MIMBRE_EXPORT(mimbre_allocate) void* mimbre_allocate(std::size_t size) { return std::malloc(size); }
MIMBRE_EXPORT(mimbre_free) void mimbre_free(void* memory) { std::free(memory); }

/// UTF-8, ends with 0.
MIMBRE_EXPORT(mimbre_text) const char* mimbre_text() { return text.c_str(); }

/// The model that model_bytes() wrote, where it starts.
MIMBRE_EXPORT(mimbre_open) int mimbre_open(const std::byte* model, std::size_t size) {
  try {
    run = std::make_unique<Run>(model_from_bytes({model, size}));
    return 0;
  } catch (const std::exception& error) {
    text = error.what();
    return -1;
  }
}

/// 0; 1: an event of the model stopped the run; negative: it failed.
MIMBRE_EXPORT(mimbre_step) int mimbre_step() {
  run->last = run->simulation.step();
  if (run->last.ok()) return run->simulation.stopped() ? 1 : 0;
  text = run->simulation.explain(run->last);
  return -1;
}
/// Of the last step: its iterations and parts.
MIMBRE_EXPORT(mimbre_iterations) int mimbre_iterations() { return run->last.iterations; }
MIMBRE_EXPORT(mimbre_parts) int mimbre_parts() { return run->last.substeps; }

MIMBRE_EXPORT(mimbre_time) double mimbre_time() { return run->simulation.time(); }
MIMBRE_EXPORT(mimbre_step_size) double mimbre_step_size() { return run->simulation.step_size(); }

MIMBRE_EXPORT(mimbre_set_input) void mimbre_set_input(int input, double value) {
  run->simulation.set_input(input, value);
}
MIMBRE_EXPORT(mimbre_input) double mimbre_input(int input) { return run->simulation.input_value(input); }
MIMBRE_EXPORT(mimbre_channel_count) int mimbre_channel_count() {
  return static_cast<int>(run->simulation.channels().size());
}
MIMBRE_EXPORT(mimbre_channel) double mimbre_channel(int channel) { return run->simulation.value({channel}); }

/// Channels of the pictures that follow.
MIMBRE_EXPORT(mimbre_choose) void mimbre_choose(const int* channels, int count) {
  run->channels.assign(channels, channels + count);
  live::Choice& choice = run->picture.choice;
  choice.count = count;
  for (int k = 0; k < count; ++k) choice.channels[static_cast<std::size_t>(k)] = channels[k];
}
/// A picture of now (docs/live-protocol.md), and how many bytes it has. `marks`: bits as in the picture.
MIMBRE_EXPORT(mimbre_picture)
const char* mimbre_picture(unsigned marks, unsigned choice, double clock, double steps, double load) {
  live::Picture& p = run->picture;
  Simulation& simulation = run->simulation;
  simulation.picture(p.row);
  p.clock = clock;
  p.steps = static_cast<std::int64_t>(steps);
  p.load = load;
  for (std::size_t k = 0; k < run->channels.size(); ++k) p.values[k] = simulation.value({run->channels[k]});
  for (std::size_t k = 0; k < p.inputs.size(); ++k) p.inputs[k] = simulation.input_value(static_cast<int>(k));
  live::PictureMarks of;
  of.paused = marks & 1u;
  of.failed = marks & 4u;
  of.ended = marks & 8u;
  of.playing = marks & 16u;
  of.control = true;
  of.choice = choice;
  bytes = live::encoded(p, run->channels, of);
  return bytes.data();
}
MIMBRE_EXPORT(mimbre_picture_size) std::size_t mimbre_picture_size() { return bytes.size(); }

/// Places 0 to 15; 16 is the beginning, which is there already.
MIMBRE_EXPORT(mimbre_save) void mimbre_save(unsigned place) {
  run->simulation.save(run->saved[place % places]);
}
MIMBRE_EXPORT(mimbre_restore) void mimbre_restore(unsigned place) {
  run->simulation.restore(run->saved[place <= places ? place : places]);
}

/// How a step went, s.
MIMBRE_EXPORT(mimbre_timed) void mimbre_timed(double computation, double latency) {
  run->computation.add(computation);
  run->latency.add(latency);
}
/// Of the computation (0) or the latency (1): median, 99 %, 99.99 %, worst, s; then 61 edges of bins, s, and
/// the counts of the 60 bins: 125 numbers.
MIMBRE_EXPORT(mimbre_timings) const double* mimbre_timings(int which) {
  static const std::vector<double> edges = histogram_edges();
  const Timings& t = which == 0 ? run->computation : run->latency;
  numbers = {t.quantile(0.5), t.quantile(0.99), t.quantile(0.9999), t.worst()};
  numbers.insert(numbers.end(), edges.begin(), edges.end());
  for (const std::int64_t count : t.between(edges)) numbers.push_back(static_cast<double>(count));
  return numbers.data();
}
