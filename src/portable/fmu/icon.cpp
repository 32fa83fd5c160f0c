#include "portable/fmu/icon.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "portable/fmu/canvas.h"

namespace mimbre::portable {
namespace {

using Eigen::Vector3d;

constexpr Colour body_colour{31, 78, 121}, spring_colour{192, 96, 16}, wheel_colour{80, 80, 80};
/// More lines of a body than these would be a blot.
constexpr std::size_t most_lines = 200;

struct SpaceStroke {
  Vector3d from, to;
  double radius = 0;  ///< m, of a wheel
  enum class Kind { body, spring, wheel, joint } kind = Kind::body;
};

Vector3d point_of(const spec::Model& m, int frame) {
  const spec::Frame& f = m.frames[static_cast<std::size_t>(frame)];
  if (f.body < 0) return f.pose.position;
  const spec::Pose& body = m.bodies[static_cast<std::size_t>(f.body)].pose;
  return body.position + body.rotation * f.pose.position;
}

/// Points of each body to which something else is fixed.
std::vector<std::vector<Vector3d>> fixed_points(const spec::Model& m) {
  std::vector<std::vector<Vector3d>> points(m.bodies.size());
  const auto add = [&](int frame) {
    if (frame < 0) return;
    const int body = m.frames[static_cast<std::size_t>(frame)].body;
    if (body >= 0) points[static_cast<std::size_t>(body)].push_back(point_of(m, frame));
  };
  for (const spec::Joint& j : m.joints) {
    add(j.frame_a);
    add(j.frame_b);
  }
  for (const spec::Spring& s : m.springs) {
    add(s.frame_a);
    add(s.frame_b);
  }
  for (const spec::Tyre& t : m.tyres) add(t.frame);
  for (const spec::Constraint& c : m.constraints) {
    add(c.frame_a);
    add(c.frame_b);
  }
  return points;
}

/// A rigid body's lines where it has some; else from its points to their mean, or where there is one point to
/// the centre of mass.
void add_body(const spec::Body& b, const std::vector<Vector3d>& points, std::vector<SpaceStroke>& to) {
  const auto global = [&](const Vector3d& p) { return Vector3d(b.pose.position + b.pose.rotation * p); };
  if (!b.lines.empty() && b.lines.size() <= most_lines) {
    for (const auto& line : b.lines) to.push_back({global(line[0]), global(line[1])});
    return;
  }
  if (points.empty()) return;
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  if (points.size() == 1)
    mean =
        global(b.flexible ? Vector3d(b.flexible->first_moment / std::max(b.flexible->mass, 1e-300)) : b.com);
  for (const Vector3d& p : points) to.push_back({p, mean});
}

std::vector<SpaceStroke> strokes_of(const spec::Model& m) {
  using Kind = SpaceStroke::Kind;
  std::vector<SpaceStroke> out;
  const std::vector<std::vector<Vector3d>> points = fixed_points(m);
  for (std::size_t k = 0; k < m.bodies.size(); ++k) add_body(m.bodies[k], points[k], out);
  for (const spec::Spring& s : m.springs)
    out.push_back({point_of(m, s.frame_a), point_of(m, s.frame_b), 0, Kind::spring});
  for (const spec::Tyre& t : m.tyres)
    out.push_back({point_of(m, t.frame), point_of(m, t.frame), t.radius, Kind::wheel});
  for (const spec::Joint& j : m.joints)
    if (j.frame_a >= 0) out.push_back({point_of(m, j.frame_a), point_of(m, j.frame_a), 0, Kind::joint});
  std::erase_if(out, [](const SpaceStroke& s) { return !(s.from.allFinite() && s.to.allFinite()); });
  return out;
}

/// From space to the picture.
struct View {
  int across = 0, up = 2;  ///< axes
  double up_sign = 1, scale = 1;
  Vector3d middle = Vector3d::Zero();

  std::array<double, 2> operator()(const Vector3d& p, int pixels) const {
    return {0.5 * pixels + scale * (p[across] - middle[across]),
            0.5 * pixels - up_sign * scale * (p[up] - middle[up])};
  }
};

View view_of(const std::vector<SpaceStroke>& strokes, const Vector3d& gravity, int pixels) {
  Vector3d low = strokes[0].from, high = low;
  for (const SpaceStroke& s : strokes)
    for (const Vector3d& p : {s.from, s.to}) {
      const Vector3d reach = Vector3d::Constant(s.radius);
      low = low.cwiseMin(p - reach);
      high = high.cwiseMax(p + reach);
    }
  const Vector3d size = high - low;
  int thinnest = 0, vertical = 0;
  for (int k = 1; k < 3; ++k) {
    // Of axes that are equally thin y, along which planes are seen most often.
    if (size[k] < size[thinnest] || (k == 1 && size[k] <= size[thinnest])) thinnest = k;
    if (std::abs(gravity[k]) > std::abs(gravity[vertical])) vertical = k;
  }
  View view;
  view.up = vertical != thinnest && gravity[vertical] != 0 ? vertical : thinnest == 2 ? 1 : 2;
  view.across = 3 - thinnest - view.up;
  view.up_sign = gravity[view.up] > 0 ? -1 : 1;
  view.middle = 0.5 * (low + high);
  const double most = std::max(size[view.across], size[view.up]);
  view.scale = most > 0 ? 0.8 * pixels / most : 1;
  return view;
}

Icon icon_of(const Canvas& canvas) { return {svg_of(canvas), png_of(canvas)}; }

}  // namespace

Icon model_icon(const spec::Model& model) {
  using Kind = SpaceStroke::Kind;
  Canvas canvas;
  const double centre = 0.5 * canvas.pixels;
  const std::vector<SpaceStroke> strokes = strokes_of(model);
  if (strokes.empty()) {
    canvas.strokes.push_back({{centre, centre}, {centre, centre}, 0.3 * canvas.pixels, 4, body_colour});
    return icon_of(canvas);
  }
  const View view = view_of(strokes, model.gravity, canvas.pixels);
  for (const Kind kind : {Kind::wheel, Kind::body, Kind::spring, Kind::joint})
    for (const SpaceStroke& s : strokes) {
      if (s.kind != kind) continue;
      const auto from = view(s.from, canvas.pixels), to = view(s.to, canvas.pixels);
      if (kind == Kind::wheel)
        canvas.strokes.push_back({from, from, std::max(view.scale * s.radius, 2.0), 3, wheel_colour});
      else if (kind == Kind::joint)
        canvas.strokes.push_back({from, from, 4.5, 0, body_colour});
      else
        canvas.strokes.push_back({from, to, 0, kind == Kind::spring ? 2.0 : 4.0,
                                  kind == Kind::spring ? spring_colour : body_colour});
    }
  return icon_of(canvas);
}

Icon terminal_icon() {
  Canvas canvas;
  canvas.pixels = 32;
  canvas.strokes.push_back({{16, 16}, {16, 16}, 14, 0, body_colour});
  return icon_of(canvas);
}

}  // namespace mimbre::portable
