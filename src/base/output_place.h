#pragma once
#include <sys/stat.h>

#include <functional>
#include <string>
#include <string_view>

namespace mimbre {

/// The place of one output file. What is written goes to a new file of its own beside the target and takes
/// the target's place when it is whole: until then an older file stands as it was, and when two programs
/// write at once the file is that of one of them. Links are followed, the older file's mode is kept, and what
/// is no plain file (a device, a pipe) is written straight. All errors are std::runtime_error with the reason
/// alone.
class OutputPlace {
 public:
  /// Makes the file to write to. Throws when it cannot be made, or another program is writing the target.
  explicit OutputPlace(const std::string& target);
  /// Removes what was written, unless it was committed or kept.
  ~OutputPlace();
  OutputPlace(const OutputPlace&) = delete;
  OutputPlace& operator=(const OutputPlace&) = delete;

  /// The file to write to; it exists, is empty and belongs to this place.
  const std::string& path() const { return path_; }
  /// Whether the target is a plain file, or none yet.
  bool plain() const { return plain_; }

  /// Writes all of the file.
  void write(std::string_view bytes) const;
  /// Where nothing stands at the target the file is called so from now on, and can be looked at while it
  /// grows: path() changes. Throws when another program was quicker.
  void show();
  /// What was written takes the target's place; where an older file stands there the new one is on the disk
  /// first. Throws, and keeps it where it is, when that fails or another program has written the target
  /// meanwhile.
  void commit();
  /// What was written is not whole, but stays: at the target where nothing stands there, else where it is.
  /// Returns its path. Never throws.
  std::string keep() noexcept;

 private:
  bool unchanged() const;
  void adopt_mode() const;

  std::string target_;  ///< what the links lead to
  std::string shown_;   ///< as the user called it
  std::string path_;
  struct ::stat before_ {};  ///< of the older file
  struct ::stat own_ {};     ///< of the file that is written, as any new one has it
  bool plain_ = true, existed_ = false, pending_ = false;
  int lock_ = -1;      ///< holds the target
  int own_lock_ = -1;  ///< holds the file that is written, where that is another
};

/// The target that a file of that name grows for, as OutputPlace names such files: `run.part-PID.h5` grows
/// for `run.h5` in the same folder. Empty: it is no such name, or one that was cut short.
std::string target_of_part(const std::string& part);

/// Whether a part of the target may be one that was kept, and which was reported: those have the mode
/// of the target, and what still grows has one of its own or is empty. True where that cannot be decided.
bool is_kept(const std::string& part, const std::string& target);

/// Removes those files of the target that processes left which have ended without a word, and of which
/// `superseded` says so, given their paths. What is being written, here or elsewhere, is not touched. Throws
/// what `superseded` throws.
void remove_abandoned_parts(const std::string& target,
                            const std::function<bool(const std::string& part)>& superseded);

/// A file that nobody else sees yet. Throws std::runtime_error with the reason alone.
void write_bytes(const std::string& path, std::string_view bytes);

/// One file at once, likewise: the older one stands until the new one is whole.
void write_whole(const std::string& target, std::string_view bytes);

}  // namespace mimbre
