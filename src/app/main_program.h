#pragma once

namespace mimbre::app {

/// The program: finds the command, runs it, reports what goes wrong. Returns the exit code.
int main_program(int argc, char** argv);

}  // namespace mimbre::app
