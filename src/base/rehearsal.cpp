#include "base/rehearsal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <vector>

#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

constexpr double least_memory = 512e6, memory_per_byte = 64;
constexpr double least_seconds = 3, seconds_per_byte = 1e-7;
constexpr double patience = 10;  ///< seconds on the clock for each of the processor, when others want it too

/// What the child says at its end; silence means that it did not come to one.
enum Verdict : char { done = 'd', refused = 'r', too_large = 'm', other = 'o' };

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

std::string said(const InputError& error) {
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

[[noreturn]] void play(int pipe, double memory, double seconds, const std::function<void()>& work) {
  // What a crash prints helps nobody.
  const int nowhere = open("/dev/null", O_WRONLY);
  if (nowhere >= 0) {
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
  }
  for (const int crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU}) signal(crash, SIG_DFL);
  signal(SIGPIPE, SIG_IGN);
  bound(RLIMIT_CORE, 0);
  bound(RLIMIT_CPU, seconds);
  if (const double now = address_space(); now > 0) bound(RLIMIT_AS, now + memory);
  std::string message(1, done);
  try {
    work();
  } catch (const InputError& error) {
    message = said(error);
  } catch (const std::bad_alloc&) {
    message = too_large;
  } catch (...) {
    message = other;  // it will be thrown once more where it is caught
  }
  for (std::size_t sent = 0; sent < message.size();) {
    const ssize_t count = write(pipe, message.data() + sent, message.size() - sent);
    if (count > 0) sent += static_cast<std::size_t>(count);
    if (count < 0 && errno != EINTR) break;
  }
  _exit(0);
}

/// All that the child says before `seconds` are over.
std::string listen(int pipe, double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  std::string message;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    pollfd waiting{pipe, POLLIN, 0};
    const int ready = left > 0 ? poll(&waiting, 1, static_cast<int>(left)) : 0;
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return {};
    char buffer[4096];
    const ssize_t count = read(pipe, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return message;
    message.append(buffer, static_cast<std::size_t>(count));
  }
}

}  // namespace

void rehearse(const std::string& path, const std::function<void()>& work) {
  std::error_code unknown;
  const auto bytes = static_cast<double>(std::filesystem::file_size(path, unknown));
  const double size = unknown ? 0 : bytes, seconds = least_seconds + seconds_per_byte * size;
  int ends[2];
  if (pipe(ends) != 0) return;
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    play(ends[1], least_memory + memory_per_byte * size, seconds, work);
  }
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    return;
  }
  const std::string message = listen(ends[0], patience * seconds);
  close(ends[0]);
  kill(child, SIGKILL);
  while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  const auto refuse = [&](const char* why) { throw InputError(Mark{path, 0, 0}, why); };
  if (message.empty()) refuse("is damaged: it cannot be read to its end");
  if (message[0] == too_large)
    refuse("is damaged, or too large: it needs more memory than a file of its size should");
  if (message[0] == refused) throw InputError(heard(message));
}

}  // namespace mimbre
