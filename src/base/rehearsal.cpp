#include "base/rehearsal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <new>
#include <vector>

#include "mimbre/diagnostics.h"

extern char** environ;

namespace mimbre {
namespace {

constexpr double least_memory = 512e6, memory_per_byte = 64;
constexpr double least_seconds = 3, seconds_per_byte = 1e-7;
constexpr double patience = 10;  ///< seconds on the clock for each of the processor

/// The first message of the other process; without it, it is none that rehearses.
constexpr char greeting[] = "mimbre rehearsal 1\n";
constexpr std::size_t greeting_size = sizeof greeting - 1;
/// Its last message; silence means that it did not come to one.
enum Verdict : char { done = 'd', refused = 'r', too_large = 'm', other = 'o' };

std::mutex program_mutex;
std::string& program_for_all() {
  static std::string program;
  return program;
}

/// Bytes of address space that this process has now; 0 where that is not known.
double address_space() {
  long pages = 0;
  std::FILE* const file = std::fopen("/proc/self/statm", "r");
  if (!file) return 0;
  if (std::fscanf(file, "%ld", &pages) != 1) pages = 0;
  std::fclose(file);
  return static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

void bound(decltype(RLIMIT_CPU) resource, double value) {
  rlimit limit{};
  getrlimit(resource, &limit);
  limit.rlim_cur = std::min(limit.rlim_max, static_cast<rlim_t>(value));
  setrlimit(resource, &limit);
}

void put(std::string& message, const std::string& text) {
  message += text;
  message += '\0';
}

std::string description(const InputError& error) {
  std::string message(1, refused);
  for (const Diagnostic& d : error.diagnostics()) {
    put(message, d.mark.file);
    put(message, std::to_string(d.mark.line));
    put(message, std::to_string(d.mark.column));
    put(message, d.message);
  }
  return message;
}

std::vector<Diagnostic> heard(const std::string& message) {
  std::vector<std::string> fields;
  for (std::size_t at = 1, end; (end = message.find('\0', at)) != std::string::npos; at = end + 1)
    fields.push_back(message.substr(at, end - at));
  std::vector<Diagnostic> diagnostics;
  for (std::size_t k = 0; k + 4 <= fields.size(); k += 4)
    diagnostics.push_back(
        {{fields[k], std::atoi(fields[k + 1].c_str()), std::atoi(fields[k + 2].c_str())}, fields[k + 3]});
  return diagnostics;
}

void send_text(int pipe, const std::string& message) {
  for (std::size_t sent = 0; sent < message.size();) {
    const ssize_t count = write(pipe, message.data() + sent, message.size() - sent);
    if (count > 0) sent += static_cast<std::size_t>(count);
    if (count < 0 && errno != EINTR) break;
  }
}

/// All messages of the other process; `in_time`: it came to its end before `seconds` were over.
std::string listen(int pipe, double seconds, bool& in_time) {
  using Clock = std::chrono::steady_clock;
  const auto end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  std::string message;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    pollfd waiting{pipe, POLLIN, 0};
    const int ready = left > 0 ? poll(&waiting, 1, static_cast<int>(left)) : 0;
    if (ready < 0 && errno == EINTR) continue;
    in_time = ready > 0;
    if (!in_time) return message;
    char buffer[4096];
    const ssize_t count = read(pipe, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return message;
    message.append(buffer, static_cast<std::size_t>(count));
  }
}

/// A process whose standard output is the pipe; −1 where none can be had. In a group of its own, so that an
/// interrupt from the terminal is for the first process alone.
pid_t start(const std::string& program, const std::string& reading, const std::string& path, int pipe) {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  if (posix_spawn_file_actions_init(&actions) != 0) return -1;
  if (posix_spawnattr_init(&attributes) != 0) {
    posix_spawn_file_actions_destroy(&actions);
    return -1;
  }
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  posix_spawn_file_actions_adddup2(&actions, pipe,
                                   STDOUT_FILENO);  // first: the pipe may be one of the others
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  // What a crash prints helps nobody.
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  std::string words[] = {program, rehearsal_option, reading, path};
  char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), words[3].data(), nullptr};
  // A BLAS that starts threads when it is loaded has no use for them there.
  std::string few = "OPENBLAS_NUM_THREADS=1";
  std::vector<char*> environment{few.data()};
  for (char** one = environ; one && *one; ++one)
    if (std::strncmp(*one, "OPENBLAS_NUM_THREADS=", 21) != 0) environment.push_back(*one);
  environment.push_back(nullptr);
  pid_t process = -1;
  if (posix_spawn(&process, program.c_str(), &actions, &attributes, arguments, environment.data()) != 0)
    process = -1;
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return process;
}

}  // namespace

void set_rehearsal_program(const std::string& program) {
  const std::lock_guard lock(program_mutex);
  program_for_all() = program;
}

RehearsalBounds rehearsal_bounds(const std::string& path) {
  std::error_code unknown;
  const auto bytes = static_cast<double>(std::filesystem::file_size(path, unknown));
  const double size = unknown ? 0 : bytes, seconds = least_seconds + seconds_per_byte * size;
  return {least_memory + memory_per_byte * size, seconds, patience * seconds};
}

bool rehearse(const std::string& reading, const std::string& path) {
  return rehearse(reading, path, rehearsal_bounds(path));
}

bool rehearse(const std::string& reading, const std::string& path, const RehearsalBounds& bounds) {
  const std::string program = [] {
    const std::lock_guard lock(program_mutex);
    return program_for_all();
  }();
  if (program.empty()) return false;
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return false;
  const pid_t process = start(program, reading, path, ends[1]);
  close(ends[1]);
  if (process < 0) {
    close(ends[0]);
    return false;
  }
  bool in_time = true;
  std::string message = listen(ends[0], bounds.wait, in_time);
  close(ends[0]);
  kill(process, SIGKILL);
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(process, &status, 0)) < 0 && errno == EINTR) {
  }
  if (!message.starts_with(greeting)) return false;
  message.erase(0, greeting_size);
  const auto refuse = [&](const std::string& why) { throw InputError(Mark{path, 0, 0}, why); };
  if (message.empty() && !in_time)
    refuse(
        fmt::format("time-out: reading it was tried in another process for {:.0f} s, and did not come to "
                    "its end; the machine is busy, or the file lies on a slow disk",
                    bounds.wait));
  if (message.empty() && ended == process && WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU)
    refuse(fmt::format(
        "time-out: reading it takes more than {:.0f} s of the processor, which no whole file of its "
        "size should",
        bounds.seconds));
  if (message.empty()) refuse("is damaged: it cannot be read to its end");
  if (message[0] == too_large)
    refuse("is damaged, or too large: it needs more memory than a file of its size should");
  if (message[0] == refused) throw InputError(heard(message));
  return true;
}

int play_rehearsal(const RehearsalBounds& bounds, const std::function<void()>& work) {
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  // What a library prints is no part of the messages.
  const int pipe = dup(STDOUT_FILENO), nowhere = open("/dev/null", O_WRONLY);
  if (pipe < 0 || nowhere < 0 || dup2(nowhere, STDOUT_FILENO) < 0) return EXIT_FAILURE;
  signal(SIGPIPE, SIG_IGN);
  send_text(pipe, greeting);
  bound(RLIMIT_CORE, 0);
  bound(RLIMIT_CPU, bounds.seconds);
  if (const double now = address_space(); now > 0) bound(RLIMIT_AS, now + bounds.memory);
  std::string message(1, done);
  try {
    work();
  } catch (const InputError& error) {
    message = description(error);
  } catch (const std::bad_alloc&) {
    message = too_large;
  } catch (...) {
    message = other;  // it will be thrown once more where it is caught
  }
  send_text(pipe, message);
  std::_Exit(EXIT_SUCCESS);  // whatever state a damaged file has left libraries in
}

}  // namespace mimbre
