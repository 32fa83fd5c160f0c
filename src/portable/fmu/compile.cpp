#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/utsname.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/sha256.h"
#include "mimbre/build.h"
#include "portable/fmu/parts.h"
#include "portable/library/library_code.h"

extern char** environ;

namespace mimbre::portable {
namespace {

namespace fs = std::filesystem;

/// A folder of its own, which goes with it.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "mimbre-fmu-XXXXXX").string();
    if (mkdtemp(name.data())) path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  bool made() const { return !path_.empty(); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

std::string content(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// Whether a program could be started; `status`: what it returned. What it prints goes to a file.
bool run(std::vector<std::string> words, const std::string& printed, int& status) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  if (posix_spawn_file_actions_init(&actions) != 0) return false;
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, printed.c_str(), O_WRONLY | O_CREAT | O_TRUNC,
                                   0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  pid_t process = 0;
  const bool started =
      posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  if (!started) return false;
  pid_t ended = 0;
  while ((ended = waitpid(process, &status, 0)) < 0 && errno == EINTR) {
  }
  return ended == process;
}

/// The file that this process has the library of formats from: that library, or what contains it.
std::string file_of_formats() {
  std::string (*const function)(fmt::string_view, fmt::format_args) = &fmt::vformat;
  Dl_info info{};
  return dladdr(reinterpret_cast<void*>(function), &info) != 0 && info.dli_fname ? info.dli_fname : "";
}

/// The runtime, under a name that no other version has, and what it needs that not every machine has: the
/// library of formats, where this program has it from a shared library, too.
ArchiveFiles runtime_files() {
  const std::span<const unsigned char> runtime = runtime_bytes();
  if (runtime.empty()) return {};
  const std::string bytes(runtime.begin(), runtime.end());
  Sha256 digest;
  digest.add(bytes);
  ArchiveFiles out{
      {fmt::format("libmimbre-{}-{}.so", build_info().version, digest.hex().substr(0, 8)), bytes}};
  const std::size_t at = bytes.find("libfmt.so");
  const std::string file = file_of_formats();
  if (at != std::string::npos && fs::path(file).filename().string().starts_with("libfmt"))
    out.emplace_back(bytes.c_str() + at, content(file));
  return out;
}

/// Where a binary for this machine lies in an FMU.
std::string place(const FmuCode& fmu) {
  utsname system{};
  if (uname(&system) != 0) return {};
  const std::string machine = system.machine, name = system.sysname;
  const bool mac = name == "Darwin";
  const std::string tuple =
      fmt::format("{}-{}", machine == "arm64" ? "aarch64" : machine, mac ? "darwin" : "linux");
  const std::string folder = fmu.version == 2 && machine == "x86_64" ? (mac ? "darwin64" : "linux64") : tuple;
  return fmt::format("binaries/{}/{}.{}", folder, fmu.code.name, mac ? "dylib" : "so");
}

}  // namespace

FmuBinary compile_fmu(const FmuCode& fmu) {
  FmuBinary out;
  out.file = place(fmu);
  const char* const chosen = std::getenv("CC");
  const std::string compiler = chosen && *chosen ? chosen : "cc";
  const Folder folder;
  if (!folder.made()) {
    out.message = "no folder for temporary files can be made";
    return out;
  }
  const std::string code = fmu.code.name + ".c", wrapper = fmu_wrapper_file(fmu);
  for (const auto& [name, text] : {std::pair(fmu.code.name + ".h", &fmu.code.header),
                                   std::pair(code, &fmu.code.source), std::pair(wrapper, &fmu.wrapper)})
    std::ofstream(folder.file(name), std::ios::binary) << *text;
  const std::string library = folder.file("library"), printed = folder.file("printed");
  std::vector<std::string> words{compiler,
                                 "-std=c99",
                                 "-O2",
                                 "-ffp-contract=off",
                                 "-fPIC",
                                 "-fvisibility=hidden",
                                 "-shared",
                                 "-o",
                                 library,
                                 folder.file(code),
                                 folder.file(wrapper)};
  if (fmu.with_library) {
    out.with = runtime_files();
    if (out.with.empty()) {
      out.message = "this mimbre was built without the runtime that FMUs take along";
      return out;
    }
    for (const auto& [name, bytes] : out.with) std::ofstream(folder.file(name), std::ios::binary) << bytes;
    // It is looked for where the binary lies.
    words.insert(words.end(), {"-L" + folder.file(""), "-l:" + out.with.front().first, "-Wl,-rpath,$ORIGIN",
                               "-Wl,--allow-shlib-undefined"});
  }
  words.emplace_back("-lm");
  int status = 0;
  if (!run(words, printed, status)) {
    out.message = fmt::format("there is no C compiler '{}'", compiler);
    return out;
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    std::string first = content(printed);
    first = first.substr(0, first.find('\n'));
    out.message = WIFEXITED(status) && WEXITSTATUS(status) == 127
                      ? fmt::format("there is no C compiler '{}'", compiler)
                      : fmt::format("the C compiler '{}' failed: {}", compiler, first);
    return out;
  }
  out.bytes = content(library);
  const std::string place_of_binary = fs::path(out.file).parent_path().string() + "/";
  for (auto& [name, bytes] : out.with) name = place_of_binary + name;
  return out;
}

}  // namespace mimbre::portable
