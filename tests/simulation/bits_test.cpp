#include <alloca.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <thread>
#include <vector>

#include "base/hash64.h"
#include "mimbre/diagnostics.h"
#include "support/models.h"
#include "support/random_mechanism.h"
#include "support/simulate.h"

/// The same model has the same bits: wherever stack and heap lie, in every thread, on every machine.
namespace mimbre::test::bits_test {
namespace {

void add(Hash64& hash, const Eigen::VectorXd& x) {
  for (const double number : x) hash.add(number);
}

/// Of the start, so many steps, all channels and the fingerprint.
std::uint64_t digest(Simulation s, int steps) {
  Hash64 hash;
  hash.add(s.fingerprint());
  ResultsRow row;
  for (int k = 0; k < steps; ++k) {
    s.sample(row);
    add(hash, row.channels);
    add(hash, row.poses.reshaped());
    add(hash, row.modes);
    const StepReport report = s.step();
    hash.add(static_cast<double>(report.iterations));
    if (!report.ok()) break;
  }
  const Simulation::Snapshot end = s.save();
  for (const Eigen::VectorXd* x :
       {&end.q, &end.v, &end.a, &end.algorithmic, &end.multipliers, &end.z, &end.memory})
    add(hash, *x);
  return hash.value();
}

std::shared_ptr<const Model> random_model(unsigned seed) {
  RandomOptions o;
  o.bodies = 3 + static_cast<int>(seed % 5);
  o.loops = static_cast<int>(seed % 3);
  o.springs = o.damping = o.loads = true;
  o.tyres = seed % 2 == 0;
  return random_mechanism(seed, o).model;
}

/// Compiled anew each time: what is compiled counts, too. `refused` counts models that cannot start.
std::uint64_t digest_of_random(unsigned seed, int* refused = nullptr) {
  const auto formulation = seed % 2 == 0 ? Formulation::relative : Formulation::natural;
  try {
    return digest(simulation_of(random_model(seed), formulation, 1e-3), 6);
  } catch (const InputError& error) {
    // Loops that its start does not close; the numbers in the message count.
    if (refused) ++*refused;
    Hash64 hash;
    hash.add(std::string_view(error.what()));
    return hash.value();
  }
}

/// With the stack lower by 16 bytes times `by`, and the next blocks of the heap likewise somewhere else.
template <class Work>
[[gnu::noinline]] std::uint64_t moved(int by, const Work& work) {
  volatile char* const below = static_cast<volatile char*>(alloca(static_cast<std::size_t>(16 * by + 1)));
  below[0] = 0;
  std::vector<std::unique_ptr<char[]>> blocks;
  for (int k = 0; k < 40 * by; ++k)
    blocks.push_back(std::make_unique<char[]>(static_cast<std::size_t>(24 + 16 * (k % 37))));
  return work();
}

TEST(Bits, AreTheSameWhereverStackAndHeapLie) {
  int refused = 0;
  for (unsigned seed = 0; seed < 24; ++seed) {
    const std::uint64_t expected = digest_of_random(seed, &refused);
    for (const int by : {1, 2, 3})
      EXPECT_EQ(moved(by, [&] { return digest_of_random(seed); }), expected)
          << "seed " << seed << ", moved by " << by;
  }
  EXPECT_LE(refused, 8);
}

TEST(Bits, AreTheSameInEveryThread) {
  constexpr unsigned seeds = 12;
  std::vector<std::uint64_t> alone(seeds), together(seeds);
  for (unsigned seed = 0; seed < seeds; ++seed) alone[seed] = digest_of_random(seed);
  std::vector<std::thread> threads;
  for (unsigned first = 0; first < 4; ++first)
    threads.emplace_back([&, first] {
      for (unsigned seed = first; seed < seeds; seed += 4) together[seed] = digest_of_random(seed);
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(together, alone);
}

/// What is in the environment lies above the stack.
TEST(Bits, AreTheSameInEveryProcess) {
  const char* const given = std::getenv("MIMBRE_PROGRAM");
  const std::string program = given ? given : MIMBRE_PROGRAM;
  for (const char* const model : {"universal", "resumed"}) {
    std::string first;
    for (int length = 0; length < 64; length += 13) {
      const std::string csv = testing::TempDir() + fmt::format("bits-{}.csv", ::getpid());
      const std::string command = fmt::format(
          "env MIMBRE_LENGTH={} {} run {}/tests/data/bits/{}.yaml --until 0.1 -q --csv {}",
          std::string(static_cast<std::size_t>(length), 'x'), program, MIMBRE_SOURCE_DIR, model, csv);
      ASSERT_EQ(std::system(command.c_str()), 0) << command;
      std::stringstream text;
      text << std::ifstream(csv).rdbuf();
      if (first.empty()) first = text.str();
      EXPECT_GT(first.size(), 100U);
      EXPECT_EQ(text.str(), first) << model << " with " << length << " characters more";
      std::remove(csv.c_str());
    }
  }
}

struct Recorded {
  const char* file;
  std::map<std::string, std::string> set;
  int steps;
};
const Recorded recorded[] = {
    {"pendulum/flexible.yaml", {}, 50},
    {"double-four-bar/mechanism.yaml", {}, 50},
    {"slider-crank/slider-crank.yaml", {}, 50},
    {"iltis/suspension.yaml", {}, 100},
    {"iltis/vehicle.yaml", {}, 100},
    {"iltis/drive.yaml", {}, 100},
    {"iltis/anti-lock.yaml", {}, 100},
    {"robot/model.yaml", {}, 50},
    {"ball-cascade/model.yaml", {}, 50},
    {"spin-up-beam/beam-3d.yaml", {{"method", "geometric_stiffness"}}, 50},
    {"stewart-platform/model.yaml", {}, 50},
    {"wind-turbine/model.yaml", {}, 50},
};

/// On every machine with the baseline's processor. Where a change of the library changes them on purpose, the
/// table is made again with MIMBRE_RECORD_BITS=1 in the environment, and the commit says why.
TEST(Bits, AreThoseRecorded) {
  const std::string path = std::string(MIMBRE_SOURCE_DIR) + "/tests/data/bits/recorded.txt";
  std::string now;
  for (const Recorded& r : recorded) {
    Simulation s(example(r.file, r.set));
    Hash64 hash;
    ResultsRow row;
    for (int k = 0; k < r.steps; ++k) {
      const StepReport report = s.step();
      ASSERT_TRUE(report.ok()) << r.file << ": " << s.explain(report);
      s.sample(row);
      add(hash, row.poses.reshaped());
      add(hash, row.modes);
    }
    now += fmt::format("{:016x} {} {}\n", hash.value(), r.steps, r.file);
  }
  if (std::getenv("MIMBRE_RECORD_BITS")) std::ofstream(path) << now;
  std::stringstream known;
  known << std::ifstream(path).rdbuf();
  EXPECT_EQ(now, known.str());
}

}  // namespace
}  // namespace mimbre::test::bits_test
