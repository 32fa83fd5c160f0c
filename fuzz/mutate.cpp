#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mimbre/diagnostics.h"
#include "mimbre/isolation.h"
#include "readers.h"

/// Changes the sample files of every reader at random, always in the same way for the same number, and reads
/// what comes of it: some of them one after another in a process of their own, with bounds on memory and on
/// the time of each. It must be read, or be refused with an InputError.
///
///   mimbre_mutate COUNT [FIRST [READER]]     the mutants FIRST to FIRST + COUNT - 1, of one reader or all in
///   turn
///
/// A mutant that is a fault is kept in the working directory as mutant-READER-NUMBER, and the exit code is 1.
/// The last line says which took longest and with which a process had come to the most memory.
///
/// Some readers try a file in a process that says nothing of its crash: under sanitizers their reports are
/// seen with ASAN_OPTIONS=log_path=PLACE:allocator_may_return_null=1 only, which also lets what wants too
/// much memory be refused as it is otherwise.
namespace mimbre::fuzz {
namespace {

constexpr double memory_bytes = 1.5e9;
constexpr rlim_t cpu_seconds = 10;
constexpr std::uint64_t at_once = 60;  ///< in one process

using Generator = std::mt19937_64;

std::size_t below(Generator& random, std::size_t count) { return count > 0 ? random() % count : 0; }

/// A place in the bytes, mostly one that is not zero: files of tables are mostly empty room.
std::size_t place(Generator& random, const std::string& bytes) {
  std::size_t at = below(random, bytes.size());
  if (random() % 4 > 0)
    for (int k = 0; k < 200 && bytes[at] == '\0'; ++k) at = below(random, bytes.size());
  return at;
}

const std::array<std::string_view, 24> words{
    "0",    "-1",  "1e308",      "1e-308",      "nan",
    "inf",  "-0",  "4294967295", "2147483648",  "9223372036854775807",
    "1e9",  "[[[", "{{{",        "99999999999", "*NODE\n",
    "\n\n", "\t",  "\"",         "&a *a",       "<<: *a",
    "[]",   "{}",  ": ",         "\xff\xfe"};

/// The number, or whatever stands around `at`, as a text range.
std::pair<std::size_t, std::size_t> number_at(const std::string& bytes, std::size_t at) {
  const auto of_number = [](char c) {
    return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+' || c == 'e';
  };
  std::size_t begin = at, end = at;
  while (begin > 0 && of_number(bytes[begin - 1])) --begin;
  while (end < bytes.size() && of_number(bytes[end])) ++end;
  return {begin, end - begin};
}

void mutate(Generator& random, std::string& bytes, const std::string& other) {
  if (bytes.empty()) bytes = "0";
  const std::size_t at = place(random, bytes);
  const std::size_t some = std::size_t{1} << below(random, 10);
  switch (random() % 10) {
    case 0:
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
      break;
    case 1:
      bytes[at] = static_cast<char>(random());
      break;
    case 2: {  // a binary number
      const std::uint64_t values[] = {
          0,       1, 0x7f, 0xff, 0xffff, 0x7fffffff, 0xffffffff, ~std::uint64_t{0}, std::uint64_t{1} << 62,
          random()};
      const std::uint64_t value = values[random() % std::size(values)];
      const std::size_t width = std::size_t{1} << random() % 4;
      for (std::size_t k = 0; k < width && at + k < bytes.size(); ++k)
        bytes[at + k] = static_cast<char>(value >> 8 * k);
      break;
    }
    case 3:
      bytes.erase(at, some);
      break;
    case 4:
      bytes.insert(below(random, bytes.size() + 1), bytes.substr(at, some));
      break;
    case 5:
      if (random() % 4 == 0) bytes.resize(at);
      break;
    case 6: {
      const std::size_t from = below(random, other.size());
      bytes.replace(at, std::min(some, bytes.size() - at), other.substr(from, some));
      break;
    }
    case 7: {
      const auto [begin, length] = number_at(bytes, at);
      bytes.replace(begin, length, words[random() % words.size()]);
      break;
    }
    case 8:
      bytes.insert(at, words[random() % words.size()]);
      break;
    default: {  // a line elsewhere
      const std::size_t end = std::min(bytes.find('\n', at), bytes.size() - 1);
      const std::string line = bytes.substr(at, end - at + 1);
      bytes.insert(below(random, bytes.size()), line);
    }
  }
}

std::string mutant(std::uint64_t number, const std::vector<std::string>& samples) {
  Generator random(number);
  std::string bytes = samples[below(random, samples.size())];
  const std::string& other = samples[below(random, samples.size())];
  for (std::size_t changes = 1 + below(random, 6); changes > 0; --changes) mutate(random, bytes, other);
  return bytes;
}

double address_space() {
  long pages = 0;
  if (std::FILE* const file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%ld", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// Of processors.
double seconds(const rusage& used) {
  double sum = 0;
  for (const timeval& time : {used.ru_utime, used.ru_stime})
    sum += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  return sum;
}

/// What this process has used so far, and those that it has waited for: some readers try a file in one first.
struct Used {
  double seconds, bytes;  ///< of processors; the most memory at any time
};
Used used_so_far() {
  Used all{};
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    getrusage(who, &used);
    all.seconds += seconds(used);
    all.bytes = std::max(all.bytes, 1024.0 * static_cast<double>(used.ru_maxrss));
  }
  return all;
}

/// For the next file: what this process has used, and as much again as one may need.
void bound_time() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  rlimit limit{};
  getrlimit(RLIMIT_CPU, &limit);
  limit.rlim_cur = std::min(limit.rlim_max, static_cast<rlim_t>(seconds(used)) + 1 + cpu_seconds);
  setrlimit(RLIMIT_CPU, &limit);
}

void bound_memory() {
  const double now = address_space();
  if (now <= 0) return;
  const auto most = static_cast<rlim_t>(now + memory_bytes);
  const rlimit limit{most, most};
  setrlimit(RLIMIT_AS, &limit);
}

/// One file for one reader.
struct Trial {
  const Reader* reader;
  std::string bytes;
};

/// Whether it was as it should be, the time it took, and the most memory that its process has had up to then.
struct Verdict {
  bool good;
  Used used;
};

/// The most of something, and of which file that was.
struct Most {
  double value = 0;
  std::string of = "none";
  void see(double one, const std::string& name) {
    if (one > value) value = one, of = name;
  }
};

/// Says of each how it went, as far as it comes.
[[noreturn]] void read_in_child(std::span<const Trial> trials, int pipe) {
  const rlimit core{0, 0};
  setrlimit(RLIMIT_CORE, &core);
  bound_memory();
  for (const Trial& trial : trials) {
    const double before = used_so_far().seconds;
    bound_time();
    Verdict verdict{true, {}};
    try {
      trial.reader->read(trial.bytes);
    } catch (const InputError&) {
    } catch (const std::exception& error) {
      fmt::print("not an InputError: {}\n", error.what());
      std::fflush(stdout);
      verdict.good = false;
    }
    verdict.used = used_so_far();
    verdict.used.seconds -= before;
    if (write(pipe, &verdict, sizeof verdict) != sizeof verdict) break;
  }
  _exit(0);
}

/// What went wrong with the first that did, and which it is; with none, their number and an empty text. Calls
/// see(index, used) for those before.
template <class See>
std::pair<std::size_t, std::string> first_fault(std::span<const Trial> trials, See&& see) {
  std::fflush(stdout);
  int ends[2];
  if (pipe(ends) != 0) return {0, "no pipe can be made"};
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    read_in_child(trials, ends[1]);
  }
  close(ends[1]);
  std::size_t read_well = 0;
  Verdict verdict{true, {}};
  while (child > 0 && verdict.good) {
    const ssize_t got = read(ends[0], &verdict, sizeof verdict);
    if (got < 0 && errno == EINTR) continue;
    if (got != sizeof verdict) break;
    if (verdict.good) see(read_well++, verdict.used);
  }
  close(ends[0]);
  if (child < 0) return {0, "no process can be made"};
  if (!verdict.good) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (read_well == trials.size()) return {read_well, ""};
  if (!verdict.good) return {read_well, "is refused by another error"};
  if (!WIFSIGNALED(status)) return {read_well, fmt::format("exit code {}", WEXITSTATUS(status))};
  const int signal = WTERMSIG(status);
  return {read_well, signal == SIGXCPU ? "takes too long" : fmt::format("ends by signal {}", signal)};
}

/// Of one file alone.
std::string fault_of(const Trial& trial) {
  return first_fault(std::span(&trial, 1), [](std::size_t, const Used&) {}).second;
}

/// Calls report(index, why) for all faults, see(index, used) for the others.
template <class Report, class See>
void find_faults(const std::vector<Trial>& trials, Report&& report, See&& see) {
  for (std::size_t at = 0; at < trials.size();) {
    const auto [count, why] = first_fault(
        std::span(trials).subspan(at), [&](std::size_t index, const Used& used) { see(at + index, used); });
    if (!why.empty()) report(at + count, why);
    at += count + 1;
  }
}

int main_program(int argc, char** argv) {
  if (const auto rehearsed = rehearse_reading(argc, argv)) return *rehearsed;
  isolate_reading("/proc/self/exe");
  if (argc < 2) {
    fmt::print(stderr, "mimbre_mutate COUNT [FIRST [READER]]\n");
    return 2;
  }
  const std::uint64_t count = std::strtoull(argv[1], nullptr, 10);
  const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
  std::vector<Reader> chosen;
  for (const Reader& reader : readers())
    if (argc < 4 || reader.name == argv[3]) chosen.push_back(reader);
  if (chosen.empty()) {
    fmt::print(stderr, "there is no reader '{}'\n", argv[3]);
    return 2;
  }
  std::vector<std::vector<std::string>> samples;
  for (const Reader& reader : chosen) {
    samples.push_back(reader.samples(MIMBRE_SOURCE_DIR));
    for (const std::string& sample : samples.back()) {
      const std::string why = fault_of({&reader, sample});
      if (why.empty()) continue;
      fmt::print("{}: a sample {}\n", reader.name, why);
      return 1;
    }
  }
  std::uint64_t faults = 0;
  Most time, memory;
  for (std::uint64_t begin = first; begin < first + count; begin += at_once) {
    std::vector<Trial> trials;
    for (std::uint64_t number = begin; number < std::min(begin + at_once, first + count); ++number) {
      const std::size_t k = number % chosen.size();
      trials.push_back({&chosen[k], mutant(number, samples[k])});
    }
    const auto name_of = [&](std::size_t index) {
      return fmt::format("mutant-{}-{}", trials[index].reader->name, begin + index);
    };
    find_faults(
        trials,
        [&](std::size_t index, const std::string& why) {
          const std::string name = name_of(index);
          std::ofstream(name, std::ios::binary) << trials[index].bytes;
          const bool alone = !fault_of(trials[index]).empty();
          fmt::print("{}: {}{}\n", name, why, alone ? "" : ", after others only");
          ++faults;
        },
        [&](std::size_t index, const Used& used) {
          time.see(used.seconds, name_of(index));
          memory.see(used.bytes, name_of(index));
        });
  }
  fmt::print("{} mutants of {} readers, {} faults; at most {:.2f} s ({}) and {:.0f} MB ({})\n", count,
             chosen.size(), faults, time.value, time.of, 1e-6 * memory.value, memory.of);
  return faults > 0 ? 1 : 0;
}

}  // namespace
}  // namespace mimbre::fuzz

int main(int argc, char** argv) { return mimbre::fuzz::main_program(argc, argv); }
