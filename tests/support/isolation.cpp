#include "mimbre/isolation.h"

/// The tests read damaged files: as the program does, in a process of their own first.
namespace mimbre::test {
namespace {

[[maybe_unused]] const bool isolated = [] {
  isolate_reading(MIMBRE_PROGRAM);
  return true;
}();

}  // namespace
}  // namespace mimbre::test
