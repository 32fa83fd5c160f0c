#pragma once
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "fe/solve/block_lanczos.h"
#include "fe/solve/symmetric_solver.h"
#include "mimbre/fe_reduce.h"
#include "reduction/factor/large_factor.h"

namespace mimbre::fe {

/// A model whose interfaces move by their six coordinates z: displacements u = Tx x + Tz z, x the remaining
/// dofs. Nodes of rigid interfaces follow z; of each mean interface six dofs ("pins") are eliminated by its
/// six equations. Free motions of the interfaces belong to x, each with the shape of the body when it alone
/// is imposed.
class TiedModel {
 public:
  TiedModel(const SolidMesh& mesh, const FeMatrices& matrices, const std::vector<Interface>& interfaces,
            Definiteness stiffness = Definiteness::definite);

  Eigen::Index internals() const { return static_cast<Eigen::Index>(internal_.size() + freed_.size()); }
  Eigen::Index boundaries() const { return 6 * static_cast<Eigen::Index>(interfaces_); }
  /// u of x and z.
  Eigen::MatrixXd expand(const Eigen::MatrixXd& x, const Eigen::MatrixXd& z) const;
  /// How the interfaces move in x and z: z, and the free motions.
  Eigen::MatrixXd motions(const Eigen::MatrixXd& x, const Eigen::MatrixXd& z) const;
  /// Txᵀ f.
  Eigen::MatrixXd restrict(const Eigen::MatrixXd& f) const;
  /// (Txᵀ K Tx)⁻¹ f.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& f) const;
  /// Interfaces held: Txᵀ K Tx, Txᵀ M Tx.
  Pencil held() const;

 private:
  struct Tied {
    Eigen::Index row = 0;
    int interface = 0;
    Eigen::Matrix<double, 1, 6> motion;  ///< displacement per z of the interface
  };
  struct Mean {
    int interface = 0;
    std::array<Eigen::Index, 6> pins{};  ///< rows
    Eigen::Matrix<double, 6, 6> from_z;  ///< u_pins = from_z z + from_x u_others
    std::vector<Eigen::Index> others;    ///< internal indices
    Eigen::Matrix<double, 6, Eigen::Dynamic> from_x;
  };

  /// Of each row its number among x; −1: eliminated.
  using Places = std::vector<Eigen::Index>;

  void tie_rigidly(int interface, const std::vector<Eigen::Index>& own, const Eigen::MatrixXd& motions,
                   Places& places);
  void tie_mean(int interface, const std::vector<Eigen::Index>& translations, const Eigen::MatrixXd& R,
                Places& places);
  void number_internals(Places& places);
  void factor(const Places& places, Definiteness stiffness);
  void prepare_means();
  void free_motions(const std::vector<Interface>& interfaces);

  const FeMatrices& matrices_;
  std::size_t interfaces_ = 0;
  std::vector<Eigen::Index> internal_;  ///< rows of x
  std::vector<Tied> tied_;
  std::vector<Mean> means_;
  std::unique_ptr<LargeFactor> factor_;
  // Txᵀ K Tx = Koo + U S Uᵀ, where pins follow the others.
  Eigen::MatrixXd U_, solved_, small_;
  std::vector<Eigen::Index> freed_;  ///< of z
  Eigen::MatrixXd freed_shapes_;     ///< dofs × freed, orthogonal by the stiffness to all that is held
  Eigen::MatrixXd freed_inverse_;    ///< of their stiffness
};

}  // namespace mimbre::fe
