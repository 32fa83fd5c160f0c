#pragma once
#include <stdexcept>
#include <string>
#include <vector>

namespace mimbre {

/// A place in a model file. Lines and columns count from 1; line 0 means "no file" (models made in C++).
struct Mark {
  std::string file;
  int line = 0;
  int column = 0;
};

/// One thing that is wrong (or suspicious) in the input: where, what, and what would be right.
struct Diagnostic {
  Mark mark;
  std::string message;
};

/// "file:line:column: message", or the message alone where there is no file.
std::string to_string(const Diagnostic& diagnostic);

/// Thrown when the input is bad. Carries every error that was found, not only the first; what() has one per
/// line.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<Diagnostic> diagnostics);
  InputError(Mark mark, std::string message);
  const std::vector<Diagnostic>& diagnostics() const { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};

/// The candidate nearest to `name` in edit distance, as " (did you mean 'x'?)"; empty when none is near.
std::string did_you_mean(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace mimbre
