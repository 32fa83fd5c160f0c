#pragma once
#include <string>

/// One line on the terminal of stderr that is written over again and again.
namespace mimbre::app {

/// Whether stderr is a terminal that can go back in its line; those of TERM=dumb cannot.
bool has_terminal_line();

/// Shows it in place of what the line showed, as much as fits into the terminal's width. Control characters
/// are shown, not obeyed.
void show_terminal_line(const std::string& text);

void clear_terminal_line();

}  // namespace mimbre::app
