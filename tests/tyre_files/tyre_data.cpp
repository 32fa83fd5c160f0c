#include "tyre_files/tyre_data.h"

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace mimbre::test {

std::string tyre_path(const std::string& name) {
  return std::string(MIMBRE_SOURCE_DIR) + "/tests/data/tyres/" + name;
}

TyreProperties tyre_of(const std::string& name) { return read_tyre_properties(tyre_path(name)); }

std::vector<std::map<std::string, double>> table_of(const std::string& name) {
  std::ifstream file(tyre_path(name));
  if (!file) throw std::runtime_error("no file " + name);
  std::vector<std::string> names;
  std::vector<std::map<std::string, double>> rows;
  for (std::string line, word; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    if (names.empty()) {
      while (std::getline(words, word, ',')) names.push_back(word);
      continue;
    }
    std::map<std::string, double>& row = rows.emplace_back();
    for (const std::string& column : names) {
      std::getline(words, word, ',');
      row[column] = std::stod(word);
    }
  }
  return rows;
}

}  // namespace mimbre::test
