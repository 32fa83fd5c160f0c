#include "forces/published_formula.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mimbre::test {
namespace {

using std::abs, std::atan, std::cos, std::exp, std::pow, std::sin, std::sqrt, std::tan;

double sgn(double x) { return x < 0 ? -1 : 1; }
double square(double x) { return x * x; }
/// The argument that all sines and cosines have: Bx − E (Bx − arctan Bx).
double argument(double B, double E, double x) { return B * x - E * (B * x - atan(B * x)); }

class Tyre {
 public:
  Tyre(const Coefficients& c, const Slip& slip) : c_(c), s_(slip) {
    old_ = c.at("version") < 60;
    R0 = p("UNLOADED_RADIUS");
    Fz0 = p("FNOMIN");
    Fz0_scaled = p("LFZO") * Fz0;                // (4.E1)
    dfz = (s_.Fz - Fz0_scaled) / Fz0_scaled;     // (4.E2a)
    dpi = (s_.p - p("NOMPRES")) / p("NOMPRES");  // (4.E2b)
    alpha_star = tan(s_.alpha);                  // (4.E3)
    gamma_star = sin(s_.gamma);                  // (4.E4)
    const double Vsx = -s_.kappa * abs(s_.Vcx), Vsy = alpha_star * abs(s_.Vcx);
    cos_alpha = s_.Vcx / std::hypot(s_.Vcx, Vsy);  // (4.E6)
    const double Vs = std::hypot(Vsx, Vsy);
    lmux = p("LMUX") / (1 + p("LMUV") * Vs / p("LONGVL"));  // (4.E7)
    lmuy = p("LMUY") / (1 + p("LMUV") * Vs / p("LONGVL"));
  }

  Published all() {
    Published out{};
    out.Fx = G_x_alpha() * Fx0();
    const double camber_y = p("LGAY") * gamma_star;
    const Side side = side_force(camber_y);
    out.Fy = G_y_kappa() * side.Fy0 + S_Vy_kappa(side.mu);
    out.Mx = Mx(out.Fy);
    out.My = My(out.Fx);
    // Version 5.2 has the tyre's own force at the trail, 6.1 the one without inclination.
    const double F = old_ ? G_y_kappa() * side.Fy0 : G_y_kappa() * side_force(0).Fy0;
    const double alpha_t = alpha_star + p("QHZ1") + p("QHZ2") * dfz +
                           (p("QHZ3") + p("QHZ4") * dfz) * p("LGAZ") * gamma_star;  // (4.E34), (4.E35)
    const double alpha_r = alpha_star + side.SHy + side.SVy / side.Ky;              // (4.E37), (4.E38)
    const double k = Kx() / side.Ky * s_.kappa;
    const double t_eq = atan(std::hypot(tan(alpha_t), k)) * sgn(alpha_t),  // (A54)
        r_eq = atan(std::hypot(tan(alpha_r), k)) * sgn(alpha_r);           // (A55)
    out.trail = trail(alpha_t, t_eq);
    const double s =
        R0 * (p("SSZ1") + p("SSZ2") * out.Fy / Fz0 + (p("SSZ3") + p("SSZ4") * dfz) * s_.gamma) * p("LS");
    out.Mz = -out.trail * F + residual(side, r_eq) + s * out.Fx;  // (4.E71) to (4.E76)
    relaxation(side.Ky, out);
    return out;
  }

 private:
  struct Side {
    double Fy0, mu, Ky, By, Cy, SHy, SVy;
  };

  double p(const std::string& key) const { return c_.at(key); }

  double Kx() const {  // (4.E15)
    return s_.Fz * (p("PKX1") + p("PKX2") * dfz) * exp(p("PKX3") * dfz) *
           (1 + p("PPX1") * dpi + p("PPX2") * square(dpi)) * p("LKX");
  }
  double Fx0() const {
    const double gamma_x = p("LGAX") * s_.gamma;
    const double SHx = (p("PHX1") + p("PHX2") * dfz) * p("LHX");  // (4.E17)
    const double kappa_x = s_.kappa + SHx;                        // (4.E10)
    const double Cx = p("PCX1") * p("LCX");                       // (4.E11)
    const double mu_x = (p("PDX1") + p("PDX2") * dfz) * (1 + p("PPX3") * dpi + p("PPX4") * square(dpi)) *
                        (1 - p("PDX3") * square(gamma_x)) * lmux;  // (4.E13)
    const double Dx = mu_x * s_.Fz;                                // (4.E12)
    const double Ex = std::min(1.0, (p("PEX1") + p("PEX2") * dfz + p("PEX3") * square(dfz)) *
                                        (1 - p("PEX4") * sgn(kappa_x)) * p("LEX"));  // (4.E14)
    const double Bx = Kx() / (Cx * Dx);                                              // (4.E16)
    const double SVx = s_.Fz * (p("PVX1") + p("PVX2") * dfz) * p("LVX") * lmux;      // (4.E18)
    return Dx * sin(Cx * atan(argument(Bx, Ex, kappa_x))) + SVx;                     // (4.E9)
  }
  double G_x_alpha() const {  // (4.E51) to (4.E57)
    const double B =
        (p("RBX1") + p("RBX3") * square(gamma_star)) * cos(atan(p("RBX2") * s_.kappa)) * p("LXAL");
    const double E = std::min(1.0, p("REX1") + p("REX2") * dfz), SH = p("RHX1");
    return cos(p("RCX1") * atan(argument(B, E, alpha_star + SH))) / cos(p("RCX1") * atan(argument(B, E, SH)));
  }

  /// (4.E19) to (4.E30).
  Side side_force(double gamma_y) const {
    Side y{};
    y.Ky = p("PKY1") * Fz0_scaled * (1 + p("PPY1") * dpi) * (1 - p("PKY3") * abs(gamma_y)) *
           sin(p("PKY4") * atan(s_.Fz / Fz0_scaled /
                                ((p("PKY2") + p("PKY5") * square(gamma_y)) * (1 + p("PPY2") * dpi)))) *
           p("LKY");
    const double SVy_gamma = s_.Fz * (p("PVY3") + p("PVY4") * dfz) * gamma_y * p("LKYC") * lmuy;
    y.SVy = s_.Fz * (p("PVY1") + p("PVY2") * dfz) * p("LVY") * lmuy + SVy_gamma;
    y.SHy = (p("PHY1") + p("PHY2") * dfz) * p("LHY");
    if (old_) {
      y.SHy += p("PHY3") * gamma_y * p("LKYC");
    } else {
      const double Ky_gamma0 =
          s_.Fz * (p("PKY6") + p("PKY7") * dfz) * (1 + p("PPY5") * dpi) * p("LKYC");  // (4.E30)
      y.SHy += (Ky_gamma0 * gamma_y - SVy_gamma) / y.Ky;
    }
    const double alpha_y = alpha_star + y.SHy;
    y.Cy = p("PCY1") * p("LCY");
    y.mu = (p("PDY1") + p("PDY2") * dfz) * (1 + p("PPY3") * dpi + p("PPY4") * square(dpi)) *
           (1 - p("PDY3") * square(gamma_y)) * lmuy;
    const double Dy = y.mu * s_.Fz;
    const double Ey = std::min(
        1.0, (p("PEY1") + p("PEY2") * dfz) *
                 (1 + p("PEY5") * square(gamma_y) - (p("PEY3") + p("PEY4") * gamma_y) * sgn(alpha_y)) *
                 p("LEY"));
    y.By = y.Ky / (y.Cy * Dy);
    y.Fy0 = Dy * sin(y.Cy * atan(argument(y.By, Ey, alpha_y))) + y.SVy;
    return y;
  }
  double G_y_kappa() const {  // (4.E59) to (4.E65)
    const double B = (p("RBY1") + p("RBY4") * square(gamma_star)) *
                     cos(atan(p("RBY2") * (alpha_star - p("RBY3")))) * p("LYKA");
    const double E = std::min(1.0, p("REY1") + p("REY2") * dfz), SH = p("RHY1") + p("RHY2") * dfz;
    return cos(p("RCY1") * atan(argument(B, E, s_.kappa + SH))) / cos(p("RCY1") * atan(argument(B, E, SH)));
  }
  double S_Vy_kappa(double mu_y) const {  // (4.E66), (4.E67)
    const double D = mu_y * s_.Fz * (p("RVY1") + p("RVY2") * dfz + p("RVY3") * gamma_star) *
                     cos(atan(p("RVY4") * alpha_star));
    return D * sin(p("RVY5") * atan(p("RVY6") * s_.kappa)) * p("LVYKA");
  }

  /// (4.E69), with the arctan of the square and the further numbers of MF-Tyre.
  double Mx(double Fy) const {
    const double g = s_.gamma, load = s_.Fz / Fz0, side = Fy / Fz0;
    double sum = p("QSX1") * p("LVMX");
    sum -= p("QSX2") * g * (1 + p("PPMX1") * dpi);
    sum += p("QSX3") * side;
    sum += p("QSX4") * cos(p("QSX5") * atan(square(p("QSX6") * load))) *
           sin(p("QSX7") * g + p("QSX8") * atan(p("QSX9") * side));
    sum += p("QSX10") * atan(p("QSX11") * load) * g;
    sum -= p("QSX12") * g * abs(g);
    return R0 * s_.Fz * sum * p("LMX") + R0 * Fy * (p("QSX13") + p("QSX14") * abs(g)) * p("LMX");
  }
  /// (4.E70), against the rotation. QSY7 is the exponent with Fz0 before it, in 5.2, too.
  double My(double Fx) const {
    const double v = s_.Vcx / p("LONGVL"), load = s_.Fz / Fz0;
    const double sum = p("QSY1") + p("QSY2") * Fx / Fz0 + p("QSY3") * abs(v) + p("QSY4") * pow(v, 4) +
                       (p("QSY5") + p("QSY6") * load) * square(s_.gamma);
    return -sgn(s_.Vcx) * R0 * Fz0 * p("LMY") * sum * pow(load, p("QSY7")) *
           pow(s_.p / p("NOMPRES"), p("QSY8"));
  }
  /// (4.E33), (4.E40) to (4.E44).
  double trail(double alpha_t, double equivalent) const {
    const double g = p("LGAZ") * s_.gamma, g_star = p("LGAZ") * gamma_star;
    const double Bt = (p("QBZ1") + p("QBZ2") * dfz + p("QBZ3") * square(dfz)) *
                      (1 + p("QBZ4") * g + p("QBZ5") * abs(g)) * p("LKY") / lmuy;  // (A58)
    const double Ct = p("QCZ1");
    const double Dt = s_.Fz * (R0 / Fz0) * (p("QDZ1") + p("QDZ2") * dfz) * (1 - p("PPZ1") * dpi) * p("LTR") *
                      (1 + p("QDZ3") * g + p("QDZ4") * square(g));  // (A56), (A60)
    const double Et = std::min(
        1.0, (p("QEZ1") + p("QEZ2") * dfz + p("QEZ3") * square(dfz)) *
                 (1 + (p("QEZ4") + p("QEZ5") * g_star) * 2 / std::numbers::pi * atan(Bt * Ct * alpha_t)));
    return Dt * cos(Ct * atan(argument(Bt, Et, equivalent))) * cos_alpha;
  }
  /// (4.E36), (4.E45) to (4.E47).
  double residual(const Side& y, double equivalent) const {
    const double g = p("LGAZ") * gamma_star;
    const double Br = p("QBZ9") * p("LKY") / lmuy + p("QBZ10") * y.By * y.Cy;
    const double Dr =
        s_.Fz * R0 *
        ((p("QDZ6") + p("QDZ7") * dfz) * p("LRES") +
         ((p("QDZ8") + p("QDZ9") * dfz) * (1 + p("PPZ2") * dpi) + (p("QDZ10") + p("QDZ11") * dfz) * abs(g)) *
             g * p("LKZC")) *
        lmuy * cos_alpha;
    return Dr * cos(atan(Br * equivalent));
  }

  /// 6.1: slip stiffness over the standing tyre's stiffness, (A3.9); 5.2: of its handbook.
  void relaxation(double Ky, Published& out) const {
    if (old_) {
      out.sigma_kappa =
          s_.Fz * (p("PTX1") + p("PTX2") * dfz) * exp(-p("PTX3") * dfz) * (R0 / Fz0) * p("LSGKP");
      out.sigma_alpha = p("PTY1") * sin(2 * atan(s_.Fz / (p("PTY2") * Fz0_scaled))) *
                        (1 - p("PKY3") * abs(p("LGAY") * gamma_star)) * R0 * p("LFZO") * p("LSGAL");
      return;
    }
    const auto standing = [&](const char* c0, const char* c1, const char* c2, const char* c3) {
      return p(c0) * (1 + p(c1) * dfz + p(c2) * square(dfz)) * (1 + p(c3) * dpi);
    };
    out.sigma_kappa = abs(Kx()) / standing("LONGITUDINAL_STIFFNESS", "PCFX1", "PCFX2", "PCFX3");
    out.sigma_alpha = abs(Ky) / standing("LATERAL_STIFFNESS", "PCFY1", "PCFY2", "PCFY3");
  }

  const Coefficients& c_;
  Slip s_;
  bool old_;
  double R0, Fz0, Fz0_scaled, dfz, dpi, alpha_star, gamma_star, cos_alpha, lmux, lmuy;
};

}  // namespace

Published published_formula(const Coefficients& c, const Slip& slip) { return Tyre(c, slip).all(); }

}  // namespace mimbre::test
