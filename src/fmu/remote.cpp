#include "fmu/remote.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "fmu/plan.h"
#include "fmu/process_bytes.h"

extern char** environ;

namespace mimbre::fmu {
namespace {

constexpr std::size_t any_size = std::numeric_limits<std::size_t>::max();
constexpr std::uint64_t largest_answer = std::uint64_t{1} << 31;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Writes the program once for each FMU; its path.
std::string program_in(const std::string& folder) {
  const std::string path = folder + "/mimbre-fmu-process";
  if (access(path.c_str(), X_OK) == 0) return path;
  const std::string part = fmt::format("{}.{}", path, static_cast<const void*>(&path));
  const auto bytes = process_bytes();
  std::ofstream out(part, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  chmod(part.c_str(), 0700);
  rename(part.c_str(), path.c_str());
  return path;
}

}  // namespace

RemoteInstance::RemoteInstance(std::shared_ptr<const Package> package, double timeout, int inputs,
                               int outputs)
    : package_(std::move(package)), timeout_(timeout), inputs_(inputs), outputs_(outputs) {}

RemoteInstance::~RemoteInstance() {
  if (child_ <= 0) return;
  // What does not end in time is ended.
  const bool ended = ask(Request::end, "", 0);
  if (child_ > 0) stop(!ended);
}

bool RemoteInstance::fail(const std::string& what) {
  message_ = what;
  return false;
}

std::string RemoteInstance::stop(bool kill_it) const {
  close(socket_);
  socket_ = -1;
  if (kill_it) kill(child_, SIGKILL);
  int state = 0;
  while (waitpid(child_, &state, 0) < 0 && errno == EINTR) {
  }
  child_ = 0;
  if (WIFSIGNALED(state))
    return fmt::format("ended by signal {} ({})", WTERMSIG(state), strsignal(WTERMSIG(state)));
  return fmt::format("ended with exit code {}", WEXITSTATUS(state));
}

bool RemoteInstance::start() {
  int pair[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0)
    return fail(fmt::format("no connection to a process: {}", std::strerror(errno)));
  const std::string program = program_in(package_->unpacked().folder);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  // dup2 onto itself would leave the descriptor to be closed: it is first moved away.
  const int away = fcntl(pair[1], F_DUPFD_CLOEXEC, process_socket + 1);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, 2, 1);
  posix_spawn_file_actions_adddup2(&actions, away, process_socket);
  std::string name = "mimbre-fmu-process";
  char* arguments[] = {name.data(), nullptr};
  const int failed = posix_spawn(&child_, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  close(away);
  close(pair[1]);
  socket_ = pair[0];
  if (failed == 0) return true;
  close(socket_);
  socket_ = -1;
  child_ = 0;
  return fail(fmt::format("its process '{}' cannot be started: {}", program, std::strerror(failed)));
}

bool RemoteInstance::transmit(const void* bytes, std::size_t count) const {
  const char* at = static_cast<const char*>(bytes);
  while (count > 0) {
    const ssize_t sent = send(socket_, at, count, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += sent;
    count -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool RemoteInstance::receive(void* bytes, std::size_t count, double until) const {
  char* at = static_cast<char*>(bytes);
  while (count > 0) {
    const double left = until - now_s();
    pollfd watched{socket_, POLLIN, 0};
    const int ready =
        left > 0 ? poll(&watched, 1, static_cast<int>(std::min(std::ceil(1000 * left), 1e9))) : 0;
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) late_ = true;
    if (ready <= 0) return false;
    const ssize_t got = recv(socket_, at, count, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    count -= static_cast<std::size_t>(got);
  }
  return true;
}

/// Sends `sent_`, and has the answer in `answer_`. `expected`: its size.
bool RemoteInstance::ask(Request request, const char* during, std::size_t expected) const {
  if (child_ <= 0) {
    if (message_.empty()) message_ = "its process has ended";
    return false;
  }
  const double until = now_s() + timeout_;
  late_ = false;
  const RequestHead head{request, 0, sent_.size()};
  AnswerHead answer;
  bool there = transmit(&head, sizeof head) && transmit(sent_.data(), sent_.size()) &&
               receive(&answer, sizeof answer, until);
  const bool sound = there && answer.bytes <= largest_answer &&
                     (answer.good == 0 || expected == any_size || answer.bytes == expected);
  if (there && sound) {
    answer_.resize(answer.bytes);
    there = receive(answer_.data(), answer_.size(), until);
  }
  if (there && sound) {
    if (answer.good != 0) return true;
    message_.assign(answer_.begin(), answer_.end());
    return false;
  }
  const std::string ended = stop(true);
  message_ = late_ ? fmt::format(
                         "did not answer within {} s {} (its process was ended; a longer `timeout` "
                         "waits longer)",
                         timeout_, during)
             : !sound && there ? fmt::format("its process answered with nonsense {}", during)
                               : fmt::format("its process {} {}", ended, during);
  return false;
}

bool RemoteInstance::open(const Plan& plan) {
  if (!start()) return false;
  const std::string bytes = to_bytes(plan);
  sent_.assign(bytes.begin(), bytes.end());
  return ask(Request::open, "while it was loaded", 0);
}

bool RemoteInstance::exchange(const Instant& i) {
  const ExchangeHead head{i.time, i.interval, i.intervals};
  const std::size_t inputs = static_cast<std::size_t>(inputs_) * sizeof(double),
                    outputs = static_cast<std::size_t>(outputs_) * sizeof(double);
  sent_.resize(sizeof head + 2 * inputs);
  std::memcpy(sent_.data(), &head, sizeof head);
  if (inputs > 0) {
    std::memcpy(sent_.data() + sizeof head, i.before, inputs);
    std::memcpy(sent_.data() + sizeof head + inputs, i.in, inputs);
  }
  if (!ask(Request::exchange, i.intervals > 0 ? "during its step" : "during its initialisation", outputs))
    return false;
  std::memcpy(i.out, answer_.data(), outputs);
  return true;
}

bool RemoteInstance::save(std::vector<std::byte>& state) {
  sent_.clear();
  if (!ask(Request::save, "while its state was saved", any_size)) return false;
  const auto* const first = reinterpret_cast<const std::byte*>(answer_.data());
  state.insert(state.end(), first, first + answer_.size());
  return true;
}

bool RemoteInstance::restore(std::span<const std::byte> state) {
  const auto* const first = reinterpret_cast<const char*>(state.data());
  sent_.assign(first, first + state.size());
  return ask(Request::restore, "while its state was restored", any_size);
}

std::string RemoteInstance::warning() const {
  if (child_ <= 0) return {};
  sent_.clear();
  return ask(Request::warning, "while its warnings were asked for", any_size)
             ? std::string(answer_.begin(), answer_.end())
             : std::string();
}

}  // namespace mimbre::fmu
