#pragma once
#include <functional>
#include <string>

namespace mimbre {

/// The place of an output that is a folder of files. They go to a new folder beside the target, which takes
/// the target's place when all of them are there: until then an older folder stands as it was. All errors are
/// std::runtime_error with the reason alone.
class OutputFolder {
 public:
  /// Makes the folder to write to, and those above it. `replaces`: whether a file of the older folder, by its
  /// name, is of its last output. Others stay; a folder in it, or one that is in use, is an error.
  OutputFolder(const std::string& target, const std::function<bool(const std::string& name)>& replaces);
  /// Removes what was written, unless it was committed.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// The folder to write to; it exists and is empty.
  const std::string& path() const { return path_; }
  /// What was written takes the target's place. Throws, and leaves the older folder as it was, when it
  /// cannot.
  void commit();

 private:
  bool others_follow(const std::string& from, const std::string& to) const;
  void remove_left_over() const;

  std::function<bool(const std::string&)> replaces_;
  std::string target_, path_;
  bool existed_ = false, pending_ = false;
  int lock_ = -1;  ///< on path_: who holds none has been killed
};

}  // namespace mimbre
