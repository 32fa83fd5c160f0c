#include "mimbre/exchange.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <limits>
#include <random>
#include <thread>

#include "mimbre/diagnostics.h"
#include "mimbre/exchange_layout.h"
#include "mimbre/unknown_name.h"
#include "support/clocked.h"
#include "support/models.h"
#include "support/simulate.h"

namespace mimbre::test::exchange_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double long_wait =
    10;  ///< s, the longest that there is: whoever answers may have to wait for its turn

Simulation four_bar() { return simulation_of(controlled_four_bar(), Formulation::relative, 0.005); }

/// The other program.
class Peer {
 public:
  explicit Peer(int port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  }
  ~Peer() { close(socket_); }
  void send(int kind, std::uint64_t layout, std::uint64_t sequence, const std::vector<double>& values = {}) {
    const mimbre_exchange_head head{MIMBRE_EXCHANGE_MAGIC,
                                    static_cast<std::uint16_t>(kind),
                                    static_cast<std::uint16_t>(values.size()),
                                    layout,
                                    sequence,
                                    0};
    std::string bytes(sizeof head + sizeof(double) * values.size(), '\0');
    std::memcpy(bytes.data(), &head, sizeof head);
    std::memcpy(bytes.data() + sizeof head, values.data(), sizeof(double) * values.size());
    raw(bytes);
  }
  void raw(const std::string& bytes) { (void)::send(socket_, bytes.data(), bytes.size(), 0); }
  /// The next packet; false where none comes for a while.
  bool take(mimbre_exchange_head& head, std::string& body, int milliseconds = 120'000) {
    pollfd ready{socket_, POLLIN, 0};
    if (poll(&ready, 1, milliseconds) <= 0) return false;
    std::string bytes(70'000, '\0');
    const ssize_t size = recv(socket_, bytes.data(), bytes.size(), 0);
    if (size < static_cast<ssize_t>(sizeof head)) return false;
    std::memcpy(&head, bytes.data(), sizeof head);
    body = bytes.substr(sizeof head, static_cast<std::size_t>(size) - sizeof head);
    return true;
  }

 private:
  int socket_;
};

/// Who only answers what it is told, with the values that the inputs have anyway, changes nothing: the same
/// bits, and a time for each round trip.
TEST(UdpExchange, AnEchoLeavesTheMotionAsItIs) {
  Simulation coupled = four_bar(), alone = four_bar();
  RealTimeLoop loop(coupled, quick_loop());
  // The model's events set another one.
  UdpExchange udp(coupled, UdpOptions{{{}, {coupled.inputs()[0].name}}, "127.0.0.1", 0, long_wait});
  loop.add(udp);
  const std::vector<double> values{coupled.inputs()[0].start};
  Peer peer(udp.port());
  peer.send(MIMBRE_EXCHANGE_HELLO, 0, 0);
  int outputs = 0;
  std::thread echo([&] {
    mimbre_exchange_head head{};
    std::string body;
    std::uint64_t last = 0;
    while (outputs < 100 && peer.take(head, body)) {
      if (head.kind != MIMBRE_EXCHANGE_OUTPUTS) continue;
      EXPECT_EQ(head.sequence, ++last);
      EXPECT_EQ(body.size(), sizeof(double) * head.count);
      ++outputs;
      peer.send(MIMBRE_EXCHANGE_INPUTS, head.layout, head.sequence, values);
    }
  });
  loop.run();
  echo.join();
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(alone.step().ok());
  const Simulation::Snapshot one = coupled.save(), other = alone.save();
  EXPECT_EQ(one.time, other.time);
  EXPECT_TRUE(one.q == other.q && one.v == other.v && one.a == other.a && one.u == other.u);
  EXPECT_EQ(outputs, 100);
  mimbre_exchange_head more{};
  std::string body;
  EXPECT_FALSE(peer.take(more, body, 0));
  EXPECT_EQ(udp.round_trips().count(), 99);  // nobody waits for the last
  EXPECT_EQ(udp.missed(), 0);
}

/// Inputs from outside are those set by hand before the same steps.
TEST(UdpExchange, AControllerOutsideIsAControllerInside) {
  Simulation outside = four_bar(), inside = four_bar();
  const std::string input = inside.inputs()[0].name;
  const std::string output = inside.channels()[0].name;
  const auto law = [&](double y) {
    return std::clamp(inside.inputs()[0].start - 0.01 * y, inside.inputs()[0].min, inside.inputs()[0].max);
  };
  RealTimeLoop loop(outside, quick_loop());
  UdpExchange udp(outside, UdpOptions{{{output}, {input}}, "127.0.0.1", 0, long_wait});
  loop.add(udp);
  Peer peer(udp.port());
  peer.send(MIMBRE_EXCHANGE_HELLO, 0, 0);
  std::thread controller([&] {
    mimbre_exchange_head head{};
    std::string body;
    for (int outputs = 0; outputs < 100 && peer.take(head, body);) {
      if (head.kind == MIMBRE_EXCHANGE_NAMES) {
        EXPECT_EQ(body.substr(0, body.find('\t')), "outputs 1\n" + output);
        EXPECT_THAT(body, testing::HasSubstr("inputs 1\n" + input + "\t"));
      }
      if (head.kind != MIMBRE_EXCHANGE_OUTPUTS) continue;
      ++outputs;
      double y = 0;
      std::memcpy(&y, body.data(), sizeof y);
      peer.send(MIMBRE_EXCHANGE_INPUTS, head.layout, head.sequence, {law(y)});
    }
  });
  loop.run();
  controller.join();
  ASSERT_EQ(udp.missed(), 0);
  for (int k = 0; k < 100; ++k) {
    if (k > 0) inside.set_input(0, law(inside.value({0})));
    ASSERT_TRUE(inside.step().ok());
  }
  EXPECT_EQ(outside.time(), inside.time());
  EXPECT_EQ(outside.value({0}), inside.value({0}));
}

TEST(UdpExchange, RubbishAndStrangersAreRefused) {
  Simulation simulation = four_bar();
  const double before = simulation.input_value(0);
  UdpExchange udp(simulation, UdpOptions{{{}, {simulation.inputs()[0].name}}, "127.0.0.1", 0, 0});
  Peer peer(udp.port()), stranger(udp.port());
  peer.send(MIMBRE_EXCHANGE_HELLO, 0, 0);
  udp.before(simulation);
  mimbre_exchange_head head{};
  std::string body;
  ASSERT_TRUE(peer.take(head, body));
  std::mt19937 random(7);
  int sent = 0;
  for (int k = 0; k < 40; ++k) {
    std::string bytes(random() % 200, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    peer.raw(bytes);
    ++sent;
  }
  peer.send(MIMBRE_EXCHANGE_INPUTS, head.layout + 1, 0, {0.25});
  peer.send(MIMBRE_EXCHANGE_INPUTS, head.layout, 0, {0.25, 0.5});
  peer.send(MIMBRE_EXCHANGE_INPUTS, head.layout, 99, {0.25});
  stranger.send(MIMBRE_EXCHANGE_INPUTS, head.layout, 0, {0.25});
  udp.before(simulation);
  EXPECT_EQ(udp.refused(), 32) << "the work of a step is bounded";
  udp.before(simulation);
  EXPECT_EQ(udp.refused(), sent + 4);
  EXPECT_EQ(simulation.input_value(0), before);
  peer.send(MIMBRE_EXCHANGE_INPUTS, head.layout, 0, {nan});
  udp.before(simulation);
  EXPECT_EQ(simulation.input_value(0), before);
  const double wanted = std::min(simulation.inputs()[0].max, before + 0.125);
  peer.send(MIMBRE_EXCHANGE_INPUTS, head.layout, 0, {wanted});
  udp.before(simulation);
  EXPECT_EQ(simulation.input_value(0), wanted);
}

/// However large the packets are, and however many say hello at once.
TEST(UdpExchange, AFloodOfStrangersCostsLittle) {
  Simulation simulation = four_bar();
  UdpExchange udp(simulation, UdpOptions{{{}, {simulation.inputs()[0].name}}, "127.0.0.1", 0, 0});
  Peer peer(udp.port()), stranger(udp.port());
  for (int k = 0; k < 10; ++k) peer.send(MIMBRE_EXCHANGE_HELLO, 0, 0);
  udp.before(simulation);
  mimbre_exchange_head head{};
  std::string body;
  ASSERT_TRUE(peer.take(head, body));
  EXPECT_EQ(head.kind, MIMBRE_EXCHANGE_NAMES);
  EXPECT_FALSE(peer.take(head, body, 0)) << "one answer is enough";
  const std::string large(60'000, 'x'), small(40, 'x');
  double worst = 0;
  for (int round = 0; round < 40; ++round) {
    for (int k = 0; k < 64; ++k) stranger.raw(round % 2 ? large : small);
    const auto begin = std::chrono::steady_clock::now();
    udp.before(simulation);
    worst = std::max(worst, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  RecordProperty("worst_us", static_cast<int>(1e6 * worst));
  EXPECT_GT(udp.refused(), 20);
  // What is whole is still taken.
  for (std::int64_t before = -1; udp.refused() != before;) {
    before = udp.refused();
    udp.before(simulation);
  }
  const double wanted = simulation.input_value(0) - 0.125;
  peer.send(MIMBRE_EXCHANGE_INPUTS, head.layout, 0, {wanted});
  udp.before(simulation);
  EXPECT_EQ(simulation.input_value(0), wanted);
}

TEST(UdpExchange, ASilentPeerCostsTheWaitAndNoMore) {
  Simulation simulation = four_bar();
  RealTimeOptions options = quick_loop();
  options.duration = 0.05;
  RealTimeLoop loop(simulation, options);
  UdpExchange udp(simulation, UdpOptions{{}, "127.0.0.1", 0, 0.01});
  loop.add(udp);
  Peer peer(udp.port());
  peer.send(MIMBRE_EXCHANGE_HELLO, 0, 0);
  loop.run();
  EXPECT_EQ(udp.missed(), 9);
  EXPECT_EQ(loop.monitor().steps, 10);
}

/// Also while no steps are made; and who no longer answers is let go.
TEST(UdpExchange, HelloIsAnsweredAtRestAndWhoHasGoneIsLetGo) {
  Simulation simulation = four_bar();
  UdpExchange udp(simulation, UdpOptions{{}, "127.0.0.1", 0, 1e-4});
  Peer peer(udp.port());
  peer.send(MIMBRE_EXCHANGE_HELLO, 0, 0);
  udp.rests(simulation);
  mimbre_exchange_head head{};
  std::string body;
  ASSERT_TRUE(peer.take(head, body));
  EXPECT_EQ(head.kind, MIMBRE_EXCHANGE_NAMES);
  for (int k = 0; k < 150; ++k) {
    udp.before(simulation);
    const StepReport report = simulation.step();
    udp.after(simulation, report, true);
  }
  EXPECT_EQ(udp.missed(), 100);
}

TEST(UdpExchange, NamesAndPortsAreChecked) {
  Simulation simulation = four_bar();
  EXPECT_THROW(UdpExchange(simulation, UdpOptions{{{"nothing"}, {}}, "127.0.0.1", 0, 0}), UnknownName);
  EXPECT_THROW(UdpExchange(simulation, UdpOptions{{{}, {"nothing"}}, "127.0.0.1", 0, 0}), UnknownName);
  EXPECT_THROW(UdpExchange(simulation, UdpOptions{{}, "here", 0, 0}), InputError);
  EXPECT_THROW(UdpExchange(simulation, UdpOptions{{}, "127.0.0.1", 0, -1}), InputError);
  const UdpExchange first(simulation, {});
  EXPECT_THROW(UdpExchange(simulation, UdpOptions{{}, "127.0.0.1", first.port(), 0}), std::runtime_error);
}

class Mapped {
 public:
  explicit Mapped(const std::string& name) {
    const int file = shm_open(name.c_str(), O_RDWR, 0);
    EXPECT_GE(file, 0);
    memory_ = static_cast<mimbre_exchange_memory*>(
        mmap(nullptr, 1 << 16, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0));
    close(file);
  }
  ~Mapped() { munmap(memory_, 1 << 16); }
  const mimbre_exchange_memory& head() const { return *memory_; }
  mimbre_exchange_block* block(std::uint32_t place) {
    return reinterpret_cast<mimbre_exchange_block*>(reinterpret_cast<char*>(memory_) + place);
  }

 private:
  mimbre_exchange_memory* memory_;
};

TEST(SharedMemoryExchange, HandsValuesBothWays) {
  Simulation simulation = four_bar();
  const std::string name = "mimbre-test-" + std::to_string(getpid());
  auto exchange = std::make_unique<SharedMemoryExchange>(simulation, name,
                                                         ExchangeOptions{{}, {simulation.inputs()[0].name}});
  EXPECT_THROW(SharedMemoryExchange(simulation, name, {}), std::runtime_error);
  Mapped mapped("/" + name);
  EXPECT_EQ(mapped.head().magic, MIMBRE_EXCHANGE_MAGIC);
  EXPECT_EQ(mapped.head().alive, 1u) << "it has not begun, which is not that it has ended";
  EXPECT_EQ(mapped.head().outputs, static_cast<std::uint32_t>(simulation.output_count()));
  EXPECT_EQ(mapped.head().inputs, 1u);
  const double before = simulation.input_value(0),
               wanted = std::min(simulation.inputs()[0].max, before + 0.125);
  exchange->before(simulation);
  EXPECT_EQ(simulation.input_value(0), before);  // nobody has written yet
  mimbre_exchange_write(mapped.block(mapped.head().input_block), 1, 0, &wanted, 1);
  exchange->before(simulation);
  EXPECT_EQ(simulation.input_value(0), wanted);
  const StepReport report = simulation.step();
  exchange->after(simulation, report, true);
  std::vector<double> values(mapped.head().outputs);
  std::uint64_t sequence = 0;
  double time = 0;
  ASSERT_TRUE(mimbre_exchange_read(mapped.block(mapped.head().output_block), &sequence, &time, values.data(),
                                   mapped.head().outputs));
  EXPECT_EQ(sequence, 1u);
  EXPECT_EQ(time, simulation.time());
  for (int k = 0; k < simulation.output_count(); ++k)
    EXPECT_EQ(values[static_cast<std::size_t>(k)], simulation.value({k}));
  EXPECT_EQ(mapped.head().alive, 2u);
  exchange.reset();
  EXPECT_EQ(mapped.head().alive, 0u);
  EXPECT_LT(shm_open(("/" + name).c_str(), O_RDWR, 0), 0);
}

/// What is read is of one time, however often it is written meanwhile.
TEST(SharedMemoryExchange, WhatIsReadIsWhole) {
  struct {
    mimbre_exchange_block block;
    double values[32];
  } shared{};
  std::atomic<bool> over{false};
  std::thread writer([&] {
    std::vector<double> values(32);
    for (int k = 1; k <= 100'000; ++k) {
      values.assign(32, k);
      mimbre_exchange_write(&shared.block, static_cast<std::uint64_t>(k), k, values.data(), 32);
    }
    over = true;
  });
  std::vector<double> values(32);
  std::uint64_t sequence = 0;
  double time = 0;
  for (bool ends = false; !ends;) {
    ends = over;
    if (!mimbre_exchange_read(&shared.block, &sequence, &time, values.data(), 32)) continue;
    for (const double value : values) ASSERT_EQ(value, time);
    ASSERT_EQ(static_cast<double>(sequence), time);
  }
  writer.join();
}

}  // namespace
}  // namespace mimbre::test::exchange_test
