#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "io/fe/cross_integrals.h"
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
// Cr (angular acceleration).

namespace mimbre::fe {
namespace {

/// Columns of Oe: the products ω_a ω_b.
constexpr int kProducts[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
/// Rows of J.
constexpr int kInertia[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

/// Factors of the products in ∫φ · ω × (ω × r) dm, of A = ∫φ rᵀ dm.
Eigen::Matrix<double, 1, 6> centrifugal(const Eigen::Matrix3d& A) {
  Eigen::Matrix<double, 1, 6> result;
  for (int c = 0; c < 6; ++c) {
    const int a = kProducts[c][0], b = kProducts[c][1];
    result(c) = a == b ? A(a, a) - A.trace() : A(a, b) + A(b, a);
  }
  return result;
}

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
    read_frames();
    for (std::string& message : finish_body(mark_.file, body))
      result_.warnings.push_back({mark_, std::move(message)});
    return std::move(result_);
  }

 private:
  const SidFile& sid_;
  Mark mark_;
  int n_;
  ImportedBody result_;

  void read_matrices() {
    ReducedBody& body = result_.body;
    body.mass_matrix = constant_part(need(sid_.blocks, "Me", n_, n_, mark_));
    body.stiffness = constant_part(need(sid_.blocks, "Ke", n_, n_, mark_));
    if (const SidBlock* damping = find(sid_.blocks, "De", n_, n_)) body.damping = constant_part(*damping);
    body.S = constant_part(need(sid_.blocks, "Ct", n_, 3, mark_)).transpose();
    body.first_moment = constant_part(need(sid_.blocks, "mdCM", 3, 1, mark_));
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
    GeometricStiffness geometric;
    const auto add = [&](int load, const Eigen::MatrixXd& stiffness, const Eigen::MatrixXd& whole) {
      if (!matters(stiffness, whole)) return;
      geometric.loads.push_back(load);
      geometric.stiffness.push_back(0.5 * (stiffness + stiffness.transpose()));
    };
    const auto column = [&](const std::vector<Eigen::MatrixXd>& parts, int c) {
      Eigen::MatrixXd result(n_, n_);
      for (int m = 0; m < n_; ++m) result.col(m) = parts[static_cast<std::size_t>(m)].col(c);
      return result;
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
    geometric.boundary_loads.resize(0, n_);
    if (!geometric.loads.empty()) body.geometric = std::move(geometric);
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

  void read_frames() {
    ReducedBody& body = result_.body;
    const auto nodes = static_cast<Eigen::Index>(sid_.nodes.size());
    body.nodes.resize(3, nodes);
    body.node_shapes.resize(3 * nodes, n_);
    for (Eigen::Index i = 0; i < nodes; ++i) {
      const SidNode& node = sid_.nodes[static_cast<std::size_t>(i)];
      BodyFrame frame;
      frame.name = to_integer(node.label) ? "node " + node.label : node.label;
      frame.position = constant_part(need(node.blocks, "origin", 3, 1, mark_));
      frame.X = constant_part(need(node.blocks, "phi", 3, n_, mark_));
      frame.X_theta = constant_part(need(node.blocks, "psi", 3, n_, mark_));
      if (const SidBlock* AP = find(node.blocks, "AP", 3, 3)) frame.rotation = constant_part(*AP);
      if (!(frame.rotation * frame.rotation.transpose()).isIdentity(1e-5) || frame.rotation.determinant() < 0)
        throw InputError(mark_, fmt::format("AP of node {} is no rotation", shown(node.label)));
      // Files have few digits; the nearest rotation is meant.
      if (!(frame.rotation * frame.rotation.transpose()).isIdentity(1e-14))
        frame.rotation = Eigen::Quaterniond(frame.rotation).normalized().toRotationMatrix();
      body.nodes.col(i) = frame.position;
      body.node_shapes.middleRows<3>(3 * i) = frame.X;
      body.frames.push_back(std::move(frame));
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
  Writer(const ReducedBody& body, const std::string& path) : body_(body), n_(body.modes), out_(path) {}

  void write() {
    out_.print("{:5} {:5}    : number of nodes, number of modes\n part\n      new modal = {}\n",
               body_.frames.size(), n_, one_line(body_.name));
    write_refmod();
    out_.print("           frame\n");
    const bool labelled = std::all_of(body_.frames.begin(), body_.frames.end(), [](const BodyFrame& frame) {
      return frame.name.starts_with("node ") && to_integer(frame.name.substr(5));
    });
    for (std::size_t i = 0; i < body_.frames.size(); ++i)
      write_frame(body_.frames[i], labelled ? body_.frames[i].name.substr(5) : std::to_string(i + 1));
    out_.print("           end frame\n");
    write_blocks();
    out_.print("      end modal\n end part\n");
    out_.finish();
  }

 private:
  const ReducedBody& body_;
  int n_;
  OutputFile out_;

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

  void write_frame(const BodyFrame& frame, const std::string& label) {
    Parts origin, turn;
    for (int m = 0; m < n_; ++m) {
      origin.push_back(frame.X.col(m));
      turn.push_back(skew(frame.X_theta.col(m)) * frame.rotation);
    }
    out_.print("                new node = {}\n                rframe = body ref\n", label);
    write_block("origin", frame.position, origin);
    write_block("phi", frame.X);
    write_block("psi", frame.X_theta);
    write_block("AP", frame.rotation, turn);
    out_.print("                end node\n");
  }

  /// The geometric stiffness of a load, or zero.
  Eigen::MatrixXd geometric(int load) const {
    if (body_.geometric)
      for (std::size_t i = 0; i < body_.geometric->loads.size(); ++i)
        if (body_.geometric->loads[i] == load) return body_.geometric->stiffness[i];
    return Eigen::MatrixXd::Zero(n_, n_);
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
