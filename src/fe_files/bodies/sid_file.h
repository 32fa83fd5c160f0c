#pragma once
#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "fe_files/text_file.h"

/// The text of a SID file, without its meaning: blocks of Taylor series by name.
namespace mimbre::fe {

/// A block m0 + Σ_q m1[q] y_q.
struct SidBlock {
  struct Entry {
    int row = 0, second = 0, third = 0;  ///< from 1; of m1 the middle index is mode or column
    double value = 0;
  };
  int order = 0, rows = 0, columns = 0, modes = 0;
  int structure = 3;  ///< 0 zero, 1 diagonal, 2 symmetric, 3 full, 4 unit
  std::vector<Entry> m0, m1;
  Mark mark;
};

struct SidNode {
  std::string label;
  std::map<std::string, SidBlock> blocks;  ///< origin, phi, psi, AP
};

struct SidFile {
  int modes = 0;
  double mass = 0;
  std::vector<std::string> mode_names;
  std::vector<SidNode> nodes;
  std::map<std::string, SidBlock> blocks;  ///< mdCM, J, Ct, Cr, Me, Gr, Ge, Oe, ksigma, Ke, De
  bool mode_is_last = false;               ///< m1(row, column, mode), as some programs write
};

SidFile parse_sid_file(TextFile& file);

/// m0, rows × columns, with what the structure implies.
Eigen::MatrixXd constant_part(const SidBlock& block);
/// m1 of mode `q`.
std::vector<Eigen::MatrixXd> linear_parts(const SidBlock& block, const SidFile& file);

}  // namespace mimbre::fe
