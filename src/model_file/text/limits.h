#pragma once
#include <cstddef>

namespace mimbre::model_file {

/// What a model file may ask for; bounds the work of reading any text.
struct Limits {
  std::size_t bytes = 8u << 20;  ///< of one file
  std::size_t nodes = 500000;    ///< YAML values, aliases and placed templates expanded
  int depth = 64;                ///< nesting
  std::size_t errors = 100;      ///< reading stops after that many
  int all_elements = 200000;     ///< finite elements of all flexible bodies that differ
  int elements = 10000;          ///< finite elements of one flexible body
  int dynamic_modes = 500;       ///< of one flexible body
};

}  // namespace mimbre::model_file
