#pragma once
#include <string>

/// A small model in which blocks and events are looked at.
namespace mimbre::test {

/// A mass of 1 kg on a guide along x, which gravity does not move, and what is put behind; its outputs are
/// place, speed and rise.
std::string slider(const std::string& more, double step, double end = 1);

/// What is said of a bad model; "accepted" of a good one.
std::string refusal_of(const std::string& text);

}  // namespace mimbre::test
