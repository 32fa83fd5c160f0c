#pragma once
#include <cstdint>

/// What a process that calls an FMU and the simulation send each other through a socket, which is the file
/// descriptor 3 there. A request is a head and so many bytes, and so is the answer to each.
namespace mimbre::fmu {

enum class Request : std::uint32_t { open, exchange, save, restore, warning, end };

struct RequestHead {
  Request request;
  std::uint32_t unused = 0;
  std::uint64_t bytes = 0;
};

/// Before the inputs of the last instant and those of now, all of them double.
struct ExchangeHead {
  double time, interval;
  std::int64_t intervals;
};

/// Where it did not go well, the bytes are the message.
struct AnswerHead {
  std::uint32_t good = 0;
  std::uint32_t unused = 0;
  std::uint64_t bytes = 0;
};

constexpr int process_socket = 3;

}  // namespace mimbre::fmu
