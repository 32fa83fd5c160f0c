#include "compile/paths.h"

#include <map>

namespace mimbre {

Path make_path(const Compiled& c, int frame_a, int frame_b) {
  std::map<int, PathEntry, std::greater<>> entries;
  const auto walk = [&](int frame, bool plus) {
    while (c.frames[frame].body >= 0) {
      const int body = c.frames[frame].body;
      PathEntry& e = entries[body];
      e.body = body;
      (plus ? e.plus : e.minus) = c.frames[frame].subspace;
      frame = c.bodies[body].inboard_frame;
    }
  };
  walk(frame_a, false);
  walk(frame_b, true);
  Path path;
  for (auto& [body, e] : entries) {
    if (e.plus == e.minus || c.bodies[body].size() == 0) continue;
    append(c, e, path);
  }
  return path;
}

void append(const Compiled& c, PathEntry& e, Path& path) {
  const BodyData& body = c.bodies[e.body];
  e.offset = path.width;
  e.first = body.v;
  e.count = body.size();
  path.width += pad_columns(e.count);
  path.entries.push_back(e);
}

int add_jacobian(Compiled& c, const Path& path, int rows) {
  const int offset = c.jacobian_storage;
  c.jacobian_storage += rows * path.width;
  return offset;
}

int ground_frame(const Compiled& c) {
  for (const BodyData& b : c.bodies)
    if (b.parent < 0) return b.inboard_frame;
  return 0;
}

spec::Pose global_pose(const Compiled& c, int frame) {
  const spec::Frame& f = c.spec().frames[frame];
  if (f.body < 0) return f.pose;
  const spec::Pose& body = c.spec().bodies[f.body].pose;
  return {body.position + body.rotation * f.pose.position, body.rotation * f.pose.rotation};
}

double assembled_distance(const Compiled& c, int frame_a, int frame_b) {
  return (global_pose(c, frame_b).position - global_pose(c, frame_a).position).norm();
}

}  // namespace mimbre
