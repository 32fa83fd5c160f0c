#pragma once
#include <map>
#include <string>
#include <vector>

#include "fe_files/nastran_cards.h"
#include "fe_files/symmetric_entries.h"

namespace mimbre::fe {

/// GRID and CORD2R cards of one file or several, and the names of the matrices.
class NastranGrids {
 public:
  void read(TextFile& file);
  /// Nodes in basic axes. Throws at systems that are not there, and at displacements in turned axes.
  SolidMesh finish(const Mark& end) const;
  const std::vector<std::string>& matrices() const { return matrices_; }

 private:
  struct Grid {
    std::int64_t label = 0, position_system = 0, displacement_system = 0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    Mark mark;
  };
  struct System {
    std::int64_t reference = 0;
    Eigen::Vector3d origin, on_z, in_xz;
    Mark mark;
  };
  struct Axes {
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  };
  Axes axes(std::int64_t system, const Mark& mark, int depth = 0) const;

  std::vector<Grid> grids_;
  std::map<std::int64_t, System> systems_;
  std::map<std::int64_t, std::string> other_systems_;  ///< those that are not read, with the card's name
  std::vector<std::string> matrices_;
};

struct NastranMatrix {
  SymmetricEntries entries;
  SymmetricEntries::Stored stored = SymmetricEntries::Stored::triangle;
};
/// The matrices of the given names from DMIG cards.
std::vector<NastranMatrix> parse_dmig(TextFile& file, const std::vector<std::string>& names,
                                      const SolidMesh& mesh);

/// The only one of `names` that begins with `letter`, or `wanted`.
std::string choose_matrix(const std::vector<std::string>& names, const std::string& wanted, char letter,
                          const Mark& mark);

}  // namespace mimbre::fe
