#pragma once
#include <functional>
#include <string>

namespace mimbre {

/// Reads a file in a process of its own first, for libraries that damaged files can crash, hang or drive into
/// taking all memory: `work` runs in a child process with bounds on memory and time in proportion to the
/// file's size. Returns when it came to its end there: the caller, in the same state, may then do the same.
/// Throws the InputError that it threw, or one saying that the file is damaged. `path` must be a plain file.
/// Where no process can be made the file is taken as it is.
void rehearse(const std::string& path, const std::function<void()>& work);

}  // namespace mimbre
