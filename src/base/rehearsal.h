#pragma once
#include <functional>
#include <string>

/// Reading a file in another process first (mimbre/isolation.h), for libraries that damaged files can crash,
/// hang or drive into taking all memory.
namespace mimbre {

/// The program that files are read in first; empty: none.
void set_rehearsal_program(const std::string& program);

/// The option that such a program is started with; behind it stand the reading's name and the path.
inline constexpr const char* rehearsal_option = "--rehearse-reading";

/// Bounds of a rehearsal, in proportion to the file's size.
struct RehearsalBounds {
  double memory = 0;   ///< bytes
  double seconds = 0;  ///< of the processor
  double wait = 0;     ///< s on the clock, for when others want the processor too
};
RehearsalBounds rehearsal_bounds(const std::string& path);

/// Reads a file there. `reading`: one of the names in results/isolation.cpp. True when it came to its end:
/// the caller may then do the same. False where no program is named, or it cannot be started, or is none that
/// rehearses: the caller has to make all checks itself. Throws the InputError that was thrown there, or one
/// that reports that the file is damaged, or that the time was over.
bool rehearse(const std::string& reading, const std::string& path, const RehearsalBounds& bounds);
bool rehearse(const std::string& reading, const std::string& path);

/// The side of the other process: does the work within the bounds, reports to the first process how it ended,
/// and returns the exit code.
int play_rehearsal(const RehearsalBounds& bounds, const std::function<void()>& work);

}  // namespace mimbre
