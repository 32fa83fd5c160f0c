#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "fe_files/bodies/cross_integrals.h"
#include "fe_files/bodies/frame_force_stiffness.h"
#include "fe_files/bodies/reduced_files.h"
#include "fe_files/bodies/sid_file.h"
#include "fe_files/bodies/sid_terms.h"
#include "fe_files/text.h"
#include "mimbre/reduced_body.h"

namespace mimbre::fe {
namespace {

const SidBlock* find(const std::map<std::string, SidBlock>& blocks, const char* name, int rows, int columns) {
  const auto found = blocks.find(name);
  if (found == blocks.end()) return nullptr;
  const SidBlock& block = found->second;
  if (block.rows != rows || block.columns != columns)
    throw InputError(block.mark, fmt::format("the block {} is {} x {}, {} x {} is needed", name, block.rows,
                                             block.columns, rows, columns));
  return &block;
}

const SidBlock& need(const std::map<std::string, SidBlock>& blocks, const char* name, int rows, int columns,
                     const Mark& mark) {
  const SidBlock* block = find(blocks, name, rows, columns);
  if (!block) throw InputError(mark, fmt::format("has no block {}", name));
  return *block;
}

/// Whether what a block has beyond the inertia is more than round-off of the file's digits.
bool matters(const Eigen::MatrixXd& difference, const Eigen::MatrixXd& whole) {
  constexpr double digits = 1e-8;
  return difference.size() > 0 &&
         difference.cwiseAbs().maxCoeff() > digits * std::max(whole.cwiseAbs().maxCoeff(), 1e-300);
}

class Meaning {
 public:
  Meaning(const SidFile& sid, Mark mark) : sid_(sid), mark_(std::move(mark)), n_(sid.modes) {}

  ImportedBody read() {
    result_.body = empty_body(n_);
    ReducedBody& body = result_.body;
    body.mass = sid_.mass;
    for (int m = 0; m < n_; ++m)
      if (const std::string& name = sid_.mode_names[static_cast<std::size_t>(m)]; !name.empty())
        body.mode_names[static_cast<std::size_t>(m)] = name;
    read_matrices();
    read_inertia();
    read_products();
    read_nodes();
    for (std::string& message : finish_body(mark_.file, body))
      result_.warnings.push_back({mark_, std::move(message)});
    if (std::string left_out = take_frame_forces(stiffening_, body); !left_out.empty())
      result_.warnings.push_back({mark_, std::move(left_out)});
    return std::move(result_);
  }

 private:
  const SidFile& sid_;
  Mark mark_;
  int n_;
  ImportedBody result_;
  FrameForceStiffness stiffening_;

  void read_matrices() {
    ReducedBody& body = result_.body;
    body.mass_matrix = constant_part(need(sid_.blocks, "Me", n_, n_, mark_));
    body.stiffness = constant_part(need(sid_.blocks, "Ke", n_, n_, mark_));
    if (const SidBlock* damping = find(sid_.blocks, "De", n_, n_)) body.damping = constant_part(*damping);
    body.S = constant_part(need(sid_.blocks, "Ct", n_, 3, mark_)).transpose();
    body.first_moment = constant_part(need(sid_.blocks, "mdCM", 3, 1, mark_));
    if (const SidBlock* initial = find(sid_.blocks, "ksigma", n_, 1)) {
      // Stress that is there at rest: its forces on the modes and how they change.
      body.stiffness += column(linear_parts(*initial, sid_), 0);
      if (!constant_part(*initial).isZero(0))
        result_.warnings.push_back(
            {initial->mark,
             "the forces of initial stress (m0 of ksigma) are left out: the body is at rest at "
             "zero amplitudes"});
    }
  }

  /// A column of the linear parts of a block of as many rows as modes: modes × modes.
  Eigen::MatrixXd column(const std::vector<Eigen::MatrixXd>& parts, int c) const {
    Eigen::MatrixXd result(n_, n_);
    for (int m = 0; m < n_; ++m) result.col(m) = parts[static_cast<std::size_t>(m)].col(c);
    return result;
  }

  void read_inertia() {
    ReducedBody& body = result_.body;
    const SidBlock& J = need(sid_.blocks, "J", 6, 1, mark_);
    const auto tensor = [](const Eigen::MatrixXd& column) {
      Eigen::Matrix3d result;
      for (int row = 0; row < 6; ++row)
        result(kInertia[row][0], kInertia[row][1]) = result(kInertia[row][1], kInertia[row][0]) =
            column(row, 0);
      return result;
    };
    body.second_moment = second_moment_of(tensor(constant_part(J)));
    std::vector<Eigen::Matrix3d> position;
    for (const Eigen::MatrixXd& part : linear_parts(J, sid_))
      position.push_back(0.5 * second_moment_of(tensor(part)));
    const Eigen::Matrix3Xd coupling = constant_part(need(sid_.blocks, "Cr", n_, 3, mark_)).transpose();
    set_position_integrals(position, coupling, body);
  }

  /// S_modes, and the geometric stiffness that hides in the linear parts.
  void read_products() {
    if (n_ == 0) return;
    ReducedBody& body = result_.body;
    const SidBlock* Gr = find(sid_.blocks, "Gr", 3, 3 * n_);
    const SidBlock* Oe = find(sid_.blocks, "Oe", n_, 6);
    const SidBlock* Ge = find(sid_.blocks, "Ge", n_, 3 * n_);
    const SidBlock& Cr = need(sid_.blocks, "Cr", n_, 3, mark_);
    const std::vector<Eigen::MatrixXd> Cr1 = linear_parts(Cr, sid_);
    const bool from_Gr = Gr && !Gr->m1.empty();
    if (from_Gr) {
      // φ_m~ φ_l~ = φ_l φ_mᵀ − (φ_m · φ_l) I
      const std::vector<Eigen::MatrixXd> Gr1 = linear_parts(*Gr, sid_);
      set_mode_integrals(
          n_,
          [&](int l, int m) -> Eigen::Matrix3d {
            const Eigen::Matrix3d block = -0.5 * Gr1[static_cast<std::size_t>(m)].middleCols<3>(3 * l);
            return block - 0.5 * block.trace() * Eigen::Matrix3d::Identity();
          },
          body);
    } else if (Oe && Ge && !Oe->m1.empty()) {
      read_products_from(linear_parts(*Oe, sid_), constant_part(*Ge));
    } else if (Ge) {
      read_products_from(
          std::vector<Eigen::MatrixXd>(static_cast<std::size_t>(n_), Eigen::MatrixXd::Zero(n_, 6)),
          constant_part(*Ge));
      result_.warnings.push_back(
          {mark_, "has no linear part of Gr or Oe: inertia has no products of amplitudes"});
    } else {
      result_.warnings.push_back(
          {mark_, "has none of the blocks Gr (order 1), Ge: inertia has no products of amplitudes"});
    }
    // What the linear parts have beyond the inertia is geometric stiffness; Oe only where S_modes come from
    // Gr.
    const auto add = [&](int load, const Eigen::MatrixXd& stiffness, const Eigen::MatrixXd& whole) {
      if (matters(stiffness, whole)) stiffening_.inertia[static_cast<std::size_t>(load)] = stiffness;
    };
    if (from_Gr && Oe && !Oe->m1.empty()) {
      const std::vector<Eigen::MatrixXd> Oe1 = linear_parts(*Oe, sid_);
      for (int c = 0; c < 6; ++c) {
        Eigen::MatrixXd stiffness = column(Oe1, c);
        for (int k = 0; k < n_; ++k)
          for (int m = 0; m < n_; ++m) stiffness(k, m) -= centrifugal(mode_integral(body, k, m))(c);
        add(GeometricStiffness::angular_velocity + c, stiffness, column(Oe1, c));
      }
    }
    const std::vector<Eigen::MatrixXd> Ct1 = linear_parts(need(sid_.blocks, "Ct", n_, 3, mark_), sid_);
    for (int c = 0; c < 3; ++c) add(GeometricStiffness::acceleration + c, column(Ct1, c), column(Ct1, c));
    for (int c = 0; c < 3 && !Cr.m1.empty(); ++c) {
      Eigen::MatrixXd stiffness = column(Cr1, c);
      for (int k = 0; k < n_; ++k)
        for (int m = 0; m < n_; ++m) stiffness(k, m) += cross_of(mode_integral(body, k, m))(c);
      add(GeometricStiffness::angular_acceleration + c, stiffness, column(Cr1, c));
    }
  }

  void read_products_from(const std::vector<Eigen::MatrixXd>& Oe1, const Eigen::MatrixXd& Ge0) {
    set_mode_integrals(
        n_,
        [&](int k, int m) -> Eigen::Matrix3d {
          const Eigen::RowVectorXd o = Oe1[static_cast<std::size_t>(m)].row(k);
          const Eigen::RowVector3d turn = -0.5 * Ge0.row(k).segment<3>(3 * m);  // ∫φ_k × φ_m dm
          Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
          // The sums of two diagonal entries are −o.
          for (int i = 0; i < 3; ++i) A(i, i) = o(i) - 0.5 * o.head<3>().sum();
          for (int c = 3; c < 6; ++c)
            A(kProducts[c][0], kProducts[c][1]) = A(kProducts[c][1], kProducts[c][0]) = 0.5 * o(c);
          for (int c = 0; c < 3; ++c) {
            A((c + 1) % 3, (c + 2) % 3) += 0.5 * turn(c);
            A((c + 2) % 3, (c + 1) % 3) -= 0.5 * turn(c);
          }
          return A;
        },
        result_.body);
  }

  /// Nodes are frames; one without psi, of which no turning is known, is only a point. Points for drawing and
  /// output are the nodes with stress or, without any, all.
  void read_nodes() {
    ReducedBody& body = result_.body;
    const bool stressed = std::any_of(sid_.nodes.begin(), sid_.nodes.end(),
                                      [](const SidNode& node) { return node.blocks.count("sigma") > 0; });
    std::vector<const SidNode*> points;
    for (const SidNode& node : sid_.nodes) {
      if (!stressed || node.blocks.count("sigma") > 0) points.push_back(&node);
      if (node.blocks.count("psi") > 0 || node.blocks.count("sigma") == 0) read_frame(node);
    }
    const auto count = static_cast<Eigen::Index>(points.size());
    body.nodes.resize(3, count);
    body.node_shapes.resize(3 * count, n_);
    if (stressed) body.stress.resize(6 * count, n_);
    const Mark* initial = nullptr;
    for (Eigen::Index k = 0; k < count; ++k) {
      const SidNode& node = *points[static_cast<std::size_t>(k)];
      body.nodes.col(k) = constant_part(need(node.blocks, "origin", 3, 1, mark_));
      body.node_shapes.middleRows<3>(3 * k) = constant_part(need(node.blocks, "phi", 3, n_, mark_));
      if (!stressed) continue;
      const SidBlock& sigma = need(node.blocks, "sigma", 6, 1, mark_);
      if (!initial && !constant_part(sigma).isZero(0)) initial = &sigma.mark;
      const std::vector<Eigen::MatrixXd> parts = linear_parts(sigma, sid_);
      for (int m = 0; m < n_; ++m) body.stress.col(m).segment<6>(6 * k) = parts[static_cast<std::size_t>(m)];
    }
    if (stressed && std::all_of(points.begin(), points.end(),
                                [](const SidNode* node) { return to_integer(node->label).has_value(); }))
      for (const SidNode* node : points) body.node_labels.push_back(*to_integer(node->label));
    if (initial)
      result_.warnings.push_back({*initial,
                                  "initial stress (m0 of sigma) is left out: only that of the modes is "
                                  "taken"});
  }

  void read_frame(const SidNode& node) {
    BodyFrame frame;
    frame.name = to_integer(node.label) ? "node " + node.label : node.label;
    frame.position = constant_part(need(node.blocks, "origin", 3, 1, mark_));
    const SidBlock &phi = need(node.blocks, "phi", 3, n_, mark_),
                   &psi = need(node.blocks, "psi", 3, n_, mark_);
    frame.X = constant_part(phi);
    frame.X_theta = constant_part(psi);
    if (const SidBlock* AP = find(node.blocks, "AP", 3, 3)) frame.rotation = constant_part(*AP);
    if (!(frame.rotation * frame.rotation.transpose()).isIdentity(1e-5) || frame.rotation.determinant() < 0)
      throw InputError(mark_, fmt::format("AP of node {} is no rotation", shown(node.label)));
    // Files have few digits; the nearest rotation is meant.
    if (!(frame.rotation * frame.rotation.transpose()).isIdentity(1e-14))
      frame.rotation = Eigen::Quaterniond(frame.rotation).normalized().toRotationMatrix();
    result_.body.frames.push_back(std::move(frame));
    read_forces(phi);
    read_forces(psi);
  }

  /// Geometric stiffness by forces or torques at a node. One without linear parts is none of the places where
  /// forces stiffen.
  void read_forces(const SidBlock& block) {
    stiffening_.forces.resize(stiffening_.forces.size() + 3);
    if (block.order == 0 && block.m1.empty()) return;
    // A file of a few lines must not fill the memory.
    constexpr std::size_t most = std::size_t{1} << 27;
    if (stiffening_.forces.size() * static_cast<std::size_t>(n_ * n_) > most)
      throw InputError(block.mark,
                       "stiffening by forces at nodes needs more than 1 GB: there are too many nodes "
                       "with linear parts of phi or psi");
    const std::vector<Eigen::MatrixXd> parts = linear_parts(block, sid_);
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::MatrixXd stiffness(n_, n_);
      for (int m = 0; m < n_; ++m) stiffness.row(m) = -parts[static_cast<std::size_t>(m)].row(axis);
      stiffening_.forces[stiffening_.forces.size() - 3 + static_cast<std::size_t>(axis)] = stiffness;
    }
  }
};

}  // namespace

ImportedBody parse_sid(TextFile& file) {
  const SidFile sid = parse_sid_file(file);
  return Meaning(sid, {file.name(), 0, 0}).read();
}

ImportedBody read_sid(const std::string& path) {
  TextFile file(path);
  return parse_sid(file);
}

}  // namespace mimbre::fe
