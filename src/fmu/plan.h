#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// What calling an FMU needs to know of it, without its description: also what a process that calls it gets.
namespace mimbre::fmu {

/// Types of variables. Those of FMI 2 are float64 (Real), int32 (Integer, Enumeration), boolean, string.
enum class Type : std::uint8_t {
  float64,
  float32,
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  boolean,
  string,
  other
};

/// One number that is exchanged: a scalar variable, or an element of an array.
struct Slot {
  std::string name;  ///< of the variable, for messages
  std::uint32_t reference = 0;
  Type type = Type::float64;
  std::uint64_t element = 0;  ///< place in the array, by rows
  std::vector<double> start;  ///< of the whole variable: one number for each of its elements
};

/// A value that is set before the initialisation, of all elements of a variable.
struct Setting {
  std::string name;
  std::uint32_t reference = 0;
  Type type = Type::float64;
  std::vector<std::string> values;
};

struct Plan {
  int version = 2;  ///< of FMI
  std::string binary, resources, token, identifier, instance;
  bool saves = false;  ///< its state can be saved as bytes
  bool inputs_of_the_end = false;
  std::vector<Slot> inputs, outputs;
  std::vector<Setting> settings;
};

/// The plan as bytes, and back; false where these are none.
std::string to_bytes(const Plan& plan);
bool from_bytes(std::string_view bytes, Plan& plan);

}  // namespace mimbre::fmu
