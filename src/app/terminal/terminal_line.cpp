#include "app/terminal/terminal_line.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "mimbre/text.h"

namespace mimbre::app {
namespace {

/// In characters; none is known of a terminal that does not report it.
std::size_t columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : std::string::npos;
}

/// The beginning of UTF-8 text.
std::string_view first_characters(std::string_view text, std::size_t count) {
  std::size_t seen = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const bool starts = (static_cast<unsigned char>(text[at]) & 0xc0) != 0x80;
    if (starts && seen++ == count) return text.substr(0, at);
  }
  return text;
}

}  // namespace

bool has_terminal_line() {
  const char* const kind = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && std::string_view(kind ? kind : "") != "dumb";
}

void show_terminal_line(const std::string& text) {
  // In its last column some terminals go on to the next line, of which nothing would be taken away.
  fmt::print(stderr, "\r{}\033[K", first_characters(printable(text), columns() - 1));
  std::fflush(stderr);
}

void clear_terminal_line() { show_terminal_line(""); }

}  // namespace mimbre::app
