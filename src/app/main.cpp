#include <signal.h>

#include "app/main_program.h"
#include "app/processor_check.h"
#include "app/terminal/standard_streams.h"

int main(int argc, char** argv) {
  mimbre::app::prepare_standard_streams();
  // A file that may not grow further is an error of writing like a full disk, not the end of the process.
  signal(SIGXFSZ, SIG_IGN);
  // Nor is a pipe whose reader went away.
  signal(SIGPIPE, SIG_IGN);
  return mimbre::app::main_program(argc, argv);
}
