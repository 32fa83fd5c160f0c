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
#include "readers.h"

/// Changes the sample files of every reader at random, always in the same way for the same number, and reads
/// what comes of it: some of them one after another in a process of their own, with bounds on memory and on
/// the time of each. It must be read, or be refused with an InputError.
///
///   mimbre_mutate COUNT [FIRST [READER]]     the mutants FIRST to FIRST + COUNT - 1, of one reader or all in
///   turn
///
/// A mutant that is a fault is kept in the working directory as mutant-READER-NUMBER, and the exit code is 1.
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

/// For the next file: what the process has used, and as much again as one may need.
void bound_time() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  const auto seconds = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
  rlimit limit{};
  getrlimit(RLIMIT_CPU, &limit);
  limit.rlim_cur = std::min(limit.rlim_max, seconds + 1 + cpu_seconds);
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

constexpr char good = 'g', bad = 'b';

/// Says of each whether it was as it should be, as far as it comes.
[[noreturn]] void read_in_child(std::span<const Trial> trials, int pipe) {
  const rlimit core{0, 0};
  setrlimit(RLIMIT_CORE, &core);
  bound_memory();
  for (const Trial& trial : trials) {
    bound_time();
    char verdict = good;
    try {
      trial.reader->read(trial.bytes);
    } catch (const InputError&) {
    } catch (const std::exception& error) {
      fmt::print("not an InputError: {}\n", error.what());
      std::fflush(stdout);
      verdict = bad;
    }
    if (write(pipe, &verdict, 1) != 1) break;
  }
  _exit(0);
}

/// What went wrong with the first that did, and which it is; with none, their number and an empty text.
std::pair<std::size_t, std::string> first_fault(std::span<const Trial> trials) {
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
  char verdict = good;
  while (child > 0 && verdict == good) {
    const ssize_t got = read(ends[0], &verdict, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    read_well += verdict == good;
  }
  close(ends[0]);
  if (child < 0) return {0, "no process can be made"};
  if (verdict == bad) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (read_well == trials.size()) return {read_well, ""};
  if (verdict == bad) return {read_well, "is refused by another error"};
  if (!WIFSIGNALED(status)) return {read_well, fmt::format("exit code {}", WEXITSTATUS(status))};
  const int signal = WTERMSIG(status);
  return {read_well, signal == SIGXCPU ? "takes too long" : fmt::format("ends by signal {}", signal)};
}

/// Calls report(index, why) for all faults.
template <class Report>
void find_faults(const std::vector<Trial>& trials, Report&& report) {
  for (std::size_t at = 0; at < trials.size();) {
    const auto [count, why] = first_fault(std::span(trials).subspan(at));
    if (!why.empty()) report(at + count, why);
    at += count + 1;
  }
}

int main_program(int argc, char** argv) {
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
      const std::string why = first_fault(std::vector{Trial{&reader, sample}}).second;
      if (why.empty()) continue;
      fmt::print("{}: a sample {}\n", reader.name, why);
      return 1;
    }
  }
  std::uint64_t faults = 0;
  for (std::uint64_t begin = first; begin < first + count; begin += at_once) {
    std::vector<Trial> trials;
    for (std::uint64_t number = begin; number < std::min(begin + at_once, first + count); ++number) {
      const std::size_t k = number % chosen.size();
      trials.push_back({&chosen[k], mutant(number, samples[k])});
    }
    find_faults(trials, [&](std::size_t index, const std::string& why) {
      const Trial& trial = trials[index];
      const std::string name = fmt::format("mutant-{}-{}", trial.reader->name, begin + index);
      std::ofstream(name, std::ios::binary) << trial.bytes;
      const bool alone = !first_fault(std::span(&trial, 1)).second.empty();
      fmt::print("{}: {}{}\n", name, why, alone ? "" : ", after others only");
      ++faults;
    });
  }
  fmt::print("{} mutants of {} readers, {} faults\n", count, chosen.size(), faults);
  return faults > 0 ? 1 : 0;
}

}  // namespace
}  // namespace mimbre::fuzz

int main(int argc, char** argv) { return mimbre::fuzz::main_program(argc, argv); }
