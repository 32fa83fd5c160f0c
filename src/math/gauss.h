#pragma once
#include <array>

namespace mimbre::fe {

/// Gauss–Legendre points on [0, 1].
struct GaussPoint {
  double xi;
  double weight;
};

/// Exact up to degree 7: products of two cubic shape functions.
inline constexpr std::array<GaussPoint, 4> gauss4{{{0.069431844202973712, 0.17392742256872693},
                                                   {0.330009478207571868, 0.32607257743127307},
                                                   {0.669990521792428132, 0.32607257743127307},
                                                   {0.930568155797026288, 0.17392742256872693}}};

/// Exact up to degree 11: products of two fields of degree five.
inline constexpr std::array<GaussPoint, 6> gauss6{{{0.033765242898423986, 0.085662246189585178},
                                                   {0.169395306766867743, 0.180380786524069303},
                                                   {0.380690406958401546, 0.233956967286345524},
                                                   {0.619309593041598454, 0.233956967286345524},
                                                   {0.830604693233132257, 0.180380786524069303},
                                                   {0.966234757101576014, 0.085662246189585178}}};

/// Masses at both ends.
inline constexpr std::array<GaussPoint, 2> trapezoid2{{{0, 0.5}, {1, 0.5}}};

}  // namespace mimbre::fe
