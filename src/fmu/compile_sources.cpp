#include "fmu/compile_sources.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "fmu/standard_headers.h"
#include "mimbre/diagnostics.h"

extern char** environ;

namespace mimbre::fmu {
namespace {

namespace fs = std::filesystem;

/// Of the file's description, or all.c, or all C files of its folder.
Sources sources_of(const fs::path& folder, const Description& description, const std::string& file) {
  const fs::path build = folder / "buildDescription.xml";
  std::error_code status;
  if (fs::is_regular_file(build, status)) {
    std::ifstream in(build, std::ios::binary);
    const std::string xml((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    return read_build_description(xml, description.identifier, file);
  }
  Sources sources;
  sources.files = description.sources;
  if (sources.files.empty() && fs::is_regular_file(folder / "all.c", status)) sources.files = {"all.c"};
  if (sources.files.empty())
    for (const auto& entry : fs::directory_iterator(folder, status))
      if (entry.path().extension() == ".c") sources.files.push_back(entry.path().filename().string());
  std::sort(sources.files.begin(), sources.files.end());
  return sources;
}

/// The exit code of a program, whose output goes to a file; 127 where there is no such program.
int run_program(std::vector<std::string> words, const std::string& output) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, 1, 2);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return 127;
  int state = 0;
  while (waitpid(child, &state, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(state) ? WEXITSTATUS(state) : 128;
}

std::string first_lines(const fs::path& path) {
  std::ifstream in(path);
  std::string text;
  std::string line;
  for (int k = 0; k < 6 && std::getline(in, line); ++k) text += "\n  " + line.substr(0, 300);
  return text;
}

bool names_a_file_inside(const std::string& name) {
  const fs::path path(name);
  return !name.empty() && path.is_relative() && name.find('\\') == std::string::npos &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

}  // namespace

std::string compile_sources(const std::string& folder, const Description& description,
                            const std::string& file) {
  const auto refuse = [&](const std::string& why) { throw InputError({file, 0, 0}, why); };
  const fs::path sources_folder = fs::path(folder) / "sources", headers = fs::path(folder) / "fmi-headers";
  const Sources sources = sources_of(sources_folder, description, file);
  if (sources.files.empty()) refuse("has no library for this platform, and no C files among its sources");
  std::error_code status;
  fs::create_directories(headers, status);
  for (const StandardHeader& header : standard_headers()) std::ofstream(headers / header.name) << header.text;
  const fs::path library = fs::path(folder) / (description.identifier + ".so");
  const char* const compiler = std::getenv("CC");
  std::vector<std::string> words{
      compiler && *compiler ? compiler : "cc", "-shared", "-fPIC", "-O2", "-w", "-o", library.string(),
      "-I" + sources_folder.string()};
  for (const std::string& name : sources.include_folders) {
    if (!names_a_file_inside(name)) refuse(fmt::format("its include folder '{}' is none of its own", name));
    words.push_back("-I" + (sources_folder / name).string());
  }
  // Behind its own.
  words.push_back("-idirafter" + headers.string());
  for (const std::string& definition : sources.definitions) words.push_back("-D" + definition);
  for (const std::string& name : sources.files) {
    const fs::path path = sources_folder / name;
    if (!names_a_file_inside(name) || !fs::is_regular_file(path, status))
      refuse(fmt::format("its source file '{}' is not there", name));
    words.push_back(path.string());
  }
  for (const std::string& name : sources.libraries)
    if (name.find_first_of("/ ") == std::string::npos) words.push_back("-l" + name);
  words.emplace_back("-lm");
  const std::string output = (fs::path(folder) / "compiler-output").string();
  const int code = run_program(words, output);
  if (code == 127)
    refuse(
        fmt::format("has no library for this platform, and its sources cannot be compiled: there is no C "
                    "compiler '{}'",
                    words.front()));
  if (code != 0)
    refuse(fmt::format("has no library for this platform, and '{}' does not compile its sources:{}",
                       words.front(), first_lines(output)));
  return library.string();
}

}  // namespace mimbre::fmu
