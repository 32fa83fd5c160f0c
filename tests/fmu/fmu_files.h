#pragma once
#include <string>
#include <utility>
#include <vector>

/// FMUs that the tests make: tests/data/fmu/unit.c in an archive with its description.
namespace mimbre::test {

using Members = std::vector<std::pair<std::string, std::string>>;  ///< names and contents

/// A ZIP archive, nothing compressed.
std::string zip_of(const Members& members);

/// A folder for files, which goes with it.
class FmuFolder {
 public:
  FmuFolder();
  ~FmuFolder();
  FmuFolder(const FmuFolder&) = delete;
  FmuFolder& operator=(const FmuFolder&) = delete;
  const std::string& path() const { return path_; }
  /// Writes a file there; its path.
  std::string write(const std::string& name, const std::string& bytes) const;
  /// The unit as an FMU of that version of FMI, with its sources, and `lines` before them: "#define FAULT
  /// 3\n".
  std::string unit(int version, const std::string& lines = {}, const std::string& attributes = {}) const;

 private:
  std::string path_;
};

/// modelDescription.xml of the unit. `attributes`: of its element CoSimulation; none: it saves its state.
std::string unit_description(int version, const std::string& attributes = {});
/// Its members, with sources.
Members unit_members(int version, const std::string& lines = {}, const std::string& attributes = {});

}  // namespace mimbre::test
