#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <stdexcept>
#include <utility>

#include "live/exchanged.h"
#include "live/host.h"
#include "mimbre/diagnostics.h"
#include "mimbre/exchange_layout.h"

namespace mimbre {
namespace {

using Head = mimbre_exchange_head;

/// Packets that are taken in one step at most: who sends more is heard later.
constexpr int most_packets = 32;
/// Outputs whose times of sending are remembered.
constexpr std::size_t remembered = 4096;
constexpr std::size_t longest_packet = 65'507, longest_names = 65'000;
/// Who leaves so many steps in a row waiting has gone.
constexpr int most_silent = 100;

union Address {
  sockaddr any;
  sockaddr_in v4;
  sockaddr_in6 v6;
};

/// ns of the clock by which the system stamps packets.
std::int64_t stamp_now() {
  timespec t{};
  clock_gettime(CLOCK_REALTIME, &t);
  return 1'000'000'000 * static_cast<std::int64_t>(t.tv_sec) + t.tv_nsec;
}

/// One packet, and when it arrived: it may have waited for the step that takes it.
struct Arrival {
  ssize_t size = -1;
  socklen_t from_size = 0;
  std::int64_t time = 0;
};

/// Of a longer packet only so much is copied as the place holds, though its size is reported.
Arrival receive(int socket, std::span<char> packet, Address& from) {
  iovec place{packet.data(), packet.size()};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(timespec))];
  msghdr message{};
  message.msg_name = &from.any;
  message.msg_namelen = sizeof from;
  message.msg_iov = &place;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  Arrival arrival;
  arrival.size = recvmsg(socket, &message, MSG_DONTWAIT | MSG_TRUNC);
  if (arrival.size < 0) return arrival;
  arrival.from_size = message.msg_namelen;
  arrival.time = stamp_now();
  for (cmsghdr* header = CMSG_FIRSTHDR(&message); header; header = CMSG_NXTHDR(&message, header)) {
    if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec t{};
    std::memcpy(&t, CMSG_DATA(header), sizeof t);
    arrival.time = 1'000'000'000 * static_cast<std::int64_t>(t.tv_sec) + t.tv_nsec;
  }
  return arrival;
}

Address address_of(const UdpOptions& options, socklen_t& size) {
  Address a{};
  const auto port = htons(static_cast<std::uint16_t>(options.port));
  if (inet_pton(AF_INET, options.address.c_str(), &a.v4.sin_addr) == 1) {
    a.v4.sin_family = AF_INET;
    a.v4.sin_port = port;
    size = sizeof a.v4;
  } else if (inet_pton(AF_INET6, options.address.c_str(), &a.v6.sin6_addr) == 1) {
    a.v6.sin6_family = AF_INET6;
    a.v6.sin6_port = port;
    size = sizeof a.v6;
  } else {
    throw InputError(Mark{}, fmt::format("'{}' is no address of an interface, like 127.0.0.1 or 0.0.0.0",
                                         options.address));
  }
  if (options.port < 0 || options.port > 65535)
    throw InputError(Mark{}, fmt::format("the port is {}; it must be 0 to 65535", options.port));
  return a;
}

}  // namespace

struct UdpExchange::Impl {
  Impl(const Simulation& simulation, const UdpOptions& options)
      : exchanged(simulation, options), wait(options.wait) {
    if (!(wait >= 0) || wait > 10)
      throw InputError(Mark{}, fmt::format("waiting for an answer is {} s; it must be 0 to 10 s", wait));
    if (exchanged.names().size() > longest_names)
      throw InputError(Mark{},
                       fmt::format("the names of what is exchanged take {} bytes, and a packet holds {}: "
                                   "exchange fewer",
                                   exchanged.names().size(), longest_names));
    socklen_t size = 0;
    Address own = address_of(options, size);
    socket = ::socket(own.any.sa_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (socket < 0 || bind(socket, &own.any, size) != 0) {
      const std::string why = std::strerror(errno);
      if (socket >= 0) close(socket);
      throw std::runtime_error(
          fmt::format("cannot take UDP packets at {} port {}: {}", options.address, options.port, why));
    }
    const int on = 1;
    setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    getsockname(socket, &own.any, &size);
    port = ntohs(own.any.sa_family == AF_INET6 ? own.v6.sin6_port : own.v4.sin_port);
    packet.resize(longest_packet);
    longest_taken = sizeof(Head) + sizeof(double) * exchanged.input_count();
    values.resize(std::max(exchanged.output_count(), exchanged.input_count()));
    inputs.resize(exchanged.input_count());
  }
  ~Impl() { close(socket); }

  void send(std::uint16_t kind, std::uint16_t count, std::uint64_t sequence, double time, const void* body,
            std::size_t bytes) {
    const Head head{MIMBRE_EXCHANGE_MAGIC, kind, count, exchanged.layout(), sequence, time};
    std::memcpy(packet.data(), &head, sizeof head);
    std::memcpy(packet.data() + sizeof head, body, bytes);
    // What cannot be sent now is lost, as any packet may be.
    sendto(socket, packet.data(), sizeof head + bytes, 0, &peer.any, peer_size);
  }

  /// Takes one packet. False where there is none.
  bool take() {
    Address from{};
    const Arrival arrival = receive(socket, std::span(packet).first(longest_taken), from);
    const ssize_t size = arrival.size;
    const socklen_t from_size = arrival.from_size;
    if (size < 0) return errno == ECONNREFUSED;  // a peer that has gone; the next may be there
    Head head{};
    if (static_cast<std::size_t>(size) < sizeof head || static_cast<std::size_t>(size) > longest_taken)
      return refuse();
    std::memcpy(&head, packet.data(), sizeof head);
    const std::size_t body = static_cast<std::size_t>(size) - sizeof head;
    if (head.magic != MIMBRE_EXCHANGE_MAGIC) return refuse();
    if (head.kind == MIMBRE_EXCHANGE_HELLO && body == 0) {
      peer = from;
      peer_size = from_size;
      answered = sent;
      silent = 0;
      greeted = true;
      return true;
    }
    const bool known = peer_size == from_size && std::memcmp(&peer, &from, from_size) == 0;
    if (!known || head.layout != exchanged.layout()) return refuse();
    if (head.kind == MIMBRE_EXCHANGE_BYE && body == 0) {
      peer_size = 0;
      return true;
    }
    if (head.kind != MIMBRE_EXCHANGE_INPUTS || head.count != exchanged.input_count() ||
        body != sizeof(double) * head.count || head.sequence > sent ||
        (head.sequence > 0 && head.sequence < answered))
      return refuse();
    std::memcpy(inputs.data(), packet.data() + sizeof head, body);
    news = true;
    silent = 0;
    if (head.sequence > answered && sent - head.sequence < remembered)
      trips.add(1e-9 * static_cast<double>(arrival.time - sent_at[head.sequence % remembered]));
    answered = std::max(answered, head.sequence);
    return true;
  }

  bool refuse() {
    refused.store(refused.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    return true;
  }

  void take_all(Simulation& simulation) {
    for (int k = 0; k < most_packets && take(); ++k) {
    }
    // However many have sent a hello, the last is the peer.
    if (!std::exchange(greeted, false)) return;
    const std::string& names = exchanged.names();
    send(MIMBRE_EXCHANGE_NAMES, static_cast<std::uint16_t>(names.size()), 0, simulation.time(), names.data(),
         names.size());
  }

  /// Until the last outputs are answered.
  void take_answer(Simulation& simulation) {
    const std::int64_t until = live::clock_now() + static_cast<std::int64_t>(1e9 * wait);
    take_all(simulation);
    while (peer_size > 0 && answered < sent) {
      const std::int64_t left = until - live::clock_now();
      if (left <= 0) {
        missed.store(missed.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
        if (++silent >= most_silent) peer_size = 0;
        return;
      }
      const timespec rest{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
      pollfd ready{socket, POLLIN, 0};
      ppoll(&ready, 1, &rest, nullptr);
      take_all(simulation);
    }
  }

  const live::Exchanged exchanged;
  const double wait;
  int socket = -1, port = 0;
  Address peer{};
  socklen_t peer_size = 0;  ///< 0: there is none
  std::vector<char> packet;
  std::size_t longest_taken = 0;  ///< bytes
  bool greeted = false;           ///< by the peer, who is not answered yet
  std::vector<double> values, inputs;
  bool news = false;
  int silent = 0;  ///< steps in a row that waited in vain
  std::uint64_t sent = 0, answered = 0;
  std::array<std::int64_t, remembered> sent_at{};  ///< ns
  Timings trips;
  std::atomic<std::int64_t> refused{0}, missed{0};
};

UdpExchange::UdpExchange(const Simulation& simulation, const UdpOptions& options)
    : impl_(std::make_unique<Impl>(simulation, options)) {}
UdpExchange::~UdpExchange() = default;

void UdpExchange::before(Simulation& simulation) {
  Impl& s = *impl_;
  if (s.wait > 0 && s.peer_size > 0)
    s.take_answer(simulation);
  else
    s.take_all(simulation);
  if (s.news) s.exchanged.write(simulation, s.inputs.data());
  s.news = false;
}

void UdpExchange::rests(Simulation& simulation) { impl_->take_all(simulation); }

void UdpExchange::after(Simulation& simulation, const StepReport& report, bool) {
  Impl& s = *impl_;
  if (s.peer_size == 0 || !report.ok()) return;
  s.exchanged.read(simulation, s.values.data());
  ++s.sent;
  s.sent_at[s.sent % remembered] = stamp_now();
  const auto count = static_cast<std::uint16_t>(s.exchanged.output_count());
  s.send(MIMBRE_EXCHANGE_OUTPUTS, count, s.sent, simulation.time(), s.values.data(), sizeof(double) * count);
}

int UdpExchange::port() const { return impl_->port; }
const Timings& UdpExchange::round_trips() const { return impl_->trips; }
std::int64_t UdpExchange::refused() const { return impl_->refused; }
std::int64_t UdpExchange::missed() const { return impl_->missed; }

}  // namespace mimbre
