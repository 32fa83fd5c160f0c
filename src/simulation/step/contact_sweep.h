#pragma once
#include "compile/compiled.h"
#include "math/rotation.h"

/// Whether a sphere meets a surface on the way that its centre makes in a step, however long that is.
namespace mimbre {

/// The way of a sphere's centre in a step as a surface sees it that turns evenly by `turn`, rad: in axes that
/// do not turn, and are those of the surface at the end, the parabola through both ends that has the right
/// velocity at the second one, q(s) = from + s (to − from) − s (1 − s) bend, 0 ≤ s ≤ 1.
struct SpherePath {
  Vec3d from, to, bend, turn = Vec3d::Zero();
  double error = 0;  ///< how far the true way may be from it, m

  /// In the axes of the surface.
  Vec3d at(double s) const;
  double longest() const;  ///< the way is no longer, m
  double farthest() const { return from.norm() + (to - from).norm() + bend.norm(); }
};

enum class Passage {
  none,      ///< what happened shows at the ends
  possible,  ///< the way is not known well enough to decide
  certain    ///< in between it was in the surface, or deeper in it than at both ends
};

/// A way on which a sphere that touches does not come to another side, as a share of its radius.
constexpr double short_way = 0.25;

/// `before`, `after`: the gaps at the ends, m, negative where they touch. `slow`: a sphere that would come
/// nearer to the surface by less than that in the step when it meets it only grazes it, m.
Passage passage(const SurfaceData& surface, double radius, const SpherePath& path, double before,
                double after, double slow);

/// Of the points of a chord the one that is nearest to triangles, from its start (0) to its end (1).
struct NearestOnChord {
  double distance = 0, at = 0;
};
/// What is not nearer than `most` is left out: then the distance is `most`.
NearestOnChord nearest_on_chord(const TriangleMesh& mesh, const Vec3d& from, const Vec3d& to, double most);

}  // namespace mimbre
