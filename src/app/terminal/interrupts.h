#pragma once

namespace mimbre::app {

/// From here on an interrupt, a termination signal or a hang-up sets a flag instead of ending the process; a
/// second one ends it.
void catch_interrupts();
/// Whether such a signal has come.
bool interrupted();

}  // namespace mimbre::app
