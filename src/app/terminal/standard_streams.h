#pragma once

namespace mimbre::app {

/// To be called first. Descriptors 0 to 2 that are closed are taken, so that no file gets their number and
/// what is meant for a stream goes into it; reading from and writing to such a stream fails as before.
/// Messages that the standard error cannot take are dropped: they change nothing else.
void prepare_standard_streams();

}  // namespace mimbre::app
