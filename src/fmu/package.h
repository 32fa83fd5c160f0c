#pragma once
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "fmu/description.h"

namespace mimbre::fmu {

/// The file of an FMU, once in a process for each content. It is unpacked where its code is first needed,
/// into a temporary folder that goes with the process.
class Package {
 public:
  /// Throws InputError where the file is no FMU, is damaged, or has members that would be written elsewhere.
  static std::shared_ptr<const Package> open(const std::string& file);
  ~Package();
  Package(const Package&) = delete;
  Package& operator=(const Package&) = delete;

  const Description& description() const { return description_; }
  const std::string& digest() const { return digest_; }  ///< SHA-256 of the file

  /// Paths of what was unpacked.
  struct Unpacked {
    std::string folder, binary, resources;  ///< resources: empty where there are none
  };
  /// Unpacks it at the first call, and compiles its sources where it has no library for this platform. Throws
  /// InputError.
  const Unpacked& unpacked() const;

 private:
  Package(std::string file, std::string bytes, std::string digest);
  void unpack() const;
  [[noreturn]] void refuse(const std::string& why) const;

  std::string file_, digest_;
  Description description_;
  mutable std::string bytes_;  ///< until it is unpacked
  mutable std::mutex guard_;
  mutable Unpacked unpacked_;
  int owner_ = 0;  ///< the process that made the folder
};

}  // namespace mimbre::fmu
