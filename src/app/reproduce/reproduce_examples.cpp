#include "app/reproduce/reproduce_examples.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "app/common.h"

namespace mimbre::app {

namespace fs = std::filesystem;

ExampleFolder::ExampleFolder() {
  std::error_code status;
  const fs::path temporary = fs::temp_directory_path(status);
  std::string name = ((status ? fs::path("/tmp") : temporary) / "mimbre-XXXXXX").string();
  if (!mkdtemp(name.data()))
    throw Failure(fmt::format("cannot make a temporary folder {}: {}", name, std::strerror(errno)));
  folder_ = name;
  for (const ExampleFile& example : embedded_examples()) {
    const fs::path path = folder_ / example.name;
    fs::create_directories(path.parent_path(), status);
    std::ofstream file(path, std::ios::binary);
    file << example.text << std::flush;
    if (file) continue;
    fs::remove_all(folder_, status);
    throw Failure(fmt::format("cannot write {}", path.string()));
  }
}

ExampleFolder::~ExampleFolder() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

}  // namespace mimbre::app
