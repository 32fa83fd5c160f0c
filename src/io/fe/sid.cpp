#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "io/fe/cross_integrals.h"
#include "io/fe/frame_force_stiffness.h"
#include "io/fe/reduced_files.h"
#include "io/fe/sid_file.h"
#include "io/fe/text.h"

// Meaning: O. Wallrapp, Mech. Struct. Mach. 22(3), 1994; R. Schwertassek, O. Wallrapp, Dynamik flexibler
// Mehrkörpersysteme, 1999, 6.3. With φ_k the displacement of mode k, r the undeformed position:
//   mdCM1 = ∫φ_k dm         J1 = −∫(r~ φ_k~ + φ_k~ r~) dm        Ct0 = ∫φ_kᵀ dm      Cr0 = ∫(r × φ_k)ᵀ dm
//   Cr1(k, m) = ∫(φ_m × φ_k)ᵀ dm      Gr0_l = −2∫r~ φ_l~ dm      Gr1_lm = −2∫φ_m~ φ_l~ dm
//   Ge0_l(k) = 2∫(φ_l × φ_k)ᵀ dm      Oe(k)·(ωx², ωy², ωz², ωxωy, ωyωz, ωxωz) = ∫φ_k · ω × (ω × (r + Σ φ_m
//   y_m)) dm
// Geometric stiffness adds to the linear parts of Oe (angular velocity), Ct (acceleration less gravity) and
// Cr (angular acceleration), of the body with nothing but its frame held. That of forces at a node is minus
// the linear part of its phi, that of torques of its psi, so that phiᵀ F is the force on the modes: under
// tension the node comes nearer by what the modes bend. sigma: stress at a node, xx yy zz xy yz zx, m1 of the
// modes.

namespace mimbre::fe {
namespace {

/// Columns of Oe: the products ω_a ω_b.
constexpr int kProducts[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
/// Rows of J.
constexpr int kInertia[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

/// ∫φ × r dm of A = ∫φ rᵀ dm.
Eigen::RowVector3d cross_of(const Eigen::Matrix3d& A) {
  return {A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0)};
}

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d result;
  result << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return result;
}

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
          {mark_, "has no linear part of Gr or Oe: inertia knows nothing of products of amplitudes"});
    } else {
      result_.warnings.push_back(
          {mark_,
           "has none of the blocks Gr (order 1), Ge: inertia knows nothing of products of amplitudes"});
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

namespace {

class Writer {
 public:
  Writer(const ReducedBody& body, const std::string& path)
      : body_(body), n_(body.modes), stiffening_(by_frame_forces(body)), out_(path) {}

  void write() {
    const Places places = find_places();
    out_.print("{:5} {:5}    : number of nodes, number of modes\n part\n      new modal = {}\n",
               body_.frames.size() + places.alone.size(), n_, one_line(body_.name));
    write_refmod();
    out_.print("           frame\n");
    for (std::size_t i = 0; i < body_.frames.size(); ++i)
      write_frame(i, places.frame_labels[i], places.of_frame[i]);
    for (std::size_t i = 0; i < places.alone.size(); ++i)
      write_point(places.alone[i], places.point_labels[i]);
    out_.print("           end frame\n");
    write_blocks();
    out_.print("      end modal\n end part\n");
    out_.finish();
  }

 private:
  const ReducedBody& body_;
  int n_;
  FrameForceStiffness stiffening_;
  OutputFile out_;

  /// The nodes of the file: the frames, then the points with stress that are at none of them.
  struct Places {
    std::vector<std::int64_t> frame_labels;
    std::vector<Eigen::Index> of_frame;  ///< point where the frame is, −1: none
    std::vector<Eigen::Index> alone;
    std::vector<std::int64_t> point_labels;
  };

  Places find_places() const {
    Places places;
    const bool stressed = body_.stress.size() > 0;
    std::vector<bool> taken(stressed ? static_cast<std::size_t>(body_.nodes.cols()) : 0, false);
    for (const BodyFrame& frame : body_.frames) {
      std::size_t k = 0;
      for (; k < taken.size(); ++k)
        if (const auto point = static_cast<Eigen::Index>(k);
            !taken[k] && body_.nodes.col(point) == frame.position &&
            body_.node_shapes.middleRows<3>(3 * point) == frame.X)
          break;
      places.of_frame.push_back(k < taken.size() ? static_cast<Eigen::Index>(k) : -1);
      if (k < taken.size()) taken[k] = true;
    }
    for (std::size_t k = 0; k < taken.size(); ++k)
      if (!taken[k]) places.alone.push_back(static_cast<Eigen::Index>(k));

    const bool numbered = std::all_of(body_.frames.begin(), body_.frames.end(), [](const BodyFrame& frame) {
      return frame.name.starts_with("node ") && to_integer(frame.name.substr(5));
    });
    std::set<std::int64_t> used;
    bool keep = !places.alone.empty() && !body_.node_labels.empty();
    if (numbered)
      for (const BodyFrame& frame : body_.frames) used.insert(*to_integer(frame.name.substr(5)));
    for (std::size_t i = 0; keep && i < places.alone.size(); ++i)
      keep = used.insert(body_.node_labels[static_cast<std::size_t>(places.alone[i])]).second;
    if (!keep && !numbered) used.clear();
    std::int64_t last = used.empty() ? 0 : std::max<std::int64_t>(0, *used.rbegin());
    for (const BodyFrame& frame : body_.frames)
      places.frame_labels.push_back(numbered ? *to_integer(frame.name.substr(5)) : ++last);
    for (const Eigen::Index point : places.alone)
      places.point_labels.push_back(keep ? body_.node_labels[static_cast<std::size_t>(point)] : ++last);
    return places;
  }

  using Parts = std::vector<Eigen::MatrixXd>;

  static std::string one_line(std::string text) {
    for (char& c : text)
      if (c == '\n' || c == '\r' || c == ':') c = ' ';
    return text;
  }
  /// 17 digits, so that reading gives the same number.
  static std::string number(double value) {
    std::string text = fmt::format("{:.16E}", value);
    text[text.find('E')] = 'D';
    return text;
  }

  void write_refmod() {
    out_.print("           refmod\n                mass = {}\n                nelastq = {}\n",
               number(body_.mass), n_);
    for (int m = 0; m < n_; ++m) {
      const double k = body_.stiffness(m, m), mass = body_.mass_matrix(m, m);
      const double frequency = k > 0 && mass > 0 ? std::sqrt(k / mass) / (2 * EIGEN_PI) : 0;
      out_.print("                ielastq ({:4}) = {} : {:.6g} Hz\n", m + 1,
                 one_line(body_.mode_names[static_cast<std::size_t>(m)]), frequency);
    }
    out_.print("           end refmod\n");
  }

  void write_block(const char* name, const Eigen::MatrixXd& m0, const Parts& m1 = {}) {
    const bool zero = m0.isZero(0) && m1.empty();
    out_.print(
        "           {}\n                order = {}\n                nrow = {}\n                ncol = {}\n   "
        "             nq = {}\n"
        "                nqn = 0\n                structure = {}\n",
        name, m1.empty() ? 0 : 1, m0.rows(), m0.cols(), n_, zero ? 0 : 3);
    for (Eigen::Index i = 0; i < m0.rows(); ++i)
      for (Eigen::Index j = 0; j < m0.cols(); ++j)
        if (m0(i, j) != 0) out_.print("                m0( {}, {}) = {}\n", i + 1, j + 1, number(m0(i, j)));
    for (std::size_t q = 0; q < m1.size(); ++q)
      for (Eigen::Index i = 0; i < m0.rows(); ++i)
        for (Eigen::Index j = 0; j < m0.cols(); ++j)
          if (m1[q](i, j) != 0)
            out_.print("                m1( {}, {}, {}) = {}\n", i + 1, q + 1, j + 1, number(m1[q](i, j)));
    out_.print("           end {}\n", name);
  }

  void write_origin(std::int64_t label, const Eigen::Vector3d& position, const Eigen::Matrix3Xd& X) {
    Parts origin;
    for (int m = 0; m < n_; ++m) origin.push_back(X.col(m));
    out_.print("                new node = {}\n                rframe = body ref\n", label);
    write_block("origin", position, origin);
  }

  void write_frame(std::size_t index, std::int64_t label, Eigen::Index point) {
    const BodyFrame& frame = body_.frames[index];
    Parts turn;
    for (int m = 0; m < n_; ++m) turn.push_back(skew(frame.X_theta.col(m)) * frame.rotation);
    write_origin(label, frame.position, frame.X);
    write_block("phi", frame.X, forces(6 * index));
    write_block("psi", frame.X_theta, forces(6 * index + 3));
    write_block("AP", frame.rotation, turn);
    if (point >= 0) write_stress(point);
    out_.print("                end node\n");
  }

  void write_point(Eigen::Index point, std::int64_t label) {
    const Eigen::Matrix3Xd X = body_.node_shapes.middleRows<3>(3 * point);
    write_origin(label, body_.nodes.col(point), X);
    write_block("phi", X);
    write_stress(point);
    out_.print("                end node\n");
  }

  void write_stress(Eigen::Index point) {
    Parts stress;
    for (int m = 0; m < n_; ++m) stress.push_back(body_.stress.col(m).segment<6>(6 * point));
    write_block("sigma", Eigen::MatrixXd::Zero(6, 1), stress);
  }

  /// Linear parts of phi or psi by the stiffening of three forces; none where they stiffen nothing.
  Parts forces(std::size_t first) const {
    Parts parts;
    if (stiffening_.forces[first].size() == 0) return parts;
    for (int m = 0; m < n_; ++m) {
      Eigen::MatrixXd part(3, n_);
      for (int axis = 0; axis < 3; ++axis)
        part.row(axis) = -stiffening_.forces[first + static_cast<std::size_t>(axis)].row(m);
      parts.push_back(std::move(part));
    }
    return parts;
  }

  /// The geometric stiffness of a load of inertia, or zero.
  Eigen::MatrixXd geometric(int load) const {
    const Eigen::MatrixXd& stiffness = stiffening_.inertia[static_cast<std::size_t>(load)];
    return stiffness.size() > 0 ? stiffness : Eigen::MatrixXd::Zero(n_, n_);
  }

  static Eigen::MatrixXd inertia_column(const Eigen::Matrix3d& J) {
    Eigen::MatrixXd column(6, 1);
    for (int row = 0; row < 6; ++row) column(row, 0) = J(kInertia[row][0], kInertia[row][1]);
    return column;
  }

  void write_blocks() {
    Parts centre, J, Ct, Cr, Gr, Oe;
    Eigen::MatrixXd Gr0(3, 3 * n_), Ge0(n_, 3 * n_), Oe0(n_, 6);
    for (int m = 0; m < n_; ++m) {
      const Eigen::Matrix3d position = position_integral(body_, m);
      centre.push_back(body_.S.col(m));
      J.push_back(inertia_column(inertia_of(position + position.transpose())));
      // r~ φ~ = φ rᵀ − (φ · r) I
      Gr0.middleCols<3>(3 * m) = 2 * inertia_of(position);
      Oe0.row(m) = centrifugal(position);
      Eigen::MatrixXd Ct1(n_, 3), Cr1(n_, 3), Gr1(3, 3 * n_), Oe1(n_, 6);
      for (int k = 0; k < n_; ++k) {
        const Eigen::Matrix3d A = mode_integral(body_, k, m);
        Ge0.row(k).segment<3>(3 * m) = -2 * cross_of(A);
        Cr1.row(k) = -cross_of(A);
        Gr1.middleCols<3>(3 * k) = 2 * inertia_of(A);
        Oe1.row(k) = centrifugal(A);
      }
      for (int c = 0; c < 3; ++c) {
        Ct1.col(c) = geometric(GeometricStiffness::acceleration + c).col(m);
        Cr1.col(c) += geometric(GeometricStiffness::angular_acceleration + c).col(m);
      }
      for (int c = 0; c < 6; ++c) Oe1.col(c) += geometric(GeometricStiffness::angular_velocity + c).col(m);
      Ct.push_back(Ct1);
      Cr.push_back(Cr1);
      Gr.push_back(Gr1);
      Oe.push_back(Oe1);
    }
    write_block("mdCM", body_.first_moment, centre);
    write_block("J", inertia_column(inertia_of(body_.second_moment)), J);
    write_block("Ct", body_.S.transpose(), body_.geometric ? Ct : Parts{});
    write_block("Cr", angular_coupling(body_).transpose(), Cr);
    write_block("Me", body_.mass_matrix);
    write_block("Gr", Gr0, Gr);
    write_block("Ge", Ge0);
    write_block("Oe", Oe0, Oe);
    write_block("ksigma", Eigen::MatrixXd::Zero(n_, 1));
    write_block("Ke", body_.stiffness);
    write_block("De", body_.damping);
  }
};

}  // namespace

void write_sid(const ReducedBody& body, const std::string& path) { Writer(body, path).write(); }

}  // namespace mimbre::fe
