#include "mimbre/model_file.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "model_file/text/parse.h"

namespace mimbre {

spec::Model load_model(const std::string& path, const std::map<std::string, std::string>& overrides,
                       std::vector<Diagnostic>* warnings, std::vector<std::string>* other_files) {
  namespace fs = std::filesystem;
  std::error_code status;
  if (!fs::exists(path, status)) throw InputError({path, 0, 0}, "there is no such file");
  if (!fs::is_regular_file(path, status)) throw InputError({path, 0, 0}, "is not a file");
  if (const auto size = fs::file_size(path, status); status || size > model_file::Limits{}.bytes)
    throw InputError({path, 0, 0}, "is too large for a model file");
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw InputError({path, 0, 0}, "cannot be read");
  const std::string directory = fs::path(path).parent_path().string();
  return parse_model(text.str(), path, directory.empty() ? "." : directory, overrides, warnings, other_files);
}

spec::Model parse_model(const std::string& text, const std::string& name, const std::string& directory,
                        const std::map<std::string, std::string>& overrides,
                        std::vector<Diagnostic>* warnings, std::vector<std::string>* other_files) {
  return model_file::parse(text, name, directory, overrides, warnings, {}, other_files);
}

spec::Model model_file::parse(const std::string& text, const std::string& name, const std::string& directory,
                              const std::map<std::string, std::string>& overrides,
                              std::vector<Diagnostic>* warnings, const Limits& limits,
                              std::vector<std::string>* other_files) {
  return parse_by(disk_files(), text, name, directory, overrides, warnings, limits, other_files, nullptr);
}

}  // namespace mimbre
