#include "mimbre/real_time.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <thread>

#include "live/host.h"
#include "mimbre/diagnostics.h"
#include "support/clocked.h"
#include "support/models.h"
#include "support/simulate.h"

namespace mimbre::test::real_time_test {
namespace {

using State = RealTimeLoop::State;
using Kind = RealTimeRequest::Kind;

/// What a test does in the loop.
struct Part : RealTimePart {
  std::function<void(Simulation&)> on_before, on_after, on_rest;
  std::vector<StepTiming> timings;
  std::vector<bool> outputs;
  void before(Simulation& s) override {
    if (on_before) on_before(s);
  }
  void after(Simulation& s, const StepReport&, bool output) override {
    outputs.push_back(output);
    if (on_after) on_after(s);
  }
  void timed(const StepTiming& t) override { timings.push_back(t); }
  void rests(Simulation& s) override {
    if (on_rest) on_rest(s);
  }
};

Simulation four_bar() { return simulation_of(controlled_four_bar(), Formulation::relative, 0.005); }

void busy_for(double seconds) {
  const auto end = live::thread_cpu_now() + static_cast<std::int64_t>(1e9 * seconds);
  while (live::thread_cpu_now() < end) {
  }
}

/// The clock and the rehearsal leave no trace in the motion.
TEST(RealTimeLoop, MakesTheStepsOfARun) {
  Simulation clocked = four_bar(), plain = four_bar();
  RealTimeLoop loop(clocked, quick_loop());
  EXPECT_EQ(loop.run(), "");
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(plain.step().ok());
  EXPECT_EQ(loop.state(), State::ended);
  EXPECT_EQ(loop.monitor().steps, 100);
  EXPECT_EQ(loop.time(), plain.time());
  EXPECT_EQ(clocked.save().bytes(), plain.save().bytes());
}

/// A request that comes with the last step does not make it begin again.
TEST(RealTimeLoop, EndsWhateverIsAskedForAtItsEnd) {
  Simulation simulation = four_bar();
  RealTimeLoop loop(simulation, quick_loop());
  Part part;
  part.on_after = [&](Simulation&) { loop.request({Kind::reset}); };
  loop.add(part);
  EXPECT_EQ(loop.run(), "");
  EXPECT_EQ(loop.monitor().steps, 100);
}

TEST(RealTimeLoop, NoStepBeginsBeforeItIsDue) {
  Simulation simulation = four_bar();
  RealTimeLoop loop(simulation, quick_loop());
  Part part;
  std::vector<std::int64_t> begins;
  begins.reserve(100);
  part.on_before = [&](Simulation&) { begins.push_back(live::clock_now()); };
  loop.add(part);
  loop.run();
  ASSERT_EQ(begins.size(), 100u);
  const double period = 0.005 / 10;
  // When the first was due by what was measured of step k, which may have been taken from the processor
  // before it could look at the clock: one of ten was not.
  const auto due = [&](std::size_t k) {
    const StepTiming& t = part.timings[k];
    return 1e-9 * static_cast<double>(begins[k] - begins[0]) - t.latency - t.behind -
           static_cast<double>(k) * period;
  };
  double first = due(0);
  for (std::size_t k = 1; k < 10; ++k) first = std::min(first, due(k));
  for (std::size_t k = 10; k < begins.size(); ++k) {
    const double since = 1e-9 * static_cast<double>(begins[k] - begins[0]) - first;
    EXPECT_GE(since, static_cast<double>(k) * period - 2e-5) << k;
  }
  for (const StepTiming& t : part.timings) {
    EXPECT_GE(t.latency, 0);
    EXPECT_GE(t.behind, 0);
    EXPECT_GT(t.computation, 0);
    EXPECT_LE(t.cpu, t.computation + 1e-4);
  }
}

/// One step that takes five of its periods: an overrun by computation; those after it are late until the
/// clock is caught up with.
TEST(RealTimeLoop, AnOverrunIsSeenWithItsCauseAndCaughtUpWith) {
  Simulation simulation = four_bar();
  RealTimeOptions options = quick_loop();
  options.speed = 0.5;  // 10 ms a step
  options.duration = 0.2;
  options.overrun = Overrun::skip_output;
  RealTimeLoop loop(simulation, options);
  Part part;
  int step = 0;
  part.on_before = [&](Simulation&) {
    if (++step == 11) busy_for(0.05);
  };
  loop.add(part);
  loop.run();
  const RealTimeMonitor& m = loop.monitor();
  const auto& slow = part.timings[10];
  EXPECT_TRUE(slow.overrun);
  EXPECT_GE(slow.cpu, 0.05);
  EXPECT_GE(m.overrun_count(), 1);
  EXPECT_GE(m.late, 3);
  EXPECT_GE(part.timings[11].behind, 0.039);
  EXPECT_FALSE(part.outputs[11]);
  EXPECT_EQ(m.skipped_outputs, std::count(part.outputs.begin(), part.outputs.end(), false));
  EXPECT_GE(m.cpu.worst(), 0.05);
}

TEST(RealTimeLoop, TheClockMaySlowDown) {
  Simulation simulation = four_bar();
  RealTimeOptions options = quick_loop();
  options.speed = 0.5;
  options.duration = 0.05;
  options.overrun = Overrun::slow_down;
  RealTimeLoop loop(simulation, options);
  Part part;
  int step = 0;
  part.on_before = [&](Simulation&) {
    if (++step == 3) busy_for(0.05);
  };
  loop.add(part);
  loop.run();
  EXPECT_GE(loop.monitor().lag, 0.039);
  for (const StepTiming& t : part.timings) EXPECT_LT(t.behind, 1e-6);
}

TEST(RealTimeLoop, AnOverrunMayEndIt) {
  Simulation simulation = four_bar();
  RealTimeOptions options = quick_loop();
  options.speed = 0.5;
  options.overrun = Overrun::stop;
  RealTimeLoop loop(simulation, options);
  Part part;
  part.on_before = [&](Simulation&) { busy_for(0.02); };
  loop.add(part);
  EXPECT_THAT(loop.run(), testing::HasSubstr("was not ready in time"));
  EXPECT_EQ(loop.state(), State::failed);
  EXPECT_EQ(loop.monitor().steps, 1);
}

/// A step that takes longer than the whole thread's share by waiting was not at work. The second begins as
/// soon as the first is done: that it was woken late is no cause.
TEST(RealTimeLoop, WaitingIsNoComputation) {
  Simulation simulation = four_bar();
  RealTimeOptions options = quick_loop();
  options.speed = 1;
  options.duration = 0.1;
  RealTimeLoop loop(simulation, options);
  Part part;
  int step = 0;
  part.on_before = [&](Simulation&) {
    if (++step == 15 || step == 16) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  };
  loop.add(part);
  loop.run();
  EXPECT_GE(loop.monitor().overruns[static_cast<std::size_t>(OverrunCause::preemption)], 1);
  for (const std::size_t k : {14, 15}) EXPECT_GE(part.timings[k].computation - part.timings[k].cpu, 0.09);
}

TEST(RealTimeLoop, PausesStepsResetsAndReturnsToSnapshots) {
  Simulation simulation = four_bar();
  const Simulation::Snapshot beginning = simulation.save();
  RealTimeOptions options = quick_loop();
  options.duration = std::numeric_limits<double>::infinity();
  options.rests_at_end = true;
  RealTimeLoop loop(simulation, options);
  Part part;
  std::vector<std::byte> at_rest;
  std::atomic<int> rests{0};
  part.on_rest = [&](Simulation& s) {
    at_rest = s.save().bytes();
    ++rests;
  };
  loop.add(part);
  std::thread runs([&] { loop.run(); });
  ASSERT_TRUE(comes_true([&] { return loop.monitor().steps > 20; }));
  ASSERT_TRUE(loop.request({Kind::pause}));
  ASSERT_TRUE(comes_true([&] { return loop.state() == State::paused; }));
  const double paused_at = loop.time();
  const std::int64_t steps = loop.monitor().steps;
  loop.request({Kind::save, 3});
  loop.request({Kind::step});
  ASSERT_TRUE(comes_true([&] { return loop.monitor().steps == steps + 1; }));
  ASSERT_TRUE(comes_true([&] { return loop.time() > paused_at; }));
  EXPECT_NEAR(loop.time(), paused_at + 0.005, 1e-12);
  loop.request({Kind::restore, 3});
  ASSERT_TRUE(comes_true([&] { return loop.time() == paused_at; }));
  EXPECT_EQ(loop.state(), State::paused);
  loop.request({Kind::restore, 4});  // nothing was saved there
  loop.request({Kind::reset});
  ASSERT_TRUE(comes_true([&] { return loop.time() == 0; }));
  const int rested = rests;
  ASSERT_TRUE(comes_true([&] { return rests > rested + 1; }));
  loop.stop();
  runs.join();
  EXPECT_EQ(at_rest, beginning.bytes());
}

TEST(RealTimeLoop, AFailureIsToldAndAResetGoesOn) {
  // Thrown together so fast that no iteration follows.
  Simulation simulation = four_bar();
  RealTimeOptions options = quick_loop();
  options.rests_at_end = true;
  options.duration = std::numeric_limits<double>::infinity();
  RealTimeLoop loop(simulation, options);
  Part part;
  std::atomic<bool> broken{false};
  part.on_before = [&](Simulation& s) {
    if (!broken.exchange(true)) {
      Simulation::Snapshot bad = s.save();
      bad.v.setConstant(1e200);
      s.restart(bad);
    }
  };
  loop.add(part);
  std::thread runs([&] { loop.run(); });
  ASSERT_TRUE(comes_true([&] { return loop.state() == State::failed; }));
  EXPECT_NE(loop.message(), "");
  loop.request({Kind::reset});
  ASSERT_TRUE(comes_true([&] { return loop.state() == State::running && loop.time() > 0.05; }));
  EXPECT_EQ(loop.message(), "");
  loop.stop();
  runs.join();
}

/// An hour to the next step is no reason not to listen.
TEST(RealTimeLoop, HeedsWhatIsAskedWhileItWaitsForAStep) {
  Simulation simulation = four_bar();
  RealTimeOptions options = quick_loop();
  options.speed = 1e-6;
  options.duration = 100;
  RealTimeLoop loop(simulation, options);
  std::thread runs([&] { loop.run(); });
  ASSERT_TRUE(comes_true([&] { return loop.monitor().steps == 1; }));
  loop.request({Kind::pause});
  EXPECT_TRUE(comes_true([&] { return loop.state() == State::paused; }));
  loop.request({Kind::step});
  EXPECT_TRUE(comes_true([&] { return loop.monitor().steps == 2; }));
  loop.request({Kind::resume});
  EXPECT_TRUE(comes_true([&] { return loop.state() == State::running; }));
  loop.stop();
  runs.join();
}

TEST(RealTimeLoop, RefusesOptionsThatCannotBe) {
  Simulation simulation = four_bar();
  const auto refused = [&](auto&& change) {
    RealTimeOptions options;
    change(options);
    EXPECT_THROW(RealTimeLoop(simulation, options), InputError);
  };
  refused([](auto& o) { o.speed = 0; });
  refused([](auto& o) { o.speed = std::nan(""); });
  refused([](auto& o) { o.duration = -1; });
  refused([](auto& o) { o.priority = 100; });
  refused([](auto& o) { o.spin = 2; });
  refused([](auto& o) { o.snapshots = -1; });
}

TEST(RealTimeLoop, SaysWhatItWasNotGranted) {
  Simulation simulation = four_bar();
  RealTimeOptions options = quick_loop();
  options.duration = 0.01;
  options.processor = 4000;
  RealTimeLoop loop(simulation, options);
  loop.run();
  EXPECT_THAT(loop.granted().processor, testing::StartsWith("any: "));
  EXPECT_EQ(loop.granted().memory, "not locked");
}

TEST(RealTimeLoop, SaysWhatBoundsAStep) {
  RunOptions bounded;
  bounded.substeps = 1;
  bounded.max_iterations = 7;
  Simulation one(geared_four_bar(), bounded);
  // Near a singular position a step of a closed loop is made once more.
  EXPECT_EQ(one.most_attempts(), 2);
  EXPECT_EQ(RealTimeLoop(one, {}).worst_case(),
            "at most 7 iterations in each of at most 2 attempts at a step or its parts");
  bounded.substeps = 4;
  Simulation four(geared_four_bar(), bounded);
  EXPECT_EQ(four.most_attempts(), 10);
  bounded.substeps.reset();
  bounded.fixed_cost = true;
  Simulation fixed(geared_four_bar(), bounded);
  EXPECT_EQ(fixed.most_attempts(), 1);
  EXPECT_EQ(RealTimeLoop(fixed, {}).worst_case(), "at most 7 iterations in a step");
}

TEST(IdleLoop, MeasuresTheMachine) {
  RealTimeMonitor monitor;
  idle_loop(1e-3, 0.05, quick_loop(), monitor);
  EXPECT_EQ(monitor.steps, 50);
  EXPECT_EQ(monitor.latency.count(), 50);
  // The least: of others the processor may have been taken away.
  EXPECT_LT(monitor.computation.quantile(0.02), 1e-4);
}

}  // namespace
}  // namespace mimbre::test::real_time_test
