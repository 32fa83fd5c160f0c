#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "mimbre/diagnostics.h"
#include "readers.h"

/// Changes the sample files of every reader at random, always in the same way for the same number, and reads
/// what comes of it: each in a process of its own with bounds on memory and time. It must be read, or be
/// refused with an InputError.
///
///   mimbre_mutate COUNT [FIRST [READER]]     the mutants FIRST to FIRST + COUNT - 1, of one reader or all in
///   turn
///
/// A mutant that is a fault is kept in the working directory as mutant-READER-NUMBER, and the exit code is 1.
namespace mimbre::fuzz {
namespace {

constexpr double memory_bytes = 1.5e9;
constexpr rlim_t cpu_seconds = 10;

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

[[noreturn]] void read_in_child(const Reader& reader, const std::string& bytes) {
  const rlimit time{cpu_seconds, cpu_seconds + 1}, core{0, 0};
  setrlimit(RLIMIT_CPU, &time);
  setrlimit(RLIMIT_CORE, &core);
  if (const double now = address_space(); now > 0) {
    const auto most = static_cast<rlim_t>(now + memory_bytes);
    const rlimit memory{most, most};
    setrlimit(RLIMIT_AS, &memory);
  }
  int code = 0;
  try {
    reader.read(bytes);
  } catch (const InputError&) {
  } catch (const std::exception& error) {
    fmt::print("not an InputError: {}\n", error.what());
    std::fflush(stdout);
    code = 2;
  }
  _exit(code);
}

/// What went wrong; empty when nothing did.
std::string fault(const Reader& reader, const std::string& bytes) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0) return "no process can be made";
  if (child == 0) read_in_child(reader, bytes);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    return signal == SIGXCPU ? "takes too long" : fmt::format("ends by signal {}", signal);
  }
  return WEXITSTATUS(status) == 0 ? "" : fmt::format("exit code {}", WEXITSTATUS(status));
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
      const std::string why = fault(reader, sample);
      if (why.empty()) continue;
      fmt::print("{}: a sample {}\n", reader.name, why);
      return 1;
    }
  }
  std::uint64_t faults = 0;
  for (std::uint64_t number = first; number < first + count; ++number) {
    const std::size_t k = number % chosen.size();
    const std::string bytes = mutant(number, samples[k]);
    const std::string why = fault(chosen[k], bytes);
    if (why.empty()) continue;
    const std::string name = fmt::format("mutant-{}-{}", chosen[k].name, number);
    std::ofstream(name, std::ios::binary) << bytes;
    fmt::print("{}: {}\n", name, why);
    ++faults;
  }
  fmt::print("{} mutants of {} readers, {} faults\n", count, chosen.size(), faults);
  return faults > 0 ? 1 : 0;
}

}  // namespace
}  // namespace mimbre::fuzz

int main(int argc, char** argv) { return mimbre::fuzz::main_program(argc, argv); }
