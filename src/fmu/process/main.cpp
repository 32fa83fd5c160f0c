#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <memory>
#include <string>
#include <thread>

#include "fmu/calls.h"
#include "fmu/process/protocol.h"

/// Calls an FMU in a process of its own: what that breaks, it breaks here.
namespace {

using namespace mimbre::fmu;

bool receive(void* to, std::size_t count) {
  char* at = static_cast<char*>(to);
  while (count > 0) {
    const ssize_t got = recv(process_socket, at, count, 0);
    if (got <= 0) return false;
    at += got;
    count -= static_cast<std::size_t>(got);
  }
  return true;
}

bool transmit(const void* from, std::size_t count) {
  const char* at = static_cast<const char*>(from);
  while (count > 0) {
    const ssize_t sent = send(process_socket, at, count, MSG_NOSIGNAL);
    if (sent <= 0) return false;
    at += sent;
    count -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool answer(bool good, const void* bytes, std::size_t count) {
  AnswerHead head;
  head.good = good ? 1 : 0;
  head.bytes = count;
  return transmit(&head, sizeof head) && transmit(bytes, count);
}

bool answer_text(bool good, const std::string& text) { return answer(good, text.data(), text.size()); }

/// Ends this process with the simulation that it belongs to, also where the FMU hangs.
void end_with_the_other() {
  pollfd watched{process_socket, POLLRDHUP, 0};
  while (poll(&watched, 1, -1) < 0 || (watched.revents & (POLLRDHUP | POLLHUP | POLLERR)) == 0) {
  }
  _exit(1);
}

bool exchange(Calls& calls, std::size_t inputs, std::size_t outputs, const std::string& bytes) {
  ExchangeHead head{};
  if (bytes.size() != sizeof head + 2 * inputs * sizeof(double)) return false;
  std::memcpy(&head, bytes.data(), sizeof head);
  std::vector<double> before(inputs + 1), in(inputs + 1), out(outputs + 1);
  std::memcpy(before.data(), bytes.data() + sizeof head, inputs * sizeof(double));
  std::memcpy(in.data(), bytes.data() + sizeof head + inputs * sizeof(double), inputs * sizeof(double));
  if (!calls.exchange(head.time, head.interval, head.intervals, before.data(), in.data(), out.data()))
    return answer_text(false, calls.message());
  return answer(true, out.data(), outputs * sizeof(double));
}

int serve() {
  std::unique_ptr<Calls> calls;
  std::size_t inputs = 0, outputs = 0;
  RequestHead head{};
  std::string bytes;
  while (receive(&head, sizeof head)) {
    bytes.resize(head.bytes);
    if (!receive(bytes.data(), bytes.size())) return 1;
    if (head.request == Request::open) {
      Plan plan;
      if (!from_bytes(bytes, plan)) return 1;
      inputs = plan.inputs.size();
      outputs = plan.outputs.size();
      calls = std::make_unique<Calls>(std::move(plan));
      if (!answer_text(calls->open(), calls->message())) return 1;
      continue;
    }
    if (!calls) return 1;
    bool sent = false;
    switch (head.request) {
      case Request::open:
        break;
      case Request::exchange:
        sent = exchange(*calls, inputs, outputs, bytes);
        break;
      case Request::save: {
        std::vector<std::byte> state;
        sent = calls->save(state) ? answer(true, state.data(), state.size())
                                  : answer_text(false, calls->message());
        break;
      }
      case Request::restore: {
        const auto* const first = reinterpret_cast<const std::byte*>(bytes.data());
        const bool good = calls->restore({first, bytes.size()});
        sent = answer_text(good, calls->message());
        break;
      }
      case Request::warning:
        sent = answer_text(true, calls->warning());
        break;
      case Request::end:
        calls = nullptr;
        answer_text(true, {});
        return 0;
    }
    if (!sent) return 1;
  }
  return 0;
}

}  // namespace

int main() {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  std::thread(end_with_the_other).detach();
  const int code = serve();
  // Without the destructors of what the FMU brought along.
  _exit(code);
}
