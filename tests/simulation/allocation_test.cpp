#include <gtest/gtest.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "live/input_board.h"
#include "live/picture.h"
#include "mimbre/real_time.h"
#include "mimbre/real_time_recorder.h"
#include "mimbre/simulation.h"
#include "support/models.h"

/// The step allocates nothing. All roads to the heap of this program are counted, except under sanitizers,
/// which bring their own.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#if defined(__has_feature)
#if !__has_feature(address_sanitizer) && !__has_feature(thread_sanitizer)
#define MIMBRE_COUNT_ALLOCATIONS
#endif
#else
#define MIMBRE_COUNT_ALLOCATIONS
#endif
#endif

#ifdef MIMBRE_COUNT_ALLOCATIONS

namespace {
/// Of the thread that counts; others may be at work beside it.
thread_local constinit bool counting = false;
thread_local constinit long allocations = 0;
void count() {
  if (counting) ++allocations;
}
}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) {
  count();
  return __libc_calloc(number, size);
}
void* realloc(void* old, std::size_t size) {
  count();
  return __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  count();
  *out = __libc_memalign(alignment, size);
  return *out ? 0 : ENOMEM;
}
}

namespace mimbre::test::allocation_test {
namespace {

long allocations_of(Simulation& s, int steps) {
  bool ok = true;
  allocations = 0;
  counting = true;
  for (int k = 0; k < steps; ++k) ok = s.step().ok() && ok;
  counting = false;
  EXPECT_TRUE(ok);
  return allocations;
}

TEST(AllocationCount, IsCounted) {
  counting = true;
  allocations = 0;
  const auto* number = new int(3);
  Eigen::VectorXd x = Eigen::VectorXd::Constant(*number, 1.0);
  counting = false;
  EXPECT_GE(allocations, 2);
  EXPECT_EQ(x.size(), 3);
  delete number;
}

class Allocation : public testing::TestWithParam<spec::Simulation::Formulation> {
 protected:
  RunOptions options() const {
    RunOptions o;
    o.formulation = GetParam();
    return o;
  }
};
INSTANTIATE_TEST_SUITE_P(Formulations, Allocation,
                         testing::Values(spec::Simulation::Formulation::relative,
                                         spec::Simulation::Formulation::natural),
                         [](const auto& formulation) {
                           return formulation.index == 0 ? "relative" : "natural";
                         });

TEST_P(Allocation, NoneInTheStepsOfTheFlexibleVehicle) {
  Simulation s(example("iltis/vehicle.yaml"), options());
  EXPECT_EQ(allocations_of(s, 1000), 0);
}

/// Tables of loops, with and without amplitudes.
TEST(AllocationByTablesOfLoops, None) {
  RunOptions options;
  options.formalism = spec::Simulation::Formalism::global_modes;
  for (const char* file : {"slider-crank/slider-crank.yaml", "iltis/suspension.yaml", "iltis/vehicle.yaml"}) {
    Simulation s(example(file), options);
    EXPECT_EQ(allocations_of(s, 300), 0) << file;
  }
}

/// Bristles so short that corrections leap across where they stick, and a start at which some break away.
TEST_P(Allocation, NoneWhereFrictionSticks) {
  Simulation s(model_of(four_bar_text({{"crank", ", velocity: 4"}}) + R"yaml(
frictions:
  a: {joint: crank, torque: 0.2, sticking: 1e-9}
  b: {joint: crank_pin, torque: 0.3, sticking: 1e-8, static_ratio: 1.3}
  c: {joint: rocker, torque: 0.2, sticking: 1e-9}
)yaml"),
               options());
  EXPECT_EQ(allocations_of(s, 300), 0);
}

/// By transfer matrices: of trees, of loops, and of forces between bodies that are not neighbours.
TEST(AllocationByTransferMatrices, None) {
  RunOptions options;
  options.formalism = spec::Simulation::Formalism::transfer_matrices;
  for (const char* file : {"pendulum/flexible.yaml", "robot/model.yaml", "iltis/vehicle.yaml"}) {
    Simulation s(example(file), options);
    EXPECT_EQ(allocations_of(s, 300), 0) << file;
  }
  Simulation geared(geared_four_bar(), options);
  EXPECT_EQ(allocations_of(geared, 200), 0);
}

/// Drives, expressions of time, quaternion joints, flexible bodies and a singular position.
TEST_P(Allocation, NoneInOtherMechanisms) {
  for (const char* file :
       {"slider-crank/slider-crank.yaml", "double-four-bar/mechanism.yaml", "pendulum/flexible.yaml"}) {
    Simulation s(example(file), options());
    EXPECT_EQ(allocations_of(s, 300), 0) << file;
  }
  Simulation contacts(die_and_ball(), options());
  EXPECT_EQ(allocations_of(contacts, 300), 0);
  Simulation swarm(example("../bench/swarm.yaml", {{"layers", "1"}}), options());
  EXPECT_EQ(allocations_of(swarm, 200), 0);
  Simulation beam(example("spin-up-beam/beam-3d.yaml", {{"method", "geometric_stiffness"}}), options());
  EXPECT_EQ(allocations_of(beam, 300), 0);
  const auto model =
      model_of(four_bar_text({{"crank", R"yaml(, drive: {position: "0.5*sin(4*t)"})yaml"}}) + R"yaml(
springs:
  law:
    between: [ground, coupler]
    at: [[0.3, 0, 0.8], [0.3, 0, 0.35]]
    force: "20*(l - 0.4) + 3*v*l + sin(5*t)"
loads:
  push: {on: rocker, at: [0.6, 0, 0.3], force: [2, 0, 1], scale: "cos(3*t)", follower: true}
)yaml");
  Simulation s(model, options());
  EXPECT_EQ(allocations_of(s, 200), 0);
  Simulation geared(geared_four_bar(), options());
  EXPECT_EQ(allocations_of(geared, 200), 0);
}

/// Trees, loops, modes, blocks and actuators.
TEST_P(Allocation, NoneWithRungeKuttaMethods) {
  using Integrator = spec::Simulation::Integrator;
  for (const auto& [integrator, accuracy] :
       {std::pair(Integrator::rk4, 0.0), std::pair(Integrator::dopri853, 0.0),
        std::pair(Integrator::dopri853, 1e-8), std::pair(Integrator::radau, 0.0),
        std::pair(Integrator::radau, 1e-8)})
    for (const auto& model : {example("double-four-bar/mechanism.yaml"), example("pendulum/flexible.yaml"),
                              controlled_four_bar()}) {
      RunOptions o = options();
      o.integrator = integrator;
      if (accuracy > 0) o.accuracy = accuracy;
      o.step = 2e-3;
      Simulation s(model, o);
      EXPECT_EQ(allocations_of(s, 300), 0) << accuracy;
    }
}

/// Loops with redundant equations, by the formalisms that choose equations and coordinates in every step.
TEST_P(Allocation, NoneWithEveryFormalism) {
  using Formalism = spec::Simulation::Formalism;
  for (const Formalism formalism : {Formalism::index1, Formalism::baumgarte, Formalism::independent,
                                    Formalism::penalty, Formalism::index1_augmented})
    for (const auto& model : {example("bricard/mechanism.yaml"), controlled_four_bar()}) {
      RunOptions o = options();
      o.formalism = formalism;
      o.step = 1e-3;
      Simulation s(model, o);
      ASSERT_TRUE(s.step().ok());  // finds how many coordinates are independent
      EXPECT_EQ(allocations_of(s, 200), 0) << static_cast<int>(formalism);
    }
}

/// Held between hinges, so that all that linear modes neglect there is watched.
TEST_P(Allocation, NoneInTheWatchOverHeldBodies) {
  Simulation s(model_of(R"yaml(
materials: {steel: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {flat: {type: rectangle, width: 0.02, height: 0.002}}
bodies:
  strip:
    frame: {at: [0, 0, 0]}
    flexible:
      material: steel
      section: flat
      nodes: {a: [0, 0, 0], m: [0.5, 0, 0], e: [1, 0, 0]}
      bars: {x: {from: a, to: m, elements: 5}, y: {from: m, to: e, elements: 5}}
      clamped: [a]
      stiffness_damping: 1e-3
      static_modes: [{node: m, all: true}, {node: e, all: true}]
      dynamic_modes: 3
joints:
  start: {type: revolute, between: [ground, strip], at: [0, 0, 0], axis: [0, 1, 0]}
  end: {type: revolute, between: [ground, strip], at: [1, 0, 0], axis: [0, 1, 0], cut: always}
loads: {load: {on: strip.m, force: [0, 0, 0.3]}}
simulation: {step: 1e-3, end: 1}
)yaml"),
               options());
  EXPECT_EQ(allocations_of(s, 200), 0);
  EXPECT_GT(s.validity().at(0).held.value, 1e-3);
}

TEST_P(Allocation, NoneWithConstraints) {
  Simulation s(every_constraint(), options());
  EXPECT_EQ(allocations_of(s, 200), 0);
}

/// Inputs set before each step, and channels read after it.
TEST_P(Allocation, NoneWithInputsSetAndChannelsRead) {
  Simulation s(controlled_four_bar(), options());
  const int wanted = s.input("wanted"), wind = s.input("wind"), k = s.input("k");
  std::vector<Simulation::Channel> channels;
  for (const char* name : {"signal.error", "signal.lift", "actuator.motor.force", "bushing.mount.force.rx",
                           "joint.rocker.position", "spring.tuned.force", "energy.dissipated"})
    channels.push_back(s.channel(name));
  double sum = 0;
  for (const Simulation::Channel channel : channels) sum += s.value(channel);
  long all = 0;
  for (int step = 0; step < 1000; ++step) {
    bool ok = true;
    allocations = 0;
    counting = true;
    s.set_input(wanted, 0.3 * std::sin(0.02 * step));
    s.set_input(wind, 1 + 0.1 * std::cos(0.05 * step));
    s.set_input(k, 30 + 0.01 * step);
    ok = s.step().ok();
    for (const Simulation::Channel channel : channels) sum += s.value(channel);
    counting = false;
    all += allocations;
    ASSERT_TRUE(ok) << step;
  }
  EXPECT_EQ(all, 0);
  EXPECT_TRUE(std::isfinite(sum));
}

/// Single channels, poses and saved states, where each was asked for once before.
TEST_P(Allocation, NoneInLookingAtTheVehicle) {
  Simulation s(example("iltis/vehicle.yaml"), options());
  std::vector<Simulation::Channel> channels;
  for (const ChannelInfo& channel : s.channels()) channels.push_back(s.channel(channel.name));
  std::vector<Simulation::Body> bodies;
  for (const spec::Body& body : s.model().spec().bodies) bodies.push_back(s.body(body.name));
  Simulation::Snapshot state;
  double sum = 0;
  const auto look = [&] {
    for (const Simulation::Channel channel : channels) sum += s.value(channel);
    for (const Simulation::Body body : bodies) sum += s.pose(body).position[0];
    s.save(state);
  };
  look();
  allocations = 0;
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(s.step().ok());
    counting = true;
    look();
    counting = false;
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_TRUE(std::isfinite(sum));
}

/// The loop in real time with inputs that change, pictures and a recording.
TEST_P(Allocation, NoneInTheLoopAgainstTheClock) {
  RunOptions of_run = options();
  of_run.step = 0.001;
  Simulation s(controlled_four_bar(), of_run);
  RealTimeOptions of_loop;
  of_loop.lock_memory = false;
  of_loop.speed = 10;
  of_loop.duration = 1;
  RealTimeLoop loop(s, of_loop);
  live::InputBoard board(s);
  live::PictureMaker pictures(s, loop.step() / of_loop.speed);
  live::Choice choice;
  choice.count = std::min(live::Choice::most, static_cast<int>(s.channels().size()));
  for (int k = 0; k < choice.count; ++k) choice.channels[static_cast<std::size_t>(k)] = k;
  pictures.choose(choice);
  const std::string file =
      testing::TempDir() + "/allocation-" + std::to_string(static_cast<int>(GetParam())) + ".h5";
  RealTimeRecorder recorder(file, s, "{}", 0.01);
  struct Counts : RealTimePart {
    live::InputBoard* board = nullptr;
    int steps = 0;
    void before(Simulation&) override {
      if (++steps == 100) counting = true;
      board->set(0, 1e-4 * steps);
      if (steps == 990) counting = false;
    }
  } counts;
  counts.board = &board;
  loop.add(counts);
  loop.add(board);
  loop.add(pictures);
  loop.add(recorder);
  allocations = 0;
  EXPECT_EQ(loop.run(), "");
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(loop.monitor().steps, 1000);
  recorder.finish(loop, "");
  std::remove(file.c_str());
}

}  // namespace
}  // namespace mimbre::test::allocation_test

#endif
