#include "dynamics/ancf_spatial.h"

/// Over doubles in a unit of its own, for the reason that other_turns.cpp has.
namespace mimbre::ancf {

void add_forces(const AncfSpatialElement& e, double elastic, double damping, const double* y,
                const double* yd, double* out) {
  add_forces<double>(e, elastic, damping, y, yd, out);
}

double energy(const AncfSpatialElement& e, const double* y) { return energy<double>(e, y); }

void tangent(const AncfSpatialElement& e, const double* y, double stiffness, double damping, double* out) {
  tangent<double>(e, y, stiffness, damping, out);
}

void marks(const AncfSpatialElement& e, const double* y, double* out) {
  const double square = e.length * e.length;
  visit_points(e, [&]<class Law>(const Law&, const AncfSpatialElement::Point& p) {
    if constexpr (std::is_same_v<Law, CableStretch> || std::is_same_v<Law, ThickBeam>) {
      const auto strain = Law::template at<double>(vectors<Law>(e, p, y, false).data());
      for (std::size_t m = 0; m < strain.value.size(); ++m)
        *out++ = p.stiffness[m] * strain.value[m] / (m < 3 ? square : square * e.length);
      for (std::size_t m = 0; m < (Law::strains > 1 ? 2 : 1); ++m)
        for (int c = 0; c < 3; ++c) *out++ = p.stiffness[m] / square * strain.by[m][0][c];
    }
  });
}

}  // namespace mimbre::ancf
