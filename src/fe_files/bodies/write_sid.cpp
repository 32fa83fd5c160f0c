#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "fe_files/bodies/cross_integrals.h"
#include "fe_files/bodies/frame_force_stiffness.h"
#include "fe_files/bodies/reduced_files.h"
#include "fe_files/bodies/sid_terms.h"
#include "fe_files/text.h"
#include "mimbre/reduced_body.h"

namespace mimbre::fe {
namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d result;
  result << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return result;
}

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

void write_sid(const ReducedBody& body, const std::string& path) {
  if (body.ancf)
    throw std::invalid_argument("a beam by absolute nodal coordinates is not linear and has no place in SID");
  Writer(body, path).write();
}

}  // namespace mimbre::fe
