#pragma once
#include <optional>
#include <string>

namespace mimbre {

/// Damaged results, reduced bodies (HDF5) and meshes can crash the libraries that read them, keep them busy
/// for ever or let them take all memory. A process that has to survive any file asks for each one to be read
/// in another process first, with bounds on memory and time. `program`: one whose main begins with
/// rehearse_reading(), as that of the program `mimbre` does; "/proc/self/exe" is the caller's own. Empty, as
/// at the start of a process: files are read here alone, and no process is made. Nothing is forked
/// (posix_spawn), so there may be threads. May be called at any time, from any thread.
void isolate_reading(const std::string& program);

/// The other side: where the command line is that of a program started for isolate_reading(), reads the file
/// and returns the exit code; otherwise nothing.
std::optional<int> rehearse_reading(int argc, const char* const* argv);

}  // namespace mimbre
