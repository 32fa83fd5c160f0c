#include "dynamics/other_turns.h"

/// Over doubles in a unit of its own: so the code of frames that turn by exp(θ~) stays small, and this unit
/// can be compiled without a vectorisation in which GCC before 14 fuses cross products against its options
/// (CMakeLists.txt).
namespace mimbre {

Mat3<double> other_rotation(const FrameData& f, const double* y) { return other_rotation<double>(f, y); }

void other_motion(const FrameData& f, const double* y, const double* yd, const double* ydd,
                  Mat3<double>& rotation, Vec3<double>& omega, Vec3<double>& alpha) {
  other_motion<double>(f, y, yd, ydd, rotation, omega, alpha);
}

void add_other_moment(const FrameData& f, const double* y, const Vec3<double>& moment, double* out) {
  add_other_moment<double>(f, y, moment, out);
}

void other_turn_rows(const FrameData& f, const double* y, const Mat3<double>& A, int stride, double* out) {
  other_turn_rows<double>(f, y, A, stride, out);
}

}  // namespace mimbre
