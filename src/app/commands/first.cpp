#include "app/common.h"

/// The commands of the program that is built first, for a picture soon.
namespace mimbre::app {

std::vector<Command> add_commands(CommandLine& program) { return {add_run(program), add_report(program)}; }

}  // namespace mimbre::app
